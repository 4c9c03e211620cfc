//! The data of a PLY file, value by value.

use std::path::Path;

use super::header::{Encoding, Scalar};
use crate::error::{Error, Excerpt, Place, Result};

/// Values as they come.
pub(super) struct Values<'a> {
    path: &'a Path,
    encoding: Encoding,
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Values<'a> {
    /// The values of `bytes` from `at` on.
    pub fn new(path: &'a Path, encoding: Encoding, bytes: &'a [u8], at: usize) -> Self {
        Self { path, encoding, bytes, at }
    }

    /// Bytes that are left.
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// The next value.
    pub fn next(&mut self, scalar: Scalar) -> Result<f64> {
        match self.encoding {
            Encoding::Ascii => self.word(),
            Encoding::LittleEndian => self.binary(scalar, false),
            Encoding::BigEndian => self.binary(scalar, true),
        }
    }

    fn word(&mut self) -> Result<f64> {
        let blank = |b: &u8| b.is_ascii_whitespace();
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !blank(b)).ok_or_else(|| self.short())?;
        let word = &rest[start..];
        let word = &word[..word.iter().position(blank).unwrap_or(word.len())];
        self.at += start + word.len();
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| {
            let (found, allowed) = (String::from_utf8_lossy(word).into_owned(), "a number");
            self.fault(self.at - word.len()..self.at, "value", format!("{found:?}"), allowed)
        })
    }

    fn binary(&mut self, scalar: Scalar, big: bool) -> Result<f64> {
        let raw = self.bytes[self.at..].get(..scalar.bytes()).ok_or_else(|| self.short())?;
        self.at += raw.len();
        // The value in the last bytes, as if big-endian.
        let mut wide = [0; 8];
        for (k, byte) in raw.iter().enumerate() {
            wide[8 - raw.len() + if big { k } else { raw.len() - 1 - k }] = *byte;
        }
        let bits = u64::from_be_bytes(wide);
        Ok(match scalar {
            Scalar::I8 => f64::from(bits as u8 as i8),
            Scalar::U8 => bits as f64,
            Scalar::I16 => f64::from(bits as u16 as i16),
            Scalar::U16 => bits as f64,
            Scalar::I32 => f64::from(bits as u32 as i32),
            Scalar::U32 => bits as f64,
            Scalar::F32 => f64::from(f32::from_bits(bits as u32)),
            Scalar::F64 => f64::from_bits(bits),
        })
    }

    /// The piece `range` is wrong.
    pub fn fault(
        &self,
        range: std::ops::Range<usize>,
        what: &str,
        found: String,
        allowed: &str,
    ) -> Error {
        // Only text has lines that help.
        let place = match self.encoding {
            Encoding::Ascii => {
                let text = String::from_utf8_lossy(self.bytes);
                Place::Text(Excerpt::new(&text, range))
            }
            _ => Place::File,
        };
        Error::invalid(self.path, place, what, found, allowed)
    }

    /// The last value, which ends here, is wrong.
    pub fn last(&self, what: &str, found: String, allowed: &str) -> Error {
        self.fault(self.at.saturating_sub(1)..self.at, what, found, allowed)
    }

    fn short(&self) -> Error {
        let found = "the file ends before its data";
        Error::invalid(
            self.path,
            Place::File,
            "content",
            found,
            "as many values as the header says",
        )
    }
}
