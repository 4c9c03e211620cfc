//! [`Nodes`]: one ray against the sixteen children of a node.

use crate::map::{Code, Pyramid};
use crate::simd::{Lanes, Mirror, WIDTH};

use super::super::leaf;
use super::super::map_ray::MapRay;
use super::super::tile::Tile;

/// Offsets of the lines of a node's blocks from its corner, cells: near and far lines in x and y.
struct Lines {
    near: [[f32; WIDTH]; 2],
    far: [[f32; WIDTH]; 2],
}

/// Levels that a map of 2^24 cells a side has.
const LEVELS: usize = 12;

/// The lines of every level.
static LINES: [Lines; LEVELS] = {
    const NONE: Lines = Lines { near: [[0.0; WIDTH]; 2], far: [[0.0; WIDTH]; 2] };
    let mut table = [NONE; LEVELS];
    let mut k = 0;
    while k < LEVELS * WIDTH {
        let (level, lane) = (k / WIDTH, k % WIDTH);
        let side = 4u64 << (2 * level);
        let lines = &mut table[level];
        let place = [lane as u64 % 4, lane as u64 / 4];
        let mut axis = 0;
        while axis < 2 {
            lines.near[axis][lane] = (place[axis] * side) as f32;
            lines.far[axis][lane] = ((place[axis] + 1) * side) as f32;
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

/// A ray in a tile, ready to be tested against nodes.
pub(super) struct Nodes<'a, L: Lanes> {
    pyramid: &'a Pyramid,
    code: Code,
    o: [L; 2],
    inv: [L; 2],
    dz: L,
    /// Height at the start, less and plus the slack of the cull.
    oz: [L; 2],
    /// The part of the ray worth walking in this tile.
    part: [L; 2],
    sinks: L::Mask,
    /// Mirrored index of the tile's forward line 0, and the mirror itself, 0 or -1.
    origin: [i32; 2],
    turn: [i32; 2],
    mirror: Mirror,
    /// Whether the ray may be below the surface.
    both: bool,
    enter: f32,
    leave: f32,
}

impl<'a, L: Lanes> Nodes<'a, L> {
    #[inline(always)]
    pub fn new(pyramid: &'a Pyramid, ray: &MapRay, tile: &Tile) -> Self {
        let slack = 2.0 * leaf::slack(ray.size);
        let (enter, leave) = (tile.enter.max(ray.cull[0]), tile.leave.min(ray.cull[1]));
        let turn = [tile.axes[0].mirror(), tile.axes[1].mirror()];
        Self {
            pyramid,
            code: pyramid.code(),
            o: ray.o.map(L::splat),
            inv: ray.inv.map(L::splat),
            dz: L::splat(ray.dz),
            oz: [L::splat(ray.oz - slack), L::splat(ray.oz + slack)],
            part: [L::splat(enter), L::splat(leave)],
            sinks: L::all(ray.dz < 0.0),
            origin: [tile.axes[0].mirrored_origin(), tile.axes[1].mirrored_origin()],
            turn,
            mirror: Mirror { x: turn[0] != 0, y: turn[1] != 0 },
            both: !ray.above,
            enter,
            leave,
        }
    }

    /// The start of a climb, if the ray starts in this tile and in the height range.
    #[inline(always)]
    pub fn start(&self, ray: &MapRay, tile: &Tile) -> Option<Start> {
        if self.enter > 0.0 {
            return None;
        }
        let limit = |axis: usize, f: i32| f.clamp(tile.axes[axis].from, tile.axes[axis].to - 1);
        let cell = [0, 1].map(|axis| limit(axis, ray.cell_of_start(axis)));
        // One cell more than the rounded end is enough: see `MapRay::cell_at`.
        let end = [0, 1].map(|axis| {
            limit(axis, (ray.o[axis] + self.leave * ray.d[axis]) as i32 + 1)
        });
        let differing = (cell[0] + self.origin[0]) ^ (end[0] + self.origin[0])
            | (cell[1] + self.origin[1]) ^ (end[1] + self.origin[1]);
        // Level l holds both if they agree above its 4 + 2 l low bits.
        let bits = 32 - differing.leading_zeros();
        let last_level = bits.saturating_sub(3) / 2;
        Some(Start { cell: [0, 1].map(|axis| cell[axis] + self.origin[axis]), last_level })
    }

    /// The children that the ray may meet of the node of `level` that holds a mirrored cell.
    #[inline(always)]
    pub fn met(&self, level: u32, cell: [i32; 2]) -> u16 {
        let shift = 2 * level + 4;
        let node = [0, 1].map(|axis| cell[axis] >> shift);
        let base = [0, 1].map(|axis| {
            L::splat(((node[axis] << shift) - self.origin[axis]) as f32)
        });
        let lines = &LINES[level as usize % LEVELS];
        let t = |axis: usize, offsets: &[f32; WIDTH]| {
            base[axis].plus(L::load(offsets)).minus(self.o[axis]).times(self.inv[axis])
        };
        let [enter, leave] = self.part;
        let near = t(0, &lines.near[0]).larger(enter).larger(t(1, &lines.near[1]));
        let far = t(0, &lines.far[0]).smaller(leave).smaller(t(1, &lines.far[1]));

        let at = self.pyramid.level(level);
        let stored = [0, 1].map(|axis| (node[axis] ^ self.turn[axis]) as u32);
        let index = (stored[1] * at.nodes[0] + stored[0]) as usize;
        let value = |codes: &[u16; WIDTH]| {
            let codes = L::from_u16(codes, self.mirror);
            L::splat(self.code.base).plus(codes.times(L::splat(self.code.step)))
        };
        let low = far.where_else(self.sinks, near).times(self.dz).plus(self.oz[0]);
        let mut met = L::and(near.below(far), low.at_most(value(&at.max[index])));
        if self.both {
            let high = near.where_else(self.sinks, far).times(self.dz).plus(self.oz[1]);
            met = L::and(met, value(&at.min[index]).at_most(high));
        }
        L::bits(met)
    }
}
