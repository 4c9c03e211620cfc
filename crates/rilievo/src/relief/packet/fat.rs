//! [`FatRay`]: bounds of the rays of a packet, against the children of a node.
//!
//! Per axis the lowest and highest start, reciprocal direction, height and slope of height. Every
//! operation of the node test of one ray is monotone in each of these, also as rounded; so the fat
//! ray's near parameter is at most that of any ray, its far parameter at least, and its lowest height
//! at most. What it passes by, all rays pass by. Starts are counted in the first ray's frame: the
//! difference of two frames is a whole number of cells, subtracted with one rounding, and the result
//! is moved outward by one step of the float.

use crate::map::Pyramid;
use crate::simd::{Lanes, Mirror, WIDTH};

use super::super::map_ray::{step_down, step_up};
use super::super::walk::{LINES, PLACES, Side, bound, culled_heights};
use super::Packet;

/// The bounds of a packet.
pub(super) struct FatRay<'a> {
    pyramid: &'a Pyramid,
    /// See [`Packet::origin`], [`Packet::turn`].
    origin: [i32; 2],
    turn: [i32; 2],
    /// Lowest and highest.
    o: [[f32; 2]; 2],
    inv: [[f32; 2]; 2],
    dz: [f32; 2],
    /// With the slack of the cull.
    oz: [f32; 2],
    /// First parameter that any ray is worth walking at, and the last.
    part: [f32; 2],
    /// First and last line of the map, forward in the first ray's frame.
    map: [[f32; 2]; 2],
    /// Whether any ray may be below the surface.
    both: bool,
}

/// Parameters between which some ray may be between two lines.
struct Between<L: Lanes> {
    near: L,
    far: L,
}

impl<'a> FatRay<'a> {
    #[inline(always)]
    pub fn new<L: Lanes>(rays: &Packet<'_>, pyramid: &'a Pyramid) -> Self {
        let lanes = &rays.batch.lanes;
        let (origin, turn) = (rays.origin(), rays.turn());
        let map = |k: usize| {
            let cells = pyramid.cells()[k] as i32;
            let first = (turn[k] & -cells) - origin[k];
            [first as f32, (first + cells) as f32]
        };
        let inv = [L::load(&lanes.inv[0]), L::load(&lanes.inv[1])];
        let part = [L::load(&lanes.part[0]), L::load(&lanes.part[1])];
        Self {
            pyramid,
            o: [starts::<L>(rays, 0), starts::<L>(rays, 1)],
            inv: [range(inv[0]), range(inv[1])],
            dz: range(L::load(&lanes.dz)),
            oz: culled_heights(range(L::load(&lanes.oz)), rays.batch.size()),
            part: [part[0].least(), part[1].greatest()],
            map: [map(0), map(1)],
            both: rays.any_may_be_below(),
            origin,
            turn,
        }
    }

    /// The children that some ray may meet of the node of `level` that holds a mirrored cell.
    #[inline(always)]
    pub fn met<L: Lanes>(&self, level: u32, [x, y]: [i32; 2]) -> u16 {
        let shift = 2 * level + 4;
        let (x, y) = (x >> shift, y >> shift);
        let lines = &LINES[level as usize % LINES.len()];
        let line = |k: usize, g: i32, of: &[i32; WIDTH]| L::wholes(g - self.origin[k], of);
        let (x_near, x_far) =
            (line(0, x << shift, &lines.near[0]), line(0, x << shift, &lines.far[0]));
        let (y_near, y_far) =
            (line(1, y << shift, &lines.near[1]), line(1, y << shift, &lines.far[1]));
        let (tx, ty) = (self.between(0, x_near, x_far), self.between(1, y_near, y_far));
        let [enter, leave] = self.part;
        let near = tx.near.larger(L::splat(enter)).larger(ty.near);
        let far = tx.far.smaller(L::splat(leave)).smaller(ty.far);
        // The fat ray may reach beyond the map where no ray does.
        let on_map = L::and(self.on_map(0, x_near, x_far), self.on_map(1, y_near, y_far));

        let [nodes_x, _] = self.pyramid.nodes(level);
        let [turn_x, turn_y] = self.turn;
        let index = (y ^ turn_y) as usize * nodes_x as usize + (x ^ turn_x) as usize;
        let (node, mirror) = ((level, index), Mirror::of(self.turn));
        let [dz_low, dz_high] = self.dz;
        let lowest = if dz_low < 0.0 { far } else { near };
        let lowest = lowest.times(L::splat(dz_low)).plus(L::splat(self.oz[0]));
        let max: L = bound(self.pyramid, node, mirror, Side::Upper);
        let mut met = L::and(L::and(near.below(far), on_map), lowest.at_most(max));
        if self.both {
            let highest = if dz_high < 0.0 { near } else { far };
            let highest = highest.times(L::splat(dz_high)).plus(L::splat(self.oz[1]));
            let min: L = bound(self.pyramid, node, mirror, Side::Lower);
            met = L::and(met, min.at_most(highest));
        }
        L::bits(met)
    }

    /// The cells that some ray may cross of the block at a mirrored cell.
    #[inline(always)]
    pub fn cells<L: Lanes>(&self, [x, y]: [i32; 2]) -> u16 {
        let one = L::splat(1.0);
        let x = L::splat((x - self.origin[0]) as f32).plus(L::load(&PLACES[0]));
        let y = L::splat((y - self.origin[1]) as f32).plus(L::load(&PLACES[1]));
        let (tx, ty) = (self.between(0, x, x.plus(one)), self.between(1, y, y.plus(one)));
        let [enter, leave] = self.part;
        let near = tx.near.larger(L::splat(enter)).larger(ty.near);
        let far = tx.far.smaller(L::splat(leave)).smaller(ty.far);
        L::bits(near.at_most(far))
    }

    #[inline(always)]
    fn between<L: Lanes>(&self, axis: usize, near: L, far: L) -> Between<L> {
        let [o_low, o_high] = self.o[axis];
        let [inv_low, inv_high] = self.inv[axis];
        let (inv_low, inv_high) = (L::splat(inv_low), L::splat(inv_high));
        let near = near.minus(L::splat(o_high));
        let far = far.minus(L::splat(o_low));
        Between {
            near: near.times(inv_low).smaller(near.times(inv_high)),
            far: far.times(inv_low).larger(far.times(inv_high)),
        }
    }

    #[inline(always)]
    fn on_map<L: Lanes>(&self, axis: usize, near: L, far: L) -> L::Mask {
        let [first, last] = self.map[axis];
        L::and(L::splat(first).below(far), near.below(L::splat(last)))
    }
}

/// The least and the greatest of some numbers.
#[inline(always)]
fn range<L: Lanes>(of: L) -> [f32; 2] {
    [of.least(), of.greatest()]
}

/// The lowest and the highest start in the first ray's frame.
#[inline(always)]
fn starts<L: Lanes>(rays: &Packet<'_>, axis: usize) -> [f32; 2] {
    let own = L::load(&rays.batch.lanes.o[axis]);
    let [low, high] = range(own.minus(L::load(&rays.shift[axis])));
    [step_down(low), step_up(high)]
}
