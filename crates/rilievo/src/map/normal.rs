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
//!
//! **Normals transform as covectors.** A map made in metric `a` has in metric `b` the normals
//! `(n.x a.x / b.x, n.y a.y / b.y, n.z a.z / b.z)`, normalised, which needs no heights and keeps
//! its sense for any normal.

use glam::DVec3;

use super::height::HeightMap;
use super::lattice::{Axis, Lattice, Wrap};
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

/// Sign of the green channel of a normal map's texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum NormalConvention {
    /// Green grows with slopes that face up the image, towards larger v.
    OpenGl,
    /// Green grows with slopes that face down the image.
    DirectX,
}

/// The texels of a normal map, row-major, row 0 at `v = 0`: red, green, blue are x, y, z, with -1 at
/// code 0 and 1 at the highest code.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum NormalTexels {
    /// 8 bits a channel.
    U8(Vec<[u8; 3]>),
    /// 16 bits a channel.
    U16(Vec<[u16; 3]>),
}

/// Why a normal map was refused.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NormalMapError {
    /// A size out of range along an axis.
    #[error("a normal map has 2 to 16777216 texels along an axis, not {width} x {height}")]
    Size {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
    },
    /// The texel count is not width times height.
    #[error("{width} x {height} needs {} texels, {found} were given", *width as u64 * *height as u64)]
    Count {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
        /// Texels given.
        found: usize,
    },
}

/// A grid of unit normals in map axes, one a sample, with a lattice and a wrap mode. Beyond a
/// clamped border the border's normals hold, as in any texture.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    x: Axis,
    y: Axis,
    normals: Vec<[f32; 3]>,
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
        match self {
            Self::Exact => {
                let h = heights.unfolded_corners(cell[0], cell[1]).map(f64::from);
                let [fx, fy] = local;
                let along_x = (h[1] - h[0]) * (1.0 - fy) + (h[3] - h[2]) * fy;
                let along_y = (h[2] - h[0]) * (1.0 - fx) + (h[3] - h[1]) * fx;
                of_slopes(metric, [along_x, along_y])
            }
            Self::Smooth | Self::Published => {
                let corner = |right, up| self.at_corner(heights, metric, cell, [right, up]);
                let corners = [
                    corner(false, false),
                    corner(true, false),
                    corner(false, true),
                    corner(true, true),
                ];
                interpolate(corners, local)
            }
        }
    }

    /// The unit normal at a corner of an unfolded cell, as seen from the cell; `far[a]` chooses the
    /// corner at the larger coordinate.
    fn at_corner(
        self,
        heights: &HeightMap,
        metric: Metric,
        cell: [i32; 2],
        far: [bool; 2],
    ) -> DVec3 {
        let x = Stencil::new(heights.x(), cell[0], far[0]);
        let y = Stencil::new(heights.y(), cell[1], far[1]);
        let raw = |i: u32, j: u32| f64::from(heights.raw(i, j));
        let own = raw(x.own, y.own);
        let slope_x = x.slope(self, own, |i| raw(i, y.own));
        let slope_y = y.slope(self, own, |j| raw(x.own, j));
        of_slopes(metric, [slope_x, slope_y])
    }
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

impl NormalMap {
    /// The normals of `heights` in `metric`, one at each sample.
    ///
    /// A cell's slope has no single value at a sample. [`NormalKind::Exact`] is therefore taken in
    /// the cell after the sample, before it at the far border of a vertex lattice: the same normal
    /// as [`NormalKind::Published`]. Bake [`NormalKind::Smooth`] for shading.
    pub fn from_height(heights: &HeightMap, kind: NormalKind, metric: Metric) -> Self {
        let (x, y) = (*heights.x(), *heights.y());
        let place = |axis: &Axis, k: u32| match axis.lattice() {
            Lattice::Vertex if k + 1 == axis.samples() => (k as i32 - 1, true),
            _ => (k as i32, false),
        };
        let mut normals = Vec::with_capacity(x.samples() as usize * y.samples() as usize);
        for j in 0..y.samples() {
            let (cell_y, up) = place(&y, j);
            for i in 0..x.samples() {
                let (cell_x, right) = place(&x, i);
                let cell = [cell_x, cell_y];
                let normal = match kind {
                    NormalKind::Exact => {
                        let local = [right, up].map(|far| f64::from(u8::from(far)));
                        kind.normal_at(heights, metric, cell, local)
                    }
                    _ => kind.at_corner(heights, metric, cell, [right, up]),
                };
                normals.push(normal.as_vec3().to_array());
            }
        }
        Self { x, y, normals }
    }

