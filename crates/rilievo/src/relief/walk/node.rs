//! [`Nodes`]: one ray against the sixteen children of a node.

use crate::map::{Pyramid, SideBounds};
use crate::simd::{Lanes, Mirror, WIDTH};

use super::super::leaf;
use super::super::map_ray::{MapRay, larger, smaller, step_down, step_up};
use super::TileFrame;

/// Offsets of the lines of a node's blocks from its corner, cells: near and far lines in x and y.
pub(crate) struct Lines {
    pub near: [[i32; WIDTH]; 2],
    pub far: [[i32; WIDTH]; 2],
}

/// Levels that a map of 2^24 cells a side has.
const LEVELS: usize = 12;

/// The lines of every level; filled up to a power of two, so that an index needs no check.
pub(crate) static LINES: [Lines; 16] = {
    const NONE: Lines = Lines { near: [[0; WIDTH]; 2], far: [[0; WIDTH]; 2] };
    let mut table = [NONE; 16];
    let mut k = 0;
    while k < LEVELS * WIDTH {
        let (level, lane) = (k / WIDTH, k % WIDTH);
        let side = 4u64 << (2 * level);
        let lines = &mut table[level];
        let place = [lane as u64 % 4, lane as u64 / 4];
        let mut axis = 0;
        while axis < 2 {
            lines.near[axis][lane] = (place[axis] * side) as i32;
            lines.far[axis][lane] = ((place[axis] + 1) * side) as i32;
            axis += 1;
        }
        k += 1;
    }
    table
};

/// Where a climb begins.
#[derive(Clone, Copy, Debug)]
pub(super) struct Start {
    /// The ray's own cell, mirrored.
    pub cell: [i32; 2],
    /// Level of the smallest node that holds this cell and the ray's end.
    pub last_level: u32,
}

/// Which bounds.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) enum Side {
    Upper,
    Lower,
}

/// A ray in a tile, ready to be tested against nodes.
pub(super) struct Nodes<'a> {
    pyramid: &'a Pyramid,
    ray: &'a MapRay,
    frame: &'a TileFrame,
    /// Height at the start, less and plus the slack of the cull.
    oz: [f32; 2],
    /// The part of the ray worth walking in this tile.
    part: [f32; 2],
    /// Whether the ray may start below the surface.
    both: bool,
}

impl<'a> Nodes<'a> {
    #[inline(always)]
    pub fn new(pyramid: &'a Pyramid, ray: &'a MapRay, frame: &'a TileFrame) -> Self {
        Self {
            pyramid,
            ray,
            frame,
            oz: culled_heights([ray.oz; 2], ray.size),
            part: [larger(frame.enter, ray.cull[0]), smaller(frame.leave, ray.cull[1])],
            both: !ray.above,
        }
    }

    /// The start of a climb, if the ray starts in this tile and in the height range.
    #[inline(always)]
    pub fn start(&self) -> Option<Start> {
        let [enter, leave] = self.part;
        if enter > 0.0 {
            return None;
        }
        let ((x, x_end), (y, y_end)) = (self.ends(0, leave), self.ends(1, leave));
        // Level l holds both if they agree above its 4 + 2 l low bits.
        let bits = 32 - ((x ^ x_end) | (y ^ y_end)).leading_zeros();
        Some(Start { cell: [x, y], last_level: bits.saturating_sub(3) / 2 })
    }

    /// Mirrored cells that hold the ray's start and its end, or lie beyond it, on the map.
    #[inline(always)]
    fn ends(&self, axis: usize, leave: f32) -> (i32, i32) {
        let cells = self.pyramid.cells()[axis] as i32;
        let (origin, turn) = (self.frame.origin[axis], self.frame.turn[axis]);
        // Stored cells 0..cells are mirrored cells -cells..0 if turned.
        let first = turn & -cells;
        let on_map = |g: i32| g.max(first).min(first + cells - 1);
        // The start is in forward cell 0. Rounding stays below one cell: coordinates are below 2^23.
        let end = (self.ray.o[axis] + leave * self.ray.d[axis]) as i32 + 1;
        (on_map(origin), on_map(origin + end))
    }

