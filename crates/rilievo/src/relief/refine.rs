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

/// The crossing near `s0` over a cell with corner heights `h`, and whether it lies inside of the
/// cell, which the window must not cut: so with nearly every root. If not, the numbers mean nothing,
/// and [`across`] finds the root. Choices are selections, not branches, so that a loop over rays
/// becomes vectors.
#[inline(always)]
pub(crate) fn inside(
    ray: &ExactRay,
    window: &Window,
    (cell, h): ([i32; 2], [f32; 4]),
    s0: f64,
) -> (Root, bool) {
    let corner = [f64::from(cell[0]), f64::from(cell[1])];
    let quad = Quadratic::new(ray, h, corner, s0);
    let e = quad.root(s0);
    let x = quad.at[0] + e * ray.direction[0];
    let y = quad.at[1] + e * ray.direction[1];
    let whole = (window.lo[0] <= corner[0])
        & (window.lo[1] <= corner[1])
        & (window.hi[0] >= corner[0] + 1.0)
        & (window.hi[1] >= corner[1] + 1.0);
    let within = (0.0..=1.0).contains(&x) & (0.0..=1.0).contains(&y);
    (quad.root_at(ray, cell, s0 + e, [x, y]), whole & within)
}

/// Finds the crossing near `s0`, first in `cell`, then in the neighbours the root leads to, never
/// outside of the window.
pub(crate) fn across(
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
    h: [f32; 4],
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
        let h = heights.unfolded_corners(cell[0], cell[1]);
        Self { cell, h, limits, goes_on }
    }

    /// Keeps a local coordinate inside cell and window. (Not `clamp`: a cell that only touches the
    /// window has limits that cross by a rounding.)
    fn inside(&self, k: usize, local: f64) -> f64 {
        local.min(self.limits[k][1]).max(self.limits[k][0])
    }

    fn root_near(&self, ray: &ExactRay, s0: f64) -> Candidate {
        let corner = self.cell.map(f64::from);
        let quad = Quadratic::new(ray, self.h, corner, s0);
        let [dx, dy, _] = ray.direction;
        let (kept, beyond) = self.keep_inside(quad.at, [dx, dy], quad.root(s0));
        let local = [0, 1].map(|k| self.inside(k, quad.at[k] + kept * ray.direction[k]));
        Candidate { root: quad.root_at(ray, self.cell, s0 + kept, local), beyond }
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

/// The gap between a ray and a cell's patch about a parameter: `g0 + g1 e + g2 e^2`.
struct Quadratic {
    /// Local coordinates of the ray there.
    at: [f64; 2],
    g: [f64; 3],
    /// The patch: `h00 + b x + c y + d x y`.
    h00: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Quadratic {
    /// The gap over the patch with corners `h` at `corner` about `s0`.
    #[inline(always)]
    fn new(ray: &ExactRay, h: [f32; 4], corner: [f64; 2], s0: f64) -> Self {
        let [dx, dy, dz] = ray.direction;
        let x = ray.origin[0] + s0 * dx - corner[0];
        let y = ray.origin[1] + s0 * dy - corner[1];
        let h00 = f64::from(h[0]);
        let (b, c) = (f64::from(h[1]) - h00, f64::from(h[2]) - h00);
        let d = (f64::from(h[3]) - f64::from(h[2])) - b;
        let height = patch_height(h00, [b, c, d], [x, y]);
        let g0 = ray.origin[2] + s0 * dz - height;
        let g1 = dz - (b + d * y) * dx - (c + d * x) * dy;
        Self { at: [x, y], g: [g0, g1, -d * dx * dy], h00, b, c, d }
    }

    /// The root nearest to `e = 0`, or the point of closest approach; not before the start.
    #[inline(always)]
    fn root(&self, s0: f64) -> f64 {
        let [g0, g1, g2] = self.g;
        let discriminant = g1 * g1 - 4.0 * g2 * g0;
        let meets = discriminant >= 0.0;
        let below = if meets { g1 + discriminant.abs().sqrt().copysign(g1) } else { 2.0 * g2 };
        let e = (if meets { -2.0 * g0 } else { -g1 }) / below;
        let kept = if e > -s0 { e } else { -s0 };
        if e.abs() < f64::INFINITY { kept } else { 0.0 }
    }

    /// The root at parameter `s` and local coordinates of the patch.
    #[inline(always)]
    fn root_at(&self, ray: &ExactRay, cell: [i32; 2], s: f64, local: [f64; 2]) -> Root {
        let raw = patch_height(self.h00, [self.b, self.c, self.d], local);
        let gap = ray.origin[2] + s * ray.direction[2] - raw;
        // The lattice coordinates themselves are rounded; on a steep cell that is a height.
        let reach = 2.0 + f64::from(cell[0]).abs() + f64::from(cell[1]).abs();
        let steepness = self.b.abs() + self.c.abs() + self.d.abs();
        let error = gap.abs() + 8.0 * f64::EPSILON * reach * steepness;
        Root { s, cell, local, raw, error }
    }
}

/// Height of a patch at local coordinates.
#[inline(always)]
fn patch_height(h00: f64, [b, c, d]: [f64; 3], [x, y]: [f64; 2]) -> f64 {
    (h00 + b * x) + (c + d * x) * y
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

    fn refined(
        ray: &ExactRay,
        heights: &HeightMap,
        window: &Window,
        cell: [i32; 2],
        s0: f64,
    ) -> Root {
        let h = heights.unfolded_corners(cell[0], cell[1]);
        let (root, inside) = inside(ray, window, (cell, h), s0);
        let followed = across(ray, heights, window, cell, s0);
        assert!(!inside || (root.s, root.local) == (followed.s, followed.local));
        followed
    }

    #[test]
    fn a_rounded_start_gives_the_root_to_double_precision() {
        // Saddle z = x y met by the ray (0.1 + 0.8 s, 0.2 + 0.5 s, 1 - s).
        let saddle = map(2, 2, &[0.0, 0.0, 0.0, 1.0]);
        let ray = ray([0.1, 0.2, 1.0], [0.8, 0.5, -1.0]);
        // 0.4 s^2 + 1.21 s - 0.98 = 0.
        let want = (-1.21 + (1.21f64 * 1.21 + 4.0 * 0.4 * 0.98).sqrt()) / 0.8;
        let root = refined(&ray, &saddle, &window([1.0, 1.0]), [0, 0], want + 3e-7);
        assert!((root.s - want).abs() < 1e-15, "{} against {want}", root.s);
        assert!((root.local[0] - (0.1 + 0.8 * want)).abs() < 1e-15 && root.error < 1e-14);
    }

    #[test]
    fn a_ray_along_a_line_keeps_its_root() {
        // 1e-17 beyond the line x = 1, drifting by 1e-16: over cell 1 or 0, the same root.
        let map = map(3, 2, &[0.0, 1.0, 0.0, 0.0, 1.0, 0.0]);
        let ray = ray([1.0 - 1e-16, 0.25, 2.0], [1e-17, 0.5, -1.25]);
        for cell in [0, 1] {
            let root = refined(&ray, &map, &window([2.0, 1.0]), [cell, 0], 0.8 + 1e-7);
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
        let root = refined(&ray, &saddle, &window([1.0, 1.0]), [0, 0], 0.5 + 1e-6);
        assert!((root.s - 0.5).abs() < 1e-9 && (root.error - 1e-9).abs() < 1e-12);
    }

    #[test]
    fn a_grazing_root_is_followed_into_the_neighbour() {
        // A plane met at x = 1.25 by a very flat ray that the walk placed in cell 0.
        let plane = map(3, 2, &[0.0; 6]);
        let ray = ray([0.0, 0.3, 1.25e-6], [1.0, 0.1, -1e-6]);
        let root = refined(&ray, &plane, &window([2.0, 1.0]), [0, 0], 0.999);
        assert_eq!(root.cell, [1, 0]);
        assert!((root.s - 1.25).abs() < 1e-9 && (root.local[0] - 0.25).abs() < 1e-9);
        // A window that ends inside of the neighbour holds it there.
        let root = refined(&ray, &plane, &window([1.125, 1.0]), [0, 0], 0.999);
        assert_eq!((root.cell, root.local[0], root.s), ([1, 0], 0.125, 1.125));
        // Without a neighbour it stays at the border, and says how far off it is.
        let root = refined(&ray, &plane, &window([1.0, 1.0]), [0, 0], 0.999);
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
