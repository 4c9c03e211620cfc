//! The answer in `f64`: the walk decides in `f32` which cell is hit and about where; here the
//! root is found again on the unrounded ray.
//!
//! About a parameter `s0` the gap over one cell's patch is a quadratic `g0 + g1 e + g2 e^2` in
//! `e = s - s0`, and the root nearest to `e = 0` is the walk's root but for its rounding. A grazing
//! ray may have its exact root in the neighbouring cell; then it is looked for there. Where the
//! unrounded ray just misses what the rounded one grazed, the point of closest approach is taken:
//! it lies within the leaf's slack of the surface.
//!
//! Where a ray passes exactly through a sample, a sliver of a neighbouring cell may see a rounding of
//! the wrong sign, beside the true crossing the other way. A face with one side asks [`crosses`]
//! before it believes such a root.

use crate::map::HeightMap;

use super::map_ray::{ExactRay, Window};

/// A refined crossing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    pub s: f64,
    /// Unfolded cell.
    pub cell: [i32; 2],
    /// Local coordinates in the cell, in [0, 1].
    pub local: [f64; 2],
    /// Raw height of the surface there.
    pub raw: f64,
    /// Bound on the raw height between the surface and the ray there.
    pub error: f64,
}

/// Whether the unrounded ray may cross the surface near `s0` from the given side: not if a little
/// before and a little after, 2^-12 of a cell, it is on the sides of the opposite crossing.
pub(crate) fn crosses(ray: &ExactRay, heights: &HeightMap, s0: f64, from_above: bool) -> bool {
    let (low, high) = heights.raw_range();
    let [dx, dy, dz] = ray.direction.map(f64::abs);
    let speed = dx.max(dy).max(dz / f64::from(high - low).max(f64::MIN_POSITIVE));
    let step = 2.0f64.powi(-12) / speed;
    let gap = |s: f64| {
        let [x, y, z] = [0, 1, 2].map(|k| ray.origin[k] + s * ray.direction[k]);
        z - heights.raw_at_lattice(x, y)
    };
    let (before, after) = (gap(s0 - step), gap(s0 + step));
    if from_above { !(before < 0.0 && after > 0.0) } else { !(before > 0.0 && after < 0.0) }
}

/// Finds the crossing near `s0`, first in `cell`, then in the neighbours the root leads to, never
/// outside of the window.
pub(crate) fn refine(
    ray: &ExactRay,
    heights: &HeightMap,
    window: &Window,
    cell: [i32; 2],
    s0: f64,
) -> Root {
    let home = Patch::new(heights, window, cell).root_near(ray, s0);
    let mut next = home;
    for _ in 0..2 {
        let Some(beyond) = next.beyond else { return next.root };
        next = Patch::new(heights, window, beyond).root_near(ray, next.root.s);
    }
    if next.beyond.is_none() { next.root } else { home.root }
}

/// Whether the unrounded ray starts beyond the crossing of `cell` that the walk found near `s0`: on
/// its far side, with no root of the cell's patch after the start. Then the walk saw the rounding of
/// the start, and there is no crossing.
pub(crate) fn starts_beyond(
    ray: &ExactRay,
    heights: &HeightMap,
    cell: [i32; 2],
    (s0, from_above): (f64, bool),
) -> bool {
    let [x, y, z] = ray.origin;
    let gap = z - heights.raw_at_lattice(x, y);
    let beyond = if from_above { gap < 0.0 } else { gap > 0.0 };
    let window = Window { lo: [f64::NEG_INFINITY; 2], hi: [f64::INFINITY; 2] };
    beyond && Patch::new(heights, &window, cell).root_near(ray, s0).root.s <= 0.0
}

/// One bilinear cell in double precision.
struct Patch {
    cell: [i32; 2],
    /// Corners h00, h10, h01, h11.
    h: [f64; 4],
    /// Lowest and highest local coordinate inside the window.
    limits: [[f64; 2]; 2],
    /// Whether the window goes on beyond the cell's low and high border.
    goes_on: [[bool; 2]; 2],
}

/// The root of a patch, moved to the cell's border if it lies outside, and the cell across that
/// border.
#[derive(Clone, Copy)]
struct Candidate {
    root: Root,
    beyond: Option<[i32; 2]>,
}

