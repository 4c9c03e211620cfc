//! `[materials.NAME]`.

use rilievo::glam::{DVec2, DVec3};

use super::super::keys::material as keys;
use super::super::syntax::{Located, Table};
use super::model::ModelEntry;
use super::texture::{NormalEntry, TextureEntry};
use crate::error::Result;
use crate::texture_set::MapRole;

/// A diffuse reflectance.
#[derive(Clone, Debug)]
pub(in super::super) enum Diffuse {
    Uniform(DVec3),
    Texture(TextureEntry),
}

/// What `[materials.NAME]` says.
#[derive(Clone, Debug)]
pub(in super::super) struct MaterialEntry {
    /// The paper's material; of other models, where a texture set gave them, what the paper's
    /// integrator shows.
    pub diffuse: Diffuse,
    pub reflective: DVec3,
    pub roughness: f64,
    pub emitted: DVec3,
    pub emission: Option<TextureEntry>,
    pub model: ModelEntry,
    pub normals: Option<NormalEntry>,
    /// Whether the scene asks for no normal map, whatever a texture set has.
    pub without_normals: bool,
}

impl MaterialEntry {
    pub fn read(table: &Table<'_>) -> Result<Self> {
        let mut entry = Self::uniform(keys::DIFFUSE.missing.0);
        entry.model = ModelEntry::read(table)?;
        if let ModelEntry::Paper = entry.model {
            let (diffuse, texture) = (table.get(&keys::DIFFUSE), table.get(&keys::TEXTURE));
            entry.diffuse = match (&diffuse, &texture) {
                (Some(_), Some(texture)) => {
                    return Err(texture.invalid("one of `diffuse` and `texture`, not both"));
                }
                (None, Some(value)) => {
                    Diffuse::Texture(TextureEntry::read(value, MapRole::Albedo)?)
                }
                (_, None) => Diffuse::Uniform(keys::DIFFUSE.of(table)?),
            };
            entry.reflective = keys::REFLECTIVE.of(table)?;
            entry.roughness = keys::ROUGHNESS.of(table)?;
        }
        entry.emitted = keys::EMITTED.of(table)?;
        if let Some(value) = table.get(&keys::EMISSION) {
            entry.emission = Some(TextureEntry::read(&value, MapRole::Emission)?);
        }
        if let Some(value) = table.get(&keys::NORMALS_TABLE) {
            entry.without_normals = matches!(value.boolean(), Ok(false));
            if !entry.without_normals {
                entry.normals = Some(NormalEntry::read(&value)?);
            }
        }
        table.finish()?;
        Ok(entry)
    }

    /// A diffuser of the paper's model.
    fn uniform(diffuse: DVec3) -> Self {
        Self {
            diffuse: Diffuse::Uniform(diffuse),
            reflective: DVec3::ZERO,
            roughness: 0.0,
            emitted: DVec3::ZERO,
            emission: None,
            model: ModelEntry::Paper,
            normals: None,
            without_normals: false,
        }
    }

    /// A diffuse material with an image.
    pub fn textured(file: Located<String>, tile: DVec2, shift: DVec2) -> Self {
        let texture = TextureEntry { tile, shift, ..TextureEntry::plain(file, MapRole::Albedo) };
        Self { diffuse: Diffuse::Texture(texture), ..Self::uniform(DVec3::ZERO) }
    }

    /// Every image.
    pub fn textures_mut(&mut self) -> Vec<&mut TextureEntry> {
        let mut all = self.model.textures_mut();
        if let Diffuse::Texture(texture) = &mut self.diffuse {
            all.push(texture);
        }
        all.extend(&mut self.emission);
        all.extend(self.normals.iter_mut().map(|normals| &mut normals.texture));
        all
    }
}
