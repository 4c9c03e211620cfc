//! Colour images for materials, at the depth of their file.
//!
//! 8- and 16-bit images are taken as sRGB, float images as linear. Grey becomes RGB with three
//! equal channels; alpha is ignored. The last row of the file becomes row 0 (`v = 0`).

use std::path::Path;

use rilievo_render::texture::{ColourImage, Texels};

use super::decode;
use super::source::{Context, Flow, ImageInfo, Row, SampleKind, Sink, Source};
use super::udim::{Mosaic, Udim};
use crate::error::{Place, Result};
use crate::limits::Limits;

/// Reads a colour image from a file.
///
/// # Errors
/// Of the file, its format or its size; a texel that is not a colour.
pub fn read_colour(path: &Path, limits: &Limits) -> Result<ColourImage> {
    match Udim::find(path)? {
        Some(tiles) => read_tiles(path, &tiles, limits),
        None => from_source(Source::open(path, limits)?),
    }
}

/// Puts the tiles of `path` together.
fn read_tiles(path: &Path, tiles: &Udim, limits: &Limits) -> Result<ColourImage> {
    let read = |file: &Path| texels(Source::open(file, limits)?);
    let (size, first) = read(tiles.first())?;
    let texel = match first {
        Texels::Srgb8(_) | Texels::Linear8(_) => 3,
        Texels::Srgb16(_) | Texels::Linear16(_) => 6,
        Texels::Linear(_) => 12,
    };
    let sides = [tiles.columns, tiles.rows, size[0], size[1], texel].map(u64::from);
    limits.check(path, Place::File, "the tiles", &sides)?;
    // Only the one that the first tile asks for has room.
    let room = |kind: u32| if kind == texel { size } else { [0; 2] };
    let mut codes = Mosaic::new(tiles, room(3), [0_u8; 3]);
    let mut wide = Mosaic::new(tiles, room(6), [0_u16; 3]);
    let mut numbers = Mosaic::new(tiles, room(12), [0_f32; 3]);
    for (column, row, file) in &tiles.tiles {
        let (found, tile) = read(file)?;
        let place = [*column, *row];
        match (&tile, texel) {
            _ if found != size => return Err(Udim::uneven(file, found, size)),
            (Texels::Srgb8(tile), 3) => codes.put(place, tile),
            (Texels::Srgb16(tile), 6) => wide.put(place, tile),
            (Texels::Linear(tile), 12) => numbers.put(place, tile),
            _ => return Err(Udim::uneven(file, found, size)),
        }
    }
    let all = match texel {
        3 => Texels::Srgb8(codes.finish()),
        6 => Texels::Srgb16(wide.finish()),
        _ => Texels::Linear(numbers.finish()),
    };
    let context = Context { path, limits };
    ColourImage::new(tiles.columns * size[0], tiles.rows * size[1], all)
        .map_err(|e| context.damaged(e))
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
    let ([width, height], texels) = texels(source)?;
    ColourImage::new(width, height, texels).map_err(|e| context.damaged(e))
}

/// Size and texels of an image.
fn texels(source: Source<'_>) -> Result<([u32; 2], Texels)> {
    let context = source.context;
    let texels = Texels::Srgb8(Vec::new());
    let mut canvas = Canvas { context, shape: (0, 0, 1), texels };
    decode(source, &mut canvas)?;
    let (width, height, _) = canvas.shape;
    Ok(([width, height], canvas.texels))
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
