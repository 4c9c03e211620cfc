//! OpenEXR reading, through the `exr` crate: flat scan lines and tiles, all its compressions.
//!
//! A height map or a texture takes, of the first layer that has them, the channels `Y`, or
//! `R G B`, or `Z`, or `R`, or the only channel there is. Pixels are those of the data window;
//! the display window plays no part. Half and unsigned samples become f32, the latter rounded to
//! the nearest.
//!
//! Blocks are decoded one at a time and only wanted channels are kept. The crate does not check
//! that every block came, so this module counts.

use exr::block::chunk::Chunk;
use exr::block::reader::ChunksReader;
use exr::block::{self, UncompressedBlock};
use exr::io::Data;
use exr::meta::attribute::{AttributeValue, SampleType};
use exr::meta::header::Header;
use exr::prelude::{Vec2, f16};

use super::ImageFormat;
use super::channels::{Attribute, Channel, ChannelImage};
use super::source::{Context, Flow, ImageInfo, Input, SampleKind, Sink, Source};
use crate::error::{Place, Result};

/// Decodes the channels of a height map or a texture.
pub(super) fn decode(
    context: Context<'_>,
    input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let file = File::open(context, input)?;
    let chosen = (0..file.headers().len()).find_map(|layer| {
        let names = file.names(layer);
        choose(&names).map(|channels| (layer, channels))
    });
    let Some((layer, channels)) = chosen else {
        let found: Vec<_> = (0..file.headers().len()).flat_map(|l| file.names(l)).collect();
        return Err(context.unsupported("channels", found.join(", "), "Y, R G B, Z or R"));
    };
    let header = &file.headers()[layer];
    let bits = |&c: &usize| header.channels.list[c].sample_type.bytes_per_sample() * 8;
    let info = ImageInfo {
        format: ImageFormat::Exr,
        width: side(header.layer_size.0),
        height: side(header.layer_size.1),
        channels: channels.len() as u32,
        sample: SampleKind::F32,
        file_bits: channels.iter().map(bits).max().unwrap_or(0) as u32,
        void: None,
    };
    context.check(&info)?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    let samples = file.samples(layer, &channels)?;
    sink.grid(&info, samples);
    Ok(())
}

/// Reads all channels of all layers that are as large as the first.
pub(super) fn channels(context: Context<'_>, input: Box<dyn Input + '_>) -> Result<ChannelImage> {
    let file = File::open(context, input)?;
    let header = &file.headers()[0];
    let (width, height) = (side(header.layer_size.0), side(header.layer_size.1));
    let mut names = file.names(0);
    if let Some(layer) = &header.own_attributes.layer_name {
        for name in names.iter_mut().filter(|_| file.headers().len() > 1) {
            *name = format!("{layer}.{name}");
        }
    }
    let attributes = attributes(header);
    if names.is_empty() {
        return Err(context.unsupported("channels", "none", "at least one"));
    }
    let wanted: Vec<_> = (0..names.len()).collect();
    let info = ImageInfo {
        format: ImageFormat::Exr,
        width,
        height,
        channels: wanted.len() as u32 * 2,
        sample: SampleKind::F32,
        file_bits: 32,
        void: None,
    };
    context.check(&info)?;
    let count = wanted.len();
    let samples = file.samples(0, &wanted)?;
    let channels = (names.into_iter().enumerate())
        .map(|(c, name)| Channel {
            name,
            samples: samples.iter().skip(c).step_by(count).copied().collect(),
        })
        .collect();
    Ok(ChannelImage { width, height, channels, attributes })
}

/// The channels of a height map or a texture among `names`.
fn choose(names: &[String]) -> Option<Vec<usize>> {
    let find = |name: &str| names.iter().position(|n| n == name);
    let all = |wanted: &[&str]| wanted.iter().map(|n| find(n)).collect::<Option<Vec<_>>>();
    [&["Y"][..], &["R", "G", "B"], &["Z"], &["R"]]
        .iter()
        .find_map(|wanted| all(wanted))
        .or_else(|| (names.len() == 1).then(|| vec![0]))
}

/// A length of the data window; the format's own are below 2^31.
fn side(length: usize) -> u32 {
    u32::try_from(length).unwrap_or(u32::MAX)
}

/// The text and number attributes of a layer, by name.
fn attributes(header: &Header) -> Vec<(String, Attribute)> {
    let own = &header.own_attributes;
    let named = [("software", &own.software_name), ("comments", &own.comments)];
    let mut all: Vec<_> = named
        .into_iter()
        .filter_map(|(name, text)| {
            Some((name.to_owned(), Attribute::Text(text.as_ref()?.to_string())))
        })
        .collect();
    let transforms =
        [("worldToCamera", own.world_to_camera), ("worldToNDC", own.world_to_normalized_device)];
    for (name, values) in transforms {
        all.extend(values.map(|values| (name.to_owned(), matrix(&values))));
    }
    for (name, value) in own.other.iter().chain(&header.shared_attributes.other) {
        let value = match value {
            AttributeValue::Text(text) => Attribute::Text(text.to_string()),
            AttributeValue::I32(value) => Attribute::Integer(*value),
            AttributeValue::F32(value) => Attribute::Number(*value),
            AttributeValue::Matrix4x4(values) => matrix(values),
            _ => continue,
        };
        all.push((name.to_string(), value));
    }
    all.sort_by(|a, b| a.0.cmp(&b.0));
    all
}

/// A matrix from its numbers, row by row.
fn matrix(values: &[f32; 16]) -> Attribute {
    Attribute::Matrix([0, 1, 2, 3].map(|row| [0, 1, 2, 3].map(|k| values[4 * row + k])))
}

