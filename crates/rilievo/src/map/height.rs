//! [`HeightMap`]: the shape of a displacement, free of any surface.
//!
//! Samples are stored once, as the file had them: `u16` codes or `f32` values, row-major, row 0
//! at `v = 0` (the *bottom* of an image). The *raw* value of a sample is its code or its value; its
//! *height* is `raw * unit`, with `unit = 1 / 65535` for codes and 1 for floats. Everything that
//! traces works on raw values, so that no second copy of the map is needed and codes stay exact.
//!
//! Between samples the height is bilinear: that is the surface, not an approximation of it.

mod edit;

use std::ops::Range;

use super::lattice::{Axis, Lattice, Run, Wrap};

pub use edit::RowMut;

/// The samples of a height map, row-major, row 0 at `v = 0`.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Codes; height = code / 65535.
    U16(Vec<u16>),
    /// Heights themselves; all finite.
    F32(Vec<f32>),
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        match self {
            Self::U16(v) => v.len(),
            Self::F32(v) => v.len(),
        }
    }

    /// Whether there is no sample.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::U16(v) => v.len() as u64 * 2,
            Self::F32(v) => v.len() as u64 * 4,
        }
    }
}

/// Why a height map was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum HeightMapError {
    /// Fewer than two samples along an axis.
    #[error("a height map needs at least 2 x 2 samples, not {width} x {height}")]
    TooSmall {
        /// Samples along u.
        width: u32,
        /// Samples along v.
        height: u32,
    },
    /// More samples along an axis than indices can count.
    #[error("a height map has at most 16777216 samples along an axis, not {width} x {height}")]
    TooLarge {
        /// Samples along u.
        width: u32,
        /// Samples along v.
        height: u32,
    },
    /// The sample count is not width times height.
    #[error("{width} x {height} needs {} samples, {found} were given", *width as u64 * *height as u64)]
    WrongCount {
        /// Samples along u.
        width: u32,
        /// Samples along v.
        height: u32,
        /// Samples given.
        found: usize,
    },
    /// A sample is NaN or infinite, or so large that heights could overflow.
    #[error("sample ({i}, {j}) is {value}; heights must be finite and below 1e18 in size")]
    NotFinite {
        /// Column.
        i: u32,
        /// Row, counted from `v = 0`.
        j: u32,
        /// The value found.
        value: f32,
    },
    /// A rectangle to edit reaches beyond the map, or ends before it begins.
    #[error("samples {x:?} x {y:?} are not a part of a map of {width} x {height}")]
    NotInside {
        /// Columns asked for.
        x: Range<u32>,
        /// Rows asked for.
        y: Range<u32>,
        /// Samples along u.
        width: u32,
        /// Samples along v.
        height: u32,
    },
}

/// A grid of heights with a lattice and a wrap mode, valid by construction and after every edit.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightMap {
    x: Axis,
    y: Axis,
    samples: Samples,
    raw_min: f32,
    raw_max: f32,
}