    /// A map from a file's texels. Vectors are normalised; one that is zero becomes (0, 0, 1), one
    /// that points below the surface is turned up to it.
    ///
    /// # Errors
    /// [`NormalMapError`] for fewer than 2 x 2 texels or a wrong count.
    pub fn from_texels(
        [width, height]: [u32; 2],
        texels: &NormalTexels,
        convention: NormalConvention,
        (lattice, wrap): (Lattice, Wrap),
    ) -> Result<Self, NormalMapError> {
        let range = 2..=1 << 24;
        if !range.contains(&width) || !range.contains(&height) {
            return Err(NormalMapError::Size { width, height });
        }
        let found = texels.len();
        if found as u64 != u64::from(width) * u64::from(height) {
            return Err(NormalMapError::Count { width, height, found });
        }
        let decode = |rgb: [f64; 3]| {
            let n = DVec3::from_array(rgb.map(|c| 2.0 * c - 1.0));
            let n = match convention {
                NormalConvention::OpenGl => n,
                NormalConvention::DirectX => DVec3::new(n.x, -n.y, n.z),
            };
            // A positive z keeps every interpolation away from zero.
            let n = DVec3::new(n.x, n.y, n.z.max(1.0 / 65535.0));
            n.normalize_or(DVec3::Z).as_vec3().to_array()
        };
        let normals = match texels {
            NormalTexels::U8(v) => {
                v.iter().map(|t| decode(t.map(|c| f64::from(c) / 255.0))).collect()
            }
            NormalTexels::U16(v) => {
                v.iter().map(|t| decode(t.map(|c| f64::from(c) / 65535.0))).collect()
            }
        };
        let (x, y) = (Axis::new(width, lattice, wrap), Axis::new(height, lattice, wrap));
        Ok(Self { x, y, normals })
    }

    /// The axis along u.
    pub fn x(&self) -> &Axis {
        &self.x
    }

    /// The axis along v.
    pub fn y(&self) -> &Axis {
        &self.y
    }

    /// Bytes held by the normals.
    pub fn bytes(&self) -> u64 {
        self.normals.len() as u64 * 12
    }

    /// The unit normal in map axes at parameters (u, v), any real numbers: interpolated and
    /// renormalised.
    pub fn normal_at(&self, u: f64, v: f64) -> DVec3 {
        let (x, y) = (self.x.coordinate(u), self.y.coordinate(v));
        let (i, j) = (x.floor(), y.floor());
        self.normal_in_cell([i as i32, j as i32], [x - i, y - j])
    }

    /// The unit normal at `local`, in `[0, 1]^2`, of unfolded cell `cell`.
    pub fn normal_in_cell(&self, cell: [i32; 2], local: [f64; 2]) -> DVec3 {
        let ((i0, i1), (j0, j1)) =
            (self.x.unfolded_corners(cell[0]), self.y.unfolded_corners(cell[1]));
        let normal = |right: bool, up: bool| {
            let (i, j) = (if right { i1 } else { i0 }, if up { j1 } else { j0 });
            let at = j as usize * self.x.samples() as usize + i as usize;
            let [x, y, z] = self.normals[at].map(f64::from);
            // What is shown in a mirror leans the other way.
            let x = if mirrored(&self.x, cell[0], right) { -x } else { x };
            let y = if mirrored(&self.y, cell[1], up) { -y } else { y };
            DVec3::new(x, y, z)
        };
        let corners =
            [normal(false, false), normal(true, false), normal(false, true), normal(true, true)];
        interpolate(corners, local)
    }

    /// The same relief's normals on a face of another size or depth: made in metric `from`, used in
    /// metric `to`. Lengths must not be 0, but for `to.z`, which then gives (0, 0, 1) everywhere.
    #[must_use]
    pub fn with_metric(mut self, from: Metric, to: Metric) -> Self {
        // Covector scaling, times to.z / from.z so that a flat face needs no division by zero.
        let depth = to.z / from.z;
        let scale = DVec3::new(depth * from.x / to.x, depth * from.y / to.y, 1.0);
        for normal in &mut self.normals {
            let n = DVec3::from_array(normal.map(f64::from)) * scale;
            *normal = n.normalize_or(DVec3::Z).as_vec3().to_array();
        }
        self
    }

    /// The texels of the map, 16 bits a channel, rounded to nearest; row-major from `v = 0`.
    pub fn to_texels(&self, convention: NormalConvention) -> Vec<[u16; 3]> {
        let green = match convention {
            NormalConvention::OpenGl => 1.0,
            NormalConvention::DirectX => -1.0,
        };
        let code = |c: f64| ((0.5 * c + 0.5) * 65535.0).round() as u16;
        self.normals
            .iter()
            .map(|&[x, y, z]| [f64::from(x), green * f64::from(y), f64::from(z)].map(code))
            .collect()
    }
}

impl NormalTexels {
    /// Number of texels.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(v) => v.len(),
            Self::U16(v) => v.len(),
        }
    }

    /// Whether there is no texel.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Whether a corner of an unfolded cell shows its sample in a mirror. On the vertex lattice mirrors
