//! Normal maps from image files: 8- and 16-bit RGB, alpha ignored.
//!
//! No transfer curve is undone: normals are not colours. The last row of the file becomes row 0
//! (`v = 0`); which way green points is the caller's to say, nothing is guessed.

use std::path::Path;

use rilievo::map::{Lattice, NormalConvention, NormalMap, NormalTexels, Wrap};

use super::decode;
use super::source::{Context, Flow, ImageInfo, Row, SampleKind, Sink, Source};
use crate::error::{Place, Result};
use crate::limits::Limits;

/// How the texels of a normal map are meant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NormalOptions {
    /// Which way green points.
    pub convention: NormalConvention,
    /// Where texels sit.
    pub lattice: Lattice,
    /// What lies beyond the borders.
    pub wrap: Wrap,
}

impl NormalOptions {
    /// Reads a normal map from a file.
    ///
    /// # Errors
    /// Of the file, its format or its size; an image that is not RGB of 8 or 16 bits.
    pub fn read(&self, path: &Path, limits: &Limits) -> Result<NormalMap> {
        self.decode_from(Source::open(path, limits)?)
    }

    /// Reads a normal map from bytes; `name` is what errors call them.
    ///
    /// # Errors
    /// As [`NormalOptions::read`].
    pub fn read_bytes(&self, bytes: &[u8], name: &Path, limits: &Limits) -> Result<NormalMap> {
        self.decode_from(Source::from_bytes(bytes, name, limits))
    }

    fn decode_from(&self, source: Source<'_>) -> Result<NormalMap> {
        let context = source.context;
        let texels = NormalTexels::U8(Vec::new());
        let mut canvas = Canvas { context, size: [0; 2], channels: 3, texels };
        decode(source, &mut canvas)?;
        let lattice = (self.lattice, self.wrap);
        NormalMap::from_texels(canvas.size, &canvas.texels, self.convention, lattice)
            .map_err(|e| context.damaged(e))
    }
}

/// Texels that fill up row by row.
struct Canvas<'a> {
    context: Context<'a>,
    size: [u32; 2],
    channels: usize,
    texels: NormalTexels,
}

impl Sink for Canvas<'_> {
    fn begin(&mut self, info: &ImageInfo) -> Result<Flow> {
        if info.channels < 3 {
            let found = format!("{} channels", info.channels);
            return Err(self.context.unsupported(
                "normal map",
                found,
                "RGB, with or without alpha",
            ));
        }
        // A texel, and the three floats it becomes.
        let texel = 3 * info.sample.bytes() + 12;
        let sides = [info.width, info.height, texel].map(u64::from);
        let Context { path, limits } = self.context;
        limits.check(path, Place::Header, "the normal map", &sides)?;
        let count = info.width as usize * info.height as usize;
        self.texels = match info.sample {
            SampleKind::U8 => NormalTexels::U8(vec![[0; 3]; count]),
            SampleKind::U16 => NormalTexels::U16(vec![[0; 3]; count]),
            SampleKind::F32 => {
                let allowed = "unsigned codes of 8 or 16 bits";
                return Err(self.context.unsupported("normal map", "numbers", allowed));
            }
        };
        self.size = [info.width, info.height];
        self.channels = info.channels as usize;
        Ok(Flow::Decode)
    }

    fn row(&mut self, y: u32, row: Row<'_>) {
        let [width, height] = self.size.map(|n| n as usize);
        let start = (height - 1 - y as usize) * width;
        match (&mut self.texels, row) {
            (NormalTexels::U8(to), Row::U8(row)) => {
                fill(&mut to[start..start + width], row, self.channels);
            }
            (NormalTexels::U16(to), Row::U16(row)) => {
                fill(&mut to[start..start + width], row, self.channels);
            }
            // `begin` chose the texels for the rows this image has.
            _ => {}
        }
    }
}

fn fill<T: Copy>(to: &mut [[T; 3]], row: &[T], channels: usize) {
    for (to, pixel) in to.iter_mut().zip(row.chunks_exact(channels)) {
        if let [r, g, b, ..] = *pixel {
            *to = [r, g, b];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::{write_png_grey16, write_png_rgb8};

    #[test]
    fn green_points_where_the_caller_says_and_rows_run_upwards() {
        let dir = tempfile::tempdir().unwrap();
        let (path, limits) = (dir.path().join("n.png"), Limits::default());
        // Top row leans along +x, bottom row along +y in OpenGL's sense.
        let pixels = [[255, 128, 128], [255, 128, 128], [128, 255, 128], [128, 255, 128]];
        write_png_rgb8(&path, [2, 2], &pixels).unwrap();
        let read = |convention| {
            let options = NormalOptions { convention, lattice: Lattice::Texel, wrap: Wrap::Clamp };
            options.read(&path, &limits).unwrap()
        };
        let (gl, dx) = (read(NormalConvention::OpenGl), read(NormalConvention::DirectX));
        assert!(gl.normal_at(0.25, 0.75).x > 0.99);
        assert!(gl.normal_at(0.25, 0.25).y > 0.99);
        assert!(dx.normal_at(0.25, 0.25).y < -0.99);
        write_png_grey16(&path, [2, 2], &[0; 4]).unwrap();
        let convention = NormalConvention::OpenGl;
        let options = NormalOptions { convention, lattice: Lattice::Texel, wrap: Wrap::Clamp };
        let error = options.read(&path, &limits).unwrap_err().to_string();
        assert!(error.contains("1 channels; allowed: RGB"), "{error}");
    }
}
