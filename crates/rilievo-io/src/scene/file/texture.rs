//! Inputs of materials: numbers, colours, and images in their place.

use rilievo::glam::{DVec2, DVec3};
use rilievo::map::{NormalConvention, Wrap};
use rilievo_render::texture::Channel;

use super::super::syntax::{Located, Table, Value};
use super::material::PAIR;
use crate::error::Result;
use crate::texture_set::MapRole;

/// Wraps by name.
pub(super) const WRAPS: [(&str, Wrap); 3] =
    [("repeat", Wrap::Repeat), ("clamp", Wrap::Clamp), ("mirror", Wrap::Mirror)];

/// Directions of green by name.
pub(super) const CONVENTIONS: [(&str, NormalConvention); 2] =
    [("opengl", NormalConvention::OpenGl), ("directx", NormalConvention::DirectX)];

const SHARE: &str = "a number from 0 to 1, an image, or a table with `file`";
const SHARES: &str =
    "three numbers from 0 to 1: [red, green, blue], an image, or a table with `file`";

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
        let mut entry = Self::plain(table.require("file")?.name()?, role);
        if let Some(value) = table.get("tile") {
            entry.tile = DVec2::from_array(value.numbers(PAIR)?);
        }
        if let Some(value) = table.get("rotate") {
            entry.rotate = value.number()?;
        }
        if let Some(value) = table.get("shift") {
            entry.shift = DVec2::from_array(value.numbers(PAIR)?);
        }
        if let Some(value) = table.get("wrap") {
            entry.wrap = match value.text() {
                Ok(_) => [value.choice(&WRAPS)?; 2],
                Err(_) => {
                    let [u, v] = value.array("one wrap, or two: [along u, along v]")?;
                    [u.choice(&WRAPS)?, v.choice(&WRAPS)?]
                }
            };
        }
        Ok(entry)
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

    /// The input `key` of a table; `default` where it is not there.
    pub fn of(
        table: &Table<'_>,
        key: &'static str,
        (default, role): (f64, MapRole),
    ) -> Result<Self> {
        let Some(value) = table.get(key) else { return Ok(Self::uniform(DVec3::splat(default))) };
        let mut entry = Self { value: DVec3::ONE, texture: None, written: true };
        if value.is_table() {
            let table = value.table()?;
            entry.texture = Some(TextureEntry::of_table(&table, role)?);
            if let Some(factor) = table.get("factor") {
                entry.value = shares(&factor)?;
            }
            table.finish()?;
        } else if value.text().is_ok() {
            entry.texture = Some(TextureEntry::read(&value, role)?);
        } else {
            entry.value = shares(&value)?;
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

    /// The input `key` of a table; `default` where it is not there.
    pub fn of(
        table: &Table<'_>,
        key: &'static str,
        (default, role): (f64, MapRole),
    ) -> Result<Self> {
        let Some(value) = table.get(key) else { return Ok(Self::uniform(default)) };
        if !value.is_table() {
            if value.text().is_ok() {
                return Ok(Self::textured(TextureEntry::read(&value, role)?, Channel::Red));
            }
            let number = value.number_in(0.0..=1.0, SHARE)?;
            return Ok(Self { written: true, ..Self::uniform(number) });
        }
        let table = value.table()?;
        let texture = TextureEntry::of_table(&table, role)?;
        let channels = [("red", Channel::Red), ("green", Channel::Green), ("blue", Channel::Blue)];
        let channel = table.get("channel").map_or(Ok(Channel::Red), |v| v.choice(&channels))?;
        let mut entry = Self::textured(texture, channel);
        if let Some(factor) = table.get("factor") {
            entry.value = factor.number_in(0.0..=1.0, "a number from 0 to 1")?;
        }
        if let Some(invert) = table.get("invert") {
            entry.invert = invert.boolean()?;
        }
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
        let convention = match table.get("convention") {
            None if set => None,
            Some(value) => Some(value.choice(&CONVENTIONS)?),
            None => Some(table.require("convention")?.choice(&CONVENTIONS)?),
        };
        let strength = match table.get("strength") {
            Some(value) => value.number_in(0.0..=10.0, "a number from 0 to 10")?,
            None => 1.0,
        };
        table.finish()?;
        Ok(Self { texture, convention, strength })
    }
}

/// A colour of shares.
fn shares(value: &Value<'_>) -> Result<DVec3> {
    let mut rgb = [0.0; 3];
    for (slot, channel) in rgb.iter_mut().zip(value.array::<3>(SHARES)?) {
        *slot = channel.number_in(0.0..=1.0, "a number from 0 to 1")?;
    }
    Ok(DVec3::from_array(rgb))
}
