//! [`ColourImage`]: texels at the depth of their file, looked up bilinearly in a pyramid of means.
//!
//! Texels are decoded to linear light before they are mixed. Texel (i, j) sits at
//! `u = (i + 0.5) / width`, `v = (j + 0.5) / height`; row 0 is at `v = 0`, the *bottom* of a
//! picture.
//!
//! Each coarser image has half the texels along an axis, rounded down, each the mean of the area it
//! covers, stored at the same depth. The coarser images are made when one is first asked for.

use std::sync::OnceLock;

use glam::DVec2;
use rilievo::map::Wrap;

use super::coarser::coarser;
use crate::colour::{Rgb, linear_from_srgb};

/// The texels of a colour image, row-major, row 0 at `v = 0`.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 8-bit sRGB codes.
    Srgb8(Vec<[u8; 3]>),
    /// 16-bit sRGB codes.
    Srgb16(Vec<[u16; 3]>),
    /// 8-bit codes of linear numbers, `code / 255`.
    Linear8(Vec<[u8; 3]>),
    /// 16-bit codes of linear numbers, `code / 65535`.
    Linear16(Vec<[u16; 3]>),
    /// Linear values.
    Linear(Vec<[f32; 3]>),
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::Srgb8(v) | Self::Linear8(v) => v.len(),
            Self::Srgb16(v) | Self::Linear16(v) => v.len(),
            Self::Linear(v) => v.len(),
        }
    }

    /// Bytes a texel.
    fn bytes(&self) -> u64 {
        match self {
            Self::Srgb8(_) | Self::Linear8(_) => 3,
            Self::Srgb16(_) | Self::Linear16(_) => 6,
            Self::Linear(_) => 12,
        }
    }
}

/// Why a colour image was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TextureError {
    /// No texel along an axis, or more than `i32` indices can count.
    #[error("a colour image needs 1 to 16777216 texels along an axis, not {width} x {height}")]
    BadSize {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
    },
    /// The texel count is not width times height.
    #[error("{width} x {height} needs {} texels, {found} were given", u64::from(*width) * u64::from(*height))]
    WrongCount {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
        /// Texels given.
        found: usize,
    },
    /// A texel is NaN, infinite or below 0.
    #[error("texel ({i}, {j}) holds {value}; colours must be finite and at least 0")]
    BadValue {
        /// Column.
        i: u32,
        /// Row, counted from `v = 0`.
        j: u32,
        /// The value found.
        value: f32,
    },
}

/// An image without coarser ones.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Texels,
}

/// A colour image; immutable and valid by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourImage {
    finest: Level,
    /// Halved again and again, down to one texel; made when first asked for.
    coarser: OnceLock<Vec<Level>>,
    /// The linear value of every 8-bit code.
    linear_of_code: Vec<f32>,
}

impl ColourImage {
    /// An image of `width` x `height` texels.
    ///
    /// # Errors
    /// [`TextureError`] for an empty axis, a wrong count, or a texel that is not a colour.
    pub fn new(width: u32, height: u32, texels: Texels) -> Result<Self, TextureError> {
        let axis = 1..=1 << 24;
        if !axis.contains(&width) || !axis.contains(&height) {
            return Err(TextureError::BadSize { width, height });
        }
        if texels.len() as u64 != u64::from(width) * u64::from(height) {
            return Err(TextureError::WrongCount { width, height, found: texels.len() });
        }
        if let Texels::Linear(v) = &texels {
            let bad = |c: &f32| !(c.is_finite() && *c >= 0.0);
            if let Some(at) = v.iter().position(|texel| texel.iter().any(bad)) {
                let (i, j) = (at % width as usize, at / width as usize);
                let value = v[at].into_iter().find(bad).unwrap_or(f32::NAN);
                return Err(TextureError::BadValue { i: i as u32, j: j as u32, value });
            }
        }
        Ok(Self::unchecked(Level { width, height, texels }))
    }

