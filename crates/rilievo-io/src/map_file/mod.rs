//! Baked maps on disk: normals, distances, min-max bounds.
//!
//! A file is a header of 128 bytes and a payload; all numbers are little endian.
//!
//! | at | type | what |
//! |---|---|---|
//! | 0 | 8 bytes | `89 52 4c 56 4f 0d 0a 1a`: a text transfer would change them |
//! | 8 | u32 | version: 2 for tiny min-max, else 1 |
//! | 12 | u32 | kind: 0 normals, 1 distances published, 2 boxes, 3 corrected, 4 min-max |
//! | 16 | u32 x 3 | size: texels and 1; voxels or nodes; stored cells along x, y and levels |
//! | 28 | u32 | bits of a code: 8 or 16 |
//! | 32 | u32 x 2 | samples of the height map along u and v |
//! | 40 | u32 | its lattice: 0 vertex, 1 texel |
//! | 44 | u32 | its wrap: 0 repeat, 1 clamp, 2 mirror |
//! | 48 | f64 x 3 | reference metric; 0 for min-max |
//! | 72 | f64 | quantum of distances; else 0 |
//! | 80 | f32 x 2 | lowest and highest raw height |
//! | 88 | u64 | hash of the height map |
//! | 96 | u64 | bytes of the payload |
//! | 104 | u64 | checksum of the payload |
//! | 112 | u64 | 0 |
//! | 120 | u64 | checksum of the 120 bytes before |
//!
//! | kind | payload |
//! |---|---|
//! | normals | red, green, blue as u16 a texel, row 0 at `v = 0`, green up (OpenGL) |
//! | distances | codes of u8 or u16, x fastest, then y, then z |
//! | min-max, 16 bits | level by level from the finest: maxima, then minima, 16 u16 a node, nodes row-major |
//! | min-max, 8 bits (tiny) | the same with u8; then level by level the ranges of the nodes, two u16 each |
//!
//! The checksum is FNV-1a over 64-bit words, the last one filled up with zeros, ended by the length:
//! each step is a bijection of the state, so no single changed word escapes. The size of a file must
//! be what its header says; nothing is allocated before that is known.
//!
//! What a checksum cannot tell is whether distances and bounds are *safe* for a height map.
//! [`Pyramid::from_levels`](rilievo::map::Pyramid::from_levels) and
//! [`DistanceMap::verify`](rilievo::map::DistanceMap::verify) decide that.

mod checksum;
mod header;
mod levels;

use std::fs::File;
use std::io::{BufReader, Cursor, Read, Write};
use std::path::Path;

use rilievo::map::{
    Codes, DistanceBits, DistanceMap, DistanceParts, HeightMap, Lattice, Level, Metric,
    NormalConvention, NormalMap, NormalMapError, NormalTexels, Samples, Wrap,
};

use crate::atomic;
use crate::error::{Error, Place, Result};
use crate::limits::Limits;
use checksum::Checksum;
use header::{Header, Kind};

/// Bytes converted at a time; a multiple of all item sizes.
const PIECE: usize = 1 << 16;

/// The height map a baked map was made from, as far as a file remembers it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MapSource {
    /// Samples along u and v.
    pub samples: [u32; 2],
    /// Where they sit.
    pub lattice: Lattice,
    /// What lies beyond the borders.
    pub wrap: Wrap,
    /// Lowest and highest raw height.
    pub raw_range: (f32, f32),
    /// Hash of all of it and of the samples.
    pub hash: u64,
}

impl MapSource {
    /// The source that `heights` is.
    pub fn of(heights: &HeightMap) -> Self {
        let samples = [heights.width(), heights.height()];
        let (lattice, wrap) = (heights.x().lattice(), heights.x().wrap());
        let mut sum = Checksum::default();
        let shape =
            [samples[0], samples[1], header::lattice_code(lattice), header::wrap_code(wrap)];
        sum.add(&shape.map(u32::to_le_bytes).concat());
        match heights.samples() {
            Samples::U16(v) => pieces(v, |v| v.to_le_bytes(), |bytes| sum.add(bytes)),
            Samples::F32(v) => pieces(v, |v| v.to_le_bytes(), |bytes| sum.add(bytes)),
        }
        Self { samples, lattice, wrap, raw_range: heights.raw_range(), hash: sum.finish() }
    }
}

/// A map made from a height map.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedMap {
    /// What it was made from.
    pub source: MapSource,
    /// What it holds.
    pub content: BakedContent,
}

