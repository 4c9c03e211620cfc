//! Height maps from image files.
//!
//! * 8-bit codes become 16-bit ones: `code * 257`, so that 255 is 1 exactly. 16-bit codes stay.
//! * Signed, wider and float samples are heights themselves, as [`Samples::F32`].
//! * Of a colour image the height is the luminance with the weights of [BT.709] taken of the
//!   stored values, in 16-bit codes rounded to the nearest. Where red, green and blue are equal it
//!   is their value exactly, so a grey map stored as RGB is read as what it is. No transfer curve is
//!   undone: heights are not colours. Alpha is ignored.
//! * `invert` turns `H` to `1 - H`.
//! * Where a file says that nothing was measured, the lowest height that was stands instead.
//!
//! The last row of the file becomes row 0 (`v = 0`) on the way in; nothing is turned afterwards.

use std::path::Path;

use rilievo::map::{HeightMap, HeightMapError, Lattice, Samples, Wrap};

use super::decode;
use super::source::{Context, Flow, ImageInfo, Row, SampleKind, Sink, Source};
use super::udim::{Mosaic, Udim};
use crate::error::{Error, Place, Result};
use crate::limits::Limits;

/// How the samples of a file are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct HeightOptions {
    /// Where samples sit.
    pub lattice: Lattice,
    /// What lies beyond the borders.
    pub wrap: Wrap,
    /// Black is high: `H` becomes `1 - H`.
    pub invert: bool,
}

impl Default for HeightOptions {
    /// Texel centres that repeat, white is high.
    fn default() -> Self {
        Self { lattice: Lattice::Texel, wrap: Wrap::Repeat, invert: false }
    }
}

impl HeightOptions {
    /// Reads a height map from a file.
    ///
    /// # Errors
    /// Of the file, its format or its size; a sample that is not finite, with its place.
    pub fn read(&self, path: &Path, limits: &Limits) -> Result<HeightMap> {
        self.read_with_voids(path, limits).map(|(map, _)| map)
    }

    /// Reads a height map from bytes; `name` is what errors call them.
    ///
    /// # Errors
    /// As [`HeightOptions::read`].
    pub fn read_bytes(&self, bytes: &[u8], name: &Path, limits: &Limits) -> Result<HeightMap> {
        self.decode_from(Source::from_bytes(bytes, name, limits))
    }

    /// Reads a height map and counts the samples where nothing was measured.
    ///
    /// # Errors
    /// As [`HeightOptions::read`].
    pub fn read_with_voids(&self, path: &Path, limits: &Limits) -> Result<(HeightMap, u64)> {
        if let Some(tiles) = Udim::find(path)? {
            return self.read_tiles(path, &tiles, limits);
        }
        self.decode_with_voids(Source::open(path, limits)?)
    }

    /// Puts the tiles of `path` together.
    fn read_tiles(&self, path: &Path, tiles: &Udim, limits: &Limits) -> Result<(HeightMap, u64)> {
        let (first, mut voids) = self.read_with_voids(tiles.first(), limits)?;
        let size = [first.width(), first.height()];
        let sample = first.samples().bytes() / first.samples().len() as u64;
        let sides = [tiles.columns, tiles.rows, size[0], size[1]].map(u64::from);
        limits.check(path, Place::File, "the tiles", &[&sides[..], &[sample]].concat())?;
        let mut codes = Mosaic::new(tiles, if sample == 2 { size } else { [0; 2] }, 0_u16);
        let mut heights = Mosaic::new(tiles, if sample == 4 { size } else { [0; 2] }, 0_f32);
        for (column, row, file) in &tiles.tiles {
            let (map, found) = self.read_with_voids(file, limits)?;
            voids += found;
            if [map.width(), map.height()] != size {
                return Err(Udim::uneven(file, [map.width(), map.height()], size));
            }
            match (map.samples(), first.samples()) {
                (Samples::U16(tile), Samples::U16(_)) => codes.put([*column, *row], tile),
                (Samples::F32(tile), Samples::F32(_)) => heights.put([*column, *row], tile),
                _ => return Err(Udim::uneven(file, size, size)),
            }
        }
        let samples = match first.samples() {
            Samples::U16(_) => Samples::U16(codes.finish()),
            Samples::F32(_) => Samples::F32(heights.finish()),
        };
        let [width, height] = [tiles.columns * size[0], tiles.rows * size[1]];
        HeightMap::new(width, height, samples, self.lattice, self.wrap)
            .map(|map| (map, voids))
            .map_err(|e| refused(Context { path, limits }, height, e))
    }

