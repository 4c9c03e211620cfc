//! PNG, through the `png` crate.
//!
//! Grey of 1, 2 and 4 bits is scaled to 8 (the code range maps onto 0 to 255), palettes become
//! RGB, a transparent colour becomes alpha. Rows go to the sink one by one; an interlaced image is
//! decoded whole first, since its rows come in seven passes.
//!
//! The crate sizes its own buffers from the header without asking its limits, so the header is
//! checked here before the first of them is made.

use png::{ColorType, Decoder, Transformations};

use super::ImageFormat;
use super::source::{Context, Flow, ImageInfo, Input, Row, SampleKind, Sink};
use crate::error::{Place, Result};

/// Decodes a PNG.
pub(super) fn decode(
    context: Context<'_>,
    input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let damaged = |e: png::DecodingError| context.damaged(e);
    let bytes = usize::try_from(context.limits.max_bytes).unwrap_or(usize::MAX);
    let mut decoder = Decoder::new_with_limits(input, png::Limits { bytes });
    decoder.set_transformations(Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let head = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = head.size();
    let file_bits = head.bit_depth as u32;
    let sample = if file_bits == 16 { SampleKind::U16 } else { SampleKind::U8 };
    let mut info = ImageInfo {
        format: ImageFormat::Png,
        width,
        height,
        channels: 1,
        sample,
        file_bits,
        void: None,
    };
    context.check(&info)?;
    let mut reader = decoder.read_info().map_err(damaged)?;
    info.channels = match reader.output_color_type().0 {
        ColorType::Grayscale => 1,
        ColorType::GrayscaleAlpha => 2,
        ColorType::Rgb | ColorType::Indexed => 3,
        ColorType::Rgba => 4,
    };
    context.check(&info)?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    let mut rows = Rows { sink, sample, wide: Vec::new() };
    if reader.info().interlaced {
        let size = reader.output_buffer_size().unwrap_or(usize::MAX);
        let what = "decoding the image";
        context.limits.check(context.path, Place::Header, what, &[size as u64])?;
        let mut frame = vec![0; size];
        let line = reader.next_frame(&mut frame).map_err(damaged)?.line_size;
        for (y, row) in frame.chunks_exact(line.max(1)).enumerate() {
            rows.give(y as u32, row);
        }
    } else {
        for y in 0..height {
            let row = reader.next_row().map_err(damaged)?;
            let row = row.ok_or_else(|| context.damaged("fewer rows than declared"))?;
            rows.give(y, row.data());
        }
    }
    // Reads on to the end mark, so that a file cut off after its pixels is found out.
    reader.finish().map_err(damaged)
}

/// Hands rows of big-endian samples to a sink.
struct Rows<'a> {
    sink: &'a mut dyn Sink,
    sample: SampleKind,
    wide: Vec<u16>,
}

impl Rows<'_> {
    fn give(&mut self, y: u32, row: &[u8]) {
        if self.sample == SampleKind::U8 {
            return self.sink.row(y, Row::U8(row));
        }
        self.wide.clear();
        self.wide.extend(row.chunks_exact(2).map(|pair| u16::from_be_bytes([pair[0], pair[1]])));
        self.sink.row(y, Row::U16(&self.wide));
    }
}
