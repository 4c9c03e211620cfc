//! Maps: height maps and what is derived from them.

mod height;
mod lattice;

pub use height::{HeightMap, HeightMapError, Samples};
pub use lattice::{Axis, Lattice, Run, Wrap};
