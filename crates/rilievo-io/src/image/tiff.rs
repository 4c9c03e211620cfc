//! TIFF and BigTIFF, through the `tiff` crate: strips and tiles, chunky samples.
//!
//! Unsigned 8- and 16-bit samples are codes. Everything else is taken as numbers and becomes f32:
//! exact for signed 8- and 16-bit integers and for half floats, rounded to the nearest for wider
//! integers and doubles (a 32-bit height in metres is good to a few millimetres at 2^15 m).
//!
//! One row of tiles, or one strip, is decoded at a time. A file that is a single strip is therefore
//! held twice while it is read, unless it is one channel of `f32`: that strip is the map.

use std::ops::Range;

use tiff::ColorType;
use tiff::decoder::{Decoder, DecodingResult, Limits as TiffLimits};
use tiff::tags::Tag;

use super::ImageFormat;
use super::source::{Context, Flow, ImageInfo, Input, Row, SampleKind, Sink};
use super::terrain::{GDAL_NODATA, void_of_text};
use crate::error::{Error, Place, Result};

/// Decodes the first image of a TIFF.
pub(super) fn decode(
    context: Context<'_>,
    input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let damaged = |e: tiff::TiffError| context.damaged(e);
    let most = usize::try_from(context.limits.max_bytes).unwrap_or(usize::MAX);
    let mut limits = TiffLimits::default();
    limits.decoding_buffer_size = most;
    limits.intermediate_buffer_size = most;
    // The tables of strip offsets are tag values too: 16 MiB are two million strips.
    limits.ifd_value_size = most.min(16 << 20);
    let mut decoder = Decoder::new(input).map_err(damaged)?.with_limits(limits);
    let info = header(context, &mut decoder)?;
    context.check(&info)?;
    let (tile_width, tile_height) = decoder.chunk_dimensions();
    if tile_width == 0 || tile_height == 0 {
        return Err(context.damaged("a tile without pixels"));
    }
    // A tile may be declared larger than its image; a strip is cut to it.
    let band_height = tile_height.min(info.height);
    let sides = [tile_width.max(info.width), band_height, info.channels, info.file_bits / 8];
    let what = "decoding a row of tiles";
    context.limits.check(context.path, Place::Header, what, &sides.map(u64::from))?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    let mut chunks = Chunks { context, decoder, info, sink };
    if tile_width == info.width {
        chunks.strips(band_height)
    } else {
        chunks.tiles(tile_width, band_height)
    }
}

/// The chunks of an image and where their rows go.
struct Chunks<'a, 'b> {
    context: Context<'a>,
    decoder: Decoder<Box<dyn Input + 'a>>,
    info: ImageInfo,
    sink: &'b mut dyn Sink,
}

impl Chunks<'_, '_> {
    /// Reads a chunk that must have at least `size` pixels.
    fn read(&mut self, chunk: u32, size: [u32; 2]) -> Result<DecodingResult> {
        let (width, height) = self.decoder.chunk_data_dimensions(chunk);
        if width < size[0] || height < size[1] {
            return Err(self.context.damaged(format!("tile {chunk} is too small")));
        }
        self.decoder.read_chunk(chunk).map_err(|e| self.context.damaged(e))
    }

    fn few(&self, chunk: u32) -> Error {
        self.context.damaged(format!("tile {chunk} holds too few samples"))
    }

    /// Strips have whole rows, which are converted and handed on one by one.
    fn strips(&mut self, strip_height: u32) -> Result<()> {
        let info = self.info;
        let mut band = Band::new(&info, 1);
        for (chunk, top) in (0..).zip((0..info.height).step_by(strip_height as usize)) {
            let rows = strip_height.min(info.height - top);
            let samples = self.read(chunk, [info.width, rows])?;
            let samples = match samples {
                DecodingResult::F32(all)
                    if rows == info.height && all.len() == band.row_length * rows as usize =>
                {
                    self.sink.grid(&info, all);
                    return Ok(());
                }
                samples => samples,
            };
            for y in 0..rows {
                let put = band.put((0, info.width), y..y + 1, &samples);
                put.ok_or_else(|| self.few(chunk))?;
                self.sink.row(top + y, band.row(0));
            }
        }
        Ok(())
    }

