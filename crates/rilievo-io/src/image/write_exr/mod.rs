//! OpenEXR writing: one part of scan lines or tiles, half or float samples, ZIP compression.
//!
//! Written here and not through a crate because the bytes must be the same for the same picture:
//! the `exr` crate keeps attributes in a hash map, whose order changes from run to run. Layout from
//! the OpenEXR file layout document:
//!
//! | part | bytes |
//! |---|---|
//! | magic, version | `76 2f 31 01`, 2 with the flags for tiles and for names of over 31 bytes |
//! | attributes | name, 0, type, 0, size (i32), value; one 0 ends the list |
//! | offset table | u64 for each block: where it starts |
//! | block of lines | first line (i32), size (i32), data |
//! | tile | column, row, level x, level y (i32 each), size (i32), data |
//!
//! `header` makes the attributes, `block` the data.

mod block;
mod header;

use std::fmt;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::Path;
use std::sync::Arc;

use super::channels::{Attribute, ChannelImage};
use crate::atomic;
use crate::error::{Error, Place, Result};
use block::Scratch;

/// Lines of a block.
const BLOCK: u32 = 16;

/// Longest name without the long-name flag, and with it.
const NAME_BYTES: [usize; 2] = [31, 255];

/// How the samples of a channel are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Stored {
    /// 16 bits: eleven significant ones, up to 65504. A finite value beyond that becomes 65504.
    Half,
    /// 32 bits, as they are.
    #[default]
    Float,
}

impl Stored {
    fn bytes(self) -> usize {
        match self {
            Self::Half => 2,
            Self::Float => 4,
        }
    }
}

/// How the pixels of a picture are cut up in its file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Blocks {
    /// Sixteen lines each.
    #[default]
    Lines,
    /// Squares of so many pixels a side, at most 65536.
    Tiles(u32),
}

impl Blocks {
    /// Pixels of a block of a picture so many pixels wide, along x and y.
    fn size(self, width: u32) -> [u32; 2] {
        match self {
            Self::Lines => [width, BLOCK],
            Self::Tiles(side) => [side; 2],
        }
    }
}

/// A picture to be written: borrowed channels of one size, top row first.
#[derive(Clone, Debug, Default)]
pub struct Picture<'a> {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Where the pixels lie in a larger picture: the data window within the display window.
    pub crop: Option<Crop>,
    /// How they are cut up.
    pub blocks: Blocks,
    /// The channels, in any order.
    pub channels: Vec<PictureChannel<'a>>,
    /// Metadata, by name.
    pub attributes: Vec<(String, Attribute)>,
}

/// A rectangle of a larger picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Crop {
    /// Its first pixel along x and y.
    pub corner: [u32; 2],
    /// Pixels of the larger picture along x and y.
    pub full: [u32; 2],
}

/// A channel of a [`Picture`].
#[derive(Clone, Debug)]
pub struct PictureChannel<'a> {
    /// Its name, such as `R` or `P.X`.
    pub name: String,
    /// The values; the first is that of the top left pixel.
    pub values: Values<'a>,
    /// How they are stored.
    pub stored: Stored,
}

/// Where the values of a channel come from.
#[derive(Clone)]
pub enum Values<'a> {
    /// They are every so many of a slice.
    Kept {
        /// The slice, which begins with the value of the top left pixel.
        values: &'a [f32],
        /// Distance between the values of neighbouring pixels.
        stride: usize,
    },
    /// Each is made when it is written, from the place of its pixel, row by row from the top left: no
    /// plane of them is ever held.
    Made(Arc<dyn Fn(usize) -> f32 + Send + Sync + 'a>),
}

impl fmt::Debug for Values<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Kept { values, stride } => write!(f, "{} values / {stride}", values.len()),
            Self::Made(_) => f.write_str("values made when written"),
        }
    }
}

impl<'a> Picture<'a> {
    /// Adds channels whose values are interleaved: pixel by pixel one value for each name.
    pub fn push_interleaved(&mut self, names: &[&str], values: &'a [f32], stored: Stored) {
        for (c, name) in names.iter().enumerate() {
            let (name, values) = ((*name).to_owned(), values.get(c..).unwrap_or(&[]));
            let values = Values::Kept { values, stride: names.len() };
            self.channels.push(PictureChannel { name, values, stored });
        }
    }

    /// Bytes that writing a picture of such a size and so many channels holds beside it, at most: some
    /// copies of a block.
    pub fn predicted_bytes([width, height]: [u32; 2], blocks: Blocks, channels: usize) -> u64 {
        let [x, y] = blocks.size(width);
        let pixels = u64::from(x.min(width)) * u64::from(y.min(height));
        3 * pixels * (Stored::Float.bytes() * channels) as u64
    }

