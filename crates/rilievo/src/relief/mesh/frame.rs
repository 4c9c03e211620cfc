//! [`Frame`]: a ray as a straight line in lattice coordinates, with a bounded remainder.
//!
//! For a centre `c = (x, y, h)` and `d = p - c` the shell map is, exactly,
//!
//! ```text
//! S(p) = S(c) + J d + d_h (N_x d_x + N_y d_y),     J = [P_x + h N_x | P_y + h N_y | N(c)]
//! ```
//!
//! Let `M` be any matrix, in practice the computed inverse of `J` in `f32`, and `q(t) = c + M (O + t D - S(c))`.
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
//! of the triangle's weights, and covers the products, sums and divisions of a clip as well; lattice
//! coordinates have a rounding of their own size. Nothing here is a fixed tolerance: in a moved or
//! scaled scene the terms move and scale along.
//!
//! So a root in the region lies, in coordinates of the straight line, in the region widened by
//! `error`, at the same `t`. Where `J` has no inverse the frame is *blind*: error is infinite and
//! nothing may be left out.
//!
//! **A frame about a part** of the region needs neither vertices nor space. By the above,
//!
//! ```text
//! q(t) - c = G(d) + n,     G(d) = d + d_h (A d_x + B d_y),     |n| <= noise
//! ```
//!
//! where `noise` is all of the error but the bend, with `A`, `B` rounded to `f32` and what that
//! moves counted as noise. `G` is a shell map again, so with a centre `k`, `e = d - k` and
//! `K = dG(k) = [1_x + k_h A | 1_y + k_h B | 1_h + k_x A + k_y B]`
//!
//! ```text
//! G(d) = G(k) + K e + e_h (A e_x + B e_y)
//! ```
//!
//! and for any matrix `W`, in practice the computed inverse of `K`, the line
//! `w(t) = c + k + W (q(t) - c - G(k))` is off `p` by at most
//! `|W K - 1| r + r_h (|W A| r_x + |W B| r_y) + |W| n`. The rounding of `w` is that of `q`, magnified by
//! `W`, once more: `noise` counts twice.

use glam::{DMat3, DVec3};

use super::footprint::MARGIN;
use super::parts::PrismFrame;
use super::prism::Sheet;

/// A linear map of space to lattice coordinates about a centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// Where the centre lies.
    at: DVec3,
    /// `M`, its columns.
    lattice_from_space: [[f32; 3]; 3],
    /// `A` and `B`.
    bend: [[f32; 3]; 2],
    /// Bound on the remainder over the region, per coordinate.
    error: [f32; 3],
    /// What of it is no bend.
    noise: [f32; 3],
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

impl Path {
    /// Of a blind frame.
    pub const BLIND: Self =
        Self { start: DVec3::ZERO, speed: DVec3::ONE, error: DVec3::splat(f64::INFINITY) };

    /// Whether it says nothing.
    #[inline(always)]
    pub fn is_blind(&self) -> bool {
        self.error.x == f64::INFINITY
    }
}

/// Heights of reported roots lie up to this far outside of a region, relative to it; a box is never
/// so small that its sides are not covered as well.
const WIDER: f64 = 1.0 + 1e-3;

/// Larger numbers are taken for infinite.
const MOST: f64 = 1e30;

impl Frame {
    pub const BLIND: Self = Self {
        at: DVec3::ZERO,
        lattice_from_space: [[0.0; 3]; 3],
        bend: [[0.0; 3]; 2],
        error: [f32::INFINITY; 3],
        noise: [f32::INFINITY; 3],
    };

    /// Whether the frame says nothing.
    #[inline(always)]
    pub fn is_blind(&self) -> bool {
        self.error[0] == f32::INFINITY
    }

    /// What it holds, for other backends; nothing if it is blind.
    pub fn parts(&self, centre: DVec3) -> Option<PrismFrame> {
        let Self { at, lattice_from_space, bend, error, noise } = *self;
        (!self.is_blind()).then(|| PrismFrame {
            centre,
            at,
            lattice_from_space: wide(lattice_from_space),
            bend: bend.map(widened),
            error: widened(error),
            noise: widened(noise),
        })
    }

    pub fn about(sheet: &Sheet, centre: DVec3, region: &Region, rounding: f64) -> Self {
        let jacobian = sheet.jacobian(centre);
        let exact = jacobian.inverse();
        let columns = [exact.x_axis, exact.y_axis, exact.z_axis].map(|v| v.as_vec3().to_array());
        // From here on `M` is what is stored.
        let inverse = wide(columns);
        if !inverse.is_finite() {
            return Self::BLIND;
        }
        let (a, b) = (inverse * sheet.rise_along[0], inverse * sheet.rise_along[1]);
        let (half, bend) = match region {
            Region::Triangle(corners, height) => {
                let bend = corners.map(|[x, y]| (a * x + b * y).abs());
                let half = corners.iter().fold(DVec3::ZERO, |half, [x, y]| {
                    half.max(DVec3::new(x.abs() + MARGIN, y.abs() + MARGIN, *height))
                });
                let beyond = MARGIN * (a.abs() + b.abs());
                (half, (bend[0].max(bend[1]).max(bend[2]) + beyond) * *height)
            }
            Region::Box(half) => (*half, (a.abs() * half.x + b.abs() * half.y) * half.z),
        };
        let off = inverse * jacobian - DMat3::IDENTITY;
        let off = off.x_axis.abs() * half.x + off.y_axis.abs() * half.y + off.z_axis.abs() * half.z;
        let stored = [a, b].map(|v| v.as_vec3());
        let moved =
            (a - stored[0].as_dvec3()).abs() * half.x + (b - stored[1].as_dvec3()).abs() * half.y;
        let spread = inverse.x_axis.abs() + inverse.y_axis.abs() + inverse.z_axis.abs();
        let coordinates = 16.0 * f64::EPSILON * (centre.abs() + half);
        let noise = (off + moved * half.z) * WIDER + spread * rounding + coordinates;
        let error = bend * WIDER + noise;
        let usable = error.max_element() < MOST && stored.iter().all(|v| v.is_finite());
        if !usable {
            return Self::BLIND;
        }
        let up = |v: DVec3| v.to_array().map(|x| (x as f32).next_up());
        Self {
            at: sheet.point(centre),
            lattice_from_space: columns,
            bend: stored.map(|v| v.to_array()),
            error: up(error),
            noise: up(noise),
        }
    }

