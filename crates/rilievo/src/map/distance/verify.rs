//! Checks of stored distances against the heights.
//!
//! `boxes`: every voxel asks, by branch and bound over a tree of the columns, whether any column is
//! nearer than its code says, in the same exact integer squares as the transform but without it.
//! `corrected` and `published`: every node's highest safe code is found again from the surface.
//! Codes are as high as they may be when built, so a code raised by one is always found.

use rayon::prelude::*;

use super::boxes::Boxes;
use super::codes::Quantiser;
use super::corrected::Nodes;
use super::{DistanceKind, DistanceMap};
use crate::map::{HeightMap, Pyramid};

/// A stored distance that is not safe, or a map that belongs to other heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DistanceViolation {
    /// The map was made for another grid of cells or another range of heights.
    #[error("the distance map was made for another height map")]
    Heights,
    /// A code above the highest safe one.
    #[error("distance {index:?} has code {stored}, at most {allowed} is safe")]
    Unsafe {
        /// Voxel or node along x, y and z.
        index: [u32; 3],
        /// The stored code.
        stored: u32,
        /// The highest safe code.
        allowed: u32,
    },
}

/// What [`DistanceMap::unsafe_codes`] found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct UnsafeCodes {
    /// How many codes are above the highest safe one.
    pub count: u64,
    /// The first of them in storage order.
    pub first: Option<DistanceViolation>,
}

impl DistanceMap {
    /// Checks every stored distance. A `published` map fails wherever the paper's method errs; count
    /// with [`DistanceMap::unsafe_codes`] there.
    ///
    /// # Errors
    /// [`DistanceViolation`], the first in storage order.
    pub fn verify(&self, heights: &HeightMap, pyramid: &Pyramid) -> Result<(), DistanceViolation> {
        self.unsafe_codes(heights, pyramid)?.first.map_or(Ok(()), Err)
    }

    /// Counts the stored distances above the highest safe code: for `boxes` that of the distance
    /// from the voxel to the columns, for the other kinds that of the node to the surface.
    /// `pyramid` must be that of `heights`.
    ///
    /// # Errors
    /// [`DistanceViolation::Heights`] if the map or the pyramid was made for other heights.
    pub fn unsafe_codes(
        &self,
        heights: &HeightMap,
        pyramid: &Pyramid,
    ) -> Result<UnsafeCodes, DistanceViolation> {
        if !self.fits(heights) || pyramid.cells() != self.domain.cells {
            return Err(DistanceViolation::Heights);
        }
        let quantiser = Quantiser::new(&self.domain, self.quantum, self.codes.bits());
        Ok(match self.kind {
            DistanceKind::Boxes => {
                let boxes = Boxes::new(heights, &self.domain, self.size);
                let tree = ColumnTree::new(&boxes, self.size);
                let quantiser = &quantiser;
                self.count(Vec::new, |stack, voxel, code| {
                    tree.allowed(stack, voxel, Stored { code, quantiser })
                })
            }
            DistanceKind::Corrected | DistanceKind::Published => {
                let (domain, size) = (&self.domain, self.size);
                let nodes = Nodes { heights, pyramid, domain, size, quantiser };
                self.count(|| nodes.search(), |search, node, _| nodes.code(node, search))
            }
        })
    }

    /// Counts codes above `allowed(state, index, stored)`, rows in parallel.
    fn count<S>(
        &self,
        state: impl Fn() -> S + Sync + Send,
        allowed: impl Fn(&mut S, [u32; 3], u32) -> u32 + Sync + Send,
    ) -> UnsafeCodes {
        let [nx, ny, nz] = self.size;
        let rows = (0..ny * nz).into_par_iter().map_init(state, |state, row| {
            let mut found = UnsafeCodes { count: 0, first: None };
            for i in 0..nx {
                let index = [i, row % ny, row / ny];
                let stored = self.code(index);
                // Code 0 is the distance 0: always safe.
                let allowed = if stored == 0 { 0 } else { allowed(state, index, stored) };
                if stored > allowed {
                    found.count += 1;
                    let violation = DistanceViolation::Unsafe { index, stored, allowed };
                    found.first = found.first.or(Some(violation));
                }
            }
            found
        });
        rows.reduce(
            || UnsafeCodes { count: 0, first: None },
            |a, b| UnsafeCodes { count: a.count + b.count, first: a.first.or(b.first) },
        )
    }
}

/// Height intervals of blocks of 4 x 4, 16 x 16 ... columns.
struct ColumnTree<'a> {
    boxes: &'a Boxes,
    size: [u32; 2],
    /// Level 0 are the columns themselves.
    levels: Vec<Grid>,
}

/// A block of a level that may hold a column too near.
#[derive(Clone, Copy)]
struct Block {
    level: usize,
    at: [u32; 2],
}

/// A code under suspicion.
#[derive(Clone, Copy)]
struct Stored<'a> {
    code: u32,
    quantiser: &'a Quantiser,
}

/// Row-major intervals of one level.
struct Grid {
    size: [u32; 2],
    bounds: Vec<(f32, f32)>,
}

