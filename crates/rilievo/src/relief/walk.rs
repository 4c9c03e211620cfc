//! Method `pyramid`: descent of the min-max pyramid, front to back.
//!
//! **Order.** In the forward frame a path rises in x and in y, so lane `4 y + x` rises along it:
//! the lowest set bit of a node's hit mask is the child met first. No sorting and no stored
//! parameters. Because the intervals of children tile their node's, the first hit found is the
//! nearest.
//!
//! **No miss.** A child is visited unless its interval is empty or the ray's height over that
//! interval, widened by the leaf's slack, stays outside the child's bounds. The height
//! `z(s) = s dz + oz` is monotone in floating point, so over any cell of the child it lies within
//! the two ends as computed; the leaf's proof (see `leaf`) says that such a cell has no root. The
//! interval is cut to `cull` here but not in the leaf: outside `cull` the ray is clear of the whole
//! map's range by more than the slack, or past its own end.

use crate::map::{HeightMap, NodeBounds, Pyramid};
use crate::probe::Probe;

use super::leaf::{self, Crossings, LeafHit, Span};
use super::map_ray::{MapRay, larger, smaller};
use super::tile::{Tile, TileAxis};

/// Deepest pyramid: 2^24 cells a side take 12 levels of a factor 4 above 4 x 4 cells.
const MAX_LEVELS: usize = 12;

/// The first admitted crossing in a tile, found through the pyramid.
pub(crate) fn walk_pyramid<P: Probe>(
    (map, pyramid): (&HeightMap, &Pyramid),
    ray: &MapRay,
    tile: &Tile,
    admit: Crossings,
    probe: &mut P,
) -> Option<LeafHit> {
    let descent = Descent::new(map, pyramid, ray, tile);
    let top = pyramid.levels() as usize - 1;
    let mut todo = [0u16; MAX_LEVELS];
    let mut node = [[0i32; 2]; MAX_LEVELS];
    let mut level = top;
    probe.node();
    todo[level] = descent.hit_mask(level as u32, node[level]);
    loop {
        if todo[level] == 0 {
            if level == top {
                return None;
            }
            level += 1;
            continue;
        }
        let lane = todo[level].trailing_zeros() as i32;
        todo[level] &= todo[level] - 1;
        let block = descent.block_of_lane(node[level], lane);
        if level == 0 {
            if let Some(hit) = descent.walk_block(block, admit, probe) {
                return Some(hit);
            }
        } else {
            level -= 1;
            node[level] = block;
            probe.node();
            todo[level] = descent.hit_mask(level as u32, block);
        }
    }
}

/// What stays the same during one descent.
struct Descent<'a> {
    map: &'a HeightMap,
    pyramid: &'a Pyramid,
    ray: &'a MapRay,
    tile: &'a Tile,
    /// The tile's lines, the window's own where they are nearer.
    lo: [f32; 2],
    hi: [f32; 2],
    /// Forward lane to stored lane, per axis: 0 or 3.
    flip: [i32; 2],
    slack: f32,
}

impl<'a> Descent<'a> {
    fn new(map: &'a HeightMap, pyramid: &'a Pyramid, ray: &'a MapRay, tile: &'a Tile) -> Self {
        let (low, high) = map.raw_range();
        let axes = &tile.axes;
        Self {
            map,
            pyramid,
            ray,
            tile,
            lo: [0, 1].map(|a| (axes[a].from as f32).max(ray.lo[a])),
            hi: [0, 1].map(|a| (axes[a].to as f32).min(ray.hi[a])),
            flip: [0, 1].map(|a| if axes[a].down { 3 } else { 0 }),
            slack: leaf::slack(low.abs().max(high.abs())),
        }
    }

    /// The stored block behind a forward lane of a node.
    #[inline]
    fn block_of_lane(&self, node: [i32; 2], lane: i32) -> [i32; 2] {
        [node[0] * 4 + ((lane & 3) ^ self.flip[0]), node[1] * 4 + ((lane >> 2) ^ self.flip[1])]
    }

    /// Parameters of the five lines of the four columns (or rows) of a node, forward.
    #[inline]
    fn times(&self, axis: usize, node: i32, side: i32) -> [f32; 5] {
        let start = self.tile.axes[axis].forward_start(node * 4 * side, 4 * side);
        let (lo, hi) = (self.lo[axis], self.hi[axis]);
        let mut times = [0.0; 5];
        for (k, time) in times.iter_mut().enumerate() {
            let line = (start + k as i32 * side) as f32;
            *time = self.ray.t(axis, smaller(larger(line, lo), hi));
        }
        times
    }

    /// Forward lanes of a node whose block the ray may meet. Lanes are independent, in loops that
    /// a compiler turns into vectors.
    #[inline]
    fn hit_mask(&self, level: u32, node: [i32; 2]) -> u16 {
        let side = 4i32 << (2 * level);
        let (x, y) = (self.times(0, node[0], side), self.times(1, node[1], side));
        let across = self.pyramid.nodes(level)[0] as usize;
        let index = node[1] as usize * across + node[0] as usize;
        let [max, min] = NodeBounds::codes(&self.pyramid.node(level, index));
        let code = self.pyramid.code();
        let [enter, leave] = self.ray.cull;
        let stored = (self.flip[0] | self.flip[1] << 2) as usize;
        let mut mask = 0;
        for row in 0..4 {
            let mut hit = [false; 4];
            for (column, hit) in hit.iter_mut().enumerate() {
                let t0 = larger(larger(x[column], y[row]), enter);
                let t1 = smaller(smaller(x[column + 1], y[row + 1]), leave);
                let (za, zb) = (self.ray.z(t0), self.ray.z(t1));
                let lane = (row * 4 + column) ^ stored;
                *hit = (t0 <= t1)
                    & (smaller(za, zb) - self.slack <= code.value_f32(max[lane]))
                    & (larger(za, zb) + self.slack >= code.value_f32(min[lane]));
            }
            for (column, hit) in hit.into_iter().enumerate() {
                mask |= u16::from(hit) << (row * 4 + column);
            }
        }
        mask
    }

    /// Shows the cells of a level-0 block to the leaf, front to back.
    fn walk_block<P: Probe>(
        &self,
        block: [i32; 2],
        admit: Crossings,
        probe: &mut P,
    ) -> Option<LeafHit> {
        let start = [0, 1].map(|axis| self.tile.axes[axis].forward_start(block[axis] * 4, 4));
        let range = |axis: usize| {
            let TileAxis { from, to, .. } = self.tile.axes[axis];
            start[axis].max(from)..(start[axis] + 4).min(to)
        };
        for fy in range(1) {
            for fx in range(0) {
                let Some(span) = Span::new(self.ray, fx, fy) else {
                    continue;
                };
                if span.t0 > self.ray.cull[1] || span.t1 < self.ray.cull[0] {
                    continue;
                }
                probe.cell();
                let hit = self.tile.intersect(self.map, self.ray, ([fx, fy], &span), admit);
                if hit.is_some() {
                    return hit;
                }
            }
        }
        None
    }
}
