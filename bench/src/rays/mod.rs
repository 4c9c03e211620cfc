//! Rays that are made once and traced by every contender.
//!
//! All numbers are `f32` values, so that a tracer in `f32` and one in `f64` get the same rays.
//! Secondary rays need hits: those are found by rilievo's reference walk over all cells
//! (`Method::Dda`), on the bilinear surface. Their origins then leave that surface *and* the two
//! triangulations of it that peers use (see [`clearance`]), so that no contender meets its own
//! start.

mod batch;
mod camera;
mod clearance;

pub use batch::{Batch, CORNERS, Family, Row, Scene, bounced, widened};
pub use camera::Camera;

/// A ray in `f32`. Points are `origin + t * direction` with `0 <= t <= t_max`, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray32 {
    pub origin: [f32; 3],
    pub direction: [f32; 3],
    /// May be infinite.
    pub t_max: f32,
}