/// An EXR file whose header has been read.
struct File<'a> {
    context: Context<'a>,
    reader: block::reader::Reader<Box<dyn Input + 'a>>,
}

impl<'a> File<'a> {
    fn open(context: Context<'a>, input: Box<dyn Input + 'a>) -> Result<Self> {
        let reader = block::read(input, false).map_err(|e| context.damaged(e))?;
        if reader.headers().is_empty() {
            return Err(context.damaged("no layer"));
        }
        Ok(Self { context, reader })
    }

    fn headers(&self) -> &[Header] {
        self.reader.headers()
    }

    fn names(&self, layer: usize) -> Vec<String> {
        self.headers()[layer].channels.list.iter().map(|c| c.name.to_string()).collect()
    }

    /// The samples of some channels of a layer, interleaved, top row first.
    fn samples(self, layer: usize, channels: &[usize]) -> Result<Vec<f32>> {
        let size = self.headers()[layer].layer_size;
        let stride = channels.len();
        let mut samples = vec![0.0; size.0 * size.1 * stride];
        self.lines(layer, channels, &mut |line| {
            let start = (line.y * size.0 + line.x) * stride + line.channel;
            for (to, from) in samples[start..].iter_mut().step_by(stride).zip(line.samples) {
                *to = *from;
            }
            Ok(())
        })?;
        Ok(samples)
    }

    /// Hands on the lines of some channels of a layer, each once, block by block. A line's channel is
    /// its place among `channels`.
    fn lines(
        self,
        layer: usize,
        channels: &[usize],
        put: &mut dyn FnMut(Line<'_>) -> Result<()>,
    ) -> Result<()> {
        let Self { context, reader } = self;
        let damaged = |e: exr::error::Error| context.damaged(e);
        let header = reader.headers()[layer].clone();
        if header.deep {
            return Err(context.unsupported("layer", "deep samples", "flat samples"));
        }
        if header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1)) {
            return Err(context.unsupported("channels", "subsampled", "one sample a pixel"));
        }
        let block = u64::try_from(header.max_block_byte_size()).unwrap_or(u64::MAX);
        context.limits.check(context.path, Place::Header, "decoding a block", &[block])?;
        let Vec2(width, height) = header.layer_size;
        // Samples that came, by row.
        let mut seen = vec![0; height];
        let mut samples = Vec::new();
        let mut chunks = reader.all_chunks(false).map_err(damaged)?;
        while let Some(chunk) = chunks.read_next_chunk() {
            let chunk: Chunk = chunk.map_err(damaged)?;
            if chunk.layer_index != layer {
                continue;
            }
            let block = UncompressedBlock::decompress_chunk(chunk, chunks.meta_data(), false)
                .map_err(damaged)?;
            if block.index.level != Vec2(0, 0) {
                continue;
            }
            for line in block.lines(&header.channels) {
                let Some(slot) = channels.iter().position(|&c| c == line.location.channel) else {
                    continue;
                };
                let kind = header.channels.list[line.location.channel].sample_type;
                let Vec2(x, y) = line.location.position;
                decode_line(kind, line.value, &mut samples).map_err(damaged)?;
                let end = x.checked_add(samples.len());
                if y >= height || end.is_none_or(|end| end > width) {
                    return Err(context.damaged("a block outside the data window"));
                }
                seen[y] += samples.len();
                put(Line { channel: slot, x, y, samples: &samples })?;
            }
        }
        if seen.iter().any(|&seen| seen != width * channels.len()) {
            return Err(context.damaged("blocks are missing or stored twice"));
        }
        Ok(())
    }
}

/// A piece of a row of one channel.
pub(crate) struct Line<'a> {
    /// Which channel.
    pub channel: usize,
    /// The column of its first sample.
    pub x: usize,
    /// Its row.
    pub y: usize,
    /// Its samples.
    pub samples: &'a [f32],
}

fn decode_line(kind: SampleType, mut bytes: &[u8], to: &mut Vec<f32>) -> exr::error::Result<()> {
    to.clear();
    for _ in 0..bytes.len() / kind.bytes_per_sample() {
        to.push(match kind {
            SampleType::F16 => f16::read_ne(&mut bytes)?.to_f32(),
            SampleType::F32 => f32::read_ne(&mut bytes)?,
            SampleType::U32 => u32::read_ne(&mut bytes)? as f32,
        });
    }
    Ok(())
}

/// An EXR file whose header has been read, and whose lines are taken one by one: nothing holds all of
/// it.
pub(crate) struct ExrLines<'a> {
    file: File<'a>,
    /// Pixels a row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// The channels of the first layer.
    pub names: Vec<String>,
    /// Its attributes.
    pub attributes: Vec<(String, Attribute)>,
}

impl<'a> ExrLines<'a> {
    /// Reads the header. To be called, and read, under [`crate::guard::guarded`].
    pub fn open(source: Source<'a>) -> Result<Self> {
        let file = File::open(source.context, source.input)?;
        let header = &file.headers()[0];
        let [width, height] = [header.layer_size.0, header.layer_size.1].map(side);
        let (names, attributes) = (file.names(0), attributes(header));
        Ok(Self { file, width, height, names, attributes })
    }

    /// Hands on every line of every channel, by its place among `names`.
    pub fn each(self, put: &mut dyn FnMut(Line<'_>) -> Result<()>) -> Result<()> {
        let all: Vec<_> = (0..self.names.len()).collect();
        self.file.lines(0, &all, put)
    }
}
