//! [`CubeHeights`]: an equirectangular map resampled onto the six faces of a cube.
//!
//! **Density.** The cells at the centre of a face span `2 / n` radian, columns of the map span
//! `2 pi / w` at the equator, rows `pi / h`: with `n >= w / pi` and `n >= 2 h / pi` the faces are
//! nowhere coarser than the map, at 1.22 times its samples.
//!
//! **Error.** A lattice point takes the map's own bilinear height in its direction; codes are rounded
//! to the nearest. Between lattice points the faces are bilinear in other coordinates than the map:
//! the difference is first order in `1 / n`, for its kinks, and [`CubeHeights::resampling_error`]
//! measures it. Towards the poles, where the columns of a map crowd, faces leave columns out.

use rayon::prelude::*;

use super::equirectangular::{Equirectangular, Tiling};
use super::{CubeFace, direction};
use crate::map::height::{HeightMap, HeightMapError, Samples};
use crate::map::lattice::{Lattice, Wrap};

use glam::DVec3;

/// Largest number of cells along a side of a face.
const MAX_CELLS: u32 = 1 << 16;

/// Why a map was not resampled.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CubeHeightsError {
    /// No cells, or more than indices and memory can serve.
    #[error("a face of {cells} x {cells} cells; 1 to {MAX_CELLS} are allowed along a side")]
    Cells {
        /// Cells along a side.
        cells: u32,
    },
    /// A map that does not close around the sphere, or is not there.
    #[error(
        "tile {tile:?}; around a sphere a whole number above 0, from pole to pole a number above 0"
    )]
    Tile {
        /// Repetitions around the sphere and from pole to pole.
        tile: [f64; 2],
    },
    /// A face was refused as a height map.
    #[error(transparent)]
    Face(#[from] HeightMapError),
}

/// Six height maps, one for each face of the cube around a sphere, in the order of
/// [`CubeFace::ALL`]. Neighbours have the same samples on their common edges and corners.
#[derive(Clone, Debug, PartialEq)]
pub struct CubeHeights {
    cells: u32,
    tiling: Tiling,
    faces: [HeightMap; 6],
}

/// How far a resampled map is off at the samples of the original, in heights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ResamplingError {
    /// The largest difference.
    pub max: f64,
    /// Root of the mean square over the area of the sphere.
    pub rms: f64,
}

impl CubeHeights {
    /// Resamples an equirectangular map to [`CubeHeights::least_cells`] cells a side. u is the
    /// longitude, v the latitude, as on [`crate::surface::Sphere`]; the map's wrap mode counts from pole
    /// to pole only, where it is tiled. The samples are codes where the map's are.
    ///
    /// # Errors
    /// [`CubeHeightsError`] if that is too many cells or the tiling does not close.
    pub fn resample(map: &HeightMap, tiling: Tiling) -> Result<Self, CubeHeightsError> {
        Self::with_cells(map, tiling, Self::least_cells(map, tiling))
    }

    /// [`CubeHeights::resample`] to `cells` cells a side.
    ///
    /// # Errors
    /// As [`CubeHeights::resample`].
    pub fn with_cells(
        map: &HeightMap,
        tiling: Tiling,
        cells: u32,
    ) -> Result<Self, CubeHeightsError> {
        let Tiling { tile, shift } = tiling;
        let usable = |tile: f64| tile > 0.0 && tile < f64::from(1 << 24);
        let countable = shift.iter().all(|shift| shift.abs() < f64::from(1 << 24));
        if !(usable(tile[0]) && usable(tile[1]) && tile[0].fract() == 0.0 && countable) {
            return Err(CubeHeightsError::Tile { tile });
        }
        if !(1..=MAX_CELLS).contains(&cells) {
            return Err(CubeHeightsError::Cells { cells });
        }
        let around = Equirectangular::new(map, tiling);
        let face = |face: CubeFace| {
            let raw = |i, j| around.raw(direction(cells, face.lattice_point(cells, [i, j])));
            let samples = match map.samples() {
                Samples::U16(_) => Samples::U16(sampled(cells, |i, j| {
                    raw(i, j).round().clamp(0.0, 65535.0) as u16
                })),
                Samples::F32(_) => Samples::F32(sampled(cells, |i, j| raw(i, j) as f32)),
            };
            let side = cells + 1;
            HeightMap::new(side, side, samples, Lattice::Vertex, Wrap::Mirror)
        };
        let [a, b, c, d, e, f] = CubeFace::ALL.map(face);
        Ok(Self { cells, tiling, faces: [a?, b?, c?, d?, e?, f?] })
    }