impl<'a> ColumnTree<'a> {
    fn new(boxes: &'a Boxes, size: [u32; 3]) -> Self {
        let size = [size[0], size[1]];
        let mut levels = vec![Grid { size, bounds: boxes.columns.bounds().to_vec() }];
        while let Some(below) = levels.last()
            && below.size != [1, 1]
        {
            let size = below.size.map(|n| n.div_ceil(4));
            let mut bounds =
                vec![(f32::INFINITY, f32::NEG_INFINITY); size[0] as usize * size[1] as usize];
            for (at, &(lo, hi)) in below.bounds.iter().enumerate() {
                let (i, j) = (at % below.size[0] as usize / 4, at / below.size[0] as usize / 4);
                let bound = &mut bounds[j * size[0] as usize + i];
                *bound = (bound.0.min(lo), bound.1.max(hi));
            }
            levels.push(Grid { size, bounds });
        }
        Self { boxes, size, levels }
    }

    /// The highest safe code of a voxel, or `stored` if that is safe.
    fn allowed(&self, stack: &mut Vec<Block>, voxel: [u32; 3], stored: Stored<'_>) -> u32 {
        let slab = self.boxes.slab(voxel[2]);
        let clear = self.boxes.steps(stored.quantiser.clear_distance(stored.code));
        let mut allowed = stored.code;
        stack.clear();
        stack.push(Block { level: self.levels.len() - 1, at: [0, 0] });
        while let Some(Block { level, at }) = stack.pop() {
            let grid = &self.levels[level];
            let column = grid.bounds[at[1] as usize * grid.size[0] as usize + at[0] as usize];
            let steps = self.across(0, voxel[0], level, at[0])
                + self.across(1, voxel[1], level, at[1])
                + self.boxes.vertical(slab, column);
            if steps > clear {
                continue;
            }
            let code = stored.quantiser.code(self.boxes.distance(steps));
            if code >= allowed {
                continue;
            }
            if level == 0 {
                allowed = code;
                continue;
            }
            let below = self.levels[level - 1].size;
            for j in 4 * at[1]..(4 * at[1] + 4).min(below[1]) {
                for i in 4 * at[0]..(4 * at[0] + 4).min(below[0]) {
                    stack.push(Block { level: level - 1, at: [i, j] });
                }
            }
        }
        allowed
    }

    /// Squared gap along `axis` between voxel `at` and block `block` of `level`.
    fn across(&self, axis: usize, at: u32, level: usize, block: u32) -> f64 {
        let side = 4u64.pow(level as u32);
        let first = u64::from(block) * side;
        let last = (first + side).min(u64::from(self.size[axis])) - 1;
        let at = u64::from(at);
        let voxels = first.saturating_sub(at).max(at.saturating_sub(last));
        self.boxes.across(axis, voxels.saturating_sub(1) as u32)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fixtures::cases;
    use super::*;
    use crate::map::{Codes, DistanceBits, DistanceOptions, Metric, Procedural};
    use crate::map::{Lattice, Wrap};

    fn raised(map: &DistanceMap, at: usize) -> Option<DistanceMap> {
        let mut parts = map.to_parts();
        match &mut parts.codes {
            Codes::U8(v) => v[at] = v[at].checked_add(1)?,
            Codes::U16(v) => v[at] = v[at].checked_add(1)?,
        }
        Some(DistanceMap::from_parts(parts).unwrap())
    }

    #[test]
    fn any_single_code_raised_by_one_is_caught() {
        for (heights, metric) in cases() {
            let pyramid = Pyramid::build(&heights);
            for (kind, bits) in [
                (DistanceKind::Boxes, DistanceBits::U16),
                (DistanceKind::Boxes, DistanceBits::U8),
                (DistanceKind::Corrected, DistanceBits::U16),
            ] {
                let size = [5, 4, 3];
                let options = DistanceOptions { size, metric, bits };
                let map = DistanceMap::from_height(&heights, kind, &options).unwrap();
                assert_eq!(map.verify(&heights, &pyramid), Ok(()));
                for at in 0..map.codes().len() {
                    let Some(bad) = raised(&map, at) else { continue };
                    let code = map.codes().get(at);
                    let i = at as u32;
                    let index = [i % 5, i / 5 % 4, i / 20];
                    let want = DistanceViolation::Unsafe { index, stored: code + 1, allowed: code };
                    assert_eq!(bad.verify(&heights, &pyramid), Err(want), "{kind:?}");
                }
            }
        }
    }

    #[test]
    fn the_published_map_of_a_step_has_unsafe_codes_and_other_heights_are_told_apart() {
        let step = Procedural::Step.height_map([16, 16], Lattice::Vertex, Wrap::Clamp).unwrap();
        let metric = Metric::of_face(&step, [1.0, 1.0], 1.0);
        let options = DistanceOptions { size: [17, 17, 9], metric, bits: DistanceBits::U16 };
        let kind = DistanceKind::Published;
        let map = DistanceMap::from_height(&step, kind, &options).unwrap();
        let pyramid = Pyramid::build(&step);
        let found = map.unsafe_codes(&step, &pyramid).unwrap();
        assert!(found.count > 100, "{}", found.count);
        assert_eq!(map.verify(&step, &pyramid).err(), found.first);
        let other = Procedural::Ramp.height_map([17, 16], Lattice::Vertex, Wrap::Clamp).unwrap();
        let error = map.verify(&other, &Pyramid::build(&other)).unwrap_err();
        assert_eq!(error, DistanceViolation::Heights);
    }
}
