//! Shading normals of a relief: three ways to get them from heights, and [`NormalMap`].
//!
//! Normals are in *map axes*: x along u, y along v, z along the displacement, each in scene units.
//! A surface `z = H(x, y)` with slopes `dH` in raw units per cell has, in a [`Metric`] `m`, the
//! normal `(-(m.z / m.x) dH/dx, -(m.z / m.y) dH/dy, 1)`, normalised.
//!
//! | kind | slopes | continuous |
//! |---|---|---|
//! | [`NormalKind::Exact`] | those of the bilinear cell | no: creases at cell borders |
//! | [`NormalKind::Smooth`] | central differences at samples | yes |
//! | [`NormalKind::Published`] | one-sided differences at samples \[Book2007, 3.3\] | yes |
//!
//! The last two are made at the four corners of a cell, turned into normals in the metric, then
//! interpolated bilinearly and renormalised. `Published` is the paper's cross product of the vectors
//! to two neighbours; it is biased by half a cell. `Smooth` is the paper's future work ("averaging
//! the normals of those faces"): the mean of the slopes on both sides.
//!
//! **Borders.** Differences are those of the *unfolded* map. Where a repeated vertex lattice jumps,
//! the surface ends: a sample there has its slope from its own side only.

mod agreement;
mod stored;

pub use agreement::NormalAgreement;
pub use stored::{NormalConvention, NormalMap, NormalMapError, NormalTexels};

use glam::DVec3;

use super::height::{HeightMap, Samples};
use super::lattice::Axis;
use super::metric::Metric;

/// How normals come from heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NormalKind {
    /// The normal of the bilinear surface itself.
    Exact,
    /// Central differences at samples, interpolated and renormalised.
    Smooth,
    /// The seed paper's one-sided differences at samples, interpolated and renormalised.
    Published,
}

impl NormalKind {
    /// The unit normal in map axes at `local`, in `[0, 1]^2`, of unfolded cell `cell`. `metric.z`
    /// may have any sign; z of the normal is positive.
    pub fn normal_at(
        self,
        heights: &HeightMap,
        metric: Metric,
        cell: [i32; 2],
        local: [f64; 2],
    ) -> DVec3 {
        self.direction_at(heights, metric, cell, local).normalize_or(DVec3::Z)
    }

    /// [`NormalKind::normal_at`] in any length: it is made into a normal of the world once, at the
    /// end.
    #[inline]
    pub(crate) fn direction_at(
        self,
        heights: &HeightMap,
        metric: Metric,
        cell: [i32; 2],
        local: [f64; 2],
    ) -> DVec3 {
        let steepness = [metric.z / metric.x, metric.z / metric.y];
        match self {
            Self::Exact => {
                let h = match block(heights, cell) {
                    Some([low, high]) => [low[0], low[1], high[0], high[1]],
                    None => heights.unfolded_corners(cell[0], cell[1]).map(f64::from),
                };
                let [fx, fy] = local;
                let along_x = (h[1] - h[0]) * (1.0 - fy) + (h[3] - h[2]) * fy;
                let along_y = (h[2] - h[0]) * (1.0 - fx) + (h[3] - h[1]) * fx;
                DVec3::new(-along_x * steepness[0], -along_y * steepness[1], 1.0)
            }
            Self::Smooth | Self::Published => {
                let first = cell.map(|i| i.saturating_sub(1));
                let slopes = match (self, block(heights, first)) {
                    (Self::Smooth, Some(rows)) => smooth_slopes(&rows),
                    _ => self.slopes_at_corners(heights, cell),
                };
                interpolate(slopes, steepness, local)
            }
        }
    }

    /// Slopes along x and along y, raw units per cell, at the corners `[00, 10, 01, 11]` of an
    /// unfolded cell, as seen from the cell.
    fn slopes_at_corners(self, heights: &HeightMap, cell: [i32; 2]) -> [[f64; 2]; 4] {
        let raw = |i: u32, j: u32| f64::from(heights.raw(i, j));
        let mut slopes = [[0.0; 2]; 4];
        for (k, slope) in slopes.iter_mut().enumerate() {
            let x = Stencil::new(heights.x(), cell[0], k % 2 == 1);
            let y = Stencil::new(heights.y(), cell[1], k / 2 == 1);
            let own = raw(x.own, y.own);
            let along_x = x.slope(self, own, |i| raw(i, y.own));
            *slope = [along_x, y.slope(self, own, |j| raw(x.own, j))];
        }
        slopes
    }
}

