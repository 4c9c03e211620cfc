//! [`DistanceMap`]: how far a ray may go from anywhere above or below a relief.
//!
//! A grid of distances over the stored cells of a height map, x and y in stored-cell coordinates
//! (stored cell `c` is `[c, c + 1]`), z in raw heights. Distances are those of the surface in a
//! *reference metric*, in its scene units.
//!
//! | kind | grid | stored | read | safe |
//! |---|---|---|---|---|
//! | [`DistanceKind::Published`] | nodes | brute force to texel points \[Book2007\] | trilinear | no |
//! | [`DistanceKind::Boxes`] | voxels | voxel box to column boxes | its voxel | proven |
//! | [`DistanceKind::Corrected`] | nodes | exact, by branch and bound | corrected | proven |
//!
//! *Safe* means: [`DistanceMap::safe_distance`] is never above the true distance to the continuous
//! bilinear surface of the stored cells, rounding included. The proofs are at the heads of `boxes`
//! and `corrected`; that quantisation and rounding keep them is at `domain` and `transform`.
//!
//! **Other faces.** A planar face maps lattice space to its plane by an affine map, and affine maps
//! keep ray parameters. So a ray with lattice direction `d` may advance its parameter by
//! `distance / |G d|`, with `G = diag(metric)` the *reference* metric, whatever the face's own size
//! and depth. A face unlike the reference takes shorter steps, never wrong ones.
//!
//! **Wrap.** Only the map's own stored cells are sites. A walk asks run by run
//! ([`Axis::run`](super::Axis::run)), and within a run there is nothing else.
//!
//! **Quantum.** Every column of the domain holds surface, so no point of it is farther from the
//! surface than the domain is deep: quantum = depth / highest code, and nothing is clamped.

mod box_steps;
mod boxes;
mod codes;
mod columns;
mod corrected;
mod default_size;
mod domain;
mod erosion;
mod exact;
#[cfg(test)]
mod fixtures;
mod node_search;
mod parts;
mod published;
mod transform;
mod verify;

pub use box_steps::BoxSteps;
pub use codes::{Codes, DistanceBits};
pub use exact::exact_distance;
pub use node_search::NodeSearch;
pub use parts::{DistanceKind, DistanceMapError, DistanceOptions, DistanceParts};
pub use verify::{DistanceViolation, UnsafeCodes};

use super::{HeightMap, Metric, Pyramid};
use boxes::Boxes;
use codes::{Code, Quantiser};
use columns::Columns;
use corrected::Nodes;
use domain::Domain;
use parts::count;

/// Distances over the stored cells of a height map. Valid by construction, safe as made; one that
/// was loaded is as safe as its file, see [`DistanceMap::verify`].
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceMap {
    kind: DistanceKind,
    size: [u32; 3],
    domain: Domain,
    quantum: f64,
    codes: Codes,
    /// Voxels, or steps between nodes, per unit of each axis; 0 where the domain has no depth.
    density: [f64; 3],
    /// Sides of a voxel between nodes or of a voxel, scene units.
    sides: [f64; 3],
    /// Empty until [`DistanceMap::laid_on`] some heights.
    columns: Columns,
}

impl DistanceMap {
    /// The distance map of `heights`. Any number of threads gives the same codes.
    ///
    /// Time: linear in the voxels for `Boxes`; nodes times a search that grows with the
    /// pyramid's levels for `Corrected`; nodes times the samples within reach for `Published`.
    ///
    /// # Errors
    /// [`DistanceMapError::Size`] or [`DistanceMapError::Metric`]; checked before anything is
    /// allocated.
    pub fn from_height(
        heights: &HeightMap,
        kind: DistanceKind,
        options: &DistanceOptions,
    ) -> Result<Self, DistanceMapError> {
        let size = options.size;
        kind.check_size(size)?;
        let domain = Domain::of(heights, options.metric)?;
        let quantum = codes::quantum(&domain, options.bits);
        let build = Build { heights, kind, domain: &domain, size };
        let quantiser = Quantiser::new(&domain, quantum, options.bits);
        let codes = match options.bits {
            DistanceBits::U8 => Codes::U8(build.codes(quantiser)),
            DistanceBits::U16 => Codes::U16(build.codes(quantiser)),
        };
        Ok(Self::assemble(kind, size, domain, quantum, codes))
    }