    /// The ray `origin + t direction`; `centre` is that of the frame.
    #[inline(always)]
    pub fn path(&self, centre: DVec3, origin: DVec3, direction: DVec3) -> Path {
        if self.is_blind() {
            return Path::BLIND;
        }
        let lattice_from_space = wide(self.lattice_from_space);
        Path {
            start: centre + lattice_from_space * (origin - self.at),
            speed: lattice_from_space * direction,
            error: widened(self.error),
        }
    }

    /// The map `G` with the first two axes turned by `sign` and `centre` for the frame's.
    #[inline(always)]
    pub fn bent(&self, centre: DVec3, sign: [f64; 2]) -> Bent {
        let turn = DVec3::new(sign[0], sign[1], 1.0);
        Bent {
            centre,
            a: sign[0] * turn * widened(self.bend[0]),
            b: sign[1] * turn * widened(self.bend[1]),
            noise: widened(self.noise),
        }
    }
}

#[inline(always)]
fn wide([x, y, z]: [[f32; 3]; 3]) -> DMat3 {
    DMat3::from_cols(widened(x), widened(y), widened(z))
}

#[inline(always)]
fn widened([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(f64::from(x), f64::from(y), f64::from(z))
}

/// How the paths of a frame bend.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bent {
    centre: DVec3,
    a: DVec3,
    b: DVec3,
    noise: DVec3,
}

impl Bent {
    /// The path of a new frame that is good for a box; `path` is that of the frame itself. It is
    /// blind where there is none.
    #[inline(always)]
    pub fn about(&self, path: &Path, low: DVec3, high: DVec3) -> Path {
        let Self { centre, a, b, noise } = *self;
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let k = middle - centre;
        let along = k.x * a + k.y * b;
        let jacobian = DMat3::from_cols(k.z * a + DVec3::X, k.z * b + DVec3::Y, along + DVec3::Z);
        let bent = k + k.z * along;
        let inverse = jacobian.inverse();
        let off = inverse * jacobian - DMat3::IDENTITY;
        let off = off.x_axis.abs() * half.x + off.y_axis.abs() * half.y + off.z_axis.abs() * half.z;
        let (a, b) = ((inverse * a).abs(), (inverse * b).abs());
        let bend = (a * half.x + b * half.y) * half.z;
        let magnified = inverse.x_axis.abs() * noise.x
            + inverse.y_axis.abs() * noise.y
            + inverse.z_axis.abs() * noise.z;
        let error = (bend + off) * WIDER + 2.0 * magnified + noise;
        // Written so that it is false for NaN.
        if !(error.x < MOST && error.y < MOST && error.z < MOST) {
            return Path::BLIND;
        }
        Path {
            start: middle + inverse * (path.start - centre - bent),
            speed: inverse * path.speed,
            error,
        }
    }
}

/// The part of `[from, to]` in which something that is `short` at 0 of what it must be at least, and grows
/// by `speed`, is enough; `t` is `short / speed`.
#[inline(always)]
pub(super) fn keep([from, to]: [f64; 2], t: f64, speed: f64, short: f64) -> [f64; 2] {
    let (later, sooner) = ((speed > 0.0) & (t > from), (speed < 0.0) & (t < to));
    let never = (speed == 0.0) & (short > 0.0);
    let to = if sooner { t } else { to };
    [if later { t } else { from }, if never { f64::NEG_INFINITY } else { to }]
}

impl Path {
    /// The part of a span in which the path is between `low` and `high`, widened, on an axis.
    #[inline(always)]
    pub fn within(&self, [from, to]: [f64; 2], axis: usize, [low, high]: [f64; 2]) -> [f64; 2] {
        let (start, speed, error) = (self.start[axis], self.speed[axis], self.error[axis]);
        let (low, high) = (low - error - start, high + error - start);
        let inverse = 1.0 / speed;
        let (a, b) = (low * inverse, high * inverse);
        let (near, far) = if a < b { (a, b) } else { (b, a) };
        let (moves, outside) = (speed != 0.0, (low > 0.0) | (high < 0.0));
        let to = if moves & (far < to) { far } else { to };
        let never = !moves & outside;
        [
            if moves & (near > from) { near } else { from },
            if never { f64::NEG_INFINITY } else { to },
        ]
    }

    #[inline(always)]
    pub fn at(&self, t: f64) -> DVec3 {
        self.start + t * self.speed
    }
}
