//! JPEG, through the `zune-jpeg` crate: grey stays grey, everything else becomes RGB.
//!
//! Strict mode, and the end mark must be there: where the crate would rather fill the rest of a
//! damaged picture with grey, a height map must be refused.

use std::io::Read;

use zune_jpeg::JpegDecoder;
use zune_jpeg::zune_core::bytestream::ZCursor;
use zune_jpeg::zune_core::colorspace::ColorSpace;
use zune_jpeg::zune_core::options::DecoderOptions;

use super::ImageFormat;
use super::source::{Context, Flow, ImageInfo, Input, Row, SampleKind, Sink};
use crate::error::{Error, Place, Result};

/// Largest width and height the format can declare.
const MOST: usize = 65535;

/// Second bytes of the markers that start a scan and end the file.
const SCAN: u8 = 0xda;
const END: u8 = 0xd9;

/// Decodes a JPEG.
pub(super) fn decode(
    context: Context<'_>,
    input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let most = context.limits.max_bytes;
    let mut bytes = Vec::new();
    let read = input.take(most.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(|e| Error::io(context.path, e))?;
    let what = "reading the file";
    context.limits.check(context.path, Place::File, what, &[bytes.len() as u64])?;
    let last = |marker: u8| bytes.windows(2).rposition(|pair| pair == [0xff, marker]);
    // Scan data never holds a marker, so an end mark after the last start of a scan is the true one.
    if last(END) <= last(SCAN) {
        return Err(context.damaged("the file stops before its end mark"));
    }
    let options = DecoderOptions::default()
        .set_max_width(MOST)
        .set_max_height(MOST)
        .set_strict_mode(true)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(&bytes), options);
    decoder.decode_headers().map_err(|e| context.damaged(e))?;
    let (width, height) = decoder
        .dimensions()
        .and_then(|(w, h)| Some((u32::try_from(w).ok()?, u32::try_from(h).ok()?)))
        .ok_or_else(|| context.damaged("no frame header"))?;
    let grey = decoder.input_colorspace() == Some(ColorSpace::Luma);
    if grey {
        decoder.set_options(options.jpeg_set_out_colorspace(ColorSpace::Luma));
    }
    let info = ImageInfo {
        format: ImageFormat::Jpeg,
        width,
        height,
        channels: if grey { 1 } else { 3 },
        sample: SampleKind::U8,
        file_bits: 8,
        void: None,
    };
    // A progressive file keeps all coefficients, 16 bits each, beside the pixels.
    context.check(&ImageInfo { sample: SampleKind::F32, ..info })?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    let length = width as usize * info.channels as usize;
    let mut pixels = vec![0; length * height as usize];
    decoder.decode_into(&mut pixels).map_err(|e| context.damaged(e))?;
    for (y, row) in pixels.chunks_exact(length.max(1)).enumerate() {
        sink.row(y as u32, Row::U8(row));
    }
    Ok(())
}
