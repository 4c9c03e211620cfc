//! Displaced spheres and meshes as the shaders read them from `numbers`, word by word in the order of
//! `shaders/sphere/radii.wgsl`, `shaders/mesh/line.wgsl`, `prism.wgsl` and `wall.wgsl`.
//!
//! Slacks of the CPU's `f64` are made anew for numbers of 48 bits and for floats.

mod mesh;
mod sphere;

pub(crate) use mesh::{write_beside, write_mesh, write_parts};
pub(crate) use sphere::write_sphere;

/// What a sum of a few doubles rounds, 2^-44 of it, where an `f64` rounds 2^-52.
const ROUNDING: f64 = 256.0 * f64::EPSILON;