    /// A map from stored parts.
    ///
    /// # Errors
    /// [`DistanceMapError`] where the parts do not fit together. Whether the distances are safe is
    /// not looked at: [`DistanceMap::verify`] does that.
    pub fn from_parts(parts: DistanceParts) -> Result<Self, DistanceMapError> {
        let DistanceParts { kind, size, cells, raw_range: raw, metric, quantum, codes } = parts;
        kind.check_size(size)?;
        if codes.len() as u128 != count(size) {
            return Err(DistanceMapError::Count { size, found: codes.len() });
        }
        let finite = raw.0.is_finite() && raw.1.is_finite() && raw.0 <= raw.1;
        if !finite || cells.iter().any(|&n| !(1..=(1 << 24) + 1).contains(&n)) {
            return Err(DistanceMapError::Domain { cells, raw });
        }
        if !(quantum > 0.0 && (quantum * f64::from(u16::MAX)).is_finite()) {
            return Err(DistanceMapError::Quantum { quantum });
        }
        let domain = Domain { cells, raw, metric }.check()?;
        Ok(Self::assemble(kind, size, domain, quantum, codes))
    }

    fn assemble(
        kind: DistanceKind,
        size: [u32; 3],
        domain: Domain,
        quantum: f64,
        codes: Codes,
    ) -> Self {
        let steps = size.map(|n| f64::from(n + 1 - kind.least_size()));
        let (low, high, extents) = (domain.low(), domain.high(), domain.extents());
        let density = std::array::from_fn(|a| {
            let side = high[a] - low[a];
            if side > 0.0 { steps[a] / side } else { 0.0 }
        });
        let sides = std::array::from_fn(|a| extents[a] / steps[a]);
        let columns = Columns::default();
        Self { kind, size, domain, quantum, codes, density, sides, columns }
    }

    /// All fields, for storing; the codes are copied.
    pub fn to_parts(&self) -> DistanceParts {
        DistanceParts {
            kind: self.kind,
            size: self.size,
            cells: self.domain.cells,
            raw_range: self.domain.raw,
            metric: self.domain.metric,
            quantum: self.quantum,
            codes: self.codes.clone(),
        }
    }

    /// How the map was made and is read.
    pub fn kind(&self) -> DistanceKind {
        self.kind
    }

    /// Voxels or nodes along x, y and z.
    pub fn size(&self) -> [u32; 3] {
        self.size
    }

    /// Stored cells of the height map along x and y.
    pub fn cells(&self) -> [u32; 2] {
        self.domain.cells
    }

    /// Lowest and highest raw height.
    pub fn raw_range(&self) -> (f32, f32) {
        self.domain.raw
    }

    /// The reference metric.
    #[inline]
    pub fn metric(&self) -> Metric {
        self.domain.metric
    }

    /// Scene units of one code step.
    pub fn quantum(&self) -> f64 {
        self.quantum
    }

    /// The codes, x fastest, then y, then z.
    pub fn codes(&self) -> &Codes {
        &self.codes
    }

    /// Bytes held by the codes, and by what a relief keeps beside them.
    pub fn bytes(&self) -> u64 {
        self.codes.len() as u64 * self.codes.bits().bytes() + self.columns.bytes()
    }

    /// Bytes the codes of a map of `size` would take; nothing is allocated.
    pub fn predicted_bytes(size: [u32; 3], bits: DistanceBits) -> u128 {
        count(size) * u128::from(bits.bytes())
    }

    /// Whether the map's cells and range of heights are those of `heights`.
    pub fn fits(&self, heights: &HeightMap) -> bool {
        self.domain.fits(heights)
    }

    /// The stored distance of voxel or node (i, j, k), scene units of the reference metric.
    ///
    /// # Panics
    /// If there is no such voxel or node.
    #[inline]
    pub fn at(&self, i: u32, j: u32, k: u32) -> f64 {
        f64::from(self.code([i, j, k])) * self.quantum
    }

    /// The stored code of a voxel or node.
    #[inline]
    fn code(&self, [i, j, k]: [u32; 3]) -> u32 {
        let [nx, ny, _] = self.size.map(|n| n as usize);
        self.codes.get((k as usize * ny + j as usize) * nx + i as usize)
    }

