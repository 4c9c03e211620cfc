//! Colour images for materials, at the depth of their file.
//!
//! 8- and 16-bit images are taken as sRGB, float images as linear. Grey becomes RGB with three
//! equal channels; alpha is ignored. The last row of the file becomes row 0 (`v = 0`).

use std::path::Path;

use rilievo_render::texture::{ColourImage, Texels};

use super::decode;
use super::source::{Context, Flow, ImageInfo, Row, SampleKind, Sink, Source};
use crate::error::{Place, Result};
use crate::limits::Limits;

/// Reads a colour image from a file.
///
/// # Errors
/// Of the file, its format or its size; a texel that is not a colour.
pub fn read_colour(path: &Path, limits: &Limits) -> Result<ColourImage> {
    from_source(Source::open(path, limits)?)
}

/// Reads a colour image from bytes; `name` is what errors call them.
///
/// # Errors
/// As [`read_colour`].
pub fn read_colour_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<ColourImage> {
    from_source(Source::from_bytes(bytes, name, limits))
}

fn from_source(source: Source<'_>) -> Result<ColourImage> {
    let context = source.context;
    let texels = Texels::Srgb8(Vec::new());
    let mut canvas = Canvas { context, shape: (0, 0, 1), texels };
    decode(source, &mut canvas)?;
    let (width, height, _) = canvas.shape;
    ColourImage::new(width, height, canvas.texels).map_err(|e| context.damaged(e))
}

/// Texels that fill up row by row.
struct Canvas<'a> {
    context: Context<'a>,
    /// Width, height and channels of the image.
    shape: (u32, u32, usize),
    texels: Texels,
}

impl Sink for Canvas<'_> {
    fn begin(&mut self, info: &ImageInfo) -> Result<Flow> {
        let (count, texel) = (info.width as usize * info.height as usize, 3 * info.sample.bytes());
        let sides = [info.width, info.height, texel].map(u64::from);
        let Context { path, limits } = self.context;
        limits.check(path, Place::Header, "the colour image", &sides)?;
        self.shape = (info.width, info.height, info.channels as usize);
        self.texels = match info.sample {
            SampleKind::U8 => Texels::Srgb8(vec![[0; 3]; count]),
            SampleKind::U16 => Texels::Srgb16(vec![[0; 3]; count]),
            SampleKind::F32 => Texels::Linear(vec![[0.0; 3]; count]),
        };
        Ok(Flow::Decode)
    }

    fn row(&mut self, y: u32, row: Row<'_>) {
        let (width, height, channels) = self.shape;
        let start = (height - 1 - y) as usize * width as usize;
        let range = start..start + width as usize;
        match (&mut self.texels, row) {
            (Texels::Srgb8(to), Row::U8(row)) => fill(&mut to[range], row, channels),
            (Texels::Srgb16(to), Row::U16(row)) => fill(&mut to[range], row, channels),
            (Texels::Linear(to), Row::F32(row)) => fill(&mut to[range], row, channels),
            // `begin` chose the texels for the rows this image has.
            _ => {}
        }
    }
}

fn fill<T: Copy>(to: &mut [[T; 3]], row: &[T], channels: usize) {
    for (to, pixel) in to.iter_mut().zip(row.chunks_exact(channels)) {
        *to = match *pixel {
            [r, g, b, ..] => [r, g, b],
            [grey, ..] => [grey; 3],
            [] => continue,
        };
    }
}
