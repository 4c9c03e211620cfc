//! rilievo-cli
fn main() {}