/// What a [`BakedMap`] holds.
#[derive(Clone, Debug, PartialEq)]
pub enum BakedContent {
    /// Normals in a metric.
    Normals(BakedNormals),
    /// Distances of one of the three kinds.
    Distances(DistanceMap),
    /// Levels of a min-max pyramid, finest first.
    MinMax(Vec<Level>),
}

/// Normals as stored: one texel a sample of the height map, on its lattice.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedNormals {
    /// The metric they were made in.
    pub metric: Metric,
    /// Row-major, row 0 at `v = 0`, green up.
    pub texels: Vec<[u16; 3]>,
}

impl BakedNormals {
    /// The normal map.
    ///
    /// # Errors
    /// [`NormalMapError`] if the texels are not as many as the samples of `source`.
    pub fn normal_map(&self, source: &MapSource) -> std::result::Result<NormalMap, NormalMapError> {
        let texels = NormalTexels::U16(self.texels.clone());
        let lattice = (source.lattice, source.wrap);
        NormalMap::from_texels(source.samples, &texels, NormalConvention::OpenGl, lattice)
    }
}

impl BakedMap {
    /// Writes the map to `path`, whole or not at all.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] if content and source do not fit each other.
    pub fn write(&self, path: &Path) -> Result<()> {
        let fail = |e| Error::io(path, e);
        let mut header = self.header();
        if self.content_bytes() != header.payload_bytes().unwrap_or(u64::MAX) {
            let found = format!("{} bytes", self.content_bytes());
            let allowed = "as much as the source asks for";
            return Err(Error::invalid(path, Place::File, "baked map", found, allowed));
        }
        let mut sum = Checksum::default();
        self.payload(|bytes| sum.add(bytes));
        header.checksum = sum.finish();
        atomic::replace(path, |out| {
            let mut outcome = out.write_all(&header.encode());
            self.payload(|bytes| {
                if outcome.is_ok() {
                    outcome = out.write_all(bytes);
                }
            });
            outcome.map_err(fail)
        })
    }

    /// Reads a map from a file.
    ///
    /// # Errors
    /// Of the file, its size or any field of its header; a checksum that does not match.
    pub fn read(path: &Path, limits: &Limits) -> Result<Self> {
        let fail = |e| Error::io(path, e);
        let file = File::open(path).map_err(fail)?;
        let length = file.metadata().map_err(fail)?.len();
        decode(path, limits, length, &mut BufReader::with_capacity(PIECE, file))
    }

    /// Reads a map from bytes; `name` is what errors call them.
    ///
    /// # Errors
    /// As [`BakedMap::read`].
    pub fn read_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<Self> {
        decode(name, limits, bytes.len() as u64, &mut Cursor::new(bytes))
    }

    fn header(&self) -> Header {
        let source = self.source;
        let plain = Header {
            kind: Kind::Normals,
            size: [source.samples[0], source.samples[1], 1],
            bits: 16,
            source,
            metric: [0.0; 3],
            quantum: 0.0,
            checksum: 0,
        };
        match &self.content {
            BakedContent::Normals(normals) => {
                let Metric { x, y, z } = normals.metric;
                Header { metric: [x, y, z], ..plain }
            }
            BakedContent::Distances(map) => {
                let Metric { x, y, z } = map.metric();
                let bits = match map.codes() {
                    Codes::U8(_) => 8,
                    Codes::U16(_) => 16,
                };
                let (size, quantum) = (map.size(), map.quantum());
                let kind = Kind::Distances(map.kind());
                Header { kind, size, bits, metric: [x, y, z], quantum, ..plain }
            }
            BakedContent::MinMax(levels) => {
                let [x, y] = plain.cells();
                let bits = levels.first().map_or(16, |level| level.bounds.layout().bits());
                Header { kind: Kind::MinMax, size: [x, y, levels.len() as u32], bits, ..plain }
            }
        }
    }

    fn content_bytes(&self) -> u64 {
        match &self.content {
            BakedContent::Normals(normals) => normals.texels.len() as u64 * 6,
            BakedContent::Distances(map) => map.bytes(),
            BakedContent::MinMax(levels) => levels.iter().map(|level| level.bounds.bytes()).sum(),
        }
    }

    /// Hands over the payload piece by piece.
    fn payload(&self, take: impl FnMut(&[u8])) {
        match &self.content {
            BakedContent::Normals(normals) => {
                pieces(normals.texels.as_flattened(), |v| v.to_le_bytes(), take);
            }
            BakedContent::Distances(map) => match map.codes() {
                Codes::U8(codes) => codes.chunks(PIECE).for_each(take),
                Codes::U16(codes) => pieces(codes, |v| v.to_le_bytes(), take),
            },
            BakedContent::MinMax(levels) => levels::give(levels, take),
        }
    }
}