impl HeightMap {
    /// A map of `width` x `height` samples, row-major from `v = 0` upwards.
    ///
    /// # Errors
    /// [`HeightMapError`] for fewer than 2 x 2 samples, a wrong count, or a sample that is not
    /// finite.
    pub fn new(
        width: u32,
        height: u32,
        samples: Samples,
        lattice: Lattice,
        wrap: Wrap,
    ) -> Result<Self, HeightMapError> {
        if width < 2 || height < 2 {
            return Err(HeightMapError::TooSmall { width, height });
        }
        if width > 1 << 24 || height > 1 << 24 {
            return Err(HeightMapError::TooLarge { width, height });
        }
        if samples.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(HeightMapError::WrongCount { width, height, found: samples.len() });
        }
        if let Samples::F32(v) = &samples
            && let Some(at) = v.iter().position(|&h| !is_height(h))
        {
            let (i, j) = ((at % width as usize) as u32, (at / width as usize) as u32);
            return Err(HeightMapError::NotFinite { i, j, value: v[at] });
        }
        let (raw_min, raw_max) = range(&samples);
        let (x, y) = (Axis::new(width, lattice, wrap), Axis::new(height, lattice, wrap));
        Ok(Self { x, y, samples, raw_min, raw_max })
    }

    /// The same samples under another lattice or wrap mode; nothing is copied.
    #[must_use]
    pub fn with_lattice(self, lattice: Lattice, wrap: Wrap) -> Self {
        let (w, h) = (self.x.samples(), self.y.samples());
        Self { x: Axis::new(w, lattice, wrap), y: Axis::new(h, lattice, wrap), ..self }
    }

    /// Samples along u.
    #[inline]
    pub fn width(&self) -> u32 {
        self.x.samples()
    }

    /// Samples along v.
    #[inline]
    pub fn height(&self) -> u32 {
        self.y.samples()
    }

    /// The axis along u.
    #[inline]
    pub fn x(&self) -> &Axis {
        &self.x
    }

    /// The axis along v.
    #[inline]
    pub fn y(&self) -> &Axis {
        &self.y
    }

    /// The samples, row-major from `v = 0` upwards.
    #[inline]
    pub fn samples(&self) -> &Samples {
        &self.samples
    }

    /// Height of one raw unit: 1/65535 for codes, 1 for floats.
    #[inline]
    pub fn unit(&self) -> f64 {
        match self.samples {
            Samples::U16(_) => 1.0 / 65535.0,
            Samples::F32(_) => 1.0,
        }
    }

    /// Lowest and highest raw sample.
    #[inline]
    pub fn raw_range(&self) -> (f32, f32) {
        (self.raw_min, self.raw_max)
    }

    /// Raw value of sample (i, j).
    ///
    /// # Panics
    /// If the sample does not exist.
    #[inline]
    pub fn raw(&self, i: u32, j: u32) -> f32 {
        let at = j as usize * self.x.samples() as usize + i as usize;
        match &self.samples {
            Samples::U16(v) => f32::from(v[at]),
            Samples::F32(v) => v[at],
        }
    }

    /// Raw values of samples (i0, j0), (i1, j0), (i0, j1), (i1, j1).
    #[inline(always)]
    fn raw_corners(&self, [i0, i1]: [u32; 2], [j0, j1]: [u32; 2]) -> [f32; 4] {
        let width = self.x.samples() as usize;
        let (low, high) = (j0 as usize * width, j1 as usize * width);
        let (i0, i1) = (i0 as usize, i1 as usize);
        match &self.samples {
            Samples::U16(v) => {
                [v[low + i0].into(), v[low + i1].into(), v[high + i0].into(), v[high + i1].into()]
            }
            Samples::F32(v) => [v[low + i0], v[low + i1], v[high + i0], v[high + i1]],
        }
    }

    /// Raw corner values `[h00, h10, h01, h11]` of the stored cell (cx, cy); `h10` is one step
    /// along x.
    #[inline(always)]
    pub fn stored_corners(&self, cx: u32, cy: u32) -> [f32; 4] {
        let ((i0, i1), (j0, j1)) = (self.x.corners(cx), self.y.corners(cy));
        self.raw_corners([i0, i1], [j0, j1])
    }

    /// Raw corner values `[h00, h10, h01, h11]` of unfolded cell (i, j).
    #[inline(always)]
    pub fn unfolded_corners(&self, i: i32, j: i32) -> [f32; 4] {
        let ((i0, i1), (j0, j1)) = (self.x.unfolded_corners(i), self.y.unfolded_corners(j));
        self.raw_corners([i0, i1], [j0, j1])
    }

    /// The runs of both axes that hold unfolded cell (i, j).
    #[inline]
    pub fn runs(&self, i: i32, j: i32) -> [Run; 2] {
        [self.x.run(i), self.y.run(j)]
    }

    /// Height at parameters (u, v), any real numbers: bilinear between samples.
    pub fn height_at(&self, u: f64, v: f64) -> f64 {
        let (x, y) = (self.x.coordinate(u), self.y.coordinate(v));
        self.raw_at_lattice(x, y) * self.unit()
    }

    /// Raw value at lattice coordinates (x, y).
    #[inline]
    pub fn raw_at_lattice(&self, x: f64, y: f64) -> f64 {
        let (i, j) = (x.floor(), y.floor());
        self.raw_in_cell([i as i32, j as i32], [x - i, y - j])
    }

    /// Raw value at a place of an unfolded cell.
    #[inline]
    pub(crate) fn raw_in_cell(&self, cell: [i32; 2], [fx, fy]: [f64; 2]) -> f64 {
        let h = self.unfolded_corners(cell[0], cell[1]).map(f64::from);
        let (low, high) = (h[0] + (h[1] - h[0]) * fx, h[2] + (h[3] - h[2]) * fx);
        low + (high - low) * fy
    }

    /// Derivatives (dH/du, dH/dv) of the bilinear surface at (u, v), heights per unit of u and v.
    /// On a cell border: those of the cell at the larger coordinate.
    pub fn gradient_at(&self, u: f64, v: f64) -> [f64; 2] {
        let (x, y) = (self.x.coordinate(u), self.y.coordinate(v));
        let (i, j) = (x.floor(), y.floor());
        let h = self.unfolded_corners(i as i32, j as i32).map(f64::from);
        let (fx, fy) = (x - i, y - j);
        let along_x = (h[1] - h[0]) * (1.0 - fy) + (h[3] - h[2]) * fy;
        let along_y = (h[2] - h[0]) * (1.0 - fx) + (h[3] - h[1]) * fx;
        let unit = self.unit();
        [along_x * unit * f64::from(self.x.period()), along_y * unit * f64::from(self.y.period())]
    }

    /// Bytes held by the samples.
    pub fn bytes(&self) -> u64 {
        self.samples.bytes()
    }
}