    /// Tiles are put together row by row of them.
    fn tiles(&mut self, tile_width: u32, tile_height: u32) -> Result<()> {
        let info = self.info;
        let across = info.width.div_ceil(tile_width);
        let mut band = Band::new(&info, tile_height);
        for (row, top) in (0..).zip((0..info.height).step_by(tile_height as usize)) {
            let rows = tile_height.min(info.height - top);
            for column in 0..across {
                let (chunk, left) = (row * across + column, column * tile_width);
                let width = tile_width.min(info.width - left);
                let samples = self.read(chunk, [width, rows])?;
                let (width, _) = self.decoder.chunk_data_dimensions(chunk);
                let put = band.put((left, width), 0..rows, &samples);
                put.ok_or_else(|| self.few(chunk))?;
            }
            for y in 0..rows {
                self.sink.row(top + y, band.row(y));
            }
        }
        Ok(())
    }
}

/// Reads and judges the header.
fn header(context: Context<'_>, decoder: &mut Decoder<Box<dyn Input + '_>>) -> Result<ImageInfo> {
    let damaged = |e: tiff::TiffError| context.damaged(e);
    let (width, height) = decoder.dimensions().map_err(damaged)?;
    let colour = decoder.colortype().map_err(damaged)?;
    let channels = match colour {
        ColorType::Gray(_) => 1,
        ColorType::GrayA(_) | ColorType::Multiband { num_samples: 2, .. } => 2,
        ColorType::RGB(_) => 3,
        ColorType::RGBA(_) => 4,
        other => {
            let allowed = "grey or RGB, with or without alpha";
            return Err(context.unsupported("colour type", format!("{other:?}"), allowed));
        }
    };
    let file_bits = u32::from(colour.bit_depth());
    if !matches!(file_bits, 8 | 16 | 32 | 64) {
        let found = format!("{file_bits} bits");
        return Err(context.unsupported("sample size", found, "8, 16, 32 or 64 bits"));
    }
    let planes = decoder.find_tag_unsigned::<u16>(Tag::PlanarConfiguration).map_err(damaged)?;
    if channels > 1 && planes == Some(2) {
        return Err(context.unsupported("planar configuration", "2 (planes)", "1 (chunky)"));
    }
    let formats = decoder.find_tag_unsigned_vec::<u16>(Tag::SampleFormat).map_err(damaged)?;
    let unsigned = formats.is_none_or(|f| f.iter().all(|&f| f == 1));
    let sample = match file_bits {
        8 if unsigned => SampleKind::U8,
        16 if unsigned => SampleKind::U16,
        _ => SampleKind::F32,
    };
    let void = decoder.find_tag(Tag::Unknown(GDAL_NODATA)).ok().flatten();
    let void = void.and_then(|value| void_of_text(&value.into_string().ok()?));
    Ok(ImageInfo { format: ImageFormat::Tiff, width, height, channels, sample, file_bits, void })
}

/// One row of tiles, put together to full image rows.
struct Band {
    row_length: usize,
    channels: usize,
    samples: Samples,
}

enum Samples {
    U8(Vec<u8>),
    U16(Vec<u16>),
    F32(Vec<f32>),
}

impl Band {
    fn new(info: &ImageInfo, rows: u32) -> Self {
        let row_length = info.width as usize * info.channels as usize;
        let count = row_length * rows as usize;
        let samples = match info.sample {
            SampleKind::U8 => Samples::U8(vec![0; count]),
            SampleKind::U16 => Samples::U16(vec![0; count]),
            SampleKind::F32 => Samples::F32(vec![0.0; count]),
        };
        Self { row_length, channels: info.channels as usize, samples }
    }

