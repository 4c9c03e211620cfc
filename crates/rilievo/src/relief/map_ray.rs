//! [`MapRay`]: a ray in the frame in which a relief is walked.
//!
//! **Frame.** A face maps world to *lattice space* by an affine map: x and y in unfolded cells, z
//! in raw heights. Affine maps keep the ray parameter, so nothing depends on the face's size or
//! depth. The walk uses a parameter `s` that runs from 0 to 1 over the part of the ray inside the
//! face's box (a margin wider than the window and the height range), and counts cells from the
//! cell in which that part starts: every number the leaf handles is small near the start, and
//! rounding errors grow with the distance travelled, not with the map or the distance of the
//! camera.
//!
//! **Mirroring.** Along an axis with a negative direction, cells are counted backward:
//! `f = base - 1 - i` and `x' = base - x`. In the *forward* frame directions are never negative,
//! cells are met in rising order of `fx` and of `fy`, and mirroring is exact.
//!
//! **Grid lines.** The parameter of a line is `T(line) = (line - o) * inv`, from the line's integer
//! index by one subtraction and one multiplication. Both are monotone in floating point, hence so
//! is T: the intervals `[T(f), T(f + 1)]` nest and tile with no tolerance (no increment is ever
//! accumulated). `inv = 1 / max(d, 1e-30)` keeps 0 * inf out.
//!
//! **Precision.** Building the ray is `f64`; only the finished numbers are rounded to `f32`. The
//! walk decides in `f32`; the answer is refined in `f64` from [`MapRay::exact`].

/// The larger of two numbers, neither NaN: one instruction, where `f32::max` takes three.
#[inline(always)]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, neither NaN.
#[inline(always)]
pub(crate) fn smaller(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}

/// The next float below one that is finite or infinite upward: `f32::next_down` without its branches,
/// which no loop over rays becomes vectors with.
#[inline(always)]
pub(crate) fn step_down(x: f32) -> f32 {
    let bits = (if x == 0.0 { -0.0 } else { x }).to_bits();
    f32::from_bits(if x > 0.0 { bits - 1 } else { bits + 1 })
}

/// The next float above one that is finite or infinite downward.
#[inline(always)]
pub(crate) fn step_up(x: f32) -> f32 {
    -step_down(-x)
}

/// A ray in the forward frame of a relief walk.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapRay {
    /// Start, in cells from the start cell; in `[0, 1]` unless the face is passed far outside.
    pub o: [f32; 2],
    /// Direction per `s`, cells; never negative.
    pub d: [f32; 2],
    /// `1 / max(d, 1e-30)`.
    pub inv: [f32; 2],
    /// Raw height at `s = 0`.
    pub oz: f32,
    /// Raw height per `s`.
    pub dz: f32,
    /// Forward cell `f` is unfolded cell `base + f`, or `base - 1 - f` if backward.
    pub base: [i32; 2],
    /// Axes along which cells are counted backward.
    pub backward: [bool; 2],
    /// The window's near and far lines, forward.
    pub lo: [f32; 2],
    /// See `lo`.
    pub hi: [f32; 2],
    /// Part of `0..1` outside which the ray is clear of the height range or past its own end; for
    /// culling only, never shown to the leaf.
    pub cull: [f32; 2],
    /// The ray's own end; infinite if it lies beyond the face's box.
    pub end: f32,
    /// Largest magnitude of a raw height of the map.
    pub size: f32,
    /// Whether the ray surely starts above the surface.
    pub above: bool,
    /// The same ray before rounding.
    pub exact: ExactRay,
}

/// A ray in lattice space, unrounded: `x, y, z = origin + s * direction`, absolute unfolded
/// coordinates; world parameter `t = t_start + s * t_length`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ExactRay {
    pub origin: [f64; 3],
    pub direction: [f64; 3],
    pub t_start: f64,
    pub t_length: f64,
}

/// The window of a face in lattice space: `u, v` in `[0, 1]`, absolute unfolded coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    pub lo: [f64; 2],
    pub hi: [f64; 2],
}

