//! Colour textures: an image kept at the depth of its file, looked up bilinearly.
//!
//! Texels are decoded to linear light before they are mixed. Texel (i, j) sits at
//! `u = (i + 0.5) / width`, `v = (j + 0.5) / height`; row 0 is at `v = 0`, the *bottom* of a
//! picture, and the image repeats in both directions.

use std::sync::Arc;

use glam::DVec2;

use crate::colour::{Rgb, linear_from_srgb};

/// The texels of a colour image, row-major, row 0 at `v = 0`.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 8-bit sRGB codes.
    Srgb8(Vec<[u8; 3]>),
    /// 16-bit sRGB codes.
    Srgb16(Vec<[u16; 3]>),
    /// Linear values.
    Linear(Vec<[f32; 3]>),
}

impl Texels {
    fn len(&self) -> usize {
        match self {
            Self::Srgb8(v) => v.len(),
            Self::Srgb16(v) => v.len(),
            Self::Linear(v) => v.len(),
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

/// A colour image; immutable and valid by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourImage {
    width: u32,
    height: u32,
    texels: Texels,
    /// `linear_from_srgb(code / 255)` for every 8-bit code.
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
        let mut linear_of_code = Vec::new();
        match &texels {
            Texels::Linear(v) => {
                let bad = |c: &f32| !(c.is_finite() && *c >= 0.0);
                if let Some(at) = v.iter().position(|texel| texel.iter().any(bad)) {
                    let (i, j) = (at % width as usize, at / width as usize);
                    let value = v[at].into_iter().find(bad).unwrap_or(f32::NAN);
                    return Err(TextureError::BadValue { i: i as u32, j: j as u32, value });
                }
            }
            Texels::Srgb8(_) => {
                linear_of_code = (0..=255)
                    .map(|code| linear_from_srgb(f64::from(code) / 255.0) as f32)
                    .collect();
            }
            Texels::Srgb16(_) => {}
        }
        Ok(Self { width, height, texels, linear_of_code })
    }

    /// Texels along u.
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Texels along v.
    pub fn height(&self) -> u32 {
        self.height
    }

    /// Bytes held by the texels.
    pub fn bytes(&self) -> u64 {
        let texel = match self.texels {
            Texels::Srgb8(_) => 3,
            Texels::Srgb16(_) => 6,
            Texels::Linear(_) => 12,
        };
        texel * self.texels.len() as u64
    }

    /// The linear colour of a texel.
    ///
    /// # Panics
    /// If `i` or `j` is out of range.
    pub fn texel(&self, i: u32, j: u32) -> Rgb {
        assert!(i < self.width && j < self.height, "texel ({i}, {j}) is outside the image");
        let at = j as usize * self.width as usize + i as usize;
        let rgb = match &self.texels {
            Texels::Srgb8(v) => v[at].map(|c| f64::from(self.linear_of_code[usize::from(c)])),
            Texels::Srgb16(v) => v[at].map(|c| linear_from_srgb(f64::from(c) / 65535.0)),
            Texels::Linear(v) => v[at].map(f64::from),
        };
        Rgb::from_array(rgb)
    }

    /// The linear colour at `uv`, bilinear between texel centres; black where `uv` is not finite.
    pub fn lookup(&self, uv: DVec2) -> Rgb {
        if !uv.is_finite() {
            return Rgb::ZERO;
        }
        let (i, s) = neighbours(uv.x, self.width);
        let (j, t) = neighbours(uv.y, self.height);
        let low = self.texel(i[0], j[0]).lerp(self.texel(i[1], j[0]), s);
        let high = self.texel(i[0], j[1]).lerp(self.texel(i[1], j[1]), s);
        low.lerp(high, t)
    }
}

/// The two texels around a repeating coordinate, and the weight of the second.
fn neighbours(u: f64, texels: u32) -> ([u32; 2], f64) {
    let n = f64::from(texels);
    let x = (u - u.floor()) * n - 0.5;
    let first = x.floor();
    let i = (first as i64).rem_euclid(i64::from(texels)) as u32;
    let next = if i + 1 == texels { 0 } else { i + 1 };
    ([i, next], x - first)
}

/// An image laid over the uv square of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The image, shared by all materials that use it.
    pub image: Arc<ColourImage>,
    /// Repetitions of the image over `u` and `v` in `[0, 1]`.
    pub tile: DVec2,
    /// Added to `uv * tile`.
    pub shift: DVec2,
}

impl Texture {
    /// The image laid over `[0, 1]^2` once.
    pub fn new(image: Arc<ColourImage>) -> Self {
        Self { image, tile: DVec2::ONE, shift: DVec2::ZERO }
    }

    /// The linear colour at `uv`.
    pub fn lookup(&self, uv: DVec2) -> Rgb {
        self.image.lookup(uv * self.tile + self.shift)
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
    fn it_repeats() {
        let texture = Texture {
            image: Arc::new(corners()),
            tile: DVec2::splat(2.0),
            shift: DVec2::new(-1.0, 3.0),
        };
        for uv in [DVec2::new(0.1, 0.2), DVec2::new(0.9, 0.4), DVec2::ZERO, DVec2::ONE] {
            let plain = texture.image.lookup(uv * 2.0);
            assert!((texture.lookup(uv) - plain).abs().max_element() < 1e-12);
        }
        assert_eq!(texture.lookup(DVec2::NAN), Rgb::ZERO);
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
