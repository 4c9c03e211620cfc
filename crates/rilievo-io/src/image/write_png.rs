//! PNG writing: 8-bit RGB marked as sRGB, 16-bit grey, 16-bit RGB.

use std::io::Write;
use std::path::Path;

use png::{BitDepth, ColorType, Encoder, SrgbRenderingIntent};

use crate::atomic;
use crate::error::{Error, Place, Result};

/// Writes `width` x `height` pixels of sRGB codes, top row first, whole or not at all.
///
/// # Errors
/// [`Error::Io`]; [`Error::Invalid`] if the number of pixels is not `width * height` or is 0.
pub fn write_png_rgb8(path: &Path, size: [u32; 2], pixels: &[[u8; 3]]) -> Result<()> {
    check(path, size, pixels.len())?;
    write(path, |out| {
        let mut encoder = Encoder::new(out, size[0], size[1]);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Eight);
        encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
        finish(encoder, pixels.as_flattened())
    })
}

/// Writes `width` x `height` 16-bit grey codes, top row first, whole or not at all.
///
/// # Errors
/// As [`write_png_rgb8`].
pub fn write_png_grey16(path: &Path, size: [u32; 2], codes: &[u16]) -> Result<()> {
    check(path, size, codes.len())?;
    let bytes: Vec<u8> = codes.iter().flat_map(|code| code.to_be_bytes()).collect();
    write(path, |out| {
        let mut encoder = Encoder::new(out, size[0], size[1]);
        encoder.set_color(ColorType::Grayscale);
        encoder.set_depth(BitDepth::Sixteen);
        finish(encoder, &bytes)
    })
}

/// Writes `width` x `height` 16-bit RGB codes, top row first, whole or not at all. They are numbers,
/// such as normals, and not marked as colours.
///
/// # Errors
/// As [`write_png_rgb8`].
pub fn write_png_rgb16(path: &Path, size: [u32; 2], codes: &[[u16; 3]]) -> Result<()> {
    check(path, size, codes.len())?;
    let bytes: Vec<u8> = codes.as_flattened().iter().flat_map(|code| code.to_be_bytes()).collect();
    write(path, |out| {
        let mut encoder = Encoder::new(out, size[0], size[1]);
        encoder.set_color(ColorType::Rgb);
        encoder.set_depth(BitDepth::Sixteen);
        finish(encoder, &bytes)
    })
}

fn check(path: &Path, [width, height]: [u32; 2], found: usize) -> Result<()> {
    if found > 0 && found as u64 == u64::from(width) * u64::from(height) {
        return Ok(());
    }
    let found = format!("{found} pixels for {width} x {height}");
    Err(Error::invalid(
        path,
        Place::File,
        "image",
        found,
        "one pixel or more, as many as the size says",
    ))
}

fn write(
    path: &Path,
    encode: impl FnOnce(&mut dyn Write) -> std::result::Result<(), png::EncodingError>,
) -> Result<()> {
    atomic::replace(path, |out| {
        encode(out).map_err(|e| match e {
            png::EncodingError::IoError(e) => Error::io(path, e),
            other => Error::io(path, std::io::Error::other(other)),
        })
    })
}

fn finish(
    encoder: Encoder<'_, &mut dyn Write>,
    bytes: &[u8],
) -> std::result::Result<(), png::EncodingError> {
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;
    use crate::image::{HeightOptions, read_colour};
    use rilievo::map::Samples;
    use rilievo_render::texture::{ColourImage, Texels};

    #[test]
    fn written_images_are_read_back_bottom_row_first() {
        let dir = tempfile::tempdir().unwrap();
        let (path, limits) = (dir.path().join("a.png"), Limits::default());
        let codes = [0, 1, 2, 257, 65534, 65535];
        write_png_grey16(&path, [3, 2], &codes).unwrap();
        let map = HeightOptions::default().read(&path, &limits).unwrap();
        assert_eq!(*map.samples(), Samples::U16(vec![257, 65534, 65535, 0, 1, 2]));

        let (top, bottom) = ([[1, 2, 3], [4, 5, 6]], [[7, 8, 9], [250, 251, 252]]);
        write_png_rgb8(&path, [2, 2], &[top, bottom].concat()).unwrap();
        let want = ColourImage::new(2, 2, Texels::Srgb8([bottom, top].concat())).unwrap();
        assert_eq!(read_colour(&path, &limits).unwrap(), want);
        assert!(write_png_grey16(&path, [3, 3], &codes).is_err());
        assert_eq!(read_colour(&path, &limits).unwrap(), want, "the old file is still there");
    }
}
