//! The judge and the suites of rilievo: an independent `f64` oracle, and one conformance suite
//! that every method of tracing joins in one line.

#![forbid(unsafe_code)]

pub mod ball;
pub mod conformance;
pub mod image;
pub mod joined;
pub mod kernel;
pub mod maps;
pub mod mesh_cases;
pub mod mesh_oracle;
pub mod meshes;
pub mod nudge;
pub mod oracle;
pub mod random;
pub mod rays;
pub mod scenes;
pub mod sphere;
pub mod world_oracle;