    /// The same codes taken as linear numbers; float texels are such already.
    #[must_use]
    pub fn into_linear(self) -> Self {
        let Level { width, height, texels } = self.finest;
        let texels = match texels {
            Texels::Srgb8(v) => Texels::Linear8(v),
            Texels::Srgb16(v) => Texels::Linear16(v),
            linear => linear,
        };
        Self::unchecked(Level { width, height, texels })
    }

    fn unchecked(finest: Level) -> Self {
        let codes = (0..=255).map(|code| f64::from(code) / 255.0);
        let linear_of_code = match finest.texels {
            Texels::Srgb8(_) => codes.map(|code| linear_from_srgb(code) as f32).collect(),
            Texels::Linear8(_) => codes.map(|code| code as f32).collect(),
            Texels::Srgb16(_) | Texels::Linear16(_) | Texels::Linear(_) => Vec::new(),
        };
        Self { finest, coarser: OnceLock::new(), linear_of_code }
    }

    /// The image at half its width and height; the image itself if it is a single texel.
    #[must_use]
    pub fn halved(&self) -> Self {
        let finest = match (self.finest.width, self.finest.height) {
            (1, 1) => self.finest.clone(),
            _ => coarser(&self.finest, &|level, i, j| self.texel_of(level, i, j)),
        };
        Self::unchecked(finest)
    }

    /// Texels along u.
    pub fn width(&self) -> u32 {
        self.finest.width
    }

    /// Texels along v.
    pub fn height(&self) -> u32 {
        self.finest.height
    }

    /// Bytes held by the texels, without those of the coarser images.
    pub fn bytes(&self) -> u64 {
        self.finest.texels.bytes() * self.finest.texels.len() as u64
    }

    /// Bytes that the coarser images hold, or will once they are asked for.
    pub fn coarser_bytes(&self) -> u64 {
        let (mut width, mut height) = (self.finest.width, self.finest.height);
        let mut texels = 0;
        while width > 1 || height > 1 {
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            texels += u64::from(width) * u64::from(height);
        }
        texels * self.finest.texels.bytes()
    }

    /// The linear colour of a texel.
    ///
    /// # Panics
    /// If `i` or `j` is out of range.
    pub fn texel(&self, i: u32, j: u32) -> Rgb {
        let Level { width, height, .. } = self.finest;
        assert!(i < width && j < height, "texel ({i}, {j}) is outside the image");
        self.texel_of(&self.finest, i, j)
    }

    #[inline]
    fn texel_of(&self, level: &Level, i: u32, j: u32) -> Rgb {
        let at = j as usize * level.width as usize + i as usize;
        let code = |c: u8| f64::from(self.linear_of_code[usize::from(c)]);
        let rgb = match &level.texels {
            Texels::Srgb8(v) | Texels::Linear8(v) => v[at].map(code),
            Texels::Srgb16(v) => v[at].map(|c| linear_from_srgb(f64::from(c) / 65535.0)),
            Texels::Linear16(v) => v[at].map(|c| f64::from(c) / 65535.0),
            Texels::Linear(v) => v[at].map(f64::from),
        };
        Rgb::from_array(rgb)
    }

    /// The linear colour at `uv`, bilinear between texel centres of the repeated image; black where
    /// `uv` is not finite.
    pub fn lookup(&self, uv: DVec2) -> Rgb {
        self.lookup_wrapped(uv, [Wrap::Repeat; 2])
    }

    /// The same with what `wrap` says lies beyond the borders along u and v.
    pub(super) fn lookup_wrapped(&self, uv: DVec2, wrap: [Wrap; 2]) -> Rgb {
        if !uv.is_finite() {
            return Rgb::ZERO;
        }
        self.lookup_level(&self.finest, uv, wrap)
    }

    fn lookup_level(&self, level: &Level, uv: DVec2, wrap: [Wrap; 2]) -> Rgb {
        let (i, s) = neighbours(uv.x, level.width, wrap[0]);
        let (j, t) = neighbours(uv.y, level.height, wrap[1]);
        let texel = |a: usize, b: usize| self.texel_of(level, i[a], j[b]);
        let low = texel(0, 0).lerp(texel(1, 0), s);
        let high = texel(0, 1).lerp(texel(1, 1), s);
        low.lerp(high, t)
    }

