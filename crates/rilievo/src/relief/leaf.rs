//! The exact leaf: a ray against one bilinear cell, in Bernstein form.
//!
//! **Theory.** Over the part of the ray inside a cell, entry `a`, exit `b`, the gap between ray and
//! surface is a quadratic whose Bernstein coefficients need no expansion about a far origin:
//!
//! ```text
//! b0 = za - H(xa, ya)
//! b1 = ((za + zb) - (H(xa, yb) + H(xb, ya))) / 2      the blossom of the bilinear form
//! b2 = zb - H(xb, yb)
//! gap(q) = b0 (1-q)^2 + 2 b1 q (1-q) + b2 q^2         q in [0, 1]
//! ```
//!
//! Three coefficients of one sign: no root. Signs of b0 and b2 differ: one root. Otherwise b1 and
//! the discriminant decide. The first root has a form without cancellation for either sign of b1.
//!
//! **Arithmetic.** `f32`, no fused multiply-add anywhere: every SIMD level and every backend that
//! does not contract gives the same bits. This file is the definition.
//!
//! **Watertight.** Cells share the parameters of their common line (see `map_ray`), the local
//! coordinate on the line that gave the parameter is *set*, not computed, and [`lerp`] is exact at
//! both ends. Two neighbours therefore compute the identical gap on their common border: a ray
//! cannot change sides between them. A cell is active only if `t0 < t1`; a ray through a corner
//! goes straight to the diagonal neighbour, and both see the corner's own sample.
//!
//! **Bound implies leaf (proof).** Let every corner of a cell be at most `M`, let
//! `A = max(|lowest|, |highest|)` over the map, and `ulp` the spacing of floats at `A`. `lerp`
//! rounds four times, each result at most `A (1 + small)`, so it exceeds the larger end by at most
//! `2 ulp`; two nested ones give `H <= M + 4 ulp`. If both ends of the ray's part have
//! `z > M + 8 ulp`, then b0 and b2 are positive (a difference of floats has the exact sign), and in
//! b1 the two sums round by at most `ulp` each (spacing at `2 A`), so
//! `za + zb >= 2 M + 16 ulp - ulp > 2 M + 8 ulp + ulp >= H + H`: b1 is positive too. All three are
//! positive: no root. The same holds below a minimum by symmetry. Hence a bound test with the
//! slack [`slack`] `= 2^-20 A >= 8 ulp` (`ulp <= 2^-23 A`) never hides a root of this leaf. In
//! units of a full u16 map it is 1/16.
//!
//! **Leaving a surface (lift).** A ray spawned on the surface starts [`lift`] `= 4 slack` away
//! from it, along the displacement, on the side it leaves to. A height field cannot be crossed
//! along its own displacement, so the lift cannot skip anything; and it exceeds the error of every
//! gap computed next to the start: rounding of the start to `f32` moves it by at most 2^-24 cell
//! along x and y, which is 2^-23 of the steepest possible difference of corners (`2 A`), i.e.
//! below `2 slack` with the leaf's own `slack`. The algorithms digest sets b0 := 0 in the start's
//! cell instead; that leaves rays which start within rounding of a cell border to their neighbour,
//! where the same rounding can flip a sign. The lift has no such case.

use super::map_ray::{MapRay, larger, smaller};

/// Which crossings count.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Crossings {
    /// Both directions.
    Both,
    /// Only from above the raw surface to below.
    Downward,
    /// Only from below to above.
    Upward,
}

impl Crossings {
    /// Whether a crossing that starts on the given side counts.
    #[inline]
    pub fn admits(self, from_above: bool) -> bool {
        match self {
            Self::Both => true,
            Self::Downward => from_above,
            Self::Upward => !from_above,
        }
    }
}

/// Slack of every bound test, raw units; see the module's proof. `size` is the largest magnitude
/// of a raw height of the map.
#[inline]
pub(crate) fn slack(size: f32) -> f32 {
    size * 2.0f32.powi(-20)
}

/// How far from the surface a spawned ray starts, raw units along the displacement.
#[inline]
pub(crate) fn lift(size: f32) -> f32 {
    4.0 * slack(size)
}

/// The part of a ray inside a cell, in parameters and local coordinates.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Span {
    pub t0: f32,
    pub t1: f32,
    near: [f32; 2],
    far: [f32; 2],
}

impl Span {
    /// The part of the ray inside forward cell (fx, fy) and the window; none if it is empty.
    #[inline]
    pub fn new(ray: &MapRay, fx: i32, fy: i32) -> Option<Self> {
        let t0 = larger(larger(ray.t_near(0, fx), ray.t_near(1, fy)), 0.0);
        let t1 = smaller(smaller(ray.t_far(0, fx), ray.t_far(1, fy)), 1.0);
        if t0 >= t1 {
            return None;
        }
        let near = [0, 1].map(|axis| entering(ray, axis, [fx, fy][axis], t0));
        let far = [0, 1].map(|axis| leaving(ray, axis, [fx, fy][axis], t1));
        Some(Self { t0, t1, near, far })
    }
}