    /// Places `rows` of a tile that is `width` pixels wide; none if it does not hold them.
    fn put(
        &mut self,
        (left, width): (u32, u32),
        rows: Range<u32>,
        tile: &DecodingResult,
    ) -> Option<()> {
        let place = Tile {
            start: left as usize * self.channels,
            length: width as usize * self.channels,
            rows: rows.start as usize..rows.end as usize,
            stride: self.row_length,
        };
        match (&mut self.samples, tile) {
            (Samples::U8(to), DecodingResult::U8(from)) => place.copy(from, to, |v| v),
            (Samples::U16(to), DecodingResult::U16(from)) => place.copy(from, to, |v| v),
            (Samples::F32(to), tile) => match tile {
                DecodingResult::I8(from) => place.copy(from, to, f32::from),
                DecodingResult::I16(from) => place.copy(from, to, f32::from),
                DecodingResult::U32(from) => place.copy(from, to, |v| v as f32),
                DecodingResult::I32(from) => place.copy(from, to, |v| v as f32),
                DecodingResult::U64(from) => place.copy(from, to, |v| v as f32),
                DecodingResult::I64(from) => place.copy(from, to, |v| v as f32),
                DecodingResult::F16(from) => place.copy(from, to, f32::from),
                DecodingResult::F32(from) => place.copy(from, to, |v| v),
                DecodingResult::F64(from) => place.copy(from, to, |v| v as f32),
                DecodingResult::U8(_) | DecodingResult::U16(_) => None,
            },
            _ => None,
        }
    }

    fn row(&self, y: u32) -> Row<'_> {
        let range = y as usize * self.row_length..(y as usize + 1) * self.row_length;
        match &self.samples {
            Samples::U8(v) => Row::U8(&v[range]),
            Samples::U16(v) => Row::U16(&v[range]),
            Samples::F32(v) => Row::F32(&v[range]),
        }
    }
}

/// Where rows of a tile go, the first of them to the first row of the band: samples, not pixels.
struct Tile {
    start: usize,
    length: usize,
    rows: Range<usize>,
    stride: usize,
}

impl Tile {
    fn copy<T: Copy, U>(self, from: &[T], to: &mut [U], convert: impl Fn(T) -> U) -> Option<()> {
        let from = from.get(self.length * self.rows.start..self.length * self.rows.end)?;
        for (y, row) in from.chunks_exact(self.length).enumerate() {
            let at = y * self.stride + self.start;
            for (to, &from) in to[at..at + self.length].iter_mut().zip(row) {
                *to = convert(from);
            }
        }
        Some(())
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;
    use std::path::Path;

    use rilievo::map::Samples as Heights;
    use tiff::encoder::TiffEncoder;
    use tiff::encoder::colortype::{ColorType, Gray16, Gray32Float, Gray64Float};

    use crate::Limits;
    use crate::image::HeightOptions;

    /// Heights of a TIFF of 3 x 4 samples in strips of so many rows.
    fn heights<C: ColorType>(samples: &[C::Inner], rows: u32) -> Heights
    where
        [C::Inner]: tiff::encoder::TiffValue,
    {
        let mut bytes = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut bytes).unwrap();
        let mut image = encoder.new_image::<C>(3, 4).unwrap();
        image.rows_per_strip(rows).unwrap();
        image.write_data(samples).unwrap();
        let options = HeightOptions::default();
        let map =
            options.read_bytes(bytes.get_ref(), Path::new("a.tiff"), &Limits::default()).unwrap();
        map.samples().clone()
    }

    /// One strip, one row each, a last one that is shorter: the same map, the top row last.
    #[test]
    fn strips_of_any_height_hold_the_same_rows() {
        let codes: Vec<u16> = (0..12).collect();
        let numbers: Vec<f32> = codes.iter().map(|&c| f32::from(c) / 4.0).collect();
        let doubles: Vec<f64> = codes.iter().map(|&c| f64::from(c) / 4.0).collect();
        let turned = |k: usize| 3 * (3 - k / 3) + k % 3;
        let want_codes = Heights::U16((0..12).map(|k| codes[turned(k)]).collect());
        let want_numbers = Heights::F32((0..12).map(|k| numbers[turned(k)]).collect());
        for rows in [1, 3, 4] {
            assert_eq!(heights::<Gray16>(&codes, rows), want_codes);
            assert_eq!(heights::<Gray32Float>(&numbers, rows), want_numbers);
            assert_eq!(heights::<Gray64Float>(&doubles, rows), want_numbers);
        }
    }
}
