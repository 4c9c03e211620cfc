//! The data of a block of lines or a tile.
//!
//! It holds, line by line and within a line channel by channel in name order, the samples. Its bytes
//! are split into even and odd ones, replaced by their differences plus 128, and deflated; a block
//! that does not shrink is stored as it is.

use std::io::{self, Write};
use std::ops::Range;

use exr::prelude::f16;
use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::{Picture, Stored, Values};

/// Buffers of one block.
#[derive(Default)]
pub(super) struct Scratch {
    raw: Vec<u8>,
    split: Vec<u8>,
    packed: Vec<u8>,
}

impl Scratch {
    /// Gathers and compresses a rectangle of a picture, its channels in the given order.
    pub(super) fn pack(
        &mut self,
        picture: &Picture<'_>,
        order: &[usize],
        x: Range<u32>,
        y: Range<u32>,
    ) -> io::Result<()> {
        self.raw.clear();
        for line in y {
            for channel in order.iter().map(|&c| &picture.channels[c]) {
                let first = line as usize * picture.width as usize + x.start as usize;
                self.raw.reserve(channel.stored.bytes() * x.len());
                match &channel.values {
                    &Values::Kept { values, stride } => {
                        let values = values[first * stride..].iter();
                        self.store(channel.stored, values.step_by(stride).take(x.len()).copied());
                    }
                    Values::Made(value) => {
                        self.store(channel.stored, (first..first + x.len()).map(|at| value(at)));
                    }
                }
            }
        }
        self.split.clear();
        self.split.extend(self.raw.iter().step_by(2));
        self.split.extend(self.raw.iter().skip(1).step_by(2));
        let mut before = 0;
        for (at, byte) in self.split.iter_mut().enumerate() {
            let here = *byte;
            if at > 0 {
                *byte = here.wrapping_sub(before).wrapping_add(128);
            }
            before = here;
        }
        self.packed.clear();
        let mut encoder = ZlibEncoder::new(&mut self.packed, Compression::new(4));
        encoder.write_all(&self.split)?;
        encoder.finish()?;
        Ok(())
    }

    fn store(&mut self, stored: Stored, values: impl Iterator<Item = f32>) {
        match stored {
            Stored::Float => values.for_each(|v| self.raw.extend(v.to_le_bytes())),
            Stored::Half => values.for_each(|v| self.raw.extend(half(v).to_le_bytes())),
        }
    }

    /// What goes into the file.
    pub(super) fn smallest(&self) -> &[u8] {
        if self.packed.len() < self.raw.len() { &self.packed } else { &self.raw }
    }
}

/// The nearest half, of a finite value a finite one.
fn half(value: f32) -> f16 {
    let most = f16::MAX.to_f32();
    f16::from_f32(if value.is_finite() { value.clamp(-most, most) } else { value })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn halves_are_the_nearest_and_never_become_infinite() {
        for (value, want) in [
            (1.0, 1.0),
            (0.1, 0.099_975_586),
            // Between 2048 and 2050: to the even one.
            (2049.0, 2048.0),
            (65_504.0, 65_504.0),
            (1e9, 65_504.0),
            (-1e9, -65_504.0),
            (6e-8, 5.960_464_5e-8),
            (1e-9, 0.0),
            (f32::INFINITY, f32::INFINITY),
        ] {
            assert_eq!(half(value).to_f32(), want, "{value}");
        }
        assert!(half(f32::NAN).is_nan());
    }
}
