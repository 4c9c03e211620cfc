//! Portable float map: three words of text, then 32-bit floats, the *bottom* row first.
//!
//! `PF` has three channels, `Pf` one. The third number is a scale whose sign tells the byte order,
//! below 0 little endian; its size, by the format's custom, is not applied.

use super::ImageFormat;
use super::source::{Context, Flow, ImageInfo, Input, Row, SampleKind, Sink};
use crate::error::{Error, Place, Result};

/// Longest header line that is read, in bytes.
const LONGEST_WORD: usize = 32;

/// Decodes a portable float map.
pub(super) fn decode(
    context: Context<'_>,
    mut input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let header = |what, found: String, allowed| {
        Error::invalid(context.path, Place::Header, what, found, allowed)
    };
    let channels = if word(context, &mut *input)? == "PF" { 3 } else { 1 };
    let mut side = |what| -> Result<u32> {
        let text = word(context, &mut *input)?;
        match text.parse() {
            Ok(side) if side > 0 => Ok(side),
            _ => Err(header(what, text, "an integer from 1 to 4294967295")),
        }
    };
    let (width, height) = (side("width")?, side("height")?);
    let text = word(context, &mut *input)?;
    let scale = text.parse::<f32>().ok().filter(|s| s.is_finite() && *s != 0.0);
    let scale = scale.ok_or_else(|| header("scale", text, "a number other than 0"))?;
    let sample = SampleKind::F32;
    let info = ImageInfo {
        format: ImageFormat::Pfm,
        width,
        height,
        channels,
        sample,
        file_bits: 32,
        void: None,
    };
    context.check(&info)?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    let length = width as usize * channels as usize;
    let (mut bytes, mut row) = (vec![0; length * 4], vec![0.0; length]);
    for y in (0..height).rev() {
        input.read_exact(&mut bytes).map_err(|e| context.damaged(format!("row {y}: {e}")))?;
        for (value, b) in row.iter_mut().zip(bytes.chunks_exact(4)) {
            let b = [b[0], b[1], b[2], b[3]];
            *value = if scale < 0.0 { f32::from_le_bytes(b) } else { f32::from_be_bytes(b) };
        }
        sink.row(y, Row::F32(&row));
    }
    Ok(())
}

/// The next word of the header and the one space after it.
fn word(context: Context<'_>, input: &mut dyn Input) -> Result<String> {
    let mut text = String::new();
    loop {
        let mut byte = [0];
        input.read_exact(&mut byte).map_err(|_| context.damaged("the header ends early"))?;
        match byte[0] {
            b' ' | b'\t' | b'\n' | b'\r' if text.is_empty() => {}
            b' ' | b'\t' | b'\n' | b'\r' => return Ok(text),
            _ if text.len() == LONGEST_WORD => return Err(context.damaged("the header has no end")),
            byte => text.push(char::from(byte)),
        }
    }
}
