//! [`Pyramid`]: bounds of the heights over blocks of cells, the renderer's own accelerator.
//!
//! **Shape.** A *block* of level `l` is a square of `4 * 4^l` stored cells a side; a *node* of level
//! `l` holds the bounds of its 4 x 4 blocks, lane `4 y + x`. The blocks of level `l + 1` are the
//! nodes of level `l`. The topmost level has one node. Cells themselves have no bounds: the leaf
//! tests the 16 cells of a level-0 block from the heights (an implicit maximum mipmap
//! \[Tevs2008\] with its two last levels left out: 0.27 byte a texel instead of 5.3).
//!
//! **Bounds.** Maxima and minima are `u16` codes in separate arrays, so that a ray known to run
//! above the surface reads 32 bytes a node. `value = base + code * step`, evaluated in `f32`. For
//! `u16` heights base is 0 and step 1: the bounds are exact. For `f32` heights codes are rounded
//! outward: the smallest code whose value is not below the maximum, the largest whose value is not
//! above the minimum. Either way every code is *tight*: one step less cuts the surface, which is
//! what [`Pyramid::verify`] looks for.
//!
//! A block's samples are all corners of its cells, border samples shared with the neighbours
//! included. Since a bilinear cell lies between its lowest and highest corner, a block's surface
//! lies between its bounds. Lanes beyond the map hold an empty interval (max 0, min 65535).
//!
//! **Measured** (one core, release, 4096 x 4096 u16, 2026-11): see docs/METHODS.md.

mod verify;

use rayon::prelude::*;

use super::height::{HeightMap, Samples};
use super::lattice::Axis;

pub use verify::PyramidViolation;

/// Children a node has, and blocks along one side of a node.
pub(crate) const LANES: usize = 16;

/// Sixteen bounds of one node, lane `4 y + x`.
pub type Bounds = [u16; LANES];

/// One level of a [`Pyramid`].
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Level {
    /// Nodes along x and y.
    pub nodes: [u32; 2],
    /// Upper bounds, nodes row-major.
    pub max: Vec<Bounds>,
    /// Lower bounds, nodes row-major.
    pub min: Vec<Bounds>,
}

/// Min-max pyramid over the stored cells of a height map.
#[derive(Clone, Debug, PartialEq)]
pub struct Pyramid {
    cells: [u32; 2],
    levels: Vec<Level>,
    code: Code,
}

/// The affine code of a bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Code {
    /// Value of code 0.
    pub base: f32,
    /// Value of one code step; 1 for `u16` heights, at least 0.
    pub step: f32,
}

impl Code {
    /// The code for a map's range of raw values.
    fn for_heights(heights: &HeightMap) -> Self {
        let (lo, hi) = heights.raw_range();
        match heights.samples() {
            Samples::U16(_) => Self { base: 0.0, step: 1.0 },
            Samples::F32(_) => {
                let mut step = (hi - lo) / 65535.0;
                while lo + 65535.0 * step < hi {
                    step = step.next_up();
                }
                Self { base: lo, step }
            }
        }
    }

    /// The raw value of a code.
    #[inline]
    pub fn value(&self, code: u16) -> f32 {
        self.base + f32::from(code) * self.step
    }

    /// The smallest code whose value is not below `raw`.
    fn above(&self, raw: f32) -> u16 {
        let mut code = self.estimate(raw);
        while code > 0 && self.value(code - 1) >= raw {
            code -= 1;
        }
        while code < u16::MAX && self.value(code) < raw {
            code += 1;
        }
        code
    }

    /// The largest code whose value is not above `raw`.
    fn below(&self, raw: f32) -> u16 {
        let mut code = self.estimate(raw);
        while code < u16::MAX && self.value(code + 1) <= raw {
            code += 1;
        }
        while code > 0 && self.value(code) > raw {
            code -= 1;
        }
        code
    }

    fn estimate(&self, raw: f32) -> u16 {
        if self.step > 0.0 { ((raw - self.base) / self.step).clamp(0.0, 65535.0) as u16 } else { 0 }
    }
}

impl Pyramid {
    /// The pyramid of a height map; parallel over rows of nodes, the same for any thread count.
    pub fn build(heights: &HeightMap) -> Self {
        let code = Code::for_heights(heights);
        let cells = [heights.x().cells(), heights.y().cells()];
        let ground = match heights.samples() {
            Samples::U16(v) => ground_level(heights, v, |lo, hi| (lo, hi)),
            Samples::F32(v) => ground_level(heights, v, |lo, hi| (code.below(lo), code.above(hi))),
        };
        let mut levels = vec![ground];
        while let Some(top) = levels.last()
            && top.nodes != [1, 1]
        {
            let next = coarser_level(top);
            levels.push(next);
        }
        Self { cells, levels, code }
    }

