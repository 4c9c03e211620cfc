//! [`Gaps`]: the leaf in sixteen lanes.
//!
//! The formulas are those of `leaf`, operation by operation, so their bits are too. Lanes are either
//! the cells of a block under one ray, or the rays of a packet over one cell: the same function.

use crate::simd::{Lanes, WIDTH};

use super::super::leaf::{Crossings, Gap, LeafHit};
use super::super::map_ray::MapRay;
use super::TileFrame;

/// What the leaf knows of the ray of each lane.
#[derive(Clone, Copy)]
pub(crate) struct LaneRay<L: Lanes> {
    pub o: [L; 2],
    pub d: [L; 2],
    pub inv: [L; 2],
    /// Near and far lines of the tile.
    pub lo: [L; 2],
    pub hi: [L; 2],
    pub oz: L,
    pub dz: L,
    pub cull: [L; 2],
}

/// The Bernstein coefficients of the gap, and which lanes have a root of either direction.
pub(crate) struct Gaps<L: Lanes> {
    t: [L; 2],
    b: [L; 3],
    pub candidates: u16,
}

/// First roots of the lanes that are candidates, where both directions count.
pub(crate) struct Roots<L: Lanes> {
    pub s: L,
    pub from_above: u16,
    /// Lanes whose root this surely is. The others start on the surface, or where the ray starts:
    /// there the leaf itself and the unrounded ray must speak.
    pub sure: u16,
}

/// [`Gaps`] in memory.
pub(crate) struct StoredGaps {
    t: [[f32; WIDTH]; 2],
    b: [[f32; WIDTH]; 3],
}

/// The place in the cell at both ends of a span along one axis.
struct Ends<L: Lanes> {
    t_near: L,
    t_far: L,
    near_line: L,
    far_line: L,
}

impl<L: Lanes> LaneRay<L> {
    /// One ray in all lanes.
    #[inline(always)]
    pub fn of(ray: &MapRay, frame: &TileFrame) -> Self {
        let pair = |[a, b]: [f32; 2]| [L::splat(a), L::splat(b)];
        Self {
            o: pair(ray.o),
            d: pair(ray.d),
            inv: pair(ray.inv),
            lo: pair(frame.lo),
            hi: pair(frame.hi),
            oz: L::splat(ray.oz),
            dz: L::splat(ray.dz),
            cull: pair(ray.cull),
        }
    }

    /// Gaps over forward cells with corners h00, h10, h01, h11.
    #[inline(always)]
    pub fn gaps(&self, cells: [L; 2], corners: [L; 4]) -> Gaps<L> {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let x = self.ends(0, cells[0]);
        let y = self.ends(1, cells[1]);
        let t0 = x.t_near.larger(y.t_near).larger(zero);
        let t1 = x.t_far.smaller(y.t_far).smaller(one);
        let cull = L::and(self.cull[0].at_most(t1), t0.at_most(self.cull[1]));
        let active = L::and(t0.below(t1), cull);
        let (xa, xb) = self.locals(0, cells[0], &x, [t0, t1]);
        let (ya, yb) = self.locals(1, cells[1], &y, [t0, t1]);
        let [h00, h10, h01, h11] = corners;
        let (near_a, far_a) = (lerp(h00, h01, ya), lerp(h10, h11, ya));
        let (near_b, far_b) = (lerp(h00, h01, yb), lerp(h10, h11, yb));
        let (za, zb) = (t0.times(self.dz).plus(self.oz), t1.times(self.dz).plus(self.oz));
        let b0 = za.minus(lerp(near_a, far_a, xa));
        let crossed = lerp(near_b, far_b, xa).plus(lerp(near_a, far_a, xb));
        let b1 = za.plus(zb).minus(crossed).times(L::splat(0.5));
        let b2 = zb.minus(lerp(near_b, far_b, xb));
        // Seen from the side of the start.
        let (start, middle, end) = (b0.turned_by(b0), b1.turned_by(b0), b2.turned_by(b0));
        let dips = L::and(middle.below(zero), zero.at_most(b1.times(b1).minus(b0.times(b2))));
        let root = L::or(L::or(start.at_most(zero), end.at_most(zero)), dips);
        let candidates = L::bits(L::and(active, root));
        Gaps { t: [t0, t1], b: [b0, b1, b2], candidates }
    }