impl Window {
    /// Largest magnitude of a coordinate.
    pub fn farthest(&self) -> f64 {
        self.lo.iter().chain(&self.hi).fold(0.0, |far, x| far.max(x.abs()))
    }
}

/// One axis of a [`MapRay`].
pub(crate) struct AxisRay {
    pub o: f32,
    pub d: f32,
    pub inv: f32,
    pub base: i32,
    pub backward: bool,
    pub lo: f32,
    pub hi: f32,
}

impl AxisRay {
    /// Rounds one axis of an exact ray in a window `[lo, hi]`. Counting backward is counting forward in the
    /// mirror, without a branch: signs are turned, and what was low is high.
    #[inline(always)]
    pub fn new(origin: f64, direction: f64, [lo, hi]: [f64; 2]) -> Self {
        // A ray in the plane of the far border is counted backward too: borders are closed.
        let backward = (direction < 0.0) | ((direction == 0.0) & (origin == hi));
        let (sign, near, far) = if backward { (-1.0, -hi, -lo) } else { (1.0, lo, hi) };
        let start = sign * origin;
        let base = start.floor();
        let d = direction.abs() as f32;
        Self {
            o: (start - base) as f32,
            d,
            inv: 1.0 / larger(d, 1e-30),
            base: whole(sign * base),
            backward,
            lo: (near - base) as f32,
            hi: (far - base) as f32,
        }
    }

    /// Parameters at which the ray enters and leaves the window along this axis.
    #[inline(always)]
    pub fn span(&self) -> [f32; 2] {
        [(self.lo - self.o) * self.inv, (self.hi - self.o) * self.inv]
    }
}

/// `1.5 * 2^52`: adding it leaves no room for a fraction, and the low bits count wholes.
const WHOLE: f64 = 6_755_399_441_055_744.0;

/// A whole number below 2^31 in size: in vectors too, for which a cast that saturates has no
/// instruction.
#[inline(always)]
fn whole(x: f64) -> i32 {
    (x + WHOLE).to_bits() as i32
}

/// The part of `0..1` worth walking, rounded outward.
#[inline(always)]
pub(crate) fn rounded_cull([first, last]: [f64; 2]) -> [f32; 2] {
    [larger(step_down(first as f32), 0.0), smaller(step_up(last as f32), 1.0)]
}

/// Whether a ray surely starts above a surface of raw heights in `range`.
#[inline(always)]
pub(crate) fn surely_above(z: f64, lift: f64, range: [f64; 2]) -> bool {
    (lift > 0.0) | (z > range[1])
}

impl MapRay {
    /// Rounds an exact ray into the forward frame. `lift` is added to the height at the start;
    /// `cull` is the part of `0..1` worth walking, `end` the ray's own end; `range` is that of the map's raw heights.
    #[inline(always)]
    pub fn new(
        exact: ExactRay,
        window: &Window,
        (lift, range): (f64, [f64; 2]),
        (cull, end): ([f64; 2], f64),
    ) -> Self {
        let axis = |k: usize| {
            AxisRay::new(exact.origin[k], exact.direction[k], [window.lo[k], window.hi[k]])
        };
        let (x, y) = (axis(0), axis(1));
        Self {
            o: [x.o, y.o],
            d: [x.d, y.d],
            inv: [x.inv, y.inv],
            oz: (exact.origin[2] + lift) as f32,
            dz: exact.direction[2] as f32,
            base: [x.base, y.base],
            backward: [x.backward, y.backward],
            lo: [x.lo, y.lo],
            hi: [x.hi, y.hi],
            cull: rounded_cull(cull),
            end: end as f32,
            size: range[0].abs().max(range[1].abs()) as f32,
            above: surely_above(exact.origin[2], lift, range),
            exact,
        }
    }

    /// Parameter at which the ray meets a line of an axis.
    #[inline]
    pub fn t(&self, axis: usize, line: f32) -> f32 {
        (line - self.o[axis]) * self.inv[axis]
    }

    /// Near line of forward cell `f`, the window's own line at its border.
    #[inline]
    pub fn near_line(&self, axis: usize, f: i32) -> f32 {
        larger(f as f32, self.lo[axis])
    }

