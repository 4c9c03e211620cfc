//! rilievo: exact ray tracing of displacement-mapped surfaces without tessellation.

pub mod accel;
mod hit;
pub mod map;
pub mod mesh;
mod probe;
mod ray;
pub mod relief;

pub use glam;
pub use hit::Hit;
pub use probe::{Counters, Probe};
pub use ray::{Origin, Part, Ray, Wall};
