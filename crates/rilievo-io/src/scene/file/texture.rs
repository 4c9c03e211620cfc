//! Inputs of materials: numbers, colours, and images in their place.

use rilievo::glam::{DVec2, DVec3};
use rilievo::map::{NormalConvention, Wrap};
use rilievo_render::texture::Channel;

use super::super::keys::kind::{Colour, Input, Number, Read};
use super::super::keys::material as keys;
use super::super::keys::model::InputKey;
use super::super::syntax::{Located, Table, Value};
use crate::error::{Error, Result};
use crate::texture_set::MapRole;

/// An image laid over uv.
#[derive(Clone, Debug)]
pub(in super::super) struct TextureEntry {
    pub file: Located<String>,
    pub tile: DVec2,
    /// Degrees, from u to v.
    pub rotate: f64,
    pub shift: DVec2,
    pub wrap: [Wrap; 2],
    /// Whose map is meant where the file is a texture set.
    pub role: MapRole,
}

impl TextureEntry {
    /// The image over `[0, 1]^2`, repeated.
    pub fn plain(file: Located<String>, role: MapRole) -> Self {
        let (tile, shift) = (DVec2::ONE, DVec2::ZERO);
        Self { file, tile, rotate: 0.0, shift, wrap: [Wrap::Repeat; 2], role }
    }

    /// A file, or a table with `file`.
    pub fn read(value: &Value<'_>, role: MapRole) -> Result<Self> {
        if !value.is_table() {
            return Ok(Self::plain(value.name()?, role));
        }
        let table = value.table()?;
        let entry = Self::of_table(&table, role)?;
        table.finish()?;
        Ok(entry)
    }

    /// The keys of an image in a table, which may have more.
    fn of_table(table: &Table<'_>, role: MapRole) -> Result<Self> {
        Ok(Self {
            file: keys::FILE.of(table)?,
            tile: DVec2::from_array(keys::TILE.of(table)?),
            rotate: keys::ROTATE.of(table)?,
            shift: DVec2::from_array(keys::SHIFT.of(table)?),
            wrap: keys::WRAP.of(table)?,
            role,
        })
    }
}

/// A colour, or a factor on an image.
#[derive(Clone, Debug)]
pub(in super::super) struct ColourEntry {
    pub value: DVec3,
    pub texture: Option<TextureEntry>,
    /// Whether the scene says it.
    pub written: bool,
}

impl ColourEntry {
    pub fn uniform(value: DVec3) -> Self {
        Self { value, texture: None, written: false }
    }

    /// An input of a table, or its default.
    pub fn of(table: &Table<'_>, key: &InputKey) -> Result<Self> {
        let Input(role) = key.kind;
        let Some(value) = table.get(key) else {
            return Ok(Self::uniform(DVec3::splat(key.missing.0)));
        };
        let mut entry = Self { value: DVec3::ONE, texture: None, written: true };
        if value.is_table() {
            let table = value.table()?;
            entry.texture = Some(TextureEntry::of_table(&table, role)?);
            entry.value = keys::TINT.of(&table)?;
            table.finish()?;
        } else if value.text().is_ok() {
            entry.texture = Some(TextureEntry::read(&value, role)?);
        } else {
            entry.value = or_image(&value, Colour::Share)?;
        }
        Ok(entry)
    }
}

/// A number from 0 to 1, or a factor on a channel of an image.
#[derive(Clone, Debug)]
pub(in super::super) struct NumberEntry {
    pub value: f64,
    pub texture: Option<(TextureEntry, Channel)>,
    pub invert: bool,
    /// Whether the scene says it.
    pub written: bool,
}

impl NumberEntry {
    pub fn uniform(value: f64) -> Self {
        Self { value, texture: None, invert: false, written: false }
    }

    /// An image, as its codes are.
    pub fn textured(texture: TextureEntry, channel: Channel) -> Self {
        Self { value: 1.0, texture: Some((texture, channel)), invert: false, written: true }
    }

    /// An input of a table, or its default.
    pub fn of(table: &Table<'_>, key: &InputKey) -> Result<Self> {
        let Input(role) = key.kind;
        let Some(value) = table.get(key) else { return Ok(Self::uniform(key.missing.0)) };
        if !value.is_table() {
            if value.text().is_ok() {
                return Ok(Self::textured(TextureEntry::read(&value, role)?, Channel::Red));
            }
            let number = or_image(&value, Number::Within(0.0, 1.0))?;
            return Ok(Self { written: true, ..Self::uniform(number) });
        }
        let table = value.table()?;
        let texture = TextureEntry::of_table(&table, role)?;
        let mut entry = Self::textured(texture, keys::CHANNEL.of(&table)?);
        entry.value = keys::FACTOR.of(&table)?;
        entry.invert = keys::INVERT.of(&table)?;
        table.finish()?;
        Ok(entry)
    }
}

/// A map of normals.
#[derive(Clone, Debug)]
pub(in super::super) struct NormalEntry {
    pub texture: TextureEntry,
    /// None of a texture set, which knows it.
    pub convention: Option<NormalConvention>,
    pub strength: f64,
}

impl NormalEntry {
    pub fn read(value: &Value<'_>) -> Result<Self> {
        let table = value.table()?;
        let texture = TextureEntry::of_table(&table, MapRole::Normal)?;
        let set = texture.file.value.ends_with('/');
        // A set knows it.
        let convention = match table.get(&keys::CONVENTION) {
            None if set => None,
            _ => Some(keys::CONVENTION.of(&table)?),
        };
        let strength = keys::STRENGTH.of(&table)?;
        table.finish()?;
        Ok(Self { texture, convention, strength })
    }
}

/// A value where an image might stand too.
fn or_image<K: Read>(value: &Value<'_>, kind: K) -> Result<K::Value> {
    kind.read(value).map_err(|error| match error {
        Error::Invalid(mut fault) => {
            fault.allowed += ", an image, or a table with `file`";
            Error::Invalid(fault)
        }
        error => error,
    })
}
