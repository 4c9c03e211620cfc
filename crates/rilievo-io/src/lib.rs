//! rilievo-io
