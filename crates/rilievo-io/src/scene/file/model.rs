//! `model = "..."` of a material and the keys that go with it.

use rilievo::glam::DVec3;

use super::super::keys::material::{MODEL, Model};
use super::super::keys::model::{self as keys, InputKey};
use super::super::syntax::{Located, Table};
use super::texture::{ColourEntry, NumberEntry, TextureEntry};
use crate::error::Result;
use crate::texture_set::MapRole;

/// How light is scattered, and by what inputs.
#[derive(Clone, Debug)]
pub(in super::super) enum ModelEntry {
    /// The keys of the material itself.
    Paper,
    Diffuse {
        colour: ColourEntry,
        roughness: NumberEntry,
    },
    Conductor {
        metal: MetalEntry,
        roughness: NumberEntry,
        compensate: bool,
    },
    Glass {
        ior: f64,
        colour: ColourEntry,
        roughness: NumberEntry,
        compensate: bool,
    },
    ThinGlass {
        ior: f64,
        colour: ColourEntry,
        roughness: NumberEntry,
    },
    Principled(Box<PrincipledEntry>),
    Mix {
        materials: [Located<String>; 2],
        share: NumberEntry,
    },
}

/// What a metal reflects.
#[derive(Clone, Debug)]
pub(in super::super) enum MetalEntry {
    Colours { facing: ColourEntry, edge: ColourEntry },
    Index { eta: DVec3, k: DVec3 },
}

/// The inputs of a principled surface, in the order of [`COLOURS`] and [`NUMBERS`].
#[derive(Clone, Debug)]
pub(in super::super) struct PrincipledEntry {
    pub colours: [ColourEntry; 3],
    pub numbers: [NumberEntry; 9],
    pub ior: f64,
    pub thin: bool,
    /// A texture set that fills in what the scene does not say.
    pub set: Option<TextureEntry>,
}

/// Colours of a principled surface.
const COLOURS: [InputKey; 3] = [keys::BASE_COLOUR, keys::SPECULAR_COLOUR, keys::SHEEN];

/// Numbers of a principled surface.
const NUMBERS: [InputKey; 9] = [
    keys::METALLIC,
    keys::ROUGHNESS,
    keys::BASE_ROUGHNESS,
    keys::SPECULAR,
    keys::TRANSMISSION,
    keys::OPACITY,
    keys::COAT,
    keys::COAT_ROUGHNESS,
    keys::SHEEN_ROUGHNESS,
];

/// Places of [`COLOURS`] and [`NUMBERS`].
pub(in super::super) const BASE_COLOUR: usize = 0;
pub(in super::super) const METALLIC: usize = 0;
pub(in super::super) const ROUGHNESS: usize = 1;
pub(in super::super) const OPACITY: usize = 5;

impl Default for PrincipledEntry {
    fn default() -> Self {
        Self {
            colours: COLOURS.map(|key| ColourEntry::uniform(DVec3::splat(key.missing.0))),
            numbers: NUMBERS.map(|key| NumberEntry::uniform(key.missing.0)),
            ior: keys::IOR.missing.0,
            thin: keys::THIN.missing.0,
            set: None,
        }
    }
}

impl PrincipledEntry {
    fn read(table: &Table<'_>) -> Result<Self> {
        let mut entry = Self::default();
        for (slot, key) in entry.colours.iter_mut().zip(&COLOURS) {
            *slot = ColourEntry::of(table, key)?;
        }
        for (slot, key) in entry.numbers.iter_mut().zip(&NUMBERS) {
            *slot = NumberEntry::of(table, key)?;
        }
        entry.ior = keys::IOR.of(table)?;
        entry.thin = keys::THIN.of(table)?;
        if let Some(value) = table.get(&keys::SET) {
            let set = TextureEntry::read(&value, MapRole::Albedo)?;
            if !set.file.value.ends_with('/') {
                return Err(value.invalid("the folder of a texture set, with a slash at its end"));
            }
            entry.set = Some(set);
        }
        Ok(entry)
    }
}

impl ModelEntry {
    /// The model of a material, by its keys `model` and those that go with it.
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let tint = |key| ColourEntry::of(table, key);
        let rough = |key| NumberEntry::of(table, key);
        Ok(match MODEL.of(table)? {
            Model::Paper => Self::Paper,
            Model::Diffuse => Self::Diffuse {
                colour: tint(&keys::DIFFUSE_COLOUR)?,
                roughness: rough(&keys::DIFFUSE_ROUGHNESS)?,
            },
            Model::Conductor => Self::Conductor {
                metal: MetalEntry::read(table)?,
                roughness: rough(&keys::METAL_ROUGHNESS)?,
                compensate: keys::COMPENSATE.of(table)?,
            },
            Model::Glass => Self::Glass {
                ior: keys::IOR.of(table)?,
                colour: tint(&keys::GLASS_COLOUR)?,
                roughness: rough(&keys::GLASS_ROUGHNESS)?,
                compensate: keys::COMPENSATE.of(table)?,
            },
            Model::ThinGlass => Self::ThinGlass {
                ior: keys::IOR.of(table)?,
                colour: tint(&keys::GLASS_COLOUR)?,
                roughness: rough(&keys::GLASS_ROUGHNESS)?,
            },
            Model::Principled => Self::Principled(Box::new(PrincipledEntry::read(table)?)),
            Model::Mix => Self::Mix {
                materials: keys::MIXED.of(table)?,
                share: NumberEntry::of(table, &keys::SHARE)?,
            },
        })
    }

    /// Every image.
    pub fn textures_mut(&mut self) -> Vec<&mut TextureEntry> {
        let (colours, numbers): (Vec<&mut ColourEntry>, Vec<&mut NumberEntry>) = match self {
            Self::Paper => return Vec::new(),
            Self::Diffuse { colour, roughness }
            | Self::Glass { colour, roughness, .. }
            | Self::ThinGlass { colour, roughness, .. } => (vec![colour], vec![roughness]),
            Self::Conductor { metal: MetalEntry::Colours { facing, edge }, roughness, .. } => {
                (vec![facing, edge], vec![roughness])
            }
            Self::Conductor { roughness, .. } => (Vec::new(), vec![roughness]),
            Self::Principled(p) => (p.colours.iter_mut().collect(), p.numbers.iter_mut().collect()),
            Self::Mix { share, .. } => (Vec::new(), vec![share]),
        };
        let colours = colours.into_iter().filter_map(|input| input.texture.as_mut());
        let numbers = numbers.into_iter().filter_map(|input| Some(&mut input.texture.as_mut()?.0));
        colours.chain(numbers).collect()
    }
}

impl MetalEntry {
    fn read(table: &Table<'_>) -> Result<Self> {
        let written =
            [table.get(&keys::METAL), table.get(&keys::ETA), table.get(&keys::METAL_COLOUR)];
        if let Some(value) = written.iter().flatten().nth(1) {
            return Err(value.invalid("one of `metal`, `eta` and `colour`"));
        }
        if let Some(index) = keys::METAL.of(table)? {
            let [eta, k] = index.map(DVec3::from_array);
            return Ok(Self::Index { eta, k });
        }
        if let Some(eta) = keys::ETA.of(table)? {
            return Ok(Self::Index { eta, k: keys::K.of(table)? });
        }
        Ok(Self::Colours {
            facing: ColourEntry::of(table, &keys::METAL_COLOUR)?,
            edge: ColourEntry::of(table, &keys::EDGE)?,
        })
    }
}