    /// Lines of the cells along one axis, cut to the tile, and their parameters. A cell of the tile
    /// has the lines that the leaf gives it; one beyond has none between them.
    #[inline(always)]
    fn ends(&self, axis: usize, cell: L) -> Ends<L> {
        let (o, inv) = (self.o[axis], self.inv[axis]);
        let near_line = cell.larger(self.lo[axis]);
        let far_line = cell.plus(L::splat(1.0)).smaller(self.hi[axis]);
        Ends {
            t_near: near_line.minus(o).times(inv),
            t_far: far_line.minus(o).times(inv),
            near_line,
            far_line,
        }
    }

    /// Local coordinates where the ray enters and leaves.
    #[inline(always)]
    fn locals(&self, axis: usize, cell: L, ends: &Ends<L>, [t0, t1]: [L; 2]) -> (L, L) {
        let (zero, one) = (L::splat(0.0), L::splat(1.0));
        let d = self.d[axis];
        let start = cell.minus(self.o[axis]);
        let enter = t0.times(d).minus(start).larger(zero).smaller(one);
        let leave = t1.times(d).minus(start).larger(zero).smaller(one);
        (
            ends.near_line.minus(cell).where_else(t0.at_most(ends.t_near), enter),
            ends.far_line.minus(cell).where_else(ends.t_far.at_most(t1), leave),
        )
    }
}

impl<L: Lanes> Gaps<L> {
    /// The roots that `Gap::first_root` finds, by the same operations.
    #[inline(always)]
    pub fn roots(&self) -> Roots<L> {
        let zero = L::splat(0.0);
        let ([t0, t1], [b0, b1, b2]) = (self.t, self.b);
        let root = b1.times(b1).minus(b0.times(b2)).larger(zero).root();
        let (b0, b1, b2, above) =
            (b0.turned_by(b0), b1.turned_by(b0), b2.turned_by(b0), zero.below(b0));
        let falling = b1.at_most(zero);
        let sum = b1.plus(root);
        let top = b0.where_else(falling, sum);
        let bottom = b0.minus(b1).plus(root).where_else(falling, sum.minus(b2));
        let s = top.over(bottom).times(t1.minus(t0)).plus(t0).smaller(t1);
        let sure = L::and(zero.below(b0), zero.below(t0));
        Roots { s, from_above: L::bits(above), sure: L::bits(sure) }
    }

    /// Lanes to be picked one by one.
    #[inline(always)]
    pub fn store(&self) -> StoredGaps {
        let [t0, t1] = self.t;
        let [b0, b1, b2] = self.b;
        StoredGaps { t: [t0.store(), t1.store()], b: [b0.store(), b1.store(), b2.store()] }
    }
}

impl StoredGaps {
    /// The first admitted crossing of a lane with a given forward cell, and where the span begins;
    /// `tile::confirms` has the last word.
    #[inline(always)]
    pub fn hit(&self, lane: usize, cell: [i32; 2], admit: Crossings) -> Option<(f32, LeafHit)> {
        let [t0, t1] = [self.t[0][lane], self.t[1][lane]];
        let gap = Gap { b0: self.b[0][lane], b1: self.b[1][lane], b2: self.b[2][lane] };
        Some((t0, gap.first_hit([t0, t1], cell, admit)?))
    }
}

/// Linear interpolation as `leaf::lerp`.
#[inline(always)]
fn lerp<L: Lanes>(a: L, b: L, t: L) -> L {
    t.times(b).plus(a.minus(t.times(a)))
}
