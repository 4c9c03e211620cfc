//! [`Texels`]: the texels of an image at the depth of its file, and what they mean.

use std::ops::Range;

use crate::colour::{Rgb, linear_from_srgb};

/// The texels of a colour image, row-major, row 0 at `v = 0`.
#[derive(Clone, Debug, PartialEq)]
pub enum Texels {
    /// 8-bit sRGB codes.
    Srgb8(Vec<[u8; 3]>),
    /// 16-bit sRGB codes.
    Srgb16(Vec<[u16; 3]>),
    /// 8-bit codes of linear numbers, `code / 255`.
    Linear8(Vec<[u8; 3]>),
    /// 16-bit codes of linear numbers, `code / 65535`.
    Linear16(Vec<[u16; 3]>),
    /// Linear values.
    Linear(Vec<[f32; 3]>),
}

impl Texels {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Srgb8(v) | Self::Linear8(v) => v.len(),
            Self::Srgb16(v) | Self::Linear16(v) => v.len(),
            Self::Linear(v) => v.len(),
        }
    }

    pub(super) fn coding(&self) -> Coding {
        match self {
            Self::Srgb8(_) => Coding::Srgb8,
            Self::Srgb16(_) => Coding::Srgb16,
            Self::Linear8(_) => Coding::Linear8,
            Self::Linear16(_) => Coding::Linear16,
            Self::Linear(_) => Coding::Linear,
        }
    }

    /// Appends texels as bytes that [`Coding::texels`] reads.
    pub(super) fn put(&self, which: Range<usize>, out: &mut Vec<u8>) {
        match self {
            Self::Srgb8(v) | Self::Linear8(v) => out.extend(v[which].as_flattened()),
            Self::Srgb16(v) | Self::Linear16(v) => {
                out.extend(v[which].as_flattened().iter().flat_map(|c| c.to_le_bytes()));
            }
            Self::Linear(v) => {
                out.extend(v[which].as_flattened().iter().flat_map(|c| c.to_le_bytes()));
            }
        }
    }
}

/// How texels are coded: the kinds of [`Texels`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Coding {
    Srgb8,
    Srgb16,
    Linear8,
    Linear16,
    Linear,
}

impl Coding {
    /// Bytes a texel.
    pub fn bytes(self) -> u64 {
        match self {
            Self::Srgb8 | Self::Linear8 => 3,
            Self::Srgb16 | Self::Linear16 => 6,
            Self::Linear => 12,
        }
    }

    /// What [`Texels::put`] has written.
    pub fn texels(self, bytes: &[u8]) -> Texels {
        let codes = || bytes.as_chunks::<3>().0.to_vec();
        let word = |[low, high]: [u8; 2]| u16::from_le_bytes([low, high]);
        let words = || {
            let texels = bytes.as_chunks::<6>().0.iter();
            texels.map(|&[a, b, c, d, e, f]| [[a, b], [c, d], [e, f]].map(word)).collect()
        };
        match self {
            Self::Srgb8 => Texels::Srgb8(codes()),
            Self::Linear8 => Texels::Linear8(codes()),
            Self::Srgb16 => Texels::Srgb16(words()),
            Self::Linear16 => Texels::Linear16(words()),
            Self::Linear => {
                let channels = bytes.as_chunks::<4>().0.iter().map(|&c| f32::from_le_bytes(c));
                let channels: Vec<f32> = channels.collect();
                Texels::Linear(channels.as_chunks::<3>().0.to_vec())
            }
        }
    }
}

/// Why a colour image was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum TextureError {
    /// No texel along an axis, or more than `i32` indices can count.
    #[error("a colour image needs 1 to 16777216 texels along an axis, not {width} x {height}")]
    BadSize {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
    },
    /// The texel count is not width times height.
    #[error("{width} x {height} needs {} texels, {found} were given", u64::from(*width) * u64::from(*height))]
    WrongCount {
        /// Texels along u.
        width: u32,
        /// Texels along v.
        height: u32,
        /// Texels given.
        found: usize,
    },
    /// A texel is NaN, infinite or below 0.
    #[error("texel ({i}, {j}) holds {value}; colours must be finite and at least 0")]
    BadValue {
        /// Column.
        i: u32,
        /// Row, counted from `v = 0`.
        j: u32,
        /// The value found.
        value: f32,
    },
}

/// An image without coarser ones, or a part of one.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Level {
    pub(super) width: u32,
    pub(super) height: u32,
    pub(super) texels: Texels,
}

/// From codes to linear light.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Decoder {
    /// The linear value of every 8-bit code.
    of_code: Vec<f32>,
}

impl Decoder {
    pub fn new(coding: Coding) -> Self {
        let codes = (0..=255).map(|code| f64::from(code) / 255.0);
        let of_code = match coding {
            Coding::Srgb8 => codes.map(|code| linear_from_srgb(code) as f32).collect(),
            Coding::Linear8 => codes.map(|code| code as f32).collect(),
            Coding::Srgb16 | Coding::Linear16 | Coding::Linear => Vec::new(),
        };
        Self { of_code }
    }

    /// The linear colour of a texel.
    #[inline]
    pub fn texel(&self, level: &Level, i: u32, j: u32) -> Rgb {
        let at = j as usize * level.width as usize + i as usize;
        let code = |c: u8| f64::from(self.of_code[usize::from(c)]);
        let rgb = match &level.texels {
            Texels::Srgb8(v) | Texels::Linear8(v) => v[at].map(code),
            Texels::Srgb16(v) => v[at].map(|c| linear_from_srgb(f64::from(c) / 65535.0)),
            Texels::Linear16(v) => v[at].map(|c| f64::from(c) / 65535.0),
            Texels::Linear(v) => v[at].map(f64::from),
        };
        Rgb::from_array(rgb)
    }
}

/// An image of those that halve each other.
pub(crate) struct ImageLevel<'a> {
    level: &'a Level,
    decoder: &'a Decoder,
}

impl<'a> ImageLevel<'a> {
    /// A level and what decodes it.
    pub(super) fn new(level: &'a Level, decoder: &'a Decoder) -> Self {
        Self { level, decoder }
    }

    /// Texels along u and v.
    pub(crate) fn size(&self) -> [u32; 2] {
        [self.level.width, self.level.height]
    }

    /// Its texels, row by row, if they are codes of 8 bits, and whether those are sRGB.
    pub(crate) fn codes(&self) -> Option<(&[[u8; 3]], bool)> {
        match &self.level.texels {
            Texels::Srgb8(codes) => Some((codes, true)),
            Texels::Linear8(codes) => Some((codes, false)),
            Texels::Srgb16(_) | Texels::Linear16(_) | Texels::Linear(_) => None,
        }
    }

    /// The linear colour of a texel.
    pub(crate) fn texel(&self, i: u32, j: u32) -> Rgb {
        self.decoder.texel(self.level, i, j)
    }
}