/// `N` rows of `N` samples, the first of them the near corner of unfolded cell `first`, if the map
/// holds them side by side: next to no cell of a large map has neighbours elsewhere.
#[inline]
fn block<const N: usize>(heights: &HeightMap, first: [i32; 2]) -> Option<[[f64; N]; N]> {
    let start = |axis: &Axis, i: i32| {
        let start = usize::try_from(i).ok()?;
        (start.checked_add(N)? <= axis.samples() as usize).then_some(start)
    };
    let (i, j) = (start(heights.x(), first[0])?, start(heights.y(), first[1])?);
    let width = heights.width() as usize;
    let mut rows = [[0.0; N]; N];
    for (k, row) in rows.iter_mut().enumerate() {
        let at = (j + k) * width + i;
        *row = match heights.samples() {
            Samples::U16(codes) => codes.get(at..)?.first_chunk::<N>()?.map(f64::from),
            Samples::F32(values) => values.get(at..)?.first_chunk::<N>()?.map(f64::from),
        };
    }
    Some(rows)
}

/// [`NormalKind::slopes_at_corners`] of [`NormalKind::Smooth`] inside a map.
#[inline]
fn smooth_slopes(rows: &[[f64; 4]; 4]) -> [[f64; 2]; 4] {
    let mean = |before: f64, own: f64, after: f64| 0.5 * ((own - before) + (after - own));
    std::array::from_fn(|k| {
        let (i, j) = (1 + k % 2, 1 + k / 2);
        let along_x = mean(rows[j][i - 1], rows[j][i], rows[j][i + 1]);
        [along_x, mean(rows[j - 1][i], rows[j][i], rows[j + 1][i])]
    })
}

/// The samples around a corner of a cell along one axis.
struct Stencil {
    before: u32,
    own: u32,
    after: u32,
    /// What the neighbouring cell holds in place of `own`: another sample at a seam.
    across: u32,
    /// Whether the neighbouring cell lies after the corner.
    neighbour_after: bool,
}

impl Stencil {
    fn new(axis: &Axis, cell: i32, far: bool) -> Self {
        let (near_end, far_end) = axis.unfolded_corners(cell);
        if far {
            let (across, after) = axis.unfolded_corners(cell.saturating_add(1));
            Self { before: near_end, own: far_end, after, across, neighbour_after: true }
        } else {
            let (before, across) = axis.unfolded_corners(cell.saturating_sub(1));
            Self { before, own: near_end, after: far_end, across, neighbour_after: false }
        }
    }

    /// Raw units per cell; `raw` reads a sample of this line, `own` is that of the corner.
    fn slope(&self, kind: NormalKind, own: f64, raw: impl Fn(u32) -> f64) -> f64 {
        let (before, after) = (|| own - raw(self.before), || raw(self.after) - own);
        let jump = raw(self.across) != own;
        match kind {
            _ if jump && self.neighbour_after => before(),
            _ if jump => after(),
            NormalKind::Published => after(),
            NormalKind::Exact | NormalKind::Smooth => 0.5 * (before() + after()),
        }
    }
}

