//! Radiance HDR (`.hdr`, `.pic`): lines of text, then pixels of three mantissas and one exponent, each
//! scan line run-length coded \[Ward1991\].
//!
//! A pixel is `mantissa * 2^(exponent - 136)`, 0 where the exponent is 0, over the product of the
//! header's `EXPOSURE`. Only `-Y height +X width` is read, the usual order: top row first.

use super::ImageFormat;
use super::source::{Context, Flow, ImageInfo, Input, Row, SampleKind, Sink};
use crate::error::{Error, Place, Result};

/// Longest header line that is read, in bytes.
const LONGEST_LINE: usize = 4096;
/// Most header lines that are read.
const MOST_LINES: usize = 1024;

/// Decodes a Radiance picture.
pub(super) fn decode(
    context: Context<'_>,
    mut input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let (width, height, exposure) = header(context, &mut *input)?;
    let info = ImageInfo {
        format: ImageFormat::Radiance,
        width,
        height,
        channels: 3,
        sample: SampleKind::F32,
        file_bits: 32,
        void: None,
    };
    context.check(&info)?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    let mut pixels = vec![[0; 4]; width as usize];
    let mut row = vec![0.0; 3 * width as usize];
    for y in 0..height {
        scan_line(&mut *input, &mut pixels)
            .map_err(|why| context.damaged(format!("row {y}: {why}")))?;
        for (to, &[r, g, b, e]) in row.chunks_exact_mut(3).zip(&pixels) {
            let scale = if e == 0 { 0.0 } else { 2.0_f64.powi(i32::from(e) - 136) / exposure };
            for (to, mantissa) in to.iter_mut().zip([r, g, b]) {
                *to = (f64::from(mantissa) * scale) as f32;
            }
        }
        sink.row(y, Row::F32(&row));
    }
    Ok(())
}

/// Width, height and the exposure to divide by.
fn header(context: Context<'_>, input: &mut dyn Input) -> Result<(u32, u32, f64)> {
    let fault = |what, found: &str, allowed| {
        Error::invalid(context.path, Place::Header, what, found, allowed)
    };
    let mut exposure = 1.0;
    for _ in 0..MOST_LINES {
        let text = line(context, input)?;
        if text.is_empty() {
            let size = line(context, input)?;
            let words: Vec<_> = size.split_whitespace().collect();
            let side = |word: &str| word.parse().ok().filter(|side| *side > 0);
            return match words.as_slice() {
                ["-Y", height, "+X", width] => match (side(width), side(height)) {
                    (Some(width), Some(height)) => Ok((width, height, exposure)),
                    _ => Err(fault("size", &size, "integers from 1 to 4294967295")),
                },
                _ => Err(context.unsupported("order of pixels", size, "-Y HEIGHT +X WIDTH")),
            };
        }
        if let Some(format) = text.strip_prefix("FORMAT=")
            && format.trim() != "32-bit_rle_rgbe"
        {
            return Err(context.unsupported("FORMAT", format.trim(), "32-bit_rle_rgbe"));
        }
        if let Some(factor) = text.strip_prefix("EXPOSURE=") {
            let number = factor.trim().parse::<f64>().ok().filter(|f| *f > 0.0 && f.is_finite());
            exposure *= number.ok_or_else(|| fault("EXPOSURE", factor, "a number above 0"))?;
        }
    }
    Err(context.damaged("the header has no end"))
}

/// The next line of the header, without its end.
fn line(context: Context<'_>, input: &mut dyn Input) -> Result<String> {
    let mut bytes = Vec::new();
    loop {
        let mut byte = [0];
        input.read_exact(&mut byte).map_err(|_| context.damaged("the header ends early"))?;
        match byte[0] {
            b'\n' => return Ok(String::from_utf8_lossy(&bytes).trim_end().to_owned()),
            _ if bytes.len() == LONGEST_LINE => {
                return Err(context.damaged("the header has no end"));
            }
            byte => bytes.push(byte),
        }
    }
}