    /// The children that the ray may meet of the node of `level` that holds a mirrored cell.
    #[inline(always)]
    pub fn met<L: Lanes>(&self, level: u32, [x, y]: [i32; 2]) -> u16 {
        let shift = 2 * level + 4;
        let (x, y) = (x >> shift, y >> shift);
        let lines = &LINES[level as usize % LINES.len()];
        let (x_near, x_far) = self.times::<L>(0, x << shift, lines);
        let (y_near, y_far) = self.times::<L>(1, y << shift, lines);
        let [enter, leave] = self.part;
        let near = x_near.larger(L::splat(enter)).larger(y_near);
        let far = x_far.smaller(L::splat(leave)).smaller(y_far);

        let [nodes_x, _] = self.pyramid.nodes(level);
        let index =
            ((y ^ self.frame.turn[1]) as u32 * nodes_x + (x ^ self.frame.turn[0]) as u32) as usize;
        let (node, mirror) = ((level, index), self.frame.mirror());
        let (dz, sinks) = (L::splat(self.ray.dz), L::all(self.ray.dz < 0.0));
        let lowest = far.where_else(sinks, near).times(dz).plus(L::splat(self.oz[0]));
        let mut met =
            L::and(near.below(far), lowest.at_most(bound(self.pyramid, node, mirror, Side::Upper)));
        if self.both {
            let highest = near.where_else(sinks, far).times(dz).plus(L::splat(self.oz[1]));
            let min: L = bound(self.pyramid, node, mirror, Side::Lower);
            met = L::and(met, min.at_most(highest));
        }
        L::bits(met)
    }

    /// Parameters of the near and far lines of a node's children; the node begins at `line`.
    #[inline(always)]
    fn times<L: Lanes>(&self, axis: usize, line: i32, lines: &Lines) -> (L, L) {
        let base = line - self.frame.origin[axis];
        let (o, inv) = (L::splat(self.ray.o[axis]), L::splat(self.ray.inv[axis]));
        (
            L::wholes(base, &lines.near[axis]).minus(o).times(inv),
            L::wholes(base, &lines.far[axis]).minus(o).times(inv),
        )
    }
}

/// Lowest and highest start heights, moved outward by the slack of the cull and a step of the float;
/// see the proof at the head of `walk`. `size` is the largest magnitude of a raw height of the map.
#[inline(always)]
pub(crate) fn culled_heights([low, high]: [f32; 2], size: f32) -> [f32; 2] {
    let slack = 2.0 * leaf::slack(size);
    [step_down(low - slack), step_up(high + slack)]
}

/// Upper or lower bounds of the children of a node, raw heights, mirrored.
#[inline(always)]
pub(crate) fn bound<L: Lanes>(
    pyramid: &Pyramid,
    (level, index): (u32, usize),
    mirror: Mirror,
    side: Side,
) -> L {
    let code = pyramid.code();
    let codes = match pyramid.side(level, index, side == Side::Upper) {
        SideBounds::Wide(codes) => L::from_u16(codes, mirror),
        SideBounds::Tiny { steps, base, step } => {
            L::splat(base).plus(L::from_u8(steps, mirror).times(L::splat(step)))
        }
    };
    L::splat(code.base).plus(codes.times(L::splat(code.step)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The proof's edge: a start far above or below the map, whose float is coarser than the slack.
    #[test]
    fn culled_heights_stay_a_slack_away_from_those_of_the_leaf() {
        let mut state = 7u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for size in [65535.0f32, 1.0, 3286.0, 1e-3] {
            let slack = leaf::slack(size);
            for reach in [1.0, 3.0, 1e3, 1e6] {
                for _ in 0..50_000 {
                    let oz = (2.0 * next() - 1.0) * reach * size;
                    let s = next().max(1e-3);
                    // A ray that comes to a height of the map at s.
                    let dz = ((2.0 * next() - 1.0) * size - oz) / s;
                    let z = s * dz + oz;
                    let [low, high] = culled_heights([oz; 2], size).map(|oz| s * dz + oz);
                    if z.abs() <= 2.0 * size {
                        assert!(low <= z - slack && high >= z + slack, "{oz} {s} {dz}");
                    }
                }
            }
        }
    }
}
