//! Files of rilievo: scenes, images, meshes and baked maps, read into typed values and written
//! back.
//!
//! | module | reads | writes |
//! |---|---|---|
//! | [`film_file`] | films that are not done, inside pictures | the same |
//! | [`image`] | height maps, colour images, normal maps, pictures: PNG, TIFF, JPEG, EXR, PFM, HDR | EXR, PNG |
//! | [`map_file`] | baked normals, distances, min-max bounds | the same |
//! | [`mesh`] | models: OBJ with MTL, PLY, glTF, GLB | |
//! | [`scene`] | TOML scenes, with all the files they name | |
//! | [`tev`] | | to the viewer tev, over TCP |
//! | [`texture_set`] | folders of maps, by their names | |
//!
//! Nothing here trusts a file. Sizes are checked against [`Limits`] before memory is asked for,
//! decoders of other crates run behind a guard that turns their panics into errors, and every
//! [`Error`] names the file, the place, the value found and the values allowed. What is written
//! appears under its name whole or not at all: [`atomic`].

#![forbid(unsafe_code)]

pub mod atomic;
mod error;
pub mod film_file;
mod guard;
pub mod image;
mod kind;
mod limits;
pub mod map_file;
pub mod mesh;
pub mod scene;
pub mod tev;
pub mod texture_set;

pub use error::{Error, Excerpt, Fault, Place, Result};
pub use kind::FileKind;
pub use limits::Limits;
