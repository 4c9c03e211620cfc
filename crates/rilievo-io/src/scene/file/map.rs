//! `[maps.NAME]`.

use rilievo::map::{DistanceBits, Lattice, Layout, Procedural, Wrap};

use super::super::syntax::{Located, Table, Value};
use super::texture::WRAPS;
use crate::error::Result;
use crate::image::HeightOptions;

/// Largest size of a procedural map along an axis.
const MAX_SIZE: u32 = 1 << 24;
/// Largest size of a distance map along an axis.
const MAX_DISTANCE_SIZE: u32 = 1 << 16;

/// What a map is made from.
#[derive(Clone, Debug)]
pub(in super::super) enum MapSource {
    /// An image file.
    File { file: Located<String>, invert: bool },
    /// A formula.
    Procedural { shape: Procedural, size: Located<[u32; 2]>, codes: bool },
}

/// Where the distance maps of a map come from, if a method asks for one.
#[derive(Clone, Debug, Default)]
pub(in super::super) struct DistanceSource {
    /// A baked file.
    pub file: Option<Located<String>>,
    /// Voxels or nodes along x, y and z.
    pub size: Option<Located<[u32; 3]>>,
    pub bits: Option<DistanceBits>,
}

/// What `[maps.NAME]` says.
#[derive(Clone, Debug)]
pub(in super::super) struct MapEntry {
    pub source: MapSource,
    pub lattice: Lattice,
    pub wrap: Wrap,
    /// How the bounds of its pyramid are stored.
    pub layout: Layout,
    pub distance: DistanceSource,
    pub at: std::ops::Range<usize>,
}

impl MapEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let (file, procedural) = (table.get("file"), table.get("procedural"));
        let (source, lattice) = match (&file, &procedural) {
            (Some(file), None) => {
                let invert = table.get("invert").map_or(Ok(false), |v| v.boolean())?;
                (MapSource::File { file: file.name()?, invert }, HeightOptions::default().lattice)
            }
            (None, Some(kind)) => (read_procedural(table, kind)?, Lattice::Vertex),
            (None, None) => {
                let found = "neither `file` nor `procedural`";
                return Err(table.invalid("map", found, "one of `file` and `procedural`"));
            }
            (Some(_), Some(both)) => {
                return Err(both.invalid("one of `file` and `procedural`, not both"));
            }
        };
        let mut entry = Self {
            source,
            lattice,
            wrap: Wrap::Repeat,
            layout: Layout::Default,
            distance: DistanceSource::default(),
            at: table.at(),
        };
        if let Some(value) = table.get("grid") {
            entry.lattice =
                value.choice(&[("vertex", Lattice::Vertex), ("texel", Lattice::Texel)])?;
        }
        if let Some(value) = table.get("wrap") {
            entry.wrap = value.choice(&WRAPS)?;
        }
        if let Some(value) = table.get("layout") {
            entry.layout = value.choice(&Layout::ALL.map(|l| (l.name(), l)))?;
        }
        if let Some(value) = table.get("distance") {
            entry.distance = read_distance(&value.table()?)?;
        }
        table.finish()?;
        Ok(entry)
    }
}

fn read_procedural(table: &Table<'_>, kind: &Value<'_>) -> Result<MapSource> {
    /// The formulas, before their parameters.
    #[derive(Clone, Copy)]
    enum Kind {
        Flat,
        Gaussian,
        Studded,
        Fbm,
        Ramp,
        Step,
        Tent,
        Ripple,
    }

    let kind = kind.choice(&[
        ("flat", Kind::Flat),
        ("gaussian", Kind::Gaussian),
        ("studded", Kind::Studded),
        ("fbm", Kind::Fbm),
        ("ramp", Kind::Ramp),
        ("step", Kind::Step),
        ("tent", Kind::Tent),
        ("ripple", Kind::Ripple),
    ])?;
    let shape = match kind {
        Kind::Flat => {
            let value = table.get("value");
            let value =
                value.map_or(Ok(0.0), |v| v.number_in(0.0..=1.0, "a number from 0 to 1"))?;
            Procedural::Flat { value }
        }
        Kind::Gaussian => Procedural::Gaussian,
        Kind::Studded => {
            let studs = table.get("studs").map_or(Ok([8, 8]), |v| v.integers(1..=MAX_SIZE))?;
            Procedural::Studded { studs }
        }
        Kind::Fbm => {
            let octaves = table.get("octaves").map_or(Ok(6), |v| v.integer(1..=16))?;
            let seed = table.get("seed").map_or(Ok(0), |v| v.integer(0..=i64::MAX as u64))?;
            Procedural::Fbm { octaves, seed }
        }
        Kind::Ramp => Procedural::Ramp,
        Kind::Step => Procedural::Step,
        Kind::Tent => Procedural::Tent,
        Kind::Ripple => {
            let waves = table.get("waves").map_or(Ok(4), |v| v.integer(1..=MAX_SIZE))?;
            Procedural::Ripple { waves }
        }
    };
    let size = match table.get("size") {
        Some(value) => value.located(|v| v.integers(2..=MAX_SIZE))?,
        None => Located { value: [256, 256], at: table.at() },
    };
    let codes = match table.get("bits") {
        Some(value) => match value.integer(0..=u32::MAX)? {
            16 => true,
            32 => false,
            _ => return Err(value.invalid("16 (codes) or 32 (floats)")),
        },
        None => true,
    };
    Ok(MapSource::Procedural { shape, size, codes })
}

fn read_distance(table: &Table<'_>) -> Result<DistanceSource> {
    let mut source = DistanceSource::default();
    let (file, size) = (table.get("file"), table.get("size"));
    let bits = table.get("bits");
    table.finish()?;
    if let (Some(_), Some(other)) = (&file, size.as_ref().or(bits.as_ref())) {
        return Err(other.invalid("nothing: a `file` has its own size and bits"));
    }
    source.file = file.map(|v| v.name()).transpose()?;
    source.size = size.map(|v| v.located(|v| v.integers(1..=MAX_DISTANCE_SIZE))).transpose()?;
    if let Some(value) = bits {
        source.bits = Some(match value.integer(0..=u32::MAX)? {
            8 => DistanceBits::U8,
            16 => DistanceBits::U16,
            _ => return Err(value.invalid("8 or 16")),
        });
    }
    Ok(source)
}
