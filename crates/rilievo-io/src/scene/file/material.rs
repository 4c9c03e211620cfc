//! `[materials.NAME]`.

use rilievo::glam::{DVec2, DVec3};

use super::super::syntax::{Located, Table, Value};
use super::view::colour;
use crate::error::Result;

/// Two numbers, in words.
pub(super) const PAIR: &str = "two numbers: [along u, along v]";

/// A colour image laid over uv.
#[derive(Clone, Debug)]
pub(in super::super) struct TextureEntry {
    pub file: Located<String>,
    pub tile: DVec2,
    pub shift: DVec2,
}

/// A diffuse reflectance.
#[derive(Clone, Debug)]
pub(in super::super) enum Diffuse {
    Uniform(DVec3),
    Texture(TextureEntry),
}

/// What `[materials.NAME]` says.
#[derive(Clone, Debug)]
pub(in super::super) struct MaterialEntry {
    pub diffuse: Diffuse,
    pub reflective: DVec3,
    pub roughness: f64,
    pub emitted: DVec3,
}

impl MaterialEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let (diffuse, texture) = (table.get("diffuse"), table.get("texture"));
        let diffuse = match (&diffuse, &texture) {
            (Some(_), Some(texture)) => {
                return Err(texture.invalid("one of `diffuse` and `texture`, not both"));
            }
            (Some(value), None) => Diffuse::Uniform(colour(value)?),
            (None, Some(value)) => Diffuse::Texture(TextureEntry::read(value)?),
            (None, None) => Diffuse::Uniform(DVec3::splat(0.5)),
        };
        let mut entry =
            Self { diffuse, reflective: DVec3::ZERO, roughness: 0.0, emitted: DVec3::ZERO };
        if let Some(value) = table.get("reflective") {
            entry.reflective = colour(&value)?;
        }
        if let Some(value) = table.get("roughness") {
            entry.roughness = value.number_in(0.0..=1.0, "a number from 0 to 1")?;
        }
        if let Some(value) = table.get("emitted") {
            entry.emitted = colour(&value)?;
        }
        table.finish()?;
        Ok(entry)
    }
}

impl MaterialEntry {
    /// A diffuse material with an image.
    pub fn textured(file: Located<String>, tile: DVec2, shift: DVec2) -> Self {
        Self {
            diffuse: Diffuse::Texture(TextureEntry { file, tile, shift }),
            reflective: DVec3::ZERO,
            roughness: 0.0,
            emitted: DVec3::ZERO,
        }
    }
}

impl TextureEntry {
    fn read(value: &Value<'_>) -> Result<Self> {
        if !value.is_table() {
            let file = value.name()?;
            return Ok(Self { file, tile: DVec2::ONE, shift: DVec2::ZERO });
        }
        let table = value.table()?;
        let file = table.require("file")?;
        let (tile, shift) = (table.get("tile"), table.get("shift"));
        table.finish()?;
        Ok(Self {
            file: file.name()?,
            tile: DVec2::from_array(tile.map_or(Ok([1.0; 2]), |v| v.numbers(PAIR))?),
            shift: DVec2::from_array(shift.map_or(Ok([0.0; 2]), |v| v.numbers(PAIR))?),
        })
    }
}