    /// How far a ray may go from `p` = (x, y, raw z) in any direction, in scene units of the
    /// reference metric: not above the true distance to the surface for `Boxes` and `Corrected`.
    /// `p` may lie anywhere; outside of the domain the value at its nearest point holds.
    #[inline]
    pub fn safe_distance(&self, p: [f64; 3]) -> f64 {
        match self.kind {
            DistanceKind::Boxes => {
                let [i, j, k] = self.voxel_of(p);
                self.at(i, j, k)
            }
            DistanceKind::Corrected => {
                let (nodes, local) = self.corners_at(p);
                corrected::safe(nodes, local, self.sides)
            }
            DistanceKind::Published => {
                let (nodes, local) = self.corners_at(p);
                corrected::trilinear(nodes, local)
            }
        }
    }

    /// The map with the columns of `heights`, for walks. `heights` must fit.
    pub(crate) fn laid_on(mut self, heights: &HeightMap) -> Self {
        let [nx, ny, _] = self.size.map(|n| n + 1 - self.kind.least_size());
        self.columns = Columns::new(heights, [nx, ny]);
        self
    }

    /// What the columns say, see [`DistanceMap::laid_on`].
    #[inline]
    pub(crate) fn columns(&self) -> &Columns {
        &self.columns
    }

    /// Voxels, or steps between nodes, per unit of each axis, and the point they count from.
    #[inline]
    pub(crate) fn grid(&self) -> ([f64; 3], [f64; 3]) {
        (self.density, self.domain.low())
    }

    /// The safe distance at a point of a voxel, which is asked for where it matters.
    #[inline]
    pub(crate) fn voxel_distance(&self, voxel: [u32; 3], p: impl Fn() -> [f64; 3]) -> f64 {
        match self.kind {
            DistanceKind::Boxes => self.at(voxel[0], voxel[1], voxel[2]),
            DistanceKind::Corrected | DistanceKind::Published => self.safe_distance(p()),
        }
    }

    /// Position of `p` in steps of the grid, clamped to the domain.
    #[inline]
    fn steps_at(&self, p: [f64; 3]) -> [f64; 3] {
        let (low, high) = (self.domain.low(), self.domain.high());
        std::array::from_fn(|a| (p[a].clamp(low[a], high[a]) - low[a]) * self.density[a])
    }

    /// The voxel that holds `p`, clamped to the domain. For node kinds, the voxel between nodes.
    #[inline]
    pub fn voxel_of(&self, p: [f64; 3]) -> [u32; 3] {
        let (steps, least) = (self.steps_at(p), self.kind.least_size());
        std::array::from_fn(|a| (steps[a] as u32).min(self.size[a] - least))
    }

    /// Lowest and highest corner of a voxel, in stored-cell coordinates and raw height.
    pub fn voxel_bounds(&self, voxel: [u32; 3]) -> ([f64; 3], [f64; 3]) {
        let steps = self.size.map(|n| n + 1 - self.kind.least_size());
        let corner = |a: usize, d: u32| self.domain.division(a, voxel[a] + d, steps[a]);
        (std::array::from_fn(|a| corner(a, 0)), std::array::from_fn(|a| corner(a, 1)))
    }

    /// Stored distances at the corners of the voxel between nodes that holds `p`, and the position
    /// in it.
    #[inline]
    fn corners_at(&self, p: [f64; 3]) -> ([f64; 8], [f64; 3]) {
        let (steps, [i, j, k]) = (self.steps_at(p), self.voxel_of(p));
        let nodes = std::array::from_fn(|at| {
            let at = at as u32;
            self.at(i + (at & 1), j + (at >> 1 & 1), k + (at >> 2))
        });
        let first = [i, j, k];
        (nodes, std::array::from_fn(|a| (steps[a] - f64::from(first[a])).clamp(0.0, 1.0)))
    }
}

/// A map in the making.
struct Build<'a> {
    heights: &'a HeightMap,
    kind: DistanceKind,
    domain: &'a Domain,
    size: [u32; 3],
}

impl Build<'_> {
    fn codes<C: Code>(&self, quantiser: Quantiser) -> Vec<C> {
        let Self { heights, kind, domain, size } = *self;
        match kind {
            DistanceKind::Published => published::codes(heights, domain, size, &quantiser),
            DistanceKind::Boxes => Boxes::new(heights, domain, size).codes(&quantiser),
            DistanceKind::Corrected => {
                let pyramid = &Pyramid::build(heights);
                Nodes { heights, pyramid, domain, size, quantiser }.codes()
            }
        }
    }
}

#[cfg(test)]
mod tests;
