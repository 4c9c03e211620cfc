//! rilievo: exact ray tracing of displacement-mapped surfaces without tessellation.

mod hit;
pub mod map;
mod probe;
mod ray;

pub use glam;
pub use hit::Hit;
pub use probe::{Counters, Probe};
pub use ray::{Origin, Part, Ray, Wall};
