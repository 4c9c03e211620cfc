//! Maps of texture sets in materials: the one that fits the place, or all of them.

use rilievo::glam::DVec3;
use rilievo::map::NormalConvention;
use rilievo_render::texture::Channel;

use super::file::{
    BASE_COLOUR, ColourEntry, Diffuse, METALLIC, MaterialEntry, ModelEntry, NormalEntry,
    NumberEntry, OPACITY, PrincipledEntry, ROUGHNESS, TextureEntry,
};
use super::sets::{Sets, is_set};
use super::syntax::Located;
use crate::error::Result;
use crate::texture_set::MapRole;

/// Which map gives a number, and how: the first that a set has.
type Sources = [(MapRole, Channel, bool)];

const ROUGHNESS_MAPS: &Sources = &[
    (MapRole::Roughness, Channel::Red, false),
    (MapRole::Glossiness, Channel::Red, true),
    (MapRole::Packed, Channel::Green, false),
];
const METALNESS_MAPS: &Sources =
    &[(MapRole::Metalness, Channel::Red, false), (MapRole::Packed, Channel::Blue, false)];
const OPACITY_MAPS: &Sources = &[(MapRole::Opacity, Channel::Red, false)];

impl Sets<'_> {
    /// `material` with files in place of texture sets; none if it names none.
    pub(super) fn in_material(
        &mut self,
        material: &MaterialEntry,
    ) -> Result<Option<MaterialEntry>> {
        let mut changed = material.clone();
        let mut any = false;
        if let Some(normals) = &mut changed.normals
            && is_set(&normals.texture.file.value)
            && normals.convention.is_none()
        {
            normals.convention = self.convention(&normals.texture.file)?;
        }
        for texture in changed.textures_mut() {
            if is_set(&texture.file.value) {
                texture.file.value = self.map(&texture.file, texture.role)?;
                any = true;
            }
        }
        if let ModelEntry::Principled(model) = &changed.model
            && let Some(set) = model.set.clone()
        {
            self.fill(&mut changed, &set)?;
            any = true;
        }
        Ok(any.then_some(changed))
    }

    /// Makes the material that stands for a set on the shape it displaces a principled one, with all of
    /// the set's maps but the normals: the relief has those.
    pub(super) fn fill_added(
        &mut self,
        material: &mut MaterialEntry,
        folder: &Located<String>,
    ) -> Result<()> {
        let Diffuse::Texture(albedo) = &material.diffuse else { return Ok(()) };
        if !self.paths {
            return Ok(());
        }
        let set = TextureEntry { file: folder.clone(), ..albedo.clone() };
        let model = PrincipledEntry { set: Some(set.clone()), ..PrincipledEntry::default() };
        material.model = ModelEntry::Principled(Box::new(model));
        material.without_normals = true;
        self.fill(material, &set)
    }

    /// Fills in what the scene does not say of a principled material.
    fn fill(&mut self, material: &mut MaterialEntry, set: &TextureEntry) -> Result<()> {
        let laid = |path: String| {
            let file = Located { value: path, at: set.file.at.clone() };
            TextureEntry { file, ..set.clone() }
        };
        let albedo = self.has(set, MapRole::Albedo)?.map(laid);
        if let Some(texture) = &albedo {
            material.diffuse = Diffuse::Texture(texture.clone());
        }
        if !self.paths {
            // The paper's integrator shows the albedo.
            material.model = ModelEntry::Paper;
            return Ok(());
        }
        if material.normals.is_none()
            && !material.without_normals
            && let Some(path) = self.has(set, MapRole::Normal)?
        {
            let convention = self.convention(&set.file)?;
            material.normals = Some(NormalEntry { texture: laid(path), convention, strength: 1.0 });
        }
        if material.emission.is_none()
            && let Some(path) = self.has(set, MapRole::Emission)?
        {
            material.emission = Some(laid(path));
            if material.emitted == DVec3::ZERO {
                material.emitted = DVec3::ONE;
            }
        }
        let ModelEntry::Principled(model) = &mut material.model else { return Ok(()) };
        if !model.colours[BASE_COLOUR].written {
            let base = ColourEntry { value: DVec3::ONE, texture: albedo, written: true };
            if base.texture.is_some() {
                model.colours[BASE_COLOUR] = base;
            }
        }
        for (input, sources) in
            [(ROUGHNESS, ROUGHNESS_MAPS), (METALLIC, METALNESS_MAPS), (OPACITY, OPACITY_MAPS)]
        {
            if model.numbers[input].written {
                continue;
            }
            for &(role, channel, invert) in sources {
                if let Some(path) = self.has(set, role)? {
                    let entry = NumberEntry::textured(laid(path), channel);
                    model.numbers[input] = NumberEntry { invert, ..entry };
                    break;
                }
            }
        }
        Ok(())
    }

    /// The path of the set's map for `role`, if it has one.
    fn has(&mut self, set: &TextureEntry, role: MapRole) -> Result<Option<String>> {
        let (found, _) = self.find(&set.file)?;
        match found.map(role) {
            Some(_) => self.map(&set.file, role).map(Some),
            None => Ok(None),
        }
    }

    /// Which way green points in the normals of a set, if a name says so.
    fn convention(&mut self, name: &Located<String>) -> Result<Option<NormalConvention>> {
        let (set, _) = self.find(name)?;
        Ok(set.map(MapRole::Normal).and_then(|map| map.convention))
    }
}
