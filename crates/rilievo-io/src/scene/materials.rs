//! Materials of a scene file: names to materials, files to images.
//!
//! Colours are read as sRGB where their file holds codes, all else as linear numbers. An image is read
//! once for each of the two. What no integrator but those of paths shows is read for those only: the
//! roughness of a texture set, say, and the like of a model's own materials.

use std::path::PathBuf;
use std::sync::Arc;

use rilievo::glam::DVec2;
use rilievo::map::NormalConvention;
use rilievo_render::bsdf::GlassTable;
use rilievo_render::scene::{
    Conductor, Diffuse as DiffuseModel, Glass, Metal, Mix, Model, Principled, ThinGlass,
};
use rilievo_render::texture::{ColourImage, ColourInput, NormalInput, NumberInput, Texture};
use rilievo_render::{Integrator, Material, Reflectance};

use super::file::{
    ColourEntry, Diffuse, MaterialEntry, MetalEntry, ModelEntry, NumberEntry, PrincipledEntry,
    SceneFile, TextureEntry,
};
use super::options::LoadOptions;
use super::resolve::Loader;
use super::syntax::Located;
use crate::error::Result;
use crate::image::read_colour;

/// What the codes of an image mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Codes {
    /// Colours: sRGB.
    Colour,
    /// Numbers: linear.
    Number,
}

/// An image by its file, or by its name in one, and what its codes mean.
pub(super) type ImageKey = (PathBuf, Codes);

impl SceneFile {
    /// Whether paths are traced: only they show all of a material.
    pub(super) fn traces_paths(&self, options: &LoadOptions<'_>) -> bool {
        let integrator = options.integrator.unwrap_or(self.render.settings.integrator);
        !matches!(integrator, Integrator::Distributed | Integrator::Aov)
    }
}

