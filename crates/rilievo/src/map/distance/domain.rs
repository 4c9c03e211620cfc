//! [`Domain`]: the box a distance map covers, and its rounding margin.

use super::DistanceMapError;
use crate::map::{HeightMap, Metric};

/// Share of the domain's scale that every stored distance gives away to rounding, see
/// [`Domain::margin`].
const MARGIN: f64 = 1.0 / (1u64 << 44) as f64;

/// The stored cells of a height map and its raw range, measured in a metric.
///
/// Axis 0 is x in `[0, cells[0]]`, axis 1 is y in `[0, cells[1]]`, both in stored-cell coordinates
/// (stored cell `c` is `[c, c + 1]`); axis 2 is z, a raw height in `[raw.0, raw.1]`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Domain {
    pub cells: [u32; 2],
    pub raw: (f32, f32),
    pub metric: Metric,
}

impl Domain {
    /// The domain of `heights`.
    ///
    /// # Errors
    /// [`DistanceMapError::Metric`], see [`Domain::check`].
    pub fn of(heights: &HeightMap, metric: Metric) -> Result<Self, DistanceMapError> {
        let cells = [heights.x().cells(), heights.y().cells()];
        Self { cells, raw: heights.raw_range(), metric }.check()
    }

    /// Refuses a metric whose squared lengths leave the normal range of f64, so that nothing
    /// downstream overflows or vanishes.
    pub fn check(self) -> Result<Self, DistanceMapError> {
        let (scale, metric) = (self.scale(), self.metric);
        let fits = metric.is_positive() && (1e-100..=1e100).contains(&scale);
        if fits { Ok(self) } else { Err(DistanceMapError::Metric { metric }) }
    }

    /// Whether `heights` has this domain's cells and range.
    pub fn fits(&self, heights: &HeightMap) -> bool {
        self.cells == [heights.x().cells(), heights.y().cells()] && self.raw == heights.raw_range()
    }

    /// Lowest corner, in stored cells and raw height.
    #[inline]
    pub fn low(&self) -> [f64; 3] {
        [0.0, 0.0, f64::from(self.raw.0)]
    }

    /// Highest corner.
    #[inline]
    pub fn high(&self) -> [f64; 3] {
        [f64::from(self.cells[0]), f64::from(self.cells[1]), f64::from(self.raw.1)]
    }

    /// Scene units per unit of each axis.
    #[inline]
    pub fn units(&self) -> [f64; 3] {
        [self.metric.x, self.metric.y, self.metric.z]
    }

    /// Side lengths in scene units.
    pub fn extents(&self) -> [f64; 3] {
        let (low, high, unit) = (self.low(), self.high(), self.units());
        std::array::from_fn(|a| (high[a] - low[a]) * unit[a])
    }

    /// The depth: no point of the domain is farther from the surface, because every column of it
    /// holds a point of the surface.
    pub fn depth(&self) -> f64 {
        self.extents()[2]
    }

    /// Sum of the sizes of all numbers a distance is computed from, scene units.
    pub fn scale(&self) -> f64 {
        let [x, y, z] = self.extents();
        let (low, high) = (f64::from(self.raw.0), f64::from(self.raw.1));
        x + y + z + low.abs().max(high.abs()) * self.metric.z
    }

    /// What is taken off every distance before it is stored, scene units: `2^-44` of the scale.
    ///
    /// Every coordinate that enters a distance (a bound of a voxel, a node, a query point within
    /// its voxel, a height in scene units) is off by less than `2^-50` of the scale, and a distance
    /// moves by at most as much as its arguments. The remaining operations, a norm and a
    /// quantisation, are relative and below `2^-50`. The margin is many times their sum.
    pub fn margin(&self) -> f64 {
        self.scale() * MARGIN
    }

    /// Coordinate of division `i` of `n` equal ones along `axis`.
    pub fn division(&self, axis: usize, i: u32, n: u32) -> f64 {
        let (low, high) = (self.low()[axis], self.high()[axis]);
        if i >= n { high } else { low + (high - low) * f64::from(i) / f64::from(n) }
    }
}