/// Local coordinate along an axis at `s`, not set by a line.
#[inline]
fn local(ray: &MapRay, axis: usize, f: i32, s: f32) -> f32 {
    smaller(larger(s * ray.d[axis] - (f as f32 - ray.o[axis]), 0.0), 1.0)
}

/// Local coordinate where the ray enters forward cell `f` at `s`: set on the near line.
#[inline]
fn entering(ray: &MapRay, axis: usize, f: i32, s: f32) -> f32 {
    if ray.t_near(axis, f) >= s {
        ray.near_line(axis, f) - f as f32
    } else {
        local(ray, axis, f, s)
    }
}

/// Local coordinate where the ray leaves forward cell `f` at `s`: set on the far line.
#[inline]
fn leaving(ray: &MapRay, axis: usize, f: i32, s: f32) -> f32 {
    if ray.t_far(axis, f) <= s { ray.far_line(axis, f) - f as f32 } else { local(ray, axis, f, s) }
}

/// Linear interpolation, exact at both ends.
#[inline]
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    t * b + (a - t * a)
}

/// Bilinear height; `h = [h00, h10, h01, h11]` in forward order.
#[inline]
pub(crate) fn bilinear(h: &[f32; 4], x: f32, y: f32) -> f32 {
    lerp(lerp(h[0], h[2], y), lerp(h[1], h[3], y), x)
}

/// Bernstein coefficients of the gap over a span.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gap {
    pub b0: f32,
    pub b1: f32,
    pub b2: f32,
}

impl Gap {
    /// The gap between the ray and the cell with the given corners, forward order.
    #[inline]
    pub fn new(ray: &MapRay, span: &Span, corners: &[f32; 4]) -> Self {
        let (za, zb) = (ray.z(span.t0), ray.z(span.t1));
        let ([xa, ya], [xb, yb]) = (span.near, span.far);
        Self {
            b0: za - bilinear(corners, xa, ya),
            b1: ((za + zb) - (bilinear(corners, xa, yb) + bilinear(corners, xb, ya))) * 0.5,
            b2: zb - bilinear(corners, xb, yb),
        }
    }

    /// The first admitted root, as a fraction of the span, and whether it comes from above.
    #[inline]
    pub fn first_root(&self, admit: Crossings) -> Option<(f32, bool)> {
        // A ray that starts on the surface came from the side it does not go to.
        let above = self.b0 > 0.0
            || (self.b0 == 0.0 && (self.b1 < 0.0 || (self.b1 == 0.0 && self.b2 < 0.0)));
        let Self { b0, b1, b2 } =
            if above { *self } else { Self { b0: -self.b0, b1: -self.b1, b2: -self.b2 } };
        let discriminant = b1 * b1 - b0 * b2;
        let crosses = b0 == 0.0 || b2 <= 0.0;
        if !(crosses || (b1 < 0.0 && discriminant >= 0.0)) {
            return None;
        }
        let root = larger(discriminant, 0.0).sqrt();
        if admit.admits(above) {
            let q = if b1 <= 0.0 {
                // 0/0 only if the ray lies in the surface: the start is the first point.
                if b0 == 0.0 { 0.0 } else { b0 / (b0 - b1 + root) }
            } else if b0 == 0.0 {
                0.0
            } else {
                (b1 + root) / (b1 + root - b2)
            };
            return Some((q, above));
        }
        // The other direction counts: the second root, where the ray comes back.
        (b2 > 0.0 && b1 < 0.0 && discriminant >= 0.0)
            .then(|| ((root - b1) / (root - b1 + b2), !above))
    }
}

impl Gap {
    /// The first admitted crossing of a forward cell over the span from `t0` to `t1`.
    #[inline]
    pub fn first_hit(
        &self,
        [t0, t1]: [f32; 2],
        cell: [i32; 2],
        admit: Crossings,
    ) -> Option<LeafHit> {
        let (q, from_above) = self.first_root(admit)?;
        Some(LeafHit { s: smaller(q * (t1 - t0) + t0, t1), cell, from_above })
    }
}

/// The gap where the ray enters a forward cell at `s`: the `b0` of its leaf.
pub(crate) fn gap_entering(ray: &MapRay, cell: [i32; 2], corners: &[f32; 4], s: f32) -> f32 {
    let [x, y] = [0, 1].map(|axis| entering(ray, axis, cell[axis], s));
    ray.z(s) - bilinear(corners, x, y)
}

/// The gap where the ray leaves a forward cell at `s`: the `b2` of its leaf.
pub(crate) fn gap_leaving(ray: &MapRay, cell: [i32; 2], corners: &[f32; 4], s: f32) -> f32 {
    let [x, y] = [0, 1].map(|axis| leaving(ray, axis, cell[axis], s));
    ray.z(s) - bilinear(corners, x, y)
}