    fn decode_from(&self, source: Source<'_>) -> Result<HeightMap> {
        self.decode_with_voids(source).map(|(map, _)| map)
    }

    fn decode_with_voids(&self, source: Source<'_>) -> Result<(HeightMap, u64)> {
        let context = source.context;
        let mut grid = Grid {
            context,
            invert: self.invert,
            shape: (0, 0, 1),
            void: None,
            bits: 0,
            samples: Samples::U16(Vec::new()),
        };
        decode(source, &mut grid)?;
        let (width, height, _) = grid.shape;
        let voids = grid.fill_voids()?;
        let map = HeightMap::new(width, height, grid.samples, self.lattice, self.wrap)
            .map_err(|e| refused(context, height, e))?;
        Ok((map, voids))
    }
}

/// What the map says about samples of a file with `height` rows.
fn refused(context: Context<'_>, height: u32, error: HeightMapError) -> Error {
    let invalid = |place, what, found: String, allowed| {
        Error::invalid(context.path, place, what, found, allowed)
    };
    match error {
        HeightMapError::TooSmall { width, height } => {
            invalid(Place::Header, "size", format!("{width} x {height}"), "at least 2 x 2 samples")
        }
        HeightMapError::TooLarge { width, height } => {
            let allowed = "at most 16777216 samples along an axis";
            invalid(Place::Header, "size", format!("{width} x {height}"), allowed)
        }
        HeightMapError::NotFinite { i, j, value } => {
            let place = Place::Sample { x: i, y: height - 1 - j };
            let allowed = "finite numbers below 1e18 in size";
            invalid(place, "height", value.to_string(), allowed)
        }
        other @ (HeightMapError::WrongCount { .. } | HeightMapError::NotInside { .. }) => {
            context.damaged(other)
        }
    }
}

/// Takes rows as they come and puts them where they stay.
struct Grid<'a> {
    context: Context<'a>,
    invert: bool,
    /// Width, height and channels of the image.
    shape: (u32, u32, usize),
    /// The sample of the file that is none.
    void: Option<f32>,
    /// Bits of a code in the file.
    bits: u32,
    samples: Samples,
}

impl Grid<'_> {
    /// Gives samples where nothing was measured the lowest height that was; their number.
    fn fill_voids(&mut self) -> Result<u64> {
        let Some(void) = self.void else { return Ok(0) };
        let filled = match &mut self.samples {
            Samples::U16(codes) => {
                let wide = match self.bits {
                    8 => void * 257.0,
                    _ => void,
                };
                let void = if self.invert { 65535.0 - wide } else { wide };
                fill(codes, |code| f32::from(*code) == void, |a, b| a < b)
            }
            Samples::F32(heights) => {
                let void = if self.invert { 1.0 - void } else { void };
                let is_void = |h: &f32| *h == void || (h.is_nan() && void.is_nan());
                fill(heights, is_void, |a, b| a < b)
            }
        };
        filled.ok_or_else(|| self.context.damaged("nothing but samples that stand for no height"))
    }

    /// Where row `y` of the file goes.
    fn range(&self, y: u32) -> std::ops::Range<usize> {
        let (width, height, _) = self.shape;
        let start = (height - 1 - y) as usize * width as usize;
        start..start + width as usize
    }
}

