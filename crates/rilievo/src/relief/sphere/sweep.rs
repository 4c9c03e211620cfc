//! [`Sweep`]: a segment against the sixteen children of a node, or the sixteen cells of a block.
//!
//! **Bound.** A ray that comes from outside passes a block if its distance from the centre, over the
//! whole of the block, is larger than the block's highest radius; one that comes from inside, if it is
//! smaller than the lowest, less what flat cells sink (`radii`). That distance is `N / q` with `N^2` a
//! quadratic in s, decreasing up to the point closest to the centre and increasing from there. So
//! one comparison decides, without root or division, and no curvature is lost: the bound of a block is
//! a part of a shell around the centre. With `m` the middle of all radii `r`, it is
//!
//! ```text
//! N^2 - m^2 q^2  against  (r - m) (r + m) q^2
//! ```
//!
//! in units of `n^2`: both sides are small where the relief is thin, and both are known to a
//! fraction of their own size. They are computed in lanes of `f32`.
//!
//! **No miss (proof).** Lines: a node's corner counts from the cell in which the segment begins, a whole
//! number, exact; what is left of the start is off by 2^-25 of a cell and moved outward by [`CELL`];
//! the rounding of difference, reciprocal and product is some 3 * 2^-24 of s, at most 1 where it
//! matters, and intervals are widened by [`PART`]. Bounds: with `M` the sum of the magnitudes of the
//! quadratic's coefficients and of the largest `(r - m)(r + m) q^2` before any cancellation, either
//! side is off by at most 16 * 2^-24 M; [`Sweep::slack`] is 2^-19 M, and on top of it what [`Radii`] asks
//! for: its slack of 2^-40 of `N^2`, and below the surface what flat cells sink.
//!
//! Over a block left out the true ray is therefore on one side of the surface by more than 2^-42 of q.
//! The leaf's coefficients are off by some 2^-50 of q, so the least value of its quadratic, which is
//! that of the true gap but for this, keeps its sign, and so does the discriminant: nothing is
//! reported there. A ray from outside is outside up to its first crossing: one side is enough.

use super::radii::Radii;
use super::segment::Segment;
use crate::relief::Relief;
use crate::relief::walk::{PLACES, Side, block_corners, bound};
use crate::simd::{Lanes, Mirror};

/// By how much lines are moved outward, cells.
const CELL: f64 = 1.0 / (1u64 << 23) as f64;

/// By how much intervals are widened, in s.
const PART: f32 = 1.0 / (1u64 << 21) as f32;

/// The part of a segment that is of interest.
#[derive(Clone, Copy, Debug)]
pub(super) struct Range {
    /// Whether the ray comes from outside.
    pub outside: bool,
    /// Where it is closest to the centre.
    pub nearest: f64,
    /// How far to look.
    pub end: f64,
}

/// A segment made ready for lanes. Cells are mirrored, so that both coordinates grow along it: cell
/// `!i` in place of `i`.
pub(super) struct Sweep<'a> {
    relief: &'a Relief,
    pub mirror: Mirror,
    /// All ones for a mirrored axis.
    pub turn: [i32; 2],
    /// The mirrored cell that holds the start.
    base: [i32; 2],
    /// The start in that cell, a little farther for near lines, a little less far for far ones.
    near: [f32; 2],
    far: [f32; 2],
    inverse: [f32; 2],
    nearest: f32,
    end: f32,
    outside: bool,
    side: Side,
    /// `(N^2 - m^2 q^2) / n^2` and `m q / n`, by powers of s.
    level: [f32; 3],
    q: [f32; 2],
    slack: f32,
    /// `(r - m) / m` at raw height 0, and its change for one raw unit.
    at_zero: f32,
    per_raw: f32,
}

impl<'a> Sweep<'a> {
    #[inline(always)]
    pub fn new(segment: &Segment<'_>, relief: &'a Relief, radii: &Radii, range: Range) -> Self {
        let Range { outside, nearest, end } = range;
        let backward = [segment.slope[0] < 0.0, segment.slope[1] < 0.0];
        let (mut turn, mut base) = ([0; 2], [0; 2]);
        let (mut near, mut far, mut inverse) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        for k in 0..2 {
            turn[k] = -i32::from(backward[k]);
            let start = if backward[k] { -segment.origin[k] } else { segment.origin[k] };
            base[k] = start.floor() as i32;
            let left = start - start.floor();
            (near[k], far[k]) = ((left + CELL) as f32, (left - CELL) as f32);
            // Beyond this a line is met at once or not at all.
            inverse[k] = segment.inverse[k].abs().min(1e30) as f32;
        }
        let n = f64::from(radii.cells);
        let (per_square, m) = (1.0 / (n * n), radii.middle);
        let [q0, q1] = [0.0, 1.0].map(|s| segment.q(s) * (m / n));
        let (q, dq) = (q0, q1 - q0);
        let [c, b, a] = segment.square();
        let level =
            [c * per_square - q * q, b * per_square - 2.0 * q * dq, a * per_square - dq * dq];
        let most = q0.max(q1) * q0.max(q1);
        let (at_zero, per_raw) = ((radii.at_zero - m) / m, radii.per_raw / m);
        let height = at_zero.abs() + (per_raw * radii.largest_raw).abs();
        let size = level[0].abs() + level[1].abs() + level[2].abs();
        let size = size + 2.0 * height * (1.0 + height) * most;
        let beyond = if outside {
            4.0 * (radii.above - 1.0)
        } else {
            let highest = radii.highest / m;
            1.25 * (1.0 - radii.below) * highest * highest * most
        };
        Self {
            relief,
            mirror: Mirror { x: backward[0], y: backward[1] },
            turn,
            base,
            near,
            far,
            inverse,
            nearest: nearest as f32,
            end: end as f32 + PART,
            outside,
            side: if outside == (radii.per_raw > 0.0) { Side::Upper } else { Side::Lower },
            level: level.map(|c| c as f32),
            q: [q as f32, dq as f32],
            slack: (2.0f64.powi(-19) * size + beyond) as f32,
            at_zero: at_zero as f32,
            per_raw: per_raw as f32,
        }
    }

