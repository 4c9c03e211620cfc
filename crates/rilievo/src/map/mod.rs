//! Maps: height maps and what is derived from them.

mod height;
mod lattice;
mod pyramid;

pub use height::{HeightMap, HeightMapError, Samples};
pub use lattice::{Axis, Lattice, Run, Wrap};
pub use pyramid::{Bounds, Code, Level, Pyramid, PyramidViolation};