    /// Far line of forward cell `f`, the window's own line at its border.
    #[inline]
    pub fn far_line(&self, axis: usize, f: i32) -> f32 {
        smaller((f + 1) as f32, self.hi[axis])
    }

    /// Parameter of the near line of forward cell `f`.
    #[inline]
    pub fn t_near(&self, axis: usize, f: i32) -> f32 {
        self.t(axis, self.near_line(axis, f))
    }

    /// Parameter of the far line of forward cell `f`.
    #[inline]
    pub fn t_far(&self, axis: usize, f: i32) -> f32 {
        self.t(axis, self.far_line(axis, f))
    }

    /// Height at `s`.
    #[inline]
    pub fn z(&self, s: f32) -> f32 {
        s * self.dz + self.oz
    }

    /// First forward cell that the window touches.
    #[inline]
    pub fn first_cell(&self, axis: usize) -> i32 {
        self.lo[axis].floor() as i32
    }

    /// One past the last forward cell that the window touches.
    #[inline]
    pub fn end_cell(&self, axis: usize) -> i32 {
        self.hi[axis].ceil() as i32
    }

    /// The forward cell `f` of the window with `T(f) <= s < T(f + 1)`; the nearest cell of the
    /// window if there is none.
    #[inline(always)]
    pub fn cell_at(&self, axis: usize, s: f32) -> i32 {
        let (first, last) = (self.first_cell(axis), self.end_cell(axis) - 1);
        let guess = (self.o[axis] + s * self.d[axis]).floor() as i32;
        let mut f = guess.clamp(first, last);
        while f > first && self.t(axis, f as f32) > s {
            f -= 1;
        }
        while f < last && self.t(axis, (f + 1) as f32) <= s {
            f += 1;
        }
        f
    }

    /// The forward cell `f` of the window with `T(f) < s <= T(f + 1)`: the one the ray is in just
    /// before `s`.
    pub fn cell_before(&self, axis: usize, s: f32) -> i32 {
        let mut f = self.cell_at(axis, s);
        while f > self.first_cell(axis) && self.t(axis, f as f32) >= s {
            f -= 1;
        }
        f
    }

    /// The unfolded cell behind forward cell `f`.
    #[inline]
    pub fn unfolded(&self, axis: usize, f: i32) -> i32 {
        if self.backward[axis] { self.base[axis] - 1 - f } else { self.base[axis] + f }
    }

    /// The unfolded lattice line behind forward line `f`.
    #[inline]
    pub fn unfolded_line(&self, axis: usize, f: i32) -> i32 {
        if self.backward[axis] { self.base[axis] - f } else { self.base[axis] + f }
    }

    /// Parameters at which the ray enters and leaves the window after `s = 0`; it passes it by unless
    /// the first is below the second.
    #[inline(always)]
    pub fn window_span(&self) -> (f32, f32) {
        let enter = larger(larger(self.t(0, self.lo[0]), self.t(1, self.lo[1])), 0.0);
        let leave = smaller(smaller(self.t(0, self.hi[0]), self.t(1, self.hi[1])), 1.0);
        (enter, leave)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_those_of_the_library() {
        let tiny = f32::from_bits(1);
        let mut numbers = vec![0.0, tiny, f32::MIN_POSITIVE, 1.0, 65535.0, f32::MAX, f32::INFINITY];
        numbers.extend((0..10_000u32).map(|k| f32::from_bits(k.wrapping_mul(429_497) >> 1)));
        for x in numbers.into_iter().filter(|x| !x.is_nan()) {
            assert_eq!(step_down(x).to_bits(), x.next_down().to_bits(), "{x}");
            assert_eq!(step_up(-x).to_bits(), (-x).next_up().to_bits(), "{x}");
            if x.is_finite() {
                assert_eq!(step_down(-x).to_bits(), (-x).next_down().to_bits(), "{x}");
                assert_eq!(step_up(x).to_bits(), x.next_up().to_bits(), "{x}");
            }
        }
    }
}