    /// The mean colour over a window of `width` along u and v around `uv`, about: between the two
    /// levels whose texels are nearest in size to its narrower side, counted in texels. So a window
    /// that is long and narrow is not blurred across; samples along it are the caller's to take.
    pub(super) fn lookup_mean(&self, uv: DVec2, width: DVec2, wrap: [Wrap; 2]) -> Rgb {
        let Level { width: columns, height: rows, .. } = self.finest;
        let side = (width.x * f64::from(columns)).min(width.y * f64::from(rows));
        if side.is_nan() || side <= 1.0 || !uv.is_finite() {
            return self.lookup_wrapped(uv, wrap);
        }
        let levels = self.coarser.get_or_init(|| self.all_coarser());
        let (whole, part) = (side.log2().floor(), side.log2().fract());
        let at = |depth: usize| match depth.min(levels.len()) {
            0 => &self.finest,
            k => &levels[k - 1],
        };
        let depth = whole.min(64.0) as usize;
        let fine = self.lookup_level(at(depth), uv, wrap);
        if depth >= levels.len() || part < 1e-3 {
            return fine;
        }
        fine.lerp(self.lookup_level(at(depth + 1), uv, wrap), part)
    }

    fn all_coarser(&self) -> Vec<Level> {
        let mut levels: Vec<Level> = Vec::new();
        loop {
            let last = levels.last().unwrap_or(&self.finest);
            if last.width == 1 && last.height == 1 {
                return levels;
            }
            let next = coarser(last, &|level, i, j| self.texel_of(level, i, j));
            levels.push(next);
        }
    }
}

