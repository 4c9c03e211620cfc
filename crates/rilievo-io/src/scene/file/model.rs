//! `model = "..."` of a material and the keys that go with it.

use rilievo::glam::DVec3;
use rilievo_render::bsdf::GlassTable;

use super::super::syntax::{Located, Table};
use super::texture::{ColourEntry, NumberEntry, TextureEntry};
use super::view::colour;
use crate::error::Result;
use crate::texture_set::MapRole;

/// Metals by name: `eta` and `k` of their index for red, green and blue light.
const METALS: [(&str, [[f64; 3]; 2]); 6] = [
    ("aluminium", [[1.3456, 0.9649, 0.6172], [7.4746, 6.3995, 5.3031]]),
    ("chromium", [[4.3696, 2.9167, 1.6547], [5.2064, 4.2313, 3.7549]]),
    ("copper", [[0.2004, 0.9240, 1.1022], [3.9129, 2.4528, 2.1421]]),
    ("gold", [[0.1431, 0.3749, 1.4424], [3.9831, 2.3857, 1.6032]]),
    ("iron", [[2.9114, 2.9497, 2.5845], [3.0893, 2.9318, 2.7670]]),
    ("silver", [[0.1552, 0.1166, 0.1382], [4.8284, 3.1222, 2.1470]]),
];

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

/// Colours of a principled surface, with what they are where nothing is said.
const COLOURS: [(&str, (f64, MapRole)); 3] = [
    ("base_colour", (0.5, MapRole::Albedo)),
    ("specular_colour", (1.0, MapRole::Specular)),
    ("sheen", (0.0, MapRole::Albedo)),
];

/// Numbers of a principled surface.
const NUMBERS: [(&str, (f64, MapRole)); 9] = [
    ("metallic", (0.0, MapRole::Metalness)),
    ("roughness", (0.5, MapRole::Roughness)),
    ("diffuse_roughness", (0.0, MapRole::Roughness)),
    ("specular", (1.0, MapRole::Specular)),
    ("transmission", (0.0, MapRole::Opacity)),
    ("opacity", (1.0, MapRole::Opacity)),
    ("coat", (0.0, MapRole::Specular)),
    ("coat_roughness", (0.0, MapRole::Roughness)),
    ("sheen_roughness", (0.5, MapRole::Roughness)),
];

/// Places of [`COLOURS`] and [`NUMBERS`].
pub(in super::super) const BASE_COLOUR: usize = 0;
pub(in super::super) const METALLIC: usize = 0;
pub(in super::super) const ROUGHNESS: usize = 1;
pub(in super::super) const OPACITY: usize = 5;

impl Default for PrincipledEntry {
    fn default() -> Self {
        Self {
            colours: COLOURS.map(|(_, (value, _))| ColourEntry::uniform(DVec3::splat(value))),
            numbers: NUMBERS.map(|(_, (value, _))| NumberEntry::uniform(value)),
            ior: 1.5,
            thin: false,
            set: None,
        }
    }
}

impl PrincipledEntry {
    fn read(table: &Table<'_>) -> Result<Self> {
        let mut entry = Self::default();
        for (slot, (key, default)) in entry.colours.iter_mut().zip(COLOURS) {
            *slot = ColourEntry::of(table, key, default)?;
        }
        for (slot, (key, default)) in entry.numbers.iter_mut().zip(NUMBERS) {
            *slot = NumberEntry::of(table, key, default)?;
        }
        entry.ior = ior(table)?;
        entry.thin = flag(table, "thin", false)?;
        if let Some(value) = table.get("set") {
            let set = TextureEntry::read(&value, MapRole::Albedo)?;
            if !set.file.value.ends_with('/') {
                return Err(value.invalid("the folder of a texture set, with a slash at its end"));
            }
            entry.set = Some(set);
        }
        Ok(entry)
    }
}

/// A model by name.
#[derive(Clone, Copy)]
enum Kind {
    Paper,
    Diffuse,
    Conductor,
    Glass,
    ThinGlass,
    Principled,
    Mix,
}

impl ModelEntry {
    /// The model of a material, by its keys `model` and those that go with it.
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let kinds = [
            ("paper", Kind::Paper),
            ("diffuse", Kind::Diffuse),
            ("conductor", Kind::Conductor),
            ("glass", Kind::Glass),
            ("thin-glass", Kind::ThinGlass),
            ("principled", Kind::Principled),
            ("mix", Kind::Mix),
        ];
        let kind = table.get("model").map_or(Ok(Kind::Paper), |value| value.choice(&kinds))?;
        let tint = |default| ColourEntry::of(table, "colour", (default, MapRole::Albedo));
        let rough = |default| NumberEntry::of(table, "roughness", (default, MapRole::Roughness));
        Ok(match kind {
            Kind::Paper => Self::Paper,
            Kind::Diffuse => Self::Diffuse { colour: tint(0.5)?, roughness: rough(0.0)? },
            Kind::Conductor => Self::Conductor {
                metal: MetalEntry::read(table)?,
                roughness: rough(0.3)?,
                compensate: flag(table, "compensate", true)?,
            },
            Kind::Glass => Self::Glass {
                ior: ior(table)?,
                colour: tint(1.0)?,
                roughness: rough(0.0)?,
                compensate: flag(table, "compensate", true)?,
            },
            Kind::ThinGlass => {
                Self::ThinGlass { ior: ior(table)?, colour: tint(1.0)?, roughness: rough(0.0)? }
            }
            Kind::Principled => Self::Principled(Box::new(PrincipledEntry::read(table)?)),
            Kind::Mix => {
                let words = "two names of materials";
                let [a, b] = table.require("materials")?.array(words)?;
                let share = NumberEntry::of(table, "share", (0.5, MapRole::Opacity))?;
                Self::Mix { materials: [a.name()?, b.name()?], share }
            }
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
        let [metal, eta, tint] = ["metal", "eta", "colour"].map(|key| table.get(key));
        for (one, other) in [(&metal, &eta), (&metal, &tint), (&eta, &tint)] {
            if let (Some(_), Some(value)) = (one, other) {
                return Err(value.invalid("one of `metal`, `eta` and `colour`"));
            }
        }
        if let Some(metal) = metal {
            let [eta, k] = metal.choice(&METALS)?.map(DVec3::from_array);
            return Ok(Self::Index { eta, k });
        }
        if let Some(eta) = eta {
            return Ok(Self::Index { eta: colour(&eta)?, k: colour(&table.require("k")?)? });
        }
        Ok(Self::Colours {
            facing: ColourEntry::of(table, "colour", (0.9, MapRole::Albedo))?,
            edge: ColourEntry::of(table, "edge", (1.0, MapRole::Specular))?,
        })
    }
}

fn ior(table: &Table<'_>) -> Result<f64> {
    match table.get("ior") {
        Some(value) => value.number_in(GlassTable::IORS, "a number from 0.1 to 10"),
        None => Ok(1.5),
    }
}

fn flag(table: &Table<'_>, key: &'static str, default: bool) -> Result<bool> {
    table.get(key).map_or(Ok(default), |value| value.boolean())
}
