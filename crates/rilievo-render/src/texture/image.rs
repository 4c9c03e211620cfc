//! [`ColourImage`]: texels at the depth of their file, looked up bilinearly in a pyramid of means.
//!
//! Texels are decoded to linear light before they are mixed. Texel (i, j) sits at
//! `u = (i + 0.5) / width`, `v = (j + 0.5) / height`; row 0 is at `v = 0`, the *bottom* of a
//! picture.
//!
//! Each coarser image has half the texels along an axis, rounded down, each the mean of the area it
//! covers, stored at the same depth. The coarser images are made when one is first asked for.
//!
//! An image that memory is too small for is kept in tiles ([`ColourImage::tiled`]), all its coarser images with
//! it; look-ups are the same to the last bit.

use std::sync::{Arc, OnceLock};

use glam::DVec2;
use rilievo::map::Wrap;

use super::cache::TileCache;
use super::coarser::coarser;
use super::texels::{Decoder, ImageLevel, Level, Texels, TextureError};
use super::tiled::Tiled;
use crate::colour::Rgb;

/// A colour image; immutable and valid by construction.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourImage {
    storage: Storage,
    decoder: Decoder,
}

/// Where the texels are.
#[derive(Clone, Debug, PartialEq)]
enum Storage {
    /// In memory.
    Held {
        finest: Level,
        /// Halved again and again, down to one texel; made when first asked for.
        coarser: OnceLock<Vec<Level>>,
    },
    /// In a file, a few tiles in memory.
    Tiled(Tiled),
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
        Ok(Self::held(Level { width, height, texels }))
    }

    /// The same codes taken as linear numbers; float texels are such already. An image in tiles stays
    /// as it is.
    #[must_use]
    pub fn into_linear(self) -> Self {
        let Storage::Held { finest: Level { width, height, texels }, .. } = self.storage else {
            return self;
        };
        let texels = match texels {
            Texels::Srgb8(v) => Texels::Linear8(v),
            Texels::Srgb16(v) => Texels::Linear16(v),
            linear => linear,
        };
        Self::held(Level { width, height, texels })
    }

    fn held(finest: Level) -> Self {
        let decoder = Decoder::new(finest.texels.coding());
        Self { storage: Storage::Held { finest, coarser: OnceLock::new() }, decoder }
    }

    /// The same image in tiles, which `cache` brings in when they are asked for. Shows all tiles, those
    /// of the coarser images too, to `write`, in the order in which the cache's source is to hold them
    /// from `first` on. Every look-up gives the same bits.
    ///
    /// # Errors
    /// Those of `write`.
    pub fn tiled<E>(
        &self,
        cache: &Arc<TileCache>,
        first: u64,
        write: &mut dyn FnMut(&[u8]) -> Result<(), E>,
    ) -> Result<Self, E> {
        let Storage::Held { finest, .. } = &self.storage else { return Ok(self.clone()) };
        let tiled = Tiled::write(finest, &self.decoder, (cache, first), write)?;
        Ok(Self { storage: Storage::Tiled(tiled), decoder: self.decoder.clone() })
    }

    /// The image, and the coarser ones if they are asked for, each half of the one before; nothing of an image in
    /// tiles.
    pub(crate) fn levels(&self, all: bool) -> Option<Vec<ImageLevel<'_>>> {
        let Storage::Held { finest, coarser } = &self.storage else { return None };
        let coarser = match all {
            true => coarser.get_or_init(|| coarser_levels(finest, &self.decoder)).as_slice(),
            false => &[],
        };
        let levels = std::iter::once(finest).chain(coarser);
        Some(levels.map(|level| ImageLevel::new(level, &self.decoder)).collect())
    }

    /// What brings in its tiles, of an image in tiles.
    pub fn cache(&self) -> Option<&Arc<TileCache>> {
        match &self.storage {
            Storage::Held { .. } => None,
            Storage::Tiled(tiled) => Some(tiled.cache()),
        }
    }

    /// Texels along u and v.
    #[inline]
    fn size(&self) -> [u32; 2] {
        match &self.storage {
            Storage::Held { finest, .. } => [finest.width, finest.height],
            Storage::Tiled(tiled) => tiled.size(0),
        }
    }

    /// Texels along u.
    pub fn width(&self) -> u32 {
        self.size()[0]
    }

    /// Texels along v.
    pub fn height(&self) -> u32 {
        self.size()[1]
    }

    /// Bytes a texel.
    fn texel_bytes(&self) -> u64 {
        match &self.storage {
            Storage::Held { finest, .. } => finest.texels.coding().bytes(),
            Storage::Tiled(tiled) => tiled.texel_bytes(),
        }
    }

    /// Bytes of the texels, without those of the coarser images.
    pub fn bytes(&self) -> u64 {
        self.texel_bytes() * u64::from(self.width()) * u64::from(self.height())
    }

    /// Bytes of the coarser images, whether or not they have been asked for.
    pub fn coarser_bytes(&self) -> u64 {
        let [mut width, mut height] = self.size();
        let mut texels = 0;
        while width > 1 || height > 1 {
            (width, height) = ((width / 2).max(1), (height / 2).max(1));
            texels += u64::from(width) * u64::from(height);
        }
        texels * self.texel_bytes()
    }

    /// The linear colour of a texel.
    ///
    /// # Panics
    /// If `i` or `j` is out of range.
    pub fn texel(&self, i: u32, j: u32) -> Rgb {
        let [width, height] = self.size();
        assert!(i < width && j < height, "texel ({i}, {j}) is outside the image");
        match &self.storage {
            Storage::Held { finest, .. } => self.decoder.texel(finest, i, j),
            Storage::Tiled(tiled) => tiled.reader(0, &self.decoder).texel(i, j),
        }
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
        match &self.storage {
            Storage::Held { finest, .. } => self.lookup_level(finest, uv, wrap),
            Storage::Tiled(tiled) => self.lookup_tiled(tiled, 0, uv, wrap),
        }
    }

    #[inline]
    fn lookup_level(&self, level: &Level, uv: DVec2, wrap: [Wrap; 2]) -> Rgb {
        let size = [level.width, level.height];
        bilinear(size, uv, wrap, |i, j| self.decoder.texel(level, i, j))
    }

    fn lookup_tiled(&self, tiled: &Tiled, depth: usize, uv: DVec2, wrap: [Wrap; 2]) -> Rgb {
        let mut reader = tiled.reader(depth, &self.decoder);
        bilinear(tiled.size(depth), uv, wrap, |i, j| reader.texel(i, j))
    }

    /// The mean colour over a window of `width` along u and v around `uv`, about: between the two
    /// levels whose texels are nearest in size to its narrower side, counted in texels. So a window
    /// that is long and narrow is not blurred across; samples along it are the caller's to take.
    pub(super) fn lookup_mean(&self, uv: DVec2, width: DVec2, wrap: [Wrap; 2]) -> Rgb {
        let [columns, rows] = self.size();
        let side = (width.x * f64::from(columns)).min(width.y * f64::from(rows));
        if side.is_nan() || side <= 1.0 || !uv.is_finite() {
            return self.lookup_wrapped(uv, wrap);
        }
        let (whole, part) = (side.log2().floor(), side.log2().fract());
        let depth = whole.min(64.0) as usize;
        match &self.storage {
            Storage::Held { finest, coarser } => {
                let levels = coarser.get_or_init(|| coarser_levels(finest, &self.decoder));
                let at = |depth: usize| match depth.min(levels.len()) {
                    0 => finest,
                    k => &levels[k - 1],
                };
                let level = |depth| self.lookup_level(at(depth), uv, wrap);
                between(level, depth, (part, levels.len()))
            }
            Storage::Tiled(tiled) => {
                let most = tiled.coarser();
                let level = |depth: usize| self.lookup_tiled(tiled, depth.min(most), uv, wrap);
                between(level, depth, (part, most))
            }
        }
    }
}

