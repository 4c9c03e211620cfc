//! [`Source`] and [`Sink`]: the two ends of a decoder.
//!
//! A decoder reads a [`Source`] and hands rows to a [`Sink`] as it goes, so that an image goes
//! straight to the place where it stays: no decoder holds a second copy of the samples, except
//! where its format stores them in another order (interlaced PNG, JPEG).

use std::fs::File;
use std::io::{BufRead, BufReader, Cursor, Seek};
use std::path::Path;

use super::ImageFormat;
use crate::error::{Error, Place, Result};
use crate::limits::Limits;

/// Something to decode from.
pub(crate) trait Input: BufRead + Seek {}

impl<T: BufRead + Seek> Input for T {}

/// What every decoder needs beside the bytes: the name errors give, and what may be allocated.
#[derive(Clone, Copy)]
pub(crate) struct Context<'a> {
    /// The file.
    pub path: &'a Path,
    /// What may be allocated.
    pub limits: &'a Limits,
}

impl Context<'_> {
    /// The content is damaged: `why` is what the decoder says.
    pub fn damaged(&self, why: impl std::fmt::Display) -> Error {
        Error::invalid(self.path, Place::File, "content", why.to_string().trim(), "")
    }

    /// The header holds a value that is not read.
    pub fn unsupported(&self, what: &str, found: impl Into<String>, allowed: &str) -> Error {
        Error::unsupported(self.path, Place::Header, what, found, allowed)
    }

    /// Checks the declared size of an image against the limits.
    pub fn check(&self, info: &ImageInfo) -> Result<()> {
        let factors = [info.width, info.height, info.channels, info.sample.bytes()];
        self.limits.check(self.path, Place::Header, "decoding the image", &factors.map(u64::from))
    }
}

/// An image file, open for reading.
pub(crate) struct Source<'a> {
    /// Name and limits.
    pub context: Context<'a>,
    /// The bytes.
    pub input: Box<dyn Input + 'a>,
}

impl<'a> Source<'a> {
    /// Opens a file.
    pub fn open(path: &'a Path, limits: &'a Limits) -> Result<Self> {
        let fail = |e| Error::io(path, e);
        let file = File::open(path).map_err(fail)?;
        if file.metadata().map_err(fail)?.is_dir() {
            return Err(fail(std::io::ErrorKind::IsADirectory.into()));
        }
        let input = Box::new(BufReader::with_capacity(1 << 16, file));
        Ok(Self { context: Context { path, limits }, input })
    }

    /// Takes bytes for a file called `path`.
    pub fn from_bytes(bytes: &'a [u8], path: &'a Path, limits: &'a Limits) -> Self {
        Self { context: Context { path, limits }, input: Box::new(Cursor::new(bytes)) }
    }

    /// The format, from the first bytes; the name of a file proves nothing, unless its format has no
    /// mark.
    pub fn format(&mut self) -> Result<ImageFormat> {
        let path = self.context.path;
        let head = self.input.fill_buf().map_err(|e| Error::io(path, e))?;
        ImageFormat::of_file(head, path).ok_or_else(|| {
            let found = match head {
                [] => "an empty file".to_owned(),
                _ => format!("a file that begins with {:02x?}", &head[..head.len().min(8)]),
            };
            Error::unsupported(path, Place::File, "image format", found, ImageFormat::NAMES)
        })
    }
}

/// How one sample is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleKind {
    /// 8-bit codes; 255 is 1.
    U8,
    /// 16-bit codes; 65535 is 1.
    U16,
    /// Numbers as they are: floats of any width, signed and 32-bit integers.
    F32,
}

impl SampleKind {
    /// Bytes of a decoded sample.
    pub fn bytes(self) -> u32 {
        match self {
            Self::U8 => 1,
            Self::U16 => 2,
            Self::F32 => 4,
        }
    }
}

/// What the header of an image says.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ImageInfo {
    /// The format.
    pub format: ImageFormat,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Samples a pixel: 1 grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha.
    pub channels: u32,
    /// How a sample is handed on.
    pub sample: SampleKind,
    /// Bits of a sample in the file.
    pub file_bits: u32,
    /// The sample that stands where nothing was measured, as stored.
    pub void: Option<f32>,
}

/// One row of pixels, left to right, channels interleaved.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Row<'a> {
    /// 8-bit codes.
    U8(&'a [u8]),
    /// 16-bit codes.
    U16(&'a [u16]),
    /// Numbers.
    F32(&'a [f32]),
}

/// Whether a decoder goes on after the header.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Flow {
    /// Decode the rows.
    Decode,
    /// The header was all that was asked for.
    Stop,
}

/// Takes what a decoder reads: one `begin`, then every row once, in any order; or `grid` once.
pub(crate) trait Sink {
    /// Sees the header, whose size has been checked against the limits.
    fn begin(&mut self, info: &ImageInfo) -> Result<Flow>;

    /// Takes row `y`, counted from the top.
    fn row(&mut self, y: u32, row: Row<'_>);

    /// Takes all samples at once, top row first, where a decoder has them so.
    fn grid(&mut self, info: &ImageInfo, samples: Vec<f32>) {
        let length = info.width as usize * info.channels as usize;
        for (y, row) in samples.chunks_exact(length.max(1)).enumerate() {
            self.row(y as u32, Row::F32(row));
        }
    }
}