/// Reads a scan line, in any of the three ways to store it.
fn scan_line(input: &mut dyn Input, pixels: &mut [[u8; 4]]) -> std::result::Result<(), String> {
    let mut next = || -> std::result::Result<[u8; 4], String> {
        let mut pixel = [0; 4];
        input.read_exact(&mut pixel).map_err(|e| e.to_string())?;
        Ok(pixel)
    };
    let first = next()?;
    let width = pixels.len();
    let length = usize::from(first[2]) << 8 | usize::from(first[3]);
    if first[..2] == [2, 2] && first[2] < 128 && length == width && width >= 8 {
        return (0..4).try_for_each(|channel| runs(input, pixels, channel));
    }
    // Pixels as they are, with runs of the one before, longer by 256 times for each that follows.
    let (mut x, mut shift, mut pixel) = (0_usize, 0, first);
    loop {
        if pixel[..3] == [1, 1, 1] {
            let before = pixels.get(x.wrapping_sub(1)).copied().ok_or("a run without a pixel")?;
            let count = usize::from(pixel[3]) << shift;
            let to = pixels.get_mut(x..x + count).ok_or("a run beyond its row")?;
            to.fill(before);
            x += count;
            shift = (shift + 8).min(24);
        } else {
            pixels[x] = pixel;
            x += 1;
            shift = 0;
        }
        if x == width {
            return Ok(());
        }
        pixel = next()?;
    }
}

/// Reads the runs of one channel of a scan line.
fn runs(
    input: &mut dyn Input,
    pixels: &mut [[u8; 4]],
    channel: usize,
) -> std::result::Result<(), String> {
    let mut byte = || -> std::result::Result<u8, String> {
        let mut byte = [0];
        input.read_exact(&mut byte).map_err(|e| e.to_string())?;
        Ok(byte[0])
    };
    let mut x = 0;
    while x < pixels.len() {
        let code = byte()?;
        let (count, same) = match code {
            0 => return Err("an empty run".to_owned()),
            1..=128 => (usize::from(code), None),
            _ => (usize::from(code - 128), Some(byte()?)),
        };
        let to = pixels.get_mut(x..x + count).ok_or("a run beyond its row")?;
        for pixel in to {
            pixel[channel] = match same {
                Some(value) => value,
                None => byte()?,
            };
        }
        x += count;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::super::read_colour_bytes;
    use crate::limits::Limits;

    fn read(head: &str, body: &[u8]) -> crate::error::Result<Vec<[f64; 3]>> {
        let bytes = [head.as_bytes(), body].concat();
        let image = read_colour_bytes(&bytes, Path::new("a.hdr"), &Limits::default())?;
        // Row 0 is the lowest.
        let places =
            (0..image.height()).rev().flat_map(|j| (0..image.width()).map(move |i| (i, j)));
        Ok(places.map(|(i, j)| image.texel(i, j).to_array()).collect())
    }

    #[test]
    fn all_ways_to_store_a_row() {
        let head = "#?RADIANCE\n# made by hand\nFORMAT=32-bit_rle_rgbe\nEXPOSURE=2\n\n-Y 2 +X 8\n";
        // Runs by channel, then pixels as they are with a run of six.
        let coded = [
            &[2, 2, 0, 8][..],
            &[136, 64],
            &[2, 1, 2, 134, 0],
            &[136, 0],
            &[136, 129],
            &[128, 64, 32, 137, 0, 0, 0, 0, 1, 1, 1, 6],
        ]
        .concat();
        let pixels = read(head, &coded).unwrap();
        // 2^(129 - 136) / 2 is 1 / 256.
        assert_eq!(pixels[0], [0.25, 1.0 / 256.0, 0.0]);
        assert_eq!(pixels[1], [0.25, 2.0 / 256.0, 0.0]);
        assert_eq!(pixels[7], [0.25, 0.0, 0.0]);
        assert_eq!(pixels[8], [128.0, 64.0, 32.0]);
        assert_eq!(pixels[9..], [[0.0; 3]; 7]);
    }

    #[test]
    fn damage_is_an_error() {
        let size = |size: &str| format!("#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n{size}\n");
        let one = size("-Y 1 +X 8");
        for (head, body) in [
            (one.as_str(), &[2, 2, 0, 8, 137, 0][..]),
            (one.as_str(), &[2, 2, 0, 8, 0]),
            (one.as_str(), &[1, 1, 1, 1]),
            (one.as_str(), &[9, 9, 9, 9, 1, 1, 1, 200]),
            (one.as_str(), &[9, 9]),
            (&size("-Y 0 +X 8"), &[]),
            (&size("+X 8 -Y 1"), &[]),
            ("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n", &[1, 2, 3, 4]),
            ("#?RADIANCE\nEXPOSURE=0\n\n-Y 1 +X 1\n", &[1, 2, 3, 4]),
            ("#?RADIANCE\n", &[]),
        ] {
            assert!(read(head, body).is_err(), "{head:?} {body:?}");
        }
    }
}