    /// Writes the picture to `path`, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] for a size of 0 or above 2^31 - 1, a crop or tiles that do
    /// not fit, a channel with too few values, names that are empty, doubled, longer than 255
    /// bytes or hold a zero byte.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        let order = self.check(path)?;
        atomic::replace(path, |out| self.encode(&order, out).map_err(|e| Error::io(path, e)))
    }

    /// The order of the channels in the file, by name.
    fn check(&self, path: &Path) -> Result<Vec<usize>> {
        let invalid = |what, found: String, allowed| {
            Err(Error::invalid(path, Place::Header, what, found, allowed))
        };
        let (size, sides) = ([self.width, self.height], 1..=i32::MAX as u32);
        if size.iter().any(|side| !sides.contains(side)) {
            let found = format!("{} x {}", self.width, self.height);
            return invalid("size", found, "1 to 2147483647 pixels a side");
        }
        let Crop { corner, full } = self.frame();
        let end = [0, 1].map(|axis| corner[axis].checked_add(size[axis]));
        if [0, 1]
            .iter()
            .any(|&k| end[k].is_none_or(|end| end > full[k]) || !sides.contains(&full[k]))
        {
            let found = format!("{corner:?} and {size:?} in {full:?}");
            return invalid("crop", found, "a rectangle of the larger picture");
        }
        if let Blocks::Tiles(side) = self.blocks
            && !(1..=65_536).contains(&side)
        {
            return invalid("tiles", format!("{side} pixels a side"), "1 to 65536");
        }
        let names = self.channels.iter().map(|c| &c.name);
        for name in names.chain(self.attributes.iter().map(|(name, _)| name)) {
            if name.is_empty() || name.len() > NAME_BYTES[1] || name.contains('\0') {
                return invalid("name", format!("{name:?}"), "1 to 255 bytes without a zero");
            }
        }
        let pixels = self.width as usize * self.height as usize;
        for channel in &self.channels {
            let Values::Kept { values, stride } = channel.values else { continue };
            let found = values.len().div_ceil(stride.max(1));
            if stride == 0 || found < pixels {
                let found = format!("{found} values in channel {}", channel.name);
                return invalid("channel", found, "one for each pixel");
            }
        }
        let mut order: Vec<_> = (0..self.channels.len()).collect();
        order.sort_by(|&a, &b| self.channels[a].name.cmp(&self.channels[b].name));
        let name = |at: usize| &self.channels[at].name;
        if let Some(pair) = order.windows(2).find(|p| name(p[0]) == name(p[1])) {
            return invalid("channel", format!("{} twice", name(pair[0])), "each name once");
        }
        if order.is_empty() {
            return invalid("channels", "none".into(), "at least one");
        }
        Ok(order)
    }

    /// The crop, or the whole.
    fn frame(&self) -> Crop {
        self.crop.unwrap_or(Crop { corner: [0, 0], full: [self.width, self.height] })
    }

    fn encode(&self, order: &[usize], out: &mut (impl Write + Seek)) -> io::Result<()> {
        let header = self.header(order);
        out.write_all(&header)?;
        let side = self.blocks.size(self.width);
        let [columns, rows] = [self.width.div_ceil(side[0]), self.height.div_ceil(side[1])];
        let count = columns as usize * rows as usize;
        // Offsets come before the blocks but are known after them: their place is left empty first, so
        // that no more than one block is held.
        let mut offsets = vec![0_u8; 8 * count];
        out.write_all(&offsets)?;
        let mut at = (header.len() + offsets.len()) as u64;
        let mut table = offsets.chunks_exact_mut(8);
        let mut scratch = Scratch::default();
        for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |c| (row, c))) {
            if let Some(entry) = table.next() {
                entry.copy_from_slice(&at.to_le_bytes());
            }
            let x = column * side[0]..self.width.min((column + 1).saturating_mul(side[0]));
            let y = row * side[1]..self.height.min((row + 1).saturating_mul(side[1]));
            scratch.pack(self, order, x, y.clone())?;
            let bytes = scratch.smallest();
            let place: &[u32] = match self.blocks {
                Blocks::Lines => &[self.frame().corner[1] + y.start],
                Blocks::Tiles(_) => &[column, row, 0, 0],
            };
            for &number in place.iter().chain([&(bytes.len() as u32)]) {
                out.write_all(&(number as i32).to_le_bytes())?;
                at += 4;
            }
            out.write_all(bytes)?;
            at += bytes.len() as u64;
        }
        out.seek(SeekFrom::Start(header.len() as u64))?;
        out.write_all(&offsets)
    }
}

impl ChannelImage {
    /// The image, ready to be written.
    pub fn picture(&self) -> Picture<'_> {
        let channels = (self.channels.iter())
            .map(|c| PictureChannel {
                name: c.name.clone(),
                values: Values::Kept { values: &c.samples, stride: 1 },
                stored: Stored::Float,
            })
            .collect();
        let attributes = self.attributes.clone();
        let (width, height) = (self.width, self.height);
        Picture { width, height, channels, attributes, ..Picture::default() }
    }
}

#[cfg(test)]
mod tests;