    /// A pyramid from stored levels, finest first, as a file holds them.
    ///
    /// # Errors
    /// [`PyramidViolation`] if the levels do not fit the heights or a bound cuts the surface.
    pub fn from_levels(levels: Vec<Level>, heights: &HeightMap) -> Result<Self, PyramidViolation> {
        let cells = [heights.x().cells(), heights.y().cells()];
        let pyramid = Self { cells, levels, code: Code::for_heights(heights) };
        pyramid.verify(heights)?;
        Ok(pyramid)
    }

    /// Stored cells along x and y.
    #[inline]
    pub fn cells(&self) -> [u32; 2] {
        self.cells
    }

    /// Number of levels, at least 1.
    #[inline]
    pub fn levels(&self) -> u32 {
        self.levels.len() as u32
    }

    /// One level; 0 is the finest.
    ///
    /// # Panics
    /// If there is no such level.
    #[inline]
    pub fn level(&self, level: u32) -> &Level {
        &self.levels[level as usize]
    }

    /// The code of the bounds.
    #[inline]
    pub fn code(&self) -> Code {
        self.code
    }

    /// Number of blocks of a level along x and y; a block is `4 * 4^level` stored cells a side.
    pub fn blocks(&self, level: u32) -> [u32; 2] {
        self.cells.map(|c| c.div_ceil(4 << (2 * level)))
    }

    /// Raw (minimum, maximum) of block (bx, by) of a level.
    ///
    /// # Panics
    /// If there is no such block.
    #[inline]
    pub fn bounds(&self, level: u32, bx: u32, by: u32) -> (f32, f32) {
        let at = &self.levels[level as usize];
        let node = (by / 4 * at.nodes[0] + bx / 4) as usize;
        let lane = (by % 4 * 4 + bx % 4) as usize;
        (self.code.value(at.min[node][lane]), self.code.value(at.max[node][lane]))
    }

    /// Bytes held by the bounds.
    pub fn bytes(&self) -> u64 {
        self.levels.iter().map(|l| 4 * LANES as u64 * l.max.len() as u64).sum()
    }

    /// Bytes that the pyramid of a map with these stored cells takes.
    pub fn predicted_bytes(cells: [u32; 2]) -> u64 {
        let mut side = 16u64;
        let mut bytes = 0;
        loop {
            let nodes = cells.map(|c| u64::from(c).div_ceil(side));
            bytes += 4 * LANES as u64 * nodes[0] * nodes[1];
            if nodes == [1, 1] {
                return bytes;
            }
            side *= 4;
        }
    }
}

/// Samples that the stored cells `from..to` of an axis touch: an inclusive range, and the sample
/// reached by wrapping, if any.
fn samples_of(axis: &Axis, from: u32, to: u32) -> (usize, usize, Option<usize>) {
    let (first, _) = axis.corners(from);
    let (near, far) = axis.corners(to - 1);
    if far < near {
        (first as usize, near as usize, Some(far as usize))
    } else {
        (first as usize, far as usize, None)
    }
}

/// Level 0: per row of blocks, minima and maxima of whole sample rows first, then of columns.
fn ground_level<T, F>(heights: &HeightMap, samples: &[T], encode: F) -> Level
where
    T: Copy + PartialOrd + Send + Sync,
    F: Fn(T, T) -> (u16, u16) + Sync,
{
    let (x, y) = (heights.x(), heights.y());
    let width = heights.width() as usize;
    let nodes = [x.cells().div_ceil(16), y.cells().div_ceil(16)];
    let count = nodes[0] as usize * nodes[1] as usize;
    let mut level =
        Level { nodes, max: vec![[0; LANES]; count], min: vec![[u16::MAX; LANES]; count] };
    let rows = level
        .max
        .par_chunks_mut(nodes[0] as usize)
        .zip(level.min.par_chunks_mut(nodes[0] as usize))
        .enumerate();
    rows.for_each(|(node_y, (max_row, min_row))| {
        let mut low = Vec::with_capacity(width);
        let mut high = Vec::with_capacity(width);
        for lane_y in 0..4 {
            let from = node_y as u32 * 16 + lane_y * 4;
            if from >= y.cells() {
                break;
            }
            let (first, last, wrapped) = samples_of(y, from, (from + 4).min(y.cells()));
            let row = |j: usize| &samples[j * width..(j + 1) * width];
            low.clear();
            low.extend_from_slice(row(first));
            high.clear();
            high.extend_from_slice(row(first));
            for j in (first + 1..=last).chain(wrapped) {
                for ((lo, hi), &h) in low.iter_mut().zip(&mut high).zip(row(j)) {
                    *lo = if h < *lo { h } else { *lo };
                    *hi = if h > *hi { h } else { *hi };
                }
            }
            for block in 0..x.cells().div_ceil(4) {
                let cell = block * 4;
                let (first, last, wrapped) = samples_of(x, cell, (cell + 4).min(x.cells()));
                let (mut lo, mut hi) = (low[first], high[first]);
                for i in (first + 1..=last).chain(wrapped) {
                    lo = if low[i] < lo { low[i] } else { lo };
                    hi = if high[i] > hi { high[i] } else { hi };
                }
                let (lo, hi) = encode(lo, hi);
                let (node, lane) = ((block / 4) as usize, (lane_y * 4 + block % 4) as usize);
                min_row[node][lane] = lo;
                max_row[node][lane] = hi;
            }
        }
    });
    level
}