/// stand at samples, and the cell tells; on the texel lattice they stand between samples, and the
/// corner itself does: it lies in the mirror if the cell before it does.
fn mirrored(axis: &Axis, cell: i32, far: bool) -> bool {
    let cell = match axis.lattice() {
        Lattice::Vertex => cell,
        Lattice::Texel => cell.saturating_add(i32::from(far)).saturating_sub(1),
    };
    axis.run(cell).flipped
}

/// The unit normal of slopes in raw units per cell.
fn of_slopes(metric: Metric, [x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(-x * metric.z / metric.x, -y * metric.z / metric.y, 1.0).normalize_or(DVec3::Z)
}

/// Bilinear mix of the normals at the corners `[00, 10, 01, 11]` of a cell, renormalised.
fn interpolate([a, b, c, d]: [DVec3; 4], [u, v]: [f64; 2]) -> DVec3 {
    a.lerp(b, u).lerp(c.lerp(d, u), v).normalize_or(DVec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Procedural, Samples};

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

    #[test]
    fn a_baked_map_reads_as_its_heights_do_at_the_samples() {
        let metric = Metric { x: 0.5, y: 0.7, z: 2.0 };
        for lattice in [Lattice::Vertex, Lattice::Texel] {
            for wrap in WRAPS {
                let map = rough(lattice, wrap);
                let baked = NormalMap::from_height(&map, NormalKind::Smooth, metric);
                // Beyond a clamped border the heights are level, but a texture keeps its border.
                let cells = if wrap == Wrap::Clamp { 0..8 } else { -12..20 };
                for i in cells {
                    let n = baked.normal_in_cell([i, 3], [0.0, 0.0]);
                    let want = NormalKind::Smooth.normal_at(&map, metric, [i, 3], [0.0; 2]);
                    assert!((n - want).length() < 1e-6, "{lattice:?} {wrap:?} {i}: {n} {want}");
                }
            }
        }
    }

    #[test]
    fn another_metric_is_the_same_as_another_bake() {
        let map = rough(Lattice::Texel, Wrap::Repeat);
        let (a, b) = (Metric { x: 0.5, y: 0.7, z: 2.0 }, Metric { x: 0.1, y: 3.0, z: 0.4 });
        for kind in KINDS {
            let moved = NormalMap::from_height(&map, kind, a).with_metric(a, b);
            let baked = NormalMap::from_height(&map, kind, b);
            for (m, n) in moved.normals.iter().zip(&baked.normals) {
                assert!(m.iter().zip(n).all(|(p, q)| (p - q).abs() < 1e-5), "{m:?} {n:?}");
            }
        }
        let flat = NormalMap::from_height(&map, NormalKind::Smooth, a);
        let flat = flat.with_metric(a, Metric { z: 0.0, ..b });
        assert_eq!(flat.normal_at(0.2, 0.7), DVec3::Z);
    }

    #[test]
    fn texels_go_out_and_come_back_in_both_conventions() {
        let map = rough(Lattice::Texel, Wrap::Repeat);
        let baked =
            NormalMap::from_height(&map, NormalKind::Smooth, Metric { z: 9.0, ..Metric::UNIT });
        let gl = baked.to_texels(NormalConvention::OpenGl);
        let dx = baked.to_texels(NormalConvention::DirectX);
        assert!(gl.iter().zip(&dx).all(|(a, b)| a[1].abs_diff(65535 - b[1]) <= 1));
        for (texels, convention) in
            [(gl, NormalConvention::OpenGl), (dx, NormalConvention::DirectX)]
        {
            let texels = NormalTexels::U16(texels);
            let wrap = (Lattice::Texel, Wrap::Repeat);
            let back = NormalMap::from_texels([9, 7], &texels, convention, wrap).unwrap();
            for (m, n) in baked.normals.iter().zip(&back.normals) {
                assert!(m.iter().zip(n).all(|(p, q)| (p - q).abs() < 1e-4), "{m:?} {n:?}");
            }
        }
    }

    #[test]
    fn odd_texels_give_unit_normals_above_the_surface() {
        let texels =
            NormalTexels::U8(vec![[128, 128, 0], [127, 127, 127], [255, 0, 0], [0, 255, 255]]);
        let wrap = (Lattice::Texel, Wrap::Clamp);
        let map = NormalMap::from_texels([2, 2], &texels, NormalConvention::OpenGl, wrap).unwrap();
        for n in &map.normals {
            let n = DVec3::from_array(n.map(f64::from));
            assert!((n.length() - 1.0).abs() < 1e-6 && n.z > 0.0);
        }
        assert!(map.normal_at(0.5, 0.5).is_normalized());
        let few = NormalMap::from_texels([3, 2], &texels, NormalConvention::OpenGl, wrap);
        let count = NormalMapError::Count { width: 3, height: 2, found: 4 };
        assert_eq!(few.unwrap_err(), count);
    }
}