/// Whether a number may be a height.
fn is_height(h: f32) -> bool {
    h.abs() <= 1e18
}

/// Lowest and highest raw value.
fn range(samples: &Samples) -> (f32, f32) {
    match samples {
        Samples::U16(v) => {
            let (lo, hi) = v.iter().fold((u16::MAX, 0), |(lo, hi), &h| (lo.min(h), hi.max(h)));
            (f32::from(lo), f32::from(hi))
        }
        Samples::F32(v) => {
            v.iter().fold((f32::INFINITY, f32::NEG_INFINITY), |(lo, hi), &h| (lo.min(h), hi.max(h)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ramp(lattice: Lattice, wrap: Wrap) -> HeightMap {
        let v = (0..12).map(|k| (k % 4) as f32 + 10.0 * (k / 4) as f32).collect();
        HeightMap::new(4, 3, Samples::F32(v), lattice, wrap).unwrap()
    }

    #[test]
    fn bilinear_lookup_meets_its_samples_and_the_plane_between() {
        let map = ramp(Lattice::Vertex, Wrap::Clamp);
        assert_eq!(map.height_at(0.0, 0.0), 0.0);
        assert_eq!(map.height_at(1.0, 1.0), 23.0);
        assert!((map.height_at(0.5, 0.25) - (1.5 + 5.0)).abs() < 1e-12);
        let g = map.gradient_at(0.5, 0.25);
        assert!((g[0] - 3.0).abs() < 1e-12 && (g[1] - 20.0).abs() < 1e-12);
    }

    #[test]
    fn texel_centres_hold_the_samples_and_the_map_repeats() {
        let map = ramp(Lattice::Texel, Wrap::Repeat);
        for (k, want) in [(0, 0.0), (3, 3.0), (4, 0.0), (-1, 3.0)] {
            let u = (f64::from(k) + 0.5) / 4.0;
            assert!((map.height_at(u, 0.5 / 3.0) - want).abs() < 1e-12);
        }
    }

    #[test]
    fn bad_maps_are_refused_with_a_reason() {
        let one = HeightMap::new(1, 2, Samples::U16(vec![0; 2]), Lattice::Texel, Wrap::Clamp);
        assert_eq!(one.unwrap_err(), HeightMapError::TooSmall { width: 1, height: 2 });
        let few = HeightMap::new(2, 2, Samples::U16(vec![0; 3]), Lattice::Texel, Wrap::Clamp);
        assert_eq!(few.unwrap_err(), HeightMapError::WrongCount { width: 2, height: 2, found: 3 });
        let nan = Samples::F32(vec![0.0, 1.0, f32::NAN, 0.0]);
        let nan = HeightMap::new(2, 2, nan, Lattice::Texel, Wrap::Clamp);
        assert!(matches!(nan.unwrap_err(), HeightMapError::NotFinite { i: 0, j: 1, .. }));
    }
}