/// The level above `fine`: sixteen-fold reductions of its nodes.
fn coarser_level(fine: &Level) -> Level {
    let nodes = fine.nodes.map(|n| n.div_ceil(4));
    let count = nodes[0] as usize * nodes[1] as usize;
    let mut level =
        Level { nodes, max: vec![[0; LANES]; count], min: vec![[u16::MAX; LANES]; count] };
    for y in 0..fine.nodes[1] {
        for x in 0..fine.nodes[0] {
            let from = (y * fine.nodes[0] + x) as usize;
            let to = (y / 4 * nodes[0] + x / 4) as usize;
            let lane = (y % 4 * 4 + x % 4) as usize;
            level.max[to][lane] = fine.max[from].iter().copied().max().unwrap_or(0);
            level.min[to][lane] = fine.min[from].iter().copied().min().unwrap_or(u16::MAX);
        }
    }
    level
}

#[cfg(test)]
mod tests {
    use super::super::lattice::{Lattice, Wrap};
    use super::*;

    fn noise(k: usize) -> u32 {
        let mut x = (k as u32).wrapping_mul(0x9E37_79B9) ^ 0x85EB_CA6B;
        x ^= x >> 16;
        x = x.wrapping_mul(0x7FEB_352D);
        x ^ (x >> 15)
    }

    pub(super) fn maps() -> Vec<HeightMap> {
        let mut maps = Vec::new();
        for (w, h) in [(2, 2), (5, 3), (17, 16), (70, 33), (65, 64)] {
            for lattice in [Lattice::Vertex, Lattice::Texel] {
                for wrap in [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror] {
                    let n = w * h;
                    let codes = (0..n).map(|k| noise(k) as u16).collect();
                    let floats = (0..n).map(|k| noise(k) as f32 * 1e-6 - 1500.0).collect();
                    for samples in [Samples::U16(codes), Samples::F32(floats)] {
                        let map = HeightMap::new(w as u32, h as u32, samples, lattice, wrap);
                        maps.push(map.unwrap());
                    }
                }
            }
        }
        maps
    }

    /// Exact range of the corners of a block, cell by cell.
    fn range(map: &HeightMap, level: u32, bx: u32, by: u32) -> (f32, f32) {
        let side = 4u32 << (2 * level);
        let mut range = (f32::INFINITY, f32::NEG_INFINITY);
        for cy in by * side..((by + 1) * side).min(map.y().cells()) {
            for cx in bx * side..((bx + 1) * side).min(map.x().cells()) {
                for h in map.stored_corners(cx, cy) {
                    range = (range.0.min(h), range.1.max(h));
                }
            }
        }
        range
    }

    #[test]
    fn bounds_are_those_of_the_cells_and_tight() {
        for map in maps() {
            let pyramid = Pyramid::build(&map);
            assert_eq!(pyramid.bytes(), Pyramid::predicted_bytes(pyramid.cells()));
            for level in 0..pyramid.levels() {
                let [nx, ny] = pyramid.blocks(level);
                for (bx, by) in (0..ny).flat_map(|by| (0..nx).map(move |bx| (bx, by))) {
                    let (lo, hi) = pyramid.bounds(level, bx, by);
                    let (want_lo, want_hi) = range(&map, level, bx, by);
                    assert!(lo <= want_lo && hi >= want_hi, "block cuts the surface");
                    let slack = pyramid.code().step * if level == 0 { 1.0 } else { 1.001 };
                    assert!(want_lo - lo <= slack && hi - want_hi <= slack, "bound is loose");
                    if matches!(map.samples(), Samples::U16(_)) {
                        assert_eq!((lo, hi), (want_lo, want_hi));
                    }
                }
            }
            assert_eq!(pyramid.verify(&map), Ok(()));
        }
    }

    #[test]
    fn a_flat_float_map_has_a_pyramid() {
        let samples = Samples::F32(vec![-3.25; 6]);
        let map = HeightMap::new(2, 3, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
        let pyramid = Pyramid::build(&map);
        assert_eq!(pyramid.bounds(0, 0, 0), (-3.25, -3.25));
    }
}