/// What `level` says at a depth and a part beyond; the last is at depth `most`.
#[inline]
fn between(level: impl Fn(usize) -> Rgb, depth: usize, (part, most): (f64, usize)) -> Rgb {
    let fine = level(depth);
    if depth >= most || part < 1e-3 {
        return fine;
    }
    fine.lerp(level(depth + 1), part)
}

/// Between the four texels around `uv`.
#[inline]
fn bilinear(
    [width, height]: [u32; 2],
    uv: DVec2,
    wrap: [Wrap; 2],
    mut texel: impl FnMut(u32, u32) -> Rgb,
) -> Rgb {
    let (i, s) = neighbours(uv.x, width, wrap[0]);
    let (j, t) = neighbours(uv.y, height, wrap[1]);
    let low = texel(i[0], j[0]).lerp(texel(i[1], j[0]), s);
    let high = texel(i[0], j[1]).lerp(texel(i[1], j[1]), s);
    low.lerp(high, t)
}

fn coarser_levels(finest: &Level, decoder: &Decoder) -> Vec<Level> {
    let mut levels: Vec<Level> = Vec::new();
    loop {
        let last = levels.last().unwrap_or(finest);
        if last.width == 1 && last.height == 1 {
            return levels;
        }
        let next = coarser(last, decoder);
        levels.push(next);
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

    /// The first of the coarser images.
    fn half(image: &ColourImage) -> ColourImage {
        let Storage::Held { finest, .. } = &image.storage else { panic!() };
        ColourImage::held(coarser(finest, &image.decoder))
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
        assert_eq!(half(&image).texel(3, 1), Rgb::splat(0.5));
    }

    #[test]
    fn means_are_taken_in_linear_light() {
        let board = |k: usize| [if k.is_multiple_of(2) { 0 } else { 255 }; 3];
        let codes: Vec<_> = (0..4).map(board).collect();
        let image = ColourImage::new(4, 1, Texels::Srgb8(codes.clone())).unwrap();
        assert!((half(&image).texel(0, 0).x - 0.5).abs() < 3e-3);
        let image = ColourImage::new(4, 1, Texels::Linear8(codes)).unwrap();
        assert!((half(&image).texel(1, 0).x - 0.5).abs() < 3e-3);
        let wide = vec![[0; 3], [65535; 3]];
        let image = ColourImage::new(1, 2, Texels::Srgb16(wide.clone())).unwrap();
        assert!((half(&image).texel(0, 0).x - 0.5).abs() < 1e-4);
        let image = ColourImage::new(1, 2, Texels::Linear16(wide)).unwrap();
        assert!((half(&image).texel(0, 0).x - 0.5).abs() < 1e-4);
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