impl Loader<'_> {
    /// The material at a place in the scene's list; `above` are the mixes that it is part of.
    pub(super) fn material(&mut self, index: usize, above: &mut Vec<usize>) -> Result<Material> {
        let file = self.file;
        let (_, entry) = &file.materials[index];
        let mut material = match &entry.model {
            ModelEntry::Paper => self.papers(entry)?,
            ModelEntry::Mix { materials, share } => {
                above.push(index);
                let mut parts = Vec::new();
                for name in materials {
                    let part = file.find(name, &file.materials, "material")?;
                    if above.contains(&part) {
                        let found = format!("\"{}\" contains itself", name.value);
                        let allowed = "a material that is no mix around this one".to_owned();
                        return Err(file.invalid(&name.at, "mix", found, allowed));
                    }
                    parts.push(self.material(part, above)?);
                }
                above.pop();
                let share = self.number_input(share)?;
                match <[Material; 2]>::try_from(parts) {
                    Ok(materials) => {
                        Material::of_model(Model::Mix(Arc::new(Mix { materials, share })))
                    }
                    Err(_) => Material::default(),
                }
            }
            model => Material::of_model(self.scattering(model)?),
        };
        if let ModelEntry::Principled(model) = &entry.model
            && model.set.is_some()
        {
            // A set looks as it always did in the paper's terms.
            let papers = self.papers(entry)?;
            material = Material { model: material.model, ..papers };
        }
        material.emitted = entry.emitted;
        if let Some(texture) = &entry.emission {
            material.emission = Some(self.texture(texture, Codes::Colour)?);
        }
        if let Some(normals) = &entry.normals {
            material.normals = Some(NormalInput {
                texture: self.texture(&normals.texture, Codes::Number)?,
                convention: normals.convention.unwrap_or(NormalConvention::OpenGl),
                strength: normals.strength,
            });
        }
        Ok(material)
    }

    /// The paper's material.
    fn papers(&mut self, entry: &MaterialEntry) -> Result<Material> {
        let diffuse = match &entry.diffuse {
            Diffuse::Uniform(rgb) => Reflectance::Uniform(*rgb),
            Diffuse::Texture(texture) => {
                Reflectance::Textured(self.texture(texture, Codes::Colour)?)
            }
        };
        let MaterialEntry { reflective, roughness, .. } = *entry;
        Ok(Material { diffuse, reflective, roughness, ..Material::default() })
    }

    /// How light is scattered; the paper's way for a mix, which is put together by its caller.
    fn scattering(&mut self, entry: &ModelEntry) -> Result<Model> {
        Ok(match entry {
            ModelEntry::Paper | ModelEntry::Mix { .. } => Model::Paper,
            ModelEntry::Diffuse { colour, roughness } => Model::Diffuse(DiffuseModel {
                colour: self.colour_input(colour)?,
                roughness: self.number_input(roughness)?,
            }),
            ModelEntry::Conductor { metal, roughness, compensate } => {
                let metal = match metal {
                    MetalEntry::Colours { facing, edge } => Metal::Colours {
                        facing: self.colour_input(facing)?,
                        edge: self.colour_input(edge)?,
                    },
                    MetalEntry::Index { eta, k } => Metal::Index { eta: *eta, k: *k },
                };
                let roughness = self.number_input(roughness)?;
                Model::Conductor(Conductor { metal, roughness, compensated: *compensate })
            }
            ModelEntry::Glass { ior, colour, roughness, compensate } => Model::Glass(Glass {
                table: self.glass(*ior)?,
                colour: self.colour_input(colour)?,
                roughness: self.number_input(roughness)?,
                compensated: *compensate,
            }),
            ModelEntry::ThinGlass { ior, colour, roughness } => Model::ThinGlass(ThinGlass {
                ior: *ior,
                colour: self.colour_input(colour)?,
                roughness: self.number_input(roughness)?,
            }),
            ModelEntry::Principled(entry) => Model::Principled(Box::new(self.principled(entry)?)),
        })
    }

    fn principled(&mut self, entry: &PrincipledEntry) -> Result<Principled> {
        let [base_colour, specular_colour, sheen] = &entry.colours;
        let [
            metallic,
            roughness,
            diffuse_roughness,
            specular,
            transmission,
            opacity,
            coat,
            coat_roughness,
            sheen_roughness,
        ] = &entry.numbers;
        Ok(Principled {
            base_colour: self.colour_input(base_colour)?,
            metallic: self.number_input(metallic)?,
            roughness: self.number_input(roughness)?,
            diffuse_roughness: self.number_input(diffuse_roughness)?,
            specular: self.number_input(specular)?,
            specular_colour: self.colour_input(specular_colour)?,
            glass: self.glass(entry.ior)?,
            transmission: self.number_input(transmission)?,
            thin: entry.thin,
            opacity: self.number_input(opacity)?,
            coat: self.number_input(coat)?,
            coat_roughness: self.number_input(coat_roughness)?,
            sheen: self.colour_input(sheen)?,
            sheen_roughness: self.number_input(sheen_roughness)?,
        })
    }

    /// An index of refraction; materials of equal ones share what is known of it.
    pub(super) fn glass(&mut self, ior: f64) -> Result<Arc<GlassTable>> {
        if let Some(glass) = self.glasses.iter().find(|glass| glass.ior() == ior) {
            return Ok(Arc::clone(glass));
        }
        let glass = GlassTable::new(ior).map_err(|e| {
            self.file.invalid(&(0..0), "ior", e.to_string(), "0.1 to 10".to_owned())
        })?;
        let glass = Arc::new(glass);
        self.glasses.push(Arc::clone(&glass));
        Ok(glass)
    }

    fn colour_input(&mut self, entry: &ColourEntry) -> Result<ColourInput> {
        let texture = entry.texture.as_ref().map(|t| self.texture(t, Codes::Colour)).transpose()?;
        Ok(ColourInput { value: entry.value, texture })
    }

    fn number_input(&mut self, entry: &NumberEntry) -> Result<NumberInput> {
        let texture = match &entry.texture {
            Some((texture, channel)) => Some((self.texture(texture, Codes::Number)?, *channel)),
            None => None,
        };
        Ok(NumberInput { value: entry.value, texture, invert: entry.invert })
    }

    fn texture(&mut self, entry: &TextureEntry, codes: Codes) -> Result<Texture> {
        let image = self.image(&entry.file, codes)?;
        let turn = match entry.rotate {
            0.0 => DVec2::X,
            degrees => DVec2::from_angle(degrees.to_radians()),
        };
        let TextureEntry { tile, shift, wrap, .. } = *entry;
        Ok(Texture { image, tile, turn, shift, wrap })
    }

    /// The image of a file that the scene names.
    fn image(&mut self, name: &Located<String>, codes: Codes) -> Result<Arc<ColourImage>> {
        let path = self.file.beside(&name.value);
        let limits = self.options.limits;
        self.image_of_file((path.clone(), codes), || read_colour(&path, &limits))
            .map_err(|e| self.file.referenced(name, "texture", e))
    }

    /// [`Self::image_once`] for a file, which the cache keeps.
    pub(super) fn image_of_file(
        &mut self,
        key: ImageKey,
        read: impl FnOnce() -> Result<ColourImage>,
    ) -> Result<Arc<ColourImage>> {
        // Images under a limit lie in the temporary file of one loading.
        let cache = self.options.cache.filter(|_| self.texture_limit().is_none());
        let Some(cache) = cache else { return self.image_once(key, read) };
        let image = match cache.image(&key) {
            Some(image) => image,
            None => self.image_once(key.clone(), read)?,
        };
        cache.keep_image(key.clone(), &image);
        self.images.insert(key, Arc::clone(&image));
        Ok(image)
    }

    /// The image under `key`; `read` gives it if it is not there yet.
    pub(super) fn image_once(
        &mut self,
        key: ImageKey,
        read: impl FnOnce() -> Result<ColourImage>,
    ) -> Result<Arc<ColourImage>> {
        if let Some(image) = self.images.get(&key) {
            return Ok(Arc::clone(image));
        }
        let image = match key.1 {
            Codes::Colour => read()?,
            Codes::Number => read()?.into_linear(),
        };
        let image = Arc::new(self.fitted(image)?);
        self.images.insert(key, Arc::clone(&image));
        Ok(image)
    }
}