    /// The fewest cells a side with which faces are nowhere coarser than the map, rounded up to a
    /// multiple of 4: `max(w, 2 h) / pi` with the samples of all repetitions.
    pub fn least_cells(map: &HeightMap, tiling: Tiling) -> u32 {
        let x = f64::from(map.x().period()) * tiling.tile[0];
        let y = f64::from(map.y().period()) * tiling.tile[1];
        let least = x.max(2.0 * y) / std::f64::consts::PI;
        ((least / 4.0).ceil() as u32).saturating_mul(4).max(4)
    }

    /// Bytes of the samples that [`CubeHeights::resample`] makes of a map.
    pub fn predicted_bytes(map: &HeightMap, tiling: Tiling) -> u64 {
        let sample = match map.samples() {
            Samples::U16(_) => 2,
            Samples::F32(_) => 4,
        };
        let side = u64::from(Self::least_cells(map, tiling)) + 1;
        side.saturating_mul(side).saturating_mul(6 * sample)
    }

    /// Six faces that meet.
    pub(super) fn of_faces(faces: [HeightMap; 6], tiling: Tiling) -> Self {
        Self { cells: faces[0].width() - 1, tiling, faces }
    }

    /// How the map lies on the sphere.
    pub fn tiling(&self) -> Tiling {
        self.tiling
    }

    /// Cells along a side of a face.
    pub fn cells(&self) -> u32 {
        self.cells
    }

    /// The map of a face, on a vertex lattice.
    pub fn face(&self, face: CubeFace) -> &HeightMap {
        &self.faces[face.index()]
    }

    /// The maps of all faces.
    pub fn into_faces(self) -> [HeightMap; 6] {
        self.faces
    }

    /// Height in a direction of any length but 0: bilinear on the face.
    pub fn height(&self, along: DVec3) -> f64 {
        let face = CubeFace::towards(along);
        let map = self.face(face);
        let [x, y, z] = face.to_frame(along);
        let n = f64::from(self.cells);
        let [x, y] = [x, y].map(|c| (0.5 * n * (c / z + 1.0)).clamp(0.0, n));
        let [i, j] = [x, y].map(|c| (c as u32).min(self.cells - 1));
        let h = map.stored_corners(i, j).map(f64::from);
        let (fx, fy) = (x - f64::from(i), y - f64::from(j));
        let (low, high) = (h[0] + (h[1] - h[0]) * fx, h[2] + (h[3] - h[2]) * fx);
        (low + (high - low) * fy) * map.unit()
    }

    /// How far these faces are off `map`, which they were made of, at its samples.
    pub fn resampling_error(&self, map: &HeightMap) -> ResamplingError {
        let around = Equirectangular::new(map, self.tiling);
        let row = |j: u32| {
            let (mut max, mut sum, mut area) = (0.0f64, 0.0, 0.0);
            for (i, k) in (0..map.width()).flat_map(|i| around.repetitions().map(move |k| (i, k))) {
                let Some(along) = around.direction([i, j], k) else { continue };
                let own = around.raw(along) * map.unit();
                let off = (self.height(DVec3::from_array(along)) - own).abs();
                let weight = along[0].hypot(along[1]);
                max = max.max(off);
                sum += weight * off * off;
                area += weight;
            }
            [max, sum, area]
        };
        let rows: Vec<_> = (0..map.height()).into_par_iter().map(row).collect();
        // In order: the same for any number of threads.
        let join =
            |[m, s, a]: [f64; 3], [max, sum, area]: [f64; 3]| [m.max(max), s + sum, a + area];
        let [max, sum, area] = rows.into_iter().fold([0.0; 3], join);
        ResamplingError { max, rms: (sum / area.max(f64::MIN_POSITIVE)).sqrt() }
    }
}