    /// The children that the ray may meet of a node, mirrored, that stands on the map.
    #[inline(always)]
    pub fn node<L: Lanes>(&self, level: u32, [x, y]: [i32; 2]) -> u16 {
        let pyramid = self.relief.pyramid();
        let across = pyramid.nodes(level)[0];
        let stored = [(x ^ self.turn[0]) as u32, (y ^ self.turn[1]) as u32];
        let index = (stored[1] * across + stored[0]) as usize;
        let raw: L = bound(pyramid, (level, index), self.mirror, self.side);
        let shift = 4 + 2 * level;
        self.reached([x << shift, y << shift], (1 << (shift - 2)) as f32, raw)
    }

    /// The cells that the ray may meet the surface in of a block, mirrored, that begins on the map.
    #[inline(always)]
    pub fn block<L: Lanes>(&self, corner: [i32; 2]) -> u16 {
        let [a, b, c, d] = block_corners::<L>(self.relief.heights(), self.mirror, corner);
        let raw = match self.side {
            Side::Upper => a.larger(b).larger(c.larger(d)),
            Side::Lower => a.smaller(b).smaller(c.smaller(d)),
        };
        self.reached(corner, 1.0, raw)
    }

    /// The squares of `side` cells, 4 x 4 of them from a mirrored cell on, with these highest or lowest
    /// raw heights, that the ray may meet the surface in.
    #[inline(always)]
    fn reached<L: Lanes>(&self, corner: [i32; 2], side: f32, raw: L) -> u16 {
        let (x_near, x_far) = self.lines::<L>(0, corner[0], side);
        let (y_near, y_far) = self.lines::<L>(1, corner[1], side);
        let none = L::splat(0.0);
        let enter = x_near.larger(y_near).larger(none);
        let leave = x_far.smaller(y_far).smaller(L::splat(self.end));
        let crossed = enter.at_most(leave);
        let all = L::splat(1.0 + PART);
        let (enter, leave) = (enter.smaller(all), leave.larger(none));
        let height = raw.times(L::splat(self.per_raw)).plus(L::splat(self.at_zero));
        let limit = height.times(height.plus(L::splat(2.0)));
        let slack = L::splat(self.slack);
        let reaches = if self.outside {
            let at = L::splat(self.nearest).larger(enter).smaller(leave);
            let (level, q) = self.at(at);
            level.at_most(limit.times(q.times(q)).plus(slack))
        } else {
            let ((near, q), (far, p)) = (self.at(enter), self.at(leave));
            L::or(
                limit.times(q.times(q)).at_most(near.plus(slack)),
                limit.times(p.times(p)).at_most(far.plus(slack)),
            )
        };
        L::bits(L::and(crossed, reaches))
    }

    /// Where the segment enters and leaves four columns or rows.
    #[inline(always)]
    fn lines<L: Lanes>(&self, axis: usize, corner: i32, side: f32) -> (L, L) {
        let first = L::splat((corner - self.base[axis]) as f32);
        let line = L::load(&PLACES[axis]).times(L::splat(side)).plus(first);
        let (inverse, part) = (L::splat(self.inverse[axis]), L::splat(PART));
        let near = line.minus(L::splat(self.near[axis])).times(inverse);
        let far = line.plus(L::splat(side)).minus(L::splat(self.far[axis])).times(inverse);
        (near.minus(part), far.plus(part))
    }

    /// `(N^2 - m^2 q^2) / n^2` and `m q / n` at s.
    #[inline(always)]
    fn at<L: Lanes>(&self, s: L) -> (L, L) {
        let [c, b, a] = [L::splat(self.level[0]), L::splat(self.level[1]), L::splat(self.level[2])];
        let (q, dq) = (L::splat(self.q[0]), L::splat(self.q[1]));
        (s.times(a).plus(b).times(s).plus(c), s.times(dq).plus(q))
    }
}
