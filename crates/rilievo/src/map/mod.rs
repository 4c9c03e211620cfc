//! Maps: height maps and what is derived from them.

mod cube;
mod distance;
mod height;
mod lattice;
mod metric;
mod mip;
mod normal;
mod procedural;
mod pyramid;
mod statistics;

pub(crate) use cube::direction as cube_direction;
pub use cube::{CubeFace, CubeHeights, CubeHeightsError, CubeMipLevel, ResamplingError, Tiling};
pub use distance::{
    BoxSteps, Codes, DistanceBits, DistanceKind, DistanceMap, DistanceMapError, DistanceOptions,
    DistanceParts, DistanceViolation, NodeSearch, UnsafeCodes, exact_distance,
};
pub use height::{HeightMap, HeightMapError, RowMut, Samples};
pub use lattice::{Axis, Lattice, Run, Wrap};
pub use metric::Metric;
pub use mip::{LostSlopes, MipLevel};
pub use normal::{
    NormalAgreement, NormalConvention, NormalKind, NormalMap, NormalMapError, NormalTexels,
};
pub use procedural::{Procedural, ProceduralError};

pub use pyramid::{
    Code, Layout, Level, LevelBounds, NodeRuns, Pyramid, PyramidViolation, UnknownLayout,
};
pub(crate) use pyramid::{NodeBounds, SideBounds};
pub use statistics::{HeightStatistics, Seam};
