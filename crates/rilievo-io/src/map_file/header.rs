//! The header of a baked map; its layout is at the head of the [module](super).

use std::path::Path;

use rilievo::map::{Axis, DistanceBits, DistanceKind, Lattice, Layout, Wrap};

use super::MapSource;
use super::checksum::Checksum;
use crate::error::{Error, Place, Result};

/// Bytes of a header.
pub(super) const BYTES: usize = 128;

pub(super) const MAGIC: [u8; 8] = [0x89, b'R', b'L', b'V', b'O', b'\r', b'\n', 0x1a];
/// The newest version read.
const VERSION: u32 = 2;

/// Largest number of samples along an axis of a height map.
const MAX_SAMPLES: u32 = 1 << 24;

/// What a file holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Normals,
    Distances(DistanceKind),
    MinMax,
}

impl Kind {
    const ALL: [Self; 5] = [
        Self::Normals,
        Self::Distances(DistanceKind::Published),
        Self::Distances(DistanceKind::Boxes),
        Self::Distances(DistanceKind::Corrected),
        Self::MinMax,
    ];
}

const LATTICES: [Lattice; 2] = [Lattice::Vertex, Lattice::Texel];
const WRAPS: [Wrap; 3] = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];

/// The place of `value` in `all`, as files number it.
fn code_of<T: PartialEq>(all: &[T], value: T) -> u32 {
    all.iter().position(|v| *v == value).unwrap_or(all.len()) as u32
}

pub(super) fn lattice_code(lattice: Lattice) -> u32 {
    code_of(&LATTICES, lattice)
}

pub(super) fn wrap_code(wrap: Wrap) -> u32 {
    code_of(&WRAPS, wrap)
}

/// The fields of a header.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Header {
    pub kind: Kind,
    pub size: [u32; 3],
    pub bits: u32,
    pub source: MapSource,
    pub metric: [f64; 3],
    pub quantum: f64,
    pub checksum: u64,
}

/// Nodes along x and y of each level of a pyramid over `cells`, finest first.
pub(super) fn level_nodes(cells: [u32; 2]) -> Vec<[u32; 2]> {
    let mut levels = Vec::new();
    let mut nodes = cells.map(|c| c.div_ceil(16));
    loop {
        levels.push(nodes);
        if nodes == [1, 1] {
            return levels;
        }
        nodes = nodes.map(|n| n.div_ceil(4));
    }
}

impl Header {
    /// Stored cells of the height map along x and y.
    pub fn cells(&self) -> [u32; 2] {
        let MapSource { samples, lattice, wrap, .. } = self.source;
        samples.map(|n| Axis::new(n, lattice, wrap).cells())
    }

    /// Width of a distance code.
    pub fn distance_bits(&self) -> DistanceBits {
        if self.bits == 8 { DistanceBits::U8 } else { DistanceBits::U16 }
    }

    /// Layout of bounds.
    pub fn layout(&self) -> Layout {
        if self.bits == 8 { Layout::Tiny } else { Layout::Default }
    }

    /// The oldest version that knows what the file holds: bounds of 8 bits came with 2.
    fn version(&self) -> u32 {
        if self.kind == Kind::MinMax && self.bits == 8 { 2 } else { 1 }
    }

    /// Bytes of the payload, by the other fields; `None` beyond 2^64.
    pub fn payload_bytes(&self) -> Option<u64> {
        let product =
            |numbers: &[u32]| numbers.iter().try_fold(1_u64, |p, &n| p.checked_mul(u64::from(n)));
        match self.kind {
            Kind::Normals => product(&[self.size[0], self.size[1], 6]),
            Kind::Distances(_) => {
                let [x, y, z] = self.size;
                product(&[x, y, z, self.bits / 8])
            }
            Kind::MinMax => {
                let node = self.layout().node_bytes() as u32;
                let bytes = |[x, y]: [u32; 2]| product(&[x, y, node]);
                level_nodes(self.cells())
                    .into_iter()
                    .try_fold(0_u64, |sum, nodes| sum.checked_add(bytes(nodes)?))
            }
        }
    }

    /// The bytes of the header.
    pub fn encode(&self) -> [u8; BYTES] {
        let MapSource { samples, lattice, wrap, raw_range, hash } = self.source;
        let mut bytes = Vec::with_capacity(BYTES);
        bytes.extend(MAGIC);
        let words = [self.version(), code_of(&Kind::ALL, self.kind)];
        let source = [samples[0], samples[1], lattice_code(lattice), wrap_code(wrap)];
        let all = words.iter().chain(&self.size).chain([&self.bits]).chain(&source);
        bytes.extend(all.flat_map(|v| v.to_le_bytes()));
        let reals = self.metric.iter().chain([&self.quantum]);
        bytes.extend(reals.flat_map(|v| v.to_le_bytes()));
        bytes.extend([raw_range.0, raw_range.1].iter().flat_map(|v| v.to_le_bytes()));
        let ends = [hash, self.payload_bytes().unwrap_or(u64::MAX), self.checksum, 0];
        bytes.extend(ends.iter().flat_map(|v| v.to_le_bytes()));
        let mut sum = Checksum::default();
        sum.add(&bytes);
        bytes.extend(sum.finish().to_le_bytes());
        let mut header = [0; BYTES];
        header.copy_from_slice(&bytes);
        header
    }