/// The two texels around a coordinate, and the weight of the second.
#[inline]
fn neighbours(u: f64, texels: u32, wrap: Wrap) -> ([u32; 2], f64) {
    let n = f64::from(texels);
    let last = texels - 1;
    match wrap {
        Wrap::Repeat => {
            let x = (u - u.floor()) * n - 0.5;
            let first = x.floor();
            let i = (first as i64).rem_euclid(i64::from(texels)) as u32;
            let next = if i == last { 0 } else { i + 1 };
            ([i, next], x - first)
        }
        Wrap::Clamp => {
            let x = (u * n - 0.5).clamp(0.0, f64::from(last));
            let i = x as u32;
            ([i, (i + 1).min(last)], x - f64::from(i))
        }
        Wrap::Mirror => {
            // There and back is one period.
            let turn = (0.5 * u - (0.5 * u).floor()) * 2.0;
            neighbours(if turn > 1.0 { 2.0 - turn } else { turn }, texels, Wrap::Clamp)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn corners() -> ColourImage {
        let texels = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
        ColourImage::new(2, 2, Texels::Linear(texels)).unwrap()
    }

    #[test]
    fn texel_centres_and_midpoints() {
        let image = corners();
        assert_eq!(image.lookup(DVec2::new(0.25, 0.25)), Rgb::X);
        assert_eq!(image.lookup(DVec2::new(0.75, 0.25)), Rgb::Y);
        assert_eq!(image.lookup(DVec2::new(0.25, 0.75)), Rgb::Z);
        assert_eq!(image.lookup(DVec2::new(0.5, 0.25)), Rgb::new(0.5, 0.5, 0.0));
        assert_eq!(image.lookup(DVec2::new(0.5, 0.5)), Rgb::splat(0.5));
    }

    #[test]
    fn beyond_the_borders() {
        let ramp = (0..4).map(|i| [i as f32; 3]).collect();
        let image = ColourImage::new(4, 1, Texels::Linear(ramp)).unwrap();
        let red = |u, wrap| image.lookup_wrapped(DVec2::new(u, 0.3), [wrap; 2]).x;
        for (u, repeat, clamp, mirror) in [
            (0.125, 0.0, 0.0, 0.0),
            (0.0, 1.5, 0.0, 0.0),
            (1.125, 0.0, 3.0, 3.0),
            (1.375, 1.0, 3.0, 2.0),
            (-0.375, 2.0, 0.0, 1.0),
            (-2.375, 2.0, 0.0, 1.0_f64),
        ] {
            assert!((red(u, Wrap::Repeat) - repeat).abs() < 1e-12, "{u}");
            assert!((red(u, Wrap::Clamp) - clamp).abs() < 1e-12, "{u}");
            assert!((red(u, Wrap::Mirror) - mirror).abs() < 1e-12, "{u}: {}", red(u, Wrap::Mirror));
        }
        assert_eq!(image.lookup(DVec2::NAN), Rgb::ZERO);
    }

    #[test]
    fn windows_show_means() {
        // Columns of 0 and 1, 12 x 5: odd sizes on the way down.
        let texels = (0..60).map(|k| [(k % 2) as f32; 3]).collect();
        let image = ColourImage::new(12, 5, Texels::Linear(texels)).unwrap();
        let wrap = [Wrap::Repeat; 2];
        let mean = |uv, width| image.lookup_mean(uv, DVec2::splat(width), wrap).x;
        for k in 0..20 {
            let uv = DVec2::new(f64::from(k) * 0.0731, 0.3);
            assert_eq!(mean(uv, 0.0), image.lookup(uv).x);
            assert_eq!(mean(uv, 0.19), image.lookup(uv).x);
            assert!((mean(uv, 0.45) - 0.5).abs() < 1e-6);
            assert!((mean(uv, 1e9) - 0.5).abs() < 1e-6);
        }
        assert_eq!(image.coarser_bytes(), 12 * (6 * 2 + 3 + 1));
        let small = image.halved();
        assert_eq!((small.width(), small.height()), (6, 2));
        assert_eq!(small.texel(3, 1), Rgb::splat(0.5));
    }

    #[test]
    fn means_are_taken_in_linear_light() {
        let board = |k: usize| [if k.is_multiple_of(2) { 0 } else { 255 }; 3];
        let codes: Vec<_> = (0..4).map(board).collect();
        let image = ColourImage::new(4, 1, Texels::Srgb8(codes.clone())).unwrap();
        assert!((image.halved().texel(0, 0).x - 0.5).abs() < 3e-3);
        let image = ColourImage::new(4, 1, Texels::Linear8(codes)).unwrap();
        assert!((image.halved().texel(1, 0).x - 0.5).abs() < 3e-3);
        let wide = vec![[0; 3], [65535; 3]];
        let image = ColourImage::new(1, 2, Texels::Srgb16(wide.clone())).unwrap();
        assert!((image.halved().texel(0, 0).x - 0.5).abs() < 1e-4);
        let image = ColourImage::new(1, 2, Texels::Linear16(wide)).unwrap();
        assert!((image.halved().texel(0, 0).x - 0.5).abs() < 1e-4);
    }

    #[test]
    fn codes_are_decoded_before_mixing() {
        let image = ColourImage::new(2, 1, Texels::Srgb8(vec![[0; 3], [255; 3]])).unwrap();
        assert!((image.lookup(DVec2::new(0.5, 0.5)).x - 0.5).abs() < 1e-6);
        let half = ColourImage::new(1, 1, Texels::Srgb16(vec![[32768; 3]])).unwrap();
        assert!((half.lookup(DVec2::ZERO).x - 0.214).abs() < 1e-3);
        assert_eq!(half.bytes(), 6);
    }

    #[test]
    fn bad_images_are_refused() {
        let short = ColourImage::new(2, 2, Texels::Srgb8(vec![[0; 3]; 3]));
        assert_eq!(short, Err(TextureError::WrongCount { width: 2, height: 2, found: 3 }));
        let none = ColourImage::new(0, 1, Texels::Srgb8(Vec::new()));
        assert!(matches!(none, Err(TextureError::BadSize { .. })));
        let nan = Texels::Linear(vec![[0.0; 3], [0.0, f32::NAN, 0.0]]);
        let error = ColourImage::new(1, 2, nan).unwrap_err();
        assert!(matches!(error, TextureError::BadValue { i: 0, j: 1, .. }));
    }
}
