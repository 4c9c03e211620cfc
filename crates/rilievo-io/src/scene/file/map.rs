//! `[maps.NAME]`.

use rilievo::map::{DistanceBits, Lattice, Layout, Procedural, Wrap};

use super::super::keys::map::{self as keys, Formula};
use super::super::syntax::{Located, Table, Value};
use crate::error::Result;
use crate::image::HeightOptions;

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
        let (file, formula) = (table.get(&keys::FILE), table.get(&keys::PROCEDURAL));
        let (source, lattice) = match (&file, &formula) {
            (Some(file), None) => {
                let (file, invert) = (keys::FILE.read(file)?, keys::INVERT.of(table)?);
                (MapSource::File { file, invert }, HeightOptions::default().lattice)
            }
            (None, Some(formula)) => (read_procedural(table, formula)?, Lattice::Vertex),
            (None, None) => {
                let found = "neither `file` nor `procedural`";
                return Err(table.invalid("map", found, "one of `file` and `procedural`"));
            }
            (Some(_), Some(both)) => {
                return Err(both.invalid("one of `file` and `procedural`, not both"));
            }
        };
        let entry = Self {
            source,
            lattice: keys::GRID.of(table)?.unwrap_or(lattice),
            wrap: keys::WRAP.of(table)?,
            layout: keys::LAYOUT.of(table)?,
            distance: match table.get(&keys::DISTANCE_TABLE) {
                Some(value) => read_distance(&value.table()?)?,
                None => DistanceSource::default(),
            },
            at: table.at(),
        };
        table.finish()?;
        Ok(entry)
    }
}

fn read_procedural(table: &Table<'_>, formula: &Value<'_>) -> Result<MapSource> {
    let shape = match keys::PROCEDURAL.read(formula)? {
        Formula::Flat => Procedural::Flat { value: keys::VALUE.of(table)? },
        Formula::Gaussian => Procedural::Gaussian,
        Formula::Studded => Procedural::Studded { studs: keys::STUDS.of(table)? },
        Formula::Fbm => {
            Procedural::Fbm { octaves: keys::OCTAVES.of(table)?, seed: keys::SEED.of(table)? }
        }
        Formula::Ramp => Procedural::Ramp,
        Formula::Step => Procedural::Step,
        Formula::Tent => Procedural::Tent,
        Formula::Ripple => Procedural::Ripple { waves: keys::WAVES.of(table)? },
    };
    let (size, codes) = (keys::SIZE.located(table)?, keys::BITS.of(table)?);
    Ok(MapSource::Procedural { shape, size, codes })
}

fn read_distance(table: &Table<'_>) -> Result<DistanceSource> {
    let (file, size) = (table.get(&keys::DISTANCE_FILE), table.get(&keys::DISTANCE_SIZE));
    let bits = table.get(&keys::DISTANCE_BITS);
    table.finish()?;
    if let (Some(_), Some(other)) = (&file, size.as_ref().or(bits.as_ref())) {
        return Err(other.invalid("nothing: a `file` has its own size and bits"));
    }
    let size = keys::DISTANCE_SIZE.located(table)?;
    Ok(DistanceSource {
        file: keys::DISTANCE_FILE.of(table)?,
        size: size.value.map(|value| Located { value, at: size.at }),
        bits: keys::DISTANCE_BITS.of(table)?,
    })
}
