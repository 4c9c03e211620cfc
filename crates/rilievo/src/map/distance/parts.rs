//! What a distance map is made of, and what is refused.

use super::{Codes, DistanceBits};
use crate::map::Metric;

/// Most codes a map may have.
const MAX_CODES: u128 = 1 << 31;

/// How distances are made and read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DistanceKind {
    /// The seed paper's; not safe.
    Published,
    /// Voxel boxes to column boxes; linear time, safe.
    Boxes,
    /// Exact at nodes, read with a correction; safe.
    Corrected,
}

/// What [`DistanceMap::from_height`](super::DistanceMap::from_height) makes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistanceOptions {
    /// Voxels (`Boxes`, at least 1) or nodes (else, at least 2) along x, y and z.
    pub size: [u32; 3],
    /// The reference metric, positive.
    pub metric: Metric,
    /// Bits of a stored distance.
    pub bits: DistanceBits,
}

/// Why a distance map was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum DistanceMapError {
    /// Too few voxels or nodes along an axis, or too many altogether.
    #[error(
        "a distance map of this kind has at least {least} along each axis and at most 2^31 \
         altogether, not {size:?}"
    )]
    Size {
        /// The size given.
        size: [u32; 3],
        /// The least size along an axis.
        least: u32,
    },
    /// A metric that is not positive, or whose distances leave the range of f64.
    #[error("a reference metric must be positive and of moderate size, not {metric:?}")]
    Metric {
        /// The metric given.
        metric: Metric,
    },
    /// A domain that no height map has.
    #[error("no height map has {cells:?} cells and raw heights from {} to {}", raw.0, raw.1)]
    Domain {
        /// The cells given.
        cells: [u32; 2],
        /// The range given.
        raw: (f32, f32),
    },
    /// A quantum that is not a positive number.
    #[error("the quantum of distances must be positive and finite, not {quantum}")]
    Quantum {
        /// The quantum given.
        quantum: f64,
    },
    /// Another number of codes than the size says.
    #[error("{size:?} needs {} codes, {found} were given", count(*size))]
    Count {
        /// The size given.
        size: [u32; 3],
        /// The codes given.
        found: usize,
    },
}

/// All that a distance map is, for storing and loading.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceParts {
    /// How it was made and is read.
    pub kind: DistanceKind,
    /// Voxels or nodes along x, y and z.
    pub size: [u32; 3],
    /// Stored cells of the height map along x and y.
    pub cells: [u32; 2],
    /// Lowest and highest raw height.
    pub raw_range: (f32, f32),
    /// The reference metric.
    pub metric: Metric,
    /// Scene units of one code step.
    pub quantum: f64,
    /// The codes, x fastest, then y, then z.
    pub codes: Codes,
}

/// Number of codes of a size.
pub(super) fn count(size: [u32; 3]) -> u128 {
    size.iter().map(|&n| u128::from(n)).product()
}

impl DistanceKind {
    /// The least size along an axis.
    pub fn least_size(self) -> u32 {
        match self {
            Self::Boxes => 1,
            Self::Published | Self::Corrected => 2,
        }
    }

    /// Refuses sizes that are too small or too large altogether.
    pub(super) fn check_size(self, size: [u32; 3]) -> Result<(), DistanceMapError> {
        let least = self.least_size();
        let fits = size.iter().all(|&n| n >= least) && count(size) <= MAX_CODES;
        if fits { Ok(()) } else { Err(DistanceMapError::Size { size, least }) }
    }
}