impl Sink for Grid<'_> {
    fn begin(&mut self, info: &ImageInfo) -> Result<Flow> {
        self.shape = (info.width, info.height, info.channels as usize);
        (self.void, self.bits) = (info.void, 8 * info.sample.bytes());
        let bytes = match info.sample {
            SampleKind::U8 | SampleKind::U16 => 2,
            SampleKind::F32 => 4,
        };
        let sides = [u64::from(info.width), u64::from(info.height), bytes];
        let Context { path, limits } = self.context;
        limits.check(path, Place::Header, "the height map", &sides)?;
        let count = info.width as usize * info.height as usize;
        self.samples = match info.sample {
            SampleKind::U8 | SampleKind::U16 => Samples::U16(vec![0; count]),
            // Of a single channel the whole grid is taken over; see `grid`.
            SampleKind::F32 => Samples::F32(Vec::new()),
        };
        Ok(Flow::Decode)
    }

    fn row(&mut self, y: u32, row: Row<'_>) {
        let (range, (width, height, channels)) = (self.range(y), self.shape);
        match (&mut self.samples, row) {
            (Samples::U16(to), Row::U8(row)) => {
                let wide = |v: &u8| u16::from(*v) * 257;
                let codes = Codes { channels, invert: self.invert };
                codes.fill(&mut to[range], row, wide);
            }
            (Samples::U16(to), Row::U16(row)) => {
                let codes = Codes { channels, invert: self.invert };
                codes.fill(&mut to[range], row, |v: &u16| *v);
            }
            (Samples::F32(to), Row::F32(row)) => {
                to.resize(width as usize * height as usize, 0.0);
                for (to, pixel) in to[range].iter_mut().zip(row.chunks_exact(channels)) {
                    let h = number(pixel);
                    *to = if self.invert { 1.0 - h } else { h };
                }
            }
            // `begin` chose the samples for the rows this image has.
            _ => {}
        }
    }

    fn grid(&mut self, info: &ImageInfo, mut samples: Vec<f32>) {
        let width = info.width as usize;
        if info.channels != 1 {
            for (y, row) in samples.chunks_exact(width * info.channels as usize).enumerate() {
                self.row(y as u32, Row::F32(row));
            }
            return;
        }
        let (mut low, mut high) = (0, info.height as usize);
        while low + 1 < high {
            high -= 1;
            let (top, bottom) = samples.split_at_mut(high * width);
            top[low * width..(low + 1) * width].swap_with_slice(&mut bottom[..width]);
            low += 1;
        }
        if self.invert {
            samples.iter_mut().for_each(|h| *h = 1.0 - *h);
        }
        self.samples = Samples::F32(samples);
    }
}

/// Replaces what `is_void` by the lowest of the rest and counts it; none if there is no rest.
fn fill<T: Copy>(
    all: &mut [T],
    is_void: impl Fn(&T) -> bool,
    less: impl Fn(&T, &T) -> bool,
) -> Option<u64> {
    let rest = all.iter().filter(|value| !is_void(value)).copied();
    let lowest = rest.reduce(|low, value| if less(&value, &low) { value } else { low })?;
    let mut count = 0;
    for value in all.iter_mut().filter(|value| is_void(value)) {
        *value = lowest;
        count += 1;
    }
    Some(count)
}

/// How codes of an image become codes of heights.
struct Codes {
    channels: usize,
    invert: bool,
}

impl Codes {
    fn fill<T>(&self, to: &mut [u16], row: &[T], wide: impl Fn(&T) -> u16) {
        for (to, pixel) in to.iter_mut().zip(row.chunks_exact(self.channels)) {
            let code = match pixel {
                [r, g, b, ..] => luminance([wide(r), wide(g), wide(b)]),
                [grey, ..] => wide(grey),
                [] => 0,
            };
            *to = if self.invert { 65535 - code } else { code };
        }
    }
}

/// Luminance of codes. The weights sum to 2^16, so equal channels give their own code.
fn luminance(rgb: [u16; 3]) -> u16 {
    let [r, g, b] = rgb.map(u64::from);
    ((13933 * r + 46871 * g + 4732 * b + 32768) >> 16) as u16
}

/// Height of a pixel of numbers.
fn number(pixel: &[f32]) -> f32 {
    match *pixel {
        [r, g, b, ..] if r == g && g == b => r,
        [r, g, b, ..] => {
            let [r, g, b] = [r, g, b].map(f64::from);
            (0.2126 * r + 0.7152 * g + 0.0722 * b) as f32
        }
        [grey, ..] => grey,
        [] => 0.0,
    }
}