/// Bilinear mix of the unit normals at the corners of a cell, from their slopes in raw units per
/// cell; `steepness` is scene units per scene unit for one raw unit per cell.
#[inline]
fn interpolate(slopes: [[f64; 2]; 4], steepness: [f64; 2], [u, v]: [f64; 2]) -> DVec3 {
    let weights = [(1.0 - u) * (1.0 - v), u * (1.0 - v), (1.0 - u) * v, u * v];
    let mut sum = DVec3::ZERO;
    for ([along_x, along_y], weight) in slopes.into_iter().zip(weights) {
        let (x, y) = (along_x * steepness[0], along_y * steepness[1]);
        let length = (x * x + y * y + 1.0).sqrt();
        sum += weight / length * DVec3::new(-x, -y, 1.0);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Lattice, Procedural, Samples, Wrap};

    const KINDS: [NormalKind; 3] = [NormalKind::Exact, NormalKind::Smooth, NormalKind::Published];
    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];

    fn rough(lattice: Lattice, wrap: Wrap) -> HeightMap {
        let shape = Procedural::Fbm { octaves: 3, seed: 5 };
        shape.height_map_f32([9, 7], lattice, wrap).unwrap()
    }

    #[test]
    fn a_plane_has_its_own_normal_in_any_metric() {
        let map = Procedural::Ramp.height_map_f32([5, 4], Lattice::Vertex, Wrap::Repeat).unwrap();
        let metric = Metric::of_face(&map, [2.0, 7.0], 3.0);
        let want = DVec3::new(-1.5, 0.0, 1.0).normalize();
        for kind in KINDS {
            for (cell, local) in [([0, 0], [0.0, 0.5]), ([3, 2], [1.0, 1.0]), ([-4, 3], [0.5; 2])] {
                let n = kind.normal_at(&map, metric, cell, local);
                assert!((n - want).length() < 1e-12, "{kind:?} {cell:?}: {n}");
            }
            let baked = NormalMap::from_height(&map, kind, Metric::UNIT);
            let n = baked.with_metric(Metric::UNIT, metric).normal_at(0.3, 0.9);
            assert!((n - want).length() < 1e-6, "{kind:?}: {n}");
        }
        let turned =
            NormalKind::Exact.normal_at(&map, Metric { z: -3.0, ..metric }, [0; 2], [0.5; 2]);
        assert!(turned.x > 0.0 && turned.z > 0.0);
    }

    #[test]
    fn smooth_and_published_normals_are_continuous_wherever_the_surface_is() {
        let metric = Metric { x: 0.5, y: 0.7, z: 2.0 };
        for lattice in [Lattice::Vertex, Lattice::Texel] {
            for wrap in WRAPS {
                let map = rough(lattice, wrap);
                for kind in [NormalKind::Smooth, NormalKind::Published] {
                    for i in -20..20 {
                        let left = kind.normal_at(&map, metric, [i - 1, 2], [1.0, 0.3]);
                        let right = kind.normal_at(&map, metric, [i, 2], [0.0, 0.3]);
                        assert!((left - right).length() < 1e-12, "{lattice:?} {wrap:?} {i}");
                        let low = kind.normal_at(&map, metric, [3, i - 1], [0.3, 1.0]);
                        let high = kind.normal_at(&map, metric, [3, i], [0.3, 0.0]);
                        assert!((low - high).length() < 1e-12, "{lattice:?} {wrap:?} {i}");
                    }
                }
            }
        }
    }

    #[test]
    fn exact_normals_are_those_of_the_height_gradient() {
        let map = rough(Lattice::Texel, Wrap::Mirror);
        let metric = Metric::of_face(&map, [1.0, 1.0], 0.5);
        for k in 0..40 {
            let (u, v) = (f64::from(k) * 0.13 - 2.0, f64::from(k) * 0.07 - 1.0);
            let (x, y) = (map.x().coordinate(u), map.y().coordinate(v));
            let cell = [x.floor() as i32, y.floor() as i32];
            let local = [x - x.floor(), y - y.floor()];
            let [gu, gv] = map.gradient_at(u, v);
            let want = DVec3::new(-0.5 * gu, -0.5 * gv, 1.0).normalize();
            let n = NormalKind::Exact.normal_at(&map, metric, cell, local);
            assert!((n - want).length() < 1e-9);
        }
    }

    #[test]
    fn inside_a_map_neighbours_are_read_at_once() {
        for lattice in [Lattice::Vertex, Lattice::Texel] {
            for wrap in WRAPS {
                let floats = rough(lattice, wrap);
                let shape = Procedural::Fbm { octaves: 3, seed: 5 };
                let codes = shape.height_map([9, 7], lattice, wrap).unwrap();
                for map in [floats, codes] {
                    let (mut cells, mut inside) = (0, 0);
                    for (i, j) in (-12..24).flat_map(|i| (-12..24).map(move |j| (i, j))) {
                        if let Some([low, high]) = block(&map, [i, j]) {
                            let slow = map.unfolded_corners(i, j).map(f64::from);
                            assert_eq!([low[0], low[1], high[0], high[1]], slow);
                            cells += 1;
                        }
                        if let Some(rows) = block(&map, [i - 1, j - 1]) {
                            let slow = NormalKind::Smooth.slopes_at_corners(&map, [i, j]);
                            assert_eq!(smooth_slopes(&rows), slow);
                            inside += 1;
                        }
                    }
                    assert_eq!((cells, inside), (8 * 6, 6 * 4));
                }
            }
        }
    }

    #[test]
    fn smooth_is_a_central_and_published_a_one_sided_difference() {
        let samples = Samples::F32(vec![0.0, 1.0, 4.0, 0.0, 1.0, 4.0]);
        let map = HeightMap::new(3, 2, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
        let slope = |kind: NormalKind, cell: i32, local: f64| {
            let n = kind.normal_at(&map, Metric::UNIT, [cell, 0], [local, 0.5]);
            -n.x / n.z
        };
        let near = |a: f64, b: f64| (a - b).abs() < 1e-12;
        assert!(near(slope(NormalKind::Smooth, 0, 1.0), 2.0));
        assert!(near(slope(NormalKind::Published, 0, 1.0), 3.0));
        assert!(near(slope(NormalKind::Smooth, 0, 0.0), 0.5), "clamped border");
        let map = map.with_lattice(Lattice::Vertex, Wrap::Repeat);
        let at_jump = NormalKind::Published.normal_at(&map, Metric::UNIT, [1, 0], [1.0, 0.5]);
        assert!(near(-at_jump.x / at_jump.z, 3.0), "a jump ends the surface");
        let after = NormalKind::Smooth.normal_at(&map, Metric::UNIT, [2, 0], [0.0, 0.5]);
        assert!(near(-after.x / after.z, 1.0));
    }
}
