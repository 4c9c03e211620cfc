//! [`Frame`]: a ray as a straight line in lattice coordinates, with a bounded remainder.
//!
//! For a centre `c = (x, y, h)` and `d = p - c` the shell map is, exactly,
//!
//! ```text
//! S(p) = S(c) + J d + d_h (N_x d_x + N_y d_y),     J = [P_x + h N_x | P_y + h N_y | N(c)]
//! ```
//!
//! Let `M` be any matrix, in practice the computed inverse of `J`, and `q(t) = c + M (O + t D - S(c))`.
//! If the ray meets the shell at `p` and `t`, then `O + t D = S(p)`, so
//!
//! ```text
//! q(t) - p = (M J - 1) d + d_h (M N_x d_x + M N_y d_y)
//! ```
//!
//! whose size over a region of half sizes `r` is at most `|M J - 1| r + r_h max |A d_x + B d_y|` with
//! `A = M N_x`, `B = M N_y`. To this comes the rounding of `q` itself: all points involved have
//! coordinates up to `reach`, the sum has few terms, and `M` turns a distance of `rounding` into
//! `|M| rounding`; `Prism::rounding` is 64 units in the last place of `reach`, times the condition
//! of the triangle's weights, and covers the products, sums and divisions of a clip as well. Nothing here
//! is a fixed tolerance: in a moved or scaled scene the terms move and scale along.
//!
//! So a root in the region lies, in coordinates of the straight line, in the region widened by
//! `error`, at the same `t`. Where `J` has no inverse the frame is *blind*: error is infinite and
//! nothing may be left out.

use glam::{DMat3, DVec3};

use super::footprint::MARGIN;
use super::prism::Sheet;

/// A linear map of space to lattice coordinates about a centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    centre: DVec3,
    /// Where the centre lies.
    at: DVec3,
    lattice_from_space: DMat3,
    /// Bound on the remainder over the region, per coordinate.
    error: DVec3,
}

/// What a frame has to be good for, about its centre.
pub(super) enum Region {
    /// A triangle by its corners, and half a range of heights.
    Triangle([[f64; 2]; 3], f64),
    /// A box by half its sizes.
    Box(DVec3),
}

/// A ray in a frame: `start + t speed`, off by at most `error`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Path {
    pub start: DVec3,
    pub speed: DVec3,
    pub error: DVec3,
}

/// Heights of reported roots lie up to this far outside of a region, relative to it; a box is never
/// so small that its sides are not covered as well.
const WIDER: f64 = 1.0 + 1e-3;

impl Frame {
    pub const BLIND: Self = Self {
        centre: DVec3::ZERO,
        at: DVec3::ZERO,
        lattice_from_space: DMat3::ZERO,
        error: DVec3::INFINITY,
    };

    /// Whether the frame says nothing.
    #[inline]
    pub fn is_blind(&self) -> bool {
        self.error.x == f64::INFINITY
    }

    pub fn about(sheet: &Sheet, centre: DVec3, region: &Region, rounding: f64) -> Self {
        let jacobian = sheet.jacobian(centre);
        let inverse = jacobian.inverse();
        if !inverse.is_finite() {
            return Self::BLIND;
        }
        let (a, b) = (inverse * sheet.rise_along[0], inverse * sheet.rise_along[1]);
        let (half, bend) = match region {
            Region::Triangle(corners, height) => {
                let bend = corners.map(|[x, y]| (a * x + b * y).abs());
                let half = corners.iter().fold(DVec3::ZERO, |half, [x, y]| {
                    half.max(DVec3::new(x.abs(), y.abs(), *height))
                });
                let beyond = MARGIN * (a.abs() + b.abs());
                (half, (bend[0].max(bend[1]).max(bend[2]) + beyond) * *height)
            }
            Region::Box(half) => (*half, (a.abs() * half.x + b.abs() * half.y) * half.z),
        };
        let off = inverse * jacobian - DMat3::IDENTITY;
        let off = off.x_axis.abs() * half.x + off.y_axis.abs() * half.y + off.z_axis.abs() * half.z;
        let spread = inverse.x_axis.abs() + inverse.y_axis.abs() + inverse.z_axis.abs();
        let error = (bend + off) * WIDER + spread * rounding;
        let error = if error.is_finite() && error.z < 1e30 { error } else { DVec3::INFINITY };
        Self { centre, at: sheet.point(centre), lattice_from_space: inverse, error }
    }

    /// The ray `origin + t direction`.
    #[inline]
    pub fn path(&self, origin: DVec3, direction: DVec3) -> Path {
        Path {
            start: self.centre + self.lattice_from_space * (origin - self.at),
            speed: self.lattice_from_space * direction,
            error: self.error,
        }
    }
}

/// The part of `[from, to]` in which `start + t speed >= least`.
#[inline]
pub(super) fn keep([from, to]: [f64; 2], start: f64, speed: f64, least: f64) -> [f64; 2] {
    let short = least - start;
    if speed > 0.0 {
        let t = short / speed;
        [if t > from { t } else { from }, to]
    } else if speed < 0.0 {
        let t = short / speed;
        [from, if t < to { t } else { to }]
    } else if short > 0.0 {
        [from, f64::NEG_INFINITY]
    } else {
        [from, to]
    }
}

impl Path {
    /// The part of a span in which the path is between `low` and `high`, widened, on an axis.
    #[inline]
    pub fn within(&self, span: [f64; 2], axis: usize, [low, high]: [f64; 2]) -> [f64; 2] {
        let (start, speed, error) = (self.start[axis], self.speed[axis], self.error[axis]);
        let span = keep(span, start, speed, low - error);
        keep(span, -start, -speed, -high - error)
    }

    #[inline]
    pub fn at(&self, t: f64) -> DVec3 {
        self.start + t * self.speed
    }
}