/// The samples of a face, row by row.
fn sampled<T: Send>(cells: u32, sample: impl Fn(u32, u32) -> T + Sync) -> Vec<T> {
    let side = u64::from(cells) + 1;
    let at = |k: u64| sample((k % side) as u32, (k / side) as u32);
    (0..side * side).into_par_iter().map(at).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::Procedural;

    fn fbm() -> HeightMap {
        let shape = Procedural::Fbm { octaves: 6, seed: 3 };
        shape.height_map([256, 128], Lattice::Texel, Wrap::Repeat).unwrap()
    }

    #[test]
    fn neighbours_share_their_edges_and_corners() {
        let cube = CubeHeights::resample(&fbm(), Tiling::default()).unwrap();
        let n = cube.cells();
        assert_eq!(n, 84);
        let mut seen = std::collections::HashMap::new();
        let mut shared = 0;
        for face in CubeFace::ALL {
            for k in 0..=n {
                for at in [[0, k], [n, k], [k, 0], [k, n]] {
                    let raw = cube.face(face).raw(at[0], at[1]).to_bits();
                    let known = *seen.entry(face.lattice_point(n, at)).or_insert(raw);
                    assert_eq!(known, raw);
                    shared += 1;
                }
            }
        }
        // Twelve edges without their corners, eight corners.
        assert_eq!((seen.len() as u32, shared), (12 * (n - 1) + 8, 24 * (n + 1)));
    }

    #[test]
    fn the_error_goes_down_with_the_cells() {
        let map = fbm();
        let mut last = f64::INFINITY;
        for cells in [21, 42, 84, 168, 336] {
            let error = CubeHeights::with_cells(&map, Tiling::default(), cells)
                .unwrap()
                .resampling_error(&map);
            assert!(error.rms < 0.8 * last && error.rms <= error.max, "{cells}: {error:?}");
            last = error.rms;
        }
        assert!(last < 0.003, "{last}");
    }

    #[test]
    fn constant_heights_stay_and_bad_sizes_are_refused() {
        let flat = HeightMap::new(9, 5, Samples::U16(vec![777; 45]), Lattice::Vertex, Wrap::Clamp);
        let flat = flat.unwrap();
        let cube = CubeHeights::resample(&flat, Tiling::default()).unwrap();
        assert_eq!(cube.resampling_error(&flat).max, 0.0);
        assert!(CubeFace::ALL.iter().all(|&f| cube.face(f).raw_range() == (777.0, 777.0)));
        for cells in [0, MAX_CELLS + 1] {
            let error = CubeHeights::with_cells(&flat, Tiling::default(), cells).unwrap_err();
            assert_eq!(error, CubeHeightsError::Cells { cells });
        }
        for tile in [[1.5, 1.0], [0.0, 1.0], [2.0, -1.0], [1.0, f64::NAN], [1e300, 1.0]] {
            let tiling = Tiling { tile, ..Tiling::default() };
            let error = CubeHeights::with_cells(&flat, tiling, 8).unwrap_err();
            assert!(matches!(error, CubeHeightsError::Tile { .. }));
        }
        let dense = Tiling { tile: [1e6, 1e6], ..Tiling::default() };
        let error = CubeHeights::resample(&flat, dense).unwrap_err();
        assert!(matches!(error, CubeHeightsError::Cells { .. }));
    }
}