impl Patch {
    fn new(heights: &HeightMap, window: &Window, cell: [i32; 2]) -> Self {
        let limits = [0, 1].map(|k| {
            let start = f64::from(cell[k]);
            [(window.lo[k] - start).max(0.0), (window.hi[k] - start).min(1.0)]
        });
        let goes_on = [0, 1].map(|k| {
            let start = f64::from(cell[k]);
            [window.lo[k] < start, window.hi[k] > start + 1.0]
        });
        let h = heights.unfolded_corners(cell[0], cell[1]).map(f64::from);
        Self { cell, h, limits, goes_on }
    }

    /// Keeps a local coordinate inside cell and window. (Not `clamp`: a cell that only touches the
    /// window has limits that cross by a rounding.)
    fn inside(&self, k: usize, local: f64) -> f64 {
        local.min(self.limits[k][1]).max(self.limits[k][0])
    }

    fn height(&self, [x, y]: [f64; 2]) -> f64 {
        let low = self.h[0] + (self.h[1] - self.h[0]) * x;
        let high = self.h[2] + (self.h[3] - self.h[2]) * x;
        low + (high - low) * y
    }

    fn root_near(&self, ray: &ExactRay, s0: f64) -> Candidate {
        let [dx, dy, dz] = ray.direction;
        let at = [0, 1].map(|k| ray.origin[k] + s0 * ray.direction[k] - f64::from(self.cell[k]));
        let [x, y] = at;
        let [b, c] = [self.h[1] - self.h[0], self.h[2] - self.h[0]];
        let d = (self.h[3] - self.h[2]) - b;
        let g0 = ray.origin[2] + s0 * dz - self.height(at);
        let g1 = dz - (b + d * y) * dx - (c + d * x) * dy;
        let g2 = -d * dx * dy;
        let discriminant = g1 * g1 - 4.0 * g2 * g0;
        let e = if discriminant >= 0.0 {
            -2.0 * g0 / (g1 + g1.signum() * discriminant.sqrt())
        } else {
            -g1 / (2.0 * g2)
        };
        let e = if e.is_finite() { e.max(-s0) } else { 0.0 };
        let (kept, beyond) = self.keep_inside(at, [dx, dy], e);
        let s = s0 + kept;
        let local = [0, 1].map(|k| self.inside(k, at[k] + kept * ray.direction[k]));
        let raw = self.height(local);
        let gap = ray.origin[2] + s * dz - raw;
        // The lattice coordinates themselves are rounded; on a steep cell that is a height.
        let rounding =
            8.0 * f64::EPSILON * (2.0 + self.cell.map(f64::from).map(f64::abs).iter().sum::<f64>());
        let error = gap.abs() + rounding * (b.abs() + c.abs() + d.abs());
        Candidate { root: Root { s, cell: self.cell, local, raw, error }, beyond }
    }

    /// Shortens the step `e` from `at` to end on the border of cell or window if it leads outside;
    /// also names the cell across the border, if the window goes on there. A start that is itself
    /// outside by a rounding goes back to the border, unless that is far along the ray.
    fn keep_inside(&self, at: [f64; 2], direction: [f64; 2], e: f64) -> (f64, Option<[i32; 2]>) {
        let (mut kept, mut beyond) = (e, None);
        for k in 0..2 {
            let end = at[k] + kept * direction[k];
            let line = self.inside(k, end);
            if (end - line).abs() <= 1e-12 {
                continue;
            }
            let to_line = (line - at[k]) / direction[k];
            let on_the_way = to_line * kept >= 0.0 && to_line.abs() <= kept.abs();
            if on_the_way || to_line.abs() <= 1e-6 {
                kept = to_line;
            }
            let mut cell = self.cell;
            cell[k] += if end < line { -1 } else { 1 };
            beyond = self.goes_on[k][usize::from(end > line)].then_some(cell);
        }
        (kept, beyond)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Lattice, Samples, Wrap};

    fn map(width: u32, height: u32, h: &[f32]) -> HeightMap {
        let samples = Samples::F32(h.to_vec());
        HeightMap::new(width, height, samples, Lattice::Vertex, Wrap::Repeat).unwrap()
    }