/// A root found by the leaf.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LeafHit {
    /// Walk parameter.
    pub s: f32,
    /// Forward cell.
    pub cell: [i32; 2],
    /// Whether the ray came from above the raw surface.
    pub from_above: bool,
}

impl Span {
    /// The first admitted crossing of the span's forward cell.
    #[inline]
    pub fn intersect(
        &self,
        ray: &MapRay,
        cell: [i32; 2],
        corners: &[f32; 4],
        admit: Crossings,
    ) -> Option<LeafHit> {
        Gap::new(ray, self, corners).first_hit([self.t0, self.t1], cell, admit)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gap(b0: f32, b1: f32, b2: f32) -> Gap {
        Gap { b0, b1, b2 }
    }

    fn value(g: &Gap, q: f32) -> f64 {
        let (b0, b1, b2, q) = (f64::from(g.b0), f64::from(g.b1), f64::from(g.b2), f64::from(q));
        b0 * (1.0 - q) * (1.0 - q) + 2.0 * b1 * q * (1.0 - q) + b2 * q * q
    }

    #[test]
    fn lerp_is_exact_at_both_ends() {
        for (a, b) in [(0.1f32, 65535.0), (65535.0, 0.3), (-1437.2, 2205.7)] {
            assert_eq!(lerp(a, b, 0.0), a);
            assert_eq!(lerp(a, b, 1.0), b);
        }
    }

    #[test]
    fn roots_of_all_sign_patterns_are_first_roots() {
        let steps = [-7.0f32, -1.0, -0.25, 0.5, 1.0, 6.0];
        for b0 in steps {
            for b1 in steps {
                for b2 in steps {
                    let g = gap(b0, b1, b2);
                    let scan = (0..=20_000).map(|k| k as f32 / 20_000.0);
                    let first = scan.clone().find(|&q| value(&g, q) * f64::from(b0) <= 0.0);
                    match (g.first_root(Crossings::Both), first) {
                        (Some((q, above)), Some(want)) => {
                            assert!((q - want).abs() <= 2e-4, "{g:?}: {q} against {want}");
                            assert_eq!(above, b0 > 0.0);
                        }
                        (None, None) => {}
                        // A double root may fall between two points of the scan.
                        (Some((q, _)), None) => assert!(value(&g, q).abs() < 1e-5, "{g:?}"),
                        (None, Some(q)) => panic!("{g:?}: root near {q} not found"),
                    }
                }
            }
        }
    }

    #[test]
    fn a_one_way_leaf_reports_the_way_back() {
        // Starts below, comes up and goes down again: 1 - r^2 turned over.
        let g = gap(-1.0, 2.0, -1.0);
        let (up, from_above) = g.first_root(Crossings::Upward).unwrap();
        assert!(!from_above && value(&g, up).abs() < 1e-6);
        let (down, from_above) = g.first_root(Crossings::Downward).unwrap();
        assert!(from_above && down > up && value(&g, down).abs() < 1e-6);
        assert_eq!(gap(-1.0, 0.5, 1.0).first_root(Crossings::Downward), None);
    }

    #[test]
    fn a_start_on_the_surface_crosses_to_the_side_the_ray_goes_to() {
        assert_eq!(gap(0.0, -1.0, -2.0).first_root(Crossings::Both), Some((0.0, true)));
        assert_eq!(gap(0.0, 1.0, 2.0).first_root(Crossings::Both), Some((0.0, false)));
        // Up through the surface at the start: no front of a one-sided face.
        assert_eq!(gap(0.0, 1.0, 2.0).first_root(Crossings::Downward), None);
        let (q, from_above) = gap(0.0, 1.0, -2.0).first_root(Crossings::Downward).unwrap();
        assert!(from_above && (q - 0.5).abs() < 1e-6);
    }

    /// The proof's edge: z just above bound + slack, the worst corners and coordinates found.
    #[test]
    fn z_above_bound_and_slack_leaves_no_root() {
        let mut state = 1u32;
        let mut next = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        };
        for size in [65535.0f32, 1.0, 3286.0, 1e-3] {
            let limit = slack(size);
            let mut worst = 0.0f32;
            for _ in 0..400_000 {
                let h = [next(), next(), next(), 1.0].map(|r| (r * size).min(size));
                let top = h.iter().copied().fold(0.0, f32::max);
                let (x, y) = (next(), next());
                worst = worst.max(bilinear(&h, x, y) - top);
                let za = (top + limit).next_up();
                let zb = (top + limit * (1.0 + next())).next_up();
                let (xb, yb) = (next(), next());
                let b1 = ((za + zb) - (bilinear(&h, x, yb) + bilinear(&h, xb, y))) * 0.5;
                assert!(
                    za - bilinear(&h, x, y) > 0.0 && b1 > 0.0 && zb - bilinear(&h, xb, yb) > 0.0
                );
            }
            assert!(worst <= limit / 2.0, "H exceeds its corners by {worst}, slack {limit}");
        }
    }
}