    /// Reads and checks every field.
    pub fn decode(path: &Path, bytes: &[u8; BYTES]) -> Result<Self> {
        let mut fields = Fields { path, bytes, at: 0 };
        if fields.take() != MAGIC {
            let found = format!("{:02x?}", &bytes[..8]);
            let allowed = format!("{MAGIC:02x?}");
            return Err(Error::unsupported(path, Place::File, "first bytes", found, allowed));
        }
        let version = fields.u32();
        if !(1..=VERSION).contains(&version) {
            return Err(fields.unsupported("version", version, "1 or 2"));
        }
        let mut sum = Checksum::default();
        sum.add(&bytes[..120]);
        let (found, stored) = (sum.finish(), fields.u64_at(120));
        if found != stored {
            let allowed = format!("{stored:016x}");
            return Err(fields.invalid("header checksum", format!("{found:016x}"), &allowed));
        }
        let kind = fields.u32();
        let Some(&kind) = Kind::ALL.get(kind as usize) else {
            return Err(fields.unsupported("kind", kind, "0 to 4"));
        };
        let size = [fields.u32(), fields.u32(), fields.u32()];
        let bits = fields.u32();
        let samples = [fields.u32(), fields.u32()];
        if !samples.iter().all(|n| (2..=MAX_SAMPLES).contains(n)) {
            let found = format!("{} x {}", samples[0], samples[1]);
            return Err(fields.invalid(
                "samples of the height map",
                found,
                "2 to 16777216 along an axis",
            ));
        }
        let (lattice, wrap) = (fields.u32(), fields.u32());
        let Some(&lattice) = LATTICES.get(lattice as usize) else {
            return Err(fields.unsupported("lattice", lattice, "0 or 1"));
        };
        let Some(&wrap) = WRAPS.get(wrap as usize) else {
            return Err(fields.unsupported("wrap", wrap, "0 to 2"));
        };
        let metric = [fields.f64(), fields.f64(), fields.f64()];
        let quantum = fields.f64();
        let raw_range = (fields.f32(), fields.f32());
        let source = MapSource { samples, lattice, wrap, raw_range, hash: fields.u64() };
        let payload = fields.u64();
        let header = Self { kind, size, bits, source, metric, quantum, checksum: fields.u64() };
        let spare = fields.u64();
        if spare != 0 {
            return Err(fields.invalid("spare field", spare.to_string(), "0"));
        }
        if header.version() > version {
            return Err(fields.invalid("version", version.to_string(), "2, for bounds of 8 bits"));
        }
        header.check(&fields, payload)?;
        Ok(header)
    }

    /// Checks the fields against each other.
    fn check(&self, fields: &Fields<'_>, payload: u64) -> Result<()> {
        let [x, y, z] = self.size;
        let cells = self.cells();
        let levels = level_nodes(cells).len() as u32;
        let fits = match self.kind {
            Kind::Normals => [x, y, z] == [self.source.samples[0], self.source.samples[1], 1],
            Kind::Distances(_) => true,
            Kind::MinMax => [x, y, z] == [cells[0], cells[1], levels],
        };
        if !fits {
            let allowed = "the size that the height map asks for";
            return Err(fields.invalid("size", format!("{x} x {y} x {z}"), allowed));
        }
        let bits: &[u32] = if self.kind == Kind::Normals { &[16] } else { &[8, 16] };
        if !bits.contains(&self.bits) {
            return Err(fields.invalid("bits", self.bits.to_string(), &format!("{bits:?}")));
        }
        let positive = |m: &f64| m.is_finite() && *m > 0.0;
        if self.kind != Kind::MinMax && !self.metric.iter().all(positive) {
            let found = format!("{:?}", self.metric);
            return Err(fields.invalid("metric", found, "three positive numbers"));
        }
        if self.payload_bytes() != Some(payload) {
            let allowed = "as many as the size asks for";
            return Err(fields.invalid("payload bytes", payload.to_string(), allowed));
        }
        Ok(())
    }
}

/// Takes fields off a header, front to back.
struct Fields<'a> {
    path: &'a Path,
    bytes: &'a [u8; BYTES],
    at: usize,
}

impl Fields<'_> {
    fn take<const N: usize>(&mut self) -> [u8; N] {
        let mut field = [0; N];
        field.copy_from_slice(&self.bytes[self.at..self.at + N]);
        self.at += N;
        field
    }

    fn u32(&mut self) -> u32 {
        u32::from_le_bytes(self.take())
    }

    fn u64(&mut self) -> u64 {
        u64::from_le_bytes(self.take())
    }

    fn f32(&mut self) -> f32 {
        f32::from_le_bytes(self.take())
    }

    fn f64(&mut self) -> f64 {
        f64::from_le_bytes(self.take())
    }

    fn u64_at(&self, at: usize) -> u64 {
        Fields { at, ..*self }.u64()
    }

    fn invalid(&self, what: &str, found: String, allowed: &str) -> Error {
        Error::invalid(self.path, Place::Header, what, found, allowed)
    }

    fn unsupported(&self, what: &str, found: u32, allowed: &str) -> Error {
        Error::unsupported(self.path, Place::Header, what, found.to_string(), allowed)
    }
}
