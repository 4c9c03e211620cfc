//! OpenEXR writing: one part of scan lines, 32-bit floats, ZIP compression of 16 lines a block.
//!
//! Written here and not through a crate because the bytes must be the same for the same picture:
//! the `exr` crate keeps attributes in a hash map, whose order changes from run to run. Layout from
//! the OpenEXR file layout document:
//!
//! | part | bytes |
//! |---|---|
//! | magic, version | `76 2f 31 01`, 2 with the long-name flag where a name has over 31 bytes |
//! | attributes | name, 0, type, 0, size (i32), value; one 0 ends the list |
//! | offset table | u64 for each block: where it starts |
//! | block | first line (i32), size (i32), data |
//!
//! A block holds, line by line and within a line channel by channel in name order, the samples. Its
//! bytes are split into even and odd ones, replaced by their differences plus 128, and deflated;
//! a block that does not shrink is stored as it is.

use std::io::{self, Write};
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::channels::{Attribute, ChannelImage};
use crate::atomic;
use crate::error::{Error, Place, Result};

/// Lines of a block.
const BLOCK: usize = 16;

/// Longest name without the long-name flag, and with it.
const NAME_BYTES: [usize; 2] = [31, 255];

/// A picture to be written: borrowed channels of one size, top row first.
#[derive(Clone, Debug, Default)]
pub struct Picture<'a> {
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The channels, in any order.
    pub channels: Vec<PictureChannel<'a>>,
    /// Metadata, by name.
    pub attributes: Vec<(String, Attribute)>,
}

/// A channel of a [`Picture`]: every `stride`-th value of `values`.
#[derive(Clone, Debug)]
pub struct PictureChannel<'a> {
    /// Its name, such as `R` or `P.X`.
    pub name: String,
    /// The values; the first is that of the top left pixel.
    pub values: &'a [f32],
    /// Distance between the values of neighbouring pixels.
    pub stride: usize,
}

impl<'a> Picture<'a> {
    /// Adds channels whose values are interleaved: pixel by pixel one value for each name.
    pub fn push_interleaved(&mut self, names: &[&str], values: &'a [f32]) {
        for (c, name) in names.iter().enumerate() {
            let (name, values) = ((*name).to_owned(), values.get(c..).unwrap_or(&[]));
            self.channels.push(PictureChannel { name, values, stride: names.len() });
        }
    }

    /// Writes the picture to `path`, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] for a size of 0 or above 2^31 - 1, a channel with too few
    /// values, names that are empty, doubled, longer than 255 bytes or hold a zero byte.
    pub fn write_exr(&self, path: &Path) -> Result<()> {
        let order = self.check(path)?;
        atomic::replace(path, |out| self.encode(&order, out).map_err(|e| Error::io(path, e)))
    }