/// Whether a file that begins with `head` is a baked map, of whatever version.
pub(crate) fn is_map_file(head: &[u8]) -> bool {
    head.starts_with(&header::MAGIC)
}

/// Hands over the bytes of `values` in pieces of a multiple of eight bytes, but for the last.
fn pieces<T: Copy, const N: usize>(
    values: &[T],
    bytes_of: impl Fn(T) -> [u8; N],
    mut take: impl FnMut(&[u8]),
) {
    let mut bytes = Vec::with_capacity(PIECE);
    for chunk in values.chunks(PIECE / N) {
        bytes.clear();
        bytes.extend(chunk.iter().flat_map(|&v| bytes_of(v)));
        take(&bytes);
    }
}

/// Reads a file of `length` bytes.
fn decode(path: &Path, limits: &Limits, length: u64, input: &mut dyn Read) -> Result<BakedMap> {
    let fail = |e| Error::io(path, e);
    let mut head = [0; header::BYTES];
    if length < head.len() as u64 {
        let allowed = format!("at least {} bytes", head.len());
        return Err(Error::invalid(path, Place::File, "file size", length.to_string(), allowed));
    }
    input.read_exact(&mut head).map_err(fail)?;
    let header = Header::decode(path, &head)?;
    let invalid = |what: &str, found: String, allowed: String| {
        Err(Error::invalid(path, Place::Header, what, found, allowed))
    };
    let payload = header.payload_bytes().unwrap_or(u64::MAX);
    limits.check(path, Place::Header, "the baked map", &[payload])?;
    if length - header::BYTES as u64 != payload {
        let allowed = format!("{payload} bytes after the header");
        return invalid("file size", format!("{} bytes", length - header::BYTES as u64), allowed);
    }
    let mut payload = Payload { input, sum: Checksum::default() };
    let content = match header.kind {
        Kind::Normals => {
            let count = header.size[0] as usize * header.size[1] as usize;
            let codes = payload.codes(count * 3, u16::from_le_bytes).map_err(fail)?;
            let texels = codes.chunks_exact(3).map(|t| [t[0], t[1], t[2]]).collect();
            let [x, y, z] = header.metric;
            BakedContent::Normals(BakedNormals { metric: Metric { x, y, z }, texels })
        }
        Kind::Distances(kind) => {
            let count = header.size.iter().map(|&n| n as usize).product();
            let codes = match header.distance_bits() {
                DistanceBits::U8 => Codes::U8(payload.codes(count, |[code]| code).map_err(fail)?),
                DistanceBits::U16 => {
                    Codes::U16(payload.codes(count, u16::from_le_bytes).map_err(fail)?)
                }
            };
            let [x, y, z] = header.metric;
            let parts = DistanceParts {
                kind,
                size: header.size,
                cells: header.cells(),
                raw_range: header.source.raw_range,
                metric: Metric { x, y, z },
                quantum: header.quantum,
                codes,
            };
            match DistanceMap::from_parts(parts) {
                Ok(map) => BakedContent::Distances(map),
                Err(e) => return invalid("distance map", e.to_string(), String::new()),
            }
        }
        Kind::MinMax => {
            let levels =
                levels::take(&mut payload, header.layout(), header::level_nodes(header.cells()));
            BakedContent::MinMax(levels.map_err(fail)?)
        }
    };
    let found = payload.sum.finish();
    if found != header.checksum {
        return invalid(
            "payload checksum",
            format!("{found:016x}"),
            format!("{:016x}", header.checksum),
        );
    }
    Ok(BakedMap { source: header.source, content })
}

/// A payload that is being read.
struct Payload<'a> {
    input: &'a mut dyn Read,
    sum: Checksum,
}

impl Payload<'_> {
    fn codes<T, const N: usize>(
        &mut self,
        count: usize,
        value_of: impl Fn([u8; N]) -> T,
    ) -> std::io::Result<Vec<T>> {
        let mut values = Vec::with_capacity(count);
        let mut bytes = vec![0; PIECE.min(count * N)];
        while values.len() < count {
            let part = (count - values.len()).min(PIECE / N) * N;
            let bytes = &mut bytes[..part];
            self.input.read_exact(bytes)?;
            self.sum.add(bytes);
            values.extend(bytes.as_chunks::<N>().0.iter().map(|&b| value_of(b)));
        }
        Ok(values)
    }
}

#[cfg(test)]
mod tests;
