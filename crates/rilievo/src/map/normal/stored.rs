//! [`NormalMap`]: normals kept in a grid, from heights or from a file.
//!
//! **Normals transform as covectors.** A map made in metric `a` has in metric `b` the normals
//! `(n.x a.x / b.x, n.y a.y / b.y, n.z a.z / b.z)`, normalised, which needs no heights and keeps
//! its sense for any normal.

use glam::DVec3;

use super::NormalKind;
use crate::map::{Axis, HeightMap, Lattice, Metric, Wrap};

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
                let local = [right, up].map(|far| f64::from(u8::from(far)));
                let normal = kind.normal_at(heights, metric, cell, local);
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
        let low = normal(false, false).lerp(normal(true, false), local[0]);
        let high = normal(false, true).lerp(normal(true, true), local[0]);
        low.lerp(high, local[1]).normalize_or(DVec3::Z)
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Procedural;

    const KINDS: [NormalKind; 3] = [NormalKind::Exact, NormalKind::Smooth, NormalKind::Published];
    const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];

    fn rough(lattice: Lattice, wrap: Wrap) -> HeightMap {
        let shape = Procedural::Fbm { octaves: 3, seed: 5 };
        shape.height_map_f32([9, 7], lattice, wrap).unwrap()
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