    /// The order of the channels in the file, by name.
    fn check(&self, path: &Path) -> Result<Vec<usize>> {
        let invalid = |what, found: String, allowed| {
            Err(Error::invalid(path, Place::Header, what, found, allowed))
        };
        let sides = 1..=i32::MAX as u32;
        if !sides.contains(&self.width) || !sides.contains(&self.height) {
            let found = format!("{} x {}", self.width, self.height);
            return invalid("size", found, "1 to 2147483647 pixels a side");
        }
        let names = self.channels.iter().map(|c| &c.name);
        for name in names.chain(self.attributes.iter().map(|(name, _)| name)) {
            if name.is_empty() || name.len() > NAME_BYTES[1] || name.contains('\0') {
                return invalid("name", format!("{name:?}"), "1 to 255 bytes without a zero");
            }
        }
        let pixels = self.width as usize * self.height as usize;
        for channel in &self.channels {
            let found = channel.values.len().div_ceil(channel.stride.max(1));
            if channel.stride == 0 || found < pixels {
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

    fn encode(&self, order: &[usize], out: &mut impl Write) -> io::Result<()> {
        let header = self.header(order);
        out.write_all(&header)?;
        let blocks: Vec<_> = (0..self.height as usize).step_by(BLOCK).collect();
        // Offsets come before the blocks but are known after them: one pass compresses, then all is
        // written. Compressed blocks are far smaller than the picture they come from.
        let mut data = Vec::new();
        let mut offsets = Vec::with_capacity(blocks.len());
        let first = header.len() + 8 * blocks.len();
        let mut scratch = Scratch::default();
        for y in blocks {
            offsets.push((first + data.len()) as u64);
            scratch.pack(self, order, y)?;
            let bytes = scratch.smallest();
            data.extend_from_slice(&(y as i32).to_le_bytes());
            data.extend_from_slice(&(bytes.len() as i32).to_le_bytes());
            data.extend_from_slice(bytes);
        }
        for offset in offsets {
            out.write_all(&offset.to_le_bytes())?;
        }
        out.write_all(&data)
    }

    fn header(&self, order: &[usize]) -> Vec<u8> {
        let channels = order.iter().map(|&c| self.channels[c].name.as_str());
        let mut list = Vec::new();
        for name in channels.clone() {
            list.extend_from_slice(name.as_bytes());
            list.push(0);
            // Type 2 is float; then pLinear, three spare bytes, sampling 1 along x and y.
            for word in [2_i32, 0, 1, 1] {
                list.extend_from_slice(&word.to_le_bytes());
            }
        }
        list.push(0);
        let corner = [0, 0, self.width as i32 - 1, self.height as i32 - 1];
        let window: Vec<u8> = corner.iter().flat_map(|v| v.to_le_bytes()).collect();
        let one = 1_f32.to_le_bytes();
        let mut all: Vec<(&str, &str, Vec<u8>)> = vec![
            ("channels", "chlist", list),
            ("compression", "compression", vec![3]),
            ("dataWindow", "box2i", window.clone()),
            ("displayWindow", "box2i", window),
            ("lineOrder", "lineOrder", vec![0]),
            ("pixelAspectRatio", "float", one.to_vec()),
            ("screenWindowCenter", "v2f", vec![0; 8]),
            ("screenWindowWidth", "float", one.to_vec()),
        ];
        for (name, value) in &self.attributes {
            if all.iter().any(|(n, ..)| n == name) {
                continue;
            }
            let (kind, bytes) = match value {
                Attribute::Text(text) => ("string", latin1(text)),
                Attribute::Integer(v) => ("int", v.to_le_bytes().to_vec()),
                Attribute::Number(v) => ("float", v.to_le_bytes().to_vec()),
            };
            all.push((name, kind, bytes));
        }
        let mut names = channels.chain(all.iter().map(|a| a.0));
        let long = names.any(|name| name.len() > NAME_BYTES[0]);
        let mut header = vec![0x76, 0x2f, 0x31, 0x01, 2, if long { 4 } else { 0 }, 0, 0];
        for (name, kind, bytes) in &all {
            for text in [name, kind] {
                header.extend_from_slice(text.as_bytes());
                header.push(0);
            }
            header.extend_from_slice(&(bytes.len() as i32).to_le_bytes());
            header.extend_from_slice(bytes);
        }
        header.push(0);
        header
    }
}

impl ChannelImage {
    /// The image, ready to be written.
    pub fn picture(&self) -> Picture<'_> {
        let channels = (self.channels.iter())
            .map(|c| PictureChannel { name: c.name.clone(), values: &c.samples, stride: 1 })
            .collect();
        let attributes = self.attributes.clone();
        Picture { width: self.width, height: self.height, channels, attributes }
    }
}

/// Text as the format keeps it.
fn latin1(text: &str) -> Vec<u8> {
    text.chars().map(|c| u8::try_from(c).unwrap_or(b'?')).collect()
}

/// Buffers of one block.
#[derive(Default)]
struct Scratch {
    raw: Vec<u8>,
    split: Vec<u8>,
    packed: Vec<u8>,
}

impl Scratch {
    /// Gathers and compresses the block that starts at line `y`.
    fn pack(&mut self, picture: &Picture<'_>, order: &[usize], y: usize) -> io::Result<()> {
        let (width, height) = (picture.width as usize, picture.height as usize);
        self.raw.clear();
        for line in y..height.min(y + BLOCK) {
            for channel in order.iter().map(|&c| &picture.channels[c]) {
                let values = channel.values[line * width * channel.stride..].iter();
                for value in values.step_by(channel.stride).take(width) {
                    self.raw.extend_from_slice(&value.to_le_bytes());
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

    /// What goes into the file.
    fn smallest(&self) -> &[u8] {
        if self.packed.len() < self.raw.len() { &self.packed } else { &self.raw }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Limits;

    fn sample(width: u32, height: u32) -> ChannelImage {
        let noise = |k: u32| (k.wrapping_mul(2_654_435_761) >> 8) as f32 / 65536.0 - 100.0;
        let channels = ["R", "G", "B", "P.X", "Z", "a name that is longer than thirty-one bytes"];
        let channels = (channels.iter().enumerate())
            .map(|(c, name)| {
                let mut samples: Vec<_> =
                    (0..width * height).map(|k| noise(k + c as u32)).collect();
                samples[0] = [f32::NAN, f32::INFINITY, -0.0, 1e-45, f32::MAX, 1.0][c];
                super::super::Channel { name: (*name).to_owned(), samples }
            })
            .collect();
        let attributes = vec![
            ("rilievo/seed".to_owned(), Attribute::Text("12345678901234567890".to_owned())),
            ("samplesPerPixel".to_owned(), Attribute::Integer(16)),
            ("renderTimeSeconds".to_owned(), Attribute::Number(1.5)),
            ("software".to_owned(), Attribute::Text("rilievo \u{e9}\u{4e2d}".to_owned())),
        ];
        ChannelImage { width, height, channels, attributes }
    }

    #[test]
    fn pictures_come_back_bit_for_bit() {
        let dir = tempfile::tempdir().unwrap();
        for (width, height) in [(1, 1), (3, 16), (17, 33), (64, 50)] {
            let (path, image) = (dir.path().join("a.exr"), sample(width, height));
            image.picture().write_exr(&path).unwrap();
            let back = ChannelImage::read(&path, &Limits::default()).unwrap();
            assert_eq!((back.width, back.height), (width, height));
            assert_eq!(back.channels.len(), image.channels.len());
            for channel in &image.channels {
                let bits = |v: &[f32]| v.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
                let other = back.channel(&channel.name).unwrap();
                assert_eq!(bits(&other.samples), bits(&channel.samples), "{}", channel.name);
            }
            assert_eq!(back.attribute("samplesPerPixel"), Some(&Attribute::Integer(16)));
            assert_eq!(back.attribute("renderTimeSeconds"), Some(&Attribute::Number(1.5)));
            assert_eq!(back.attribute("rilievo/seed"), image.attribute("rilievo/seed"));
            let software = Attribute::Text("rilievo \u{e9}?".to_owned());
            assert_eq!(back.attribute("software"), Some(&software));
            let first = std::fs::read(&path).unwrap();
            image.picture().write_exr(&path).unwrap();
            assert_eq!(std::fs::read(&path).unwrap(), first, "same picture, same bytes");
        }
    }

    #[test]
    fn pictures_that_no_file_can_hold_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let values = [0.0; 12];
        let put = |names: &[&str], size: [u32; 2]| {
            let mut picture = Picture { width: size[0], height: size[1], ..Picture::default() };
            picture.push_interleaved(names, &values);
            picture.write_exr(&path).map_err(|e| e.to_string())
        };
        assert!(put(&["R", "G", "B"], [2, 2]).is_ok());
        assert!(put(&["R", "G", "B"], [3, 2]).unwrap_err().contains("one for each pixel"));
        assert!(put(&["R", "R"], [2, 2]).unwrap_err().contains("R twice"));
        assert!(put(&[""], [2, 2]).unwrap_err().contains("255 bytes"));
        assert!(put(&["R"], [0, 2]).unwrap_err().contains("0 x 2"));
        assert!(put(&[], [2, 2]).unwrap_err().contains("at least one"));
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }
}