    fn ray(origin: [f64; 3], direction: [f64; 3]) -> ExactRay {
        ExactRay { origin, direction, t_start: 0.0, t_length: 1.0 }
    }

    fn window(hi: [f64; 2]) -> Window {
        Window { lo: [0.0; 2], hi }
    }

    #[test]
    fn a_rounded_start_gives_the_root_to_double_precision() {
        // Saddle z = x y met by the ray (0.1 + 0.8 s, 0.2 + 0.5 s, 1 - s).
        let saddle = map(2, 2, &[0.0, 0.0, 0.0, 1.0]);
        let ray = ray([0.1, 0.2, 1.0], [0.8, 0.5, -1.0]);
        // 0.4 s^2 + 1.21 s - 0.98 = 0.
        let want = (-1.21 + (1.21f64 * 1.21 + 4.0 * 0.4 * 0.98).sqrt()) / 0.8;
        let root = refine(&ray, &saddle, &window([1.0, 1.0]), [0, 0], want + 3e-7);
        assert!((root.s - want).abs() < 1e-15, "{} against {want}", root.s);
        assert!((root.local[0] - (0.1 + 0.8 * want)).abs() < 1e-15 && root.error < 1e-14);
    }

    #[test]
    fn a_ray_along_a_line_keeps_its_root() {
        // 1e-17 beyond the line x = 1, drifting by 1e-16: over cell 1 or 0, the same root.
        let map = map(3, 2, &[0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
        let ray = ray([1.0 - 1e-16, 0.25, 2.0], [1e-17, 0.5, -1.25]);
        for cell in [0, 1] {
            let root = refine(&ray, &map, &window([2.0, 1.0]), [cell, 0], 0.8 + 1e-7);
            assert!((root.s - 0.8).abs() < 1e-14, "{root:?}");
            assert!(root.error < 1e-13);
            assert!(crosses(&ray, &map, 0.8, true));
            assert!(!crosses(&ray, &map, 0.8, false));
        }
    }

    #[test]
    fn a_ray_that_just_misses_gets_its_closest_approach() {
        // Along the ridge of a saddle, 1e-9 above its tangent point at s = 0.5.
        let saddle = map(2, 2, &[0.0, 1.0, 1.0, 0.0]);
        let ray = ray([0.0, 0.0, 0.5 + 1e-9], [1.0, 1.0, 0.0]);
        let root = refine(&ray, &saddle, &window([1.0, 1.0]), [0, 0], 0.5 + 1e-6);
        assert!((root.s - 0.5).abs() < 1e-9 && (root.error - 1e-9).abs() < 1e-12);
    }

    #[test]
    fn a_grazing_root_is_followed_into_the_neighbour() {
        // A plane met at x = 1.25 by a very flat ray that the walk placed in cell 0.
        let plane = map(3, 2, &[0.0; 6]);
        let ray = ray([0.0, 0.3, 1.25e-6], [1.0, 0.1, -1e-6]);
        let root = refine(&ray, &plane, &window([2.0, 1.0]), [0, 0], 0.999);
        assert_eq!(root.cell, [1, 0]);
        assert!((root.s - 1.25).abs() < 1e-9 && (root.local[0] - 0.25).abs() < 1e-9);
        // A window that ends inside of the neighbour holds it there.
        let root = refine(&ray, &plane, &window([1.125, 1.0]), [0, 0], 0.999);
        assert_eq!((root.cell, root.local[0], root.s), ([1, 0], 0.125, 1.125));
        // Without a neighbour it stays at the border, and says how far off it is.
        let root = refine(&ray, &plane, &window([1.0, 1.0]), [0, 0], 0.999);
        assert_eq!((root.cell, root.local[0]), ([0, 0], 1.0));
        assert!((root.error - 0.25e-6).abs() < 1e-12);
    }

    #[test]
    fn a_start_a_hair_beyond_the_surface_does_not_cross_it() {
        let plane = map(2, 2, &[0.0; 4]);
        let start = |z: f64| ray([0.4, 0.3, z], [0.1, 0.1, -0.5]);
        assert!(starts_beyond(&start(-1e-9), &plane, [0, 0], (0.0, true)));
        assert!(!starts_beyond(&start(1e-9), &plane, [0, 0], (0.0, true)));
    }
}
