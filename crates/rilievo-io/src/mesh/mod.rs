//! Mesh files.

mod obj;

pub use obj::{read_obj, read_obj_bytes};
