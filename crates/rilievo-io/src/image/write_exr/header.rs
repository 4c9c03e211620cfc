//! The attributes at the head of an EXR file.

use super::{Blocks, Crop, NAME_BYTES, Picture, Stored};
use crate::image::Attribute;

impl Picture<'_> {
    /// Magic, version and attributes.
    pub(super) fn header(&self, order: &[usize]) -> Vec<u8> {
        let channels = order.iter().map(|&c| self.channels[c].name.as_str());
        let mut list = Vec::new();
        for channel in order.iter().map(|&c| &self.channels[c]) {
            list.extend_from_slice(channel.name.as_bytes());
            list.push(0);
            let kind = match channel.stored {
                Stored::Half => 1,
                Stored::Float => 2,
            };
            // The type; then pLinear, three spare bytes, sampling 1 along x and y.
            for word in [kind, 0, 1, 1] {
                list.extend_from_slice(&i32::to_le_bytes(word));
            }
        }
        list.push(0);
        let Crop { corner, full } = self.frame();
        let last = |from: u32, size: u32| from + size - 1;
        let window =
            [corner[0], corner[1], last(corner[0], self.width), last(corner[1], self.height)];
        let display = [0, 0, full[0] - 1, full[1] - 1];
        let one = 1_f32.to_le_bytes();
        // Compression 3 is ZIP over 16 lines; of tiles, over a tile. Line order 0: from the top.
        let mut all: Vec<(&str, &str, Vec<u8>)> = vec![
            ("channels", "chlist", list),
            ("compression", "compression", vec![3]),
            ("dataWindow", "box2i", words(window)),
            ("displayWindow", "box2i", words(display)),
            ("lineOrder", "lineOrder", vec![0]),
            ("pixelAspectRatio", "float", one.to_vec()),
            ("screenWindowCenter", "v2f", vec![0; 8]),
            ("screenWindowWidth", "float", one.to_vec()),
        ];
        if let Blocks::Tiles(side) = self.blocks {
            // One level.
            let mut tiles = words([side, side]);
            tiles.push(0);
            all.push(("tiles", "tiledesc", tiles));
        }
        for (name, value) in &self.attributes {
            if all.iter().any(|(n, ..)| n == name) {
                continue;
            }
            let (kind, bytes) = match value {
                Attribute::Text(text) => ("string", latin1(text)),
                Attribute::Integer(v) => ("int", v.to_le_bytes().to_vec()),
                Attribute::Number(v) => ("float", v.to_le_bytes().to_vec()),
                Attribute::Matrix(rows) => {
                    ("m44f", rows.as_flattened().iter().flat_map(|v| v.to_le_bytes()).collect())
                }
            };
            all.push((name, kind, bytes));
        }
        let mut names = channels.chain(all.iter().map(|a| a.0));
        let long = names.any(|name| name.len() > NAME_BYTES[0]);
        let flags = if long { 4 } else { 0 } | if self.blocks == Blocks::Lines { 0 } else { 2 };
        let mut header = vec![0x76, 0x2f, 0x31, 0x01, 2, flags, 0, 0];
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

fn words<const N: usize>(numbers: [u32; N]) -> Vec<u8> {
    numbers.iter().flat_map(|n| n.to_le_bytes()).collect()
}

/// Text as the format keeps it.
fn latin1(text: &str) -> Vec<u8> {
    text.chars().map(|c| u8::try_from(c).unwrap_or(b'?')).collect()
}
