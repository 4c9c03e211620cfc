//! The answer in `f64`: the walk decides in `f32` which cell is hit and about where; here the
//! root is found again on the unrounded ray.
//!
//! About the walk's parameter `s0` the gap is a quadratic `g0 + g1 e + g2 e^2` in `e = s - s0`; the
//! root nearest to `e = 0` is the walk's root but for its rounding. Where the `f64` ray just misses
//! what the `f32` ray grazed, the point of closest approach is taken: it lies within the leaf's
//! slack of the surface. The root may leave the cell by that rounding; the patch is then continued
//! there, at most to the nearest point of the cell's closed part of the ray.

use super::map_ray::ExactRay;

/// A refined crossing: parameter and position within the cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub s: f64,
    /// Local coordinates in the unfolded cell, in [0, 1].
    pub local: [f64; 2],
}

/// Finds the root of the unfolded cell (i, j) with corners `[h00, h10, h01, h11]` near `s0`.
pub(crate) fn refine(ray: &ExactRay, [i, j]: [i32; 2], corners: [f32; 4], s0: f64) -> Root {
    let h = corners.map(f64::from);
    let (dx, dy, dz) = (ray.direction[0], ray.direction[1], ray.direction[2]);
    let x = ray.origin[0] + s0 * dx - f64::from(i);
    let y = ray.origin[1] + s0 * dy - f64::from(j);
    let z = ray.origin[2] + s0 * dz;
    let (a, b, c, d) = (h[0], h[1] - h[0], h[2] - h[0], (h[3] - h[2]) - (h[1] - h[0]));
    let g0 = z - (a + b * x + (c + d * x) * y);
    let g1 = dz - (b + d * y) * dx - (c + d * x) * dy;
    let g2 = -d * dx * dy;
    let discriminant = g1 * g1 - 4.0 * g2 * g0;
    let e = if discriminant >= 0.0 {
        let q = g1 + g1.signum() * discriminant.sqrt();
        if q == 0.0 { 0.0 } else { -2.0 * g0 / q }
    } else {
        -g1 / (2.0 * g2)
    };
    // The walk's own rounding bounds how far the true root can be.
    let (enter, leave) = span_in_cell([x, y], [dx, dy]);
    let e = if e.is_finite() { e.clamp(enter.min(0.0), leave.max(0.0)) } else { 0.0 };
    let s = (s0 + e).max(0.0);
    let e = s - s0;
    Root { s, local: [(x + e * dx).clamp(0.0, 1.0), (y + e * dy).clamp(0.0, 1.0)] }
}

/// Parameters, relative to the current one, between which the ray is in the cell [0, 1]^2, with a
/// margin of a thousandth of a cell.
fn span_in_cell(at: [f64; 2], direction: [f64; 2]) -> (f64, f64) {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for k in 0..2 {
        if direction[k] != 0.0 {
            let a = (-1e-3 - at[k]) / direction[k];
            let b = (1.0 + 1e-3 - at[k]) / direction[k];
            enter = enter.max(a.min(b));
            leave = leave.min(a.max(b));
        }
    }
    (enter, leave)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rounded_start_gives_the_root_to_double_precision() {
        // Saddle z = x y met by the ray (0.1 + 0.8 s, 0.2 + 0.5 s, 1 - s).
        let ray = ExactRay {
            origin: [0.1, 0.2, 1.0],
            direction: [0.8, 0.5, -1.0],
            t_start: 0.0,
            t_length: 1.0,
        };
        // 0.4 s^2 + 1.21 s - 0.98 = 0.
        let want = (-1.21 + (1.21f64 * 1.21 + 4.0 * 0.4 * 0.98).sqrt()) / 0.8;
        let root = refine(&ray, [0, 0], [0.0, 0.0, 0.0, 1.0], want + 3e-7);
        assert!((root.s - want).abs() < 1e-15, "{} against {want}", root.s);
        assert!((root.local[0] - (0.1 + 0.8 * want)).abs() < 1e-15);
    }

    #[test]
    fn a_ray_that_just_misses_gets_its_closest_approach() {
        // Ridge-like saddle, ray passes 1e-9 above its tangent point at s = 0.5.
        let corners = [0.0, 1.0, 1.0, 0.0];
        let ray = ExactRay {
            origin: [0.0, 0.0, 0.5 + 1e-9],
            direction: [1.0, 1.0, 0.0],
            t_start: 0.0,
            t_length: 1.0,
        };
        let root = refine(&ray, [0, 0], corners, 0.5 + 1e-6);
        assert!((root.s - 0.5).abs() < 1e-9);
    }
}
