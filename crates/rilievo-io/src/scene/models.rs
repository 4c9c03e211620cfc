//! Meshes of a scene with the materials of their own files.
//!
//! What the renderer has is used: base colour as a number or an image, mirror reflectance,
//! roughness, emission. A metal (metalness from 0.5, without an image of it) reflects its base colour and diffuses nothing.
//! The rest of a material stays in the [`Model`] and is not used yet. An image that cannot be read
//! costs the image, not the scene; a note says so.

use std::sync::Arc;

use rilievo::glam::DAffine3;
use rilievo::mesh::Mesh;
use rilievo_render::colour::Rgb;
use rilievo_render::texture::{ColourImage, Texture};
use rilievo_render::{Material, Reflectance};

use super::resolve::Loader;
use super::syntax::Located;
use crate::error::{Error, Result};
use crate::image::{read_colour, read_colour_bytes};
use crate::mesh::{ImageSource, ImageUse, Model, ModelMaterial};

/// Metalness from which a material is a metal.
const METAL: f64 = 0.5;

impl Loader<'_> {
    /// Reads the model `file`.
    pub(super) fn model(&mut self, file: &Located<String>) -> Result<Model> {
        let path = self.file.beside(&file.value);
        let model = Model::read(&path, &self.options.limits)
            .map_err(|e| self.file.referenced(file, "mesh", e))?;
        self.notes.extend(model.notes.iter().map(|note| format!("{}: {note}", path.display())));
        Ok(model)
    }

    /// The mesh of `data`, placed.
    pub(super) fn placed(
        &self,
        data: rilievo::mesh::MeshData,
        file: &Located<String>,
        place: Option<&Located<DAffine3>>,
    ) -> Result<Mesh> {
        let refused = |at: &Located<String>, found: String, allowed: &str| {
            let fault = self.file.document().fault(&at.at, "mesh", found, allowed);
            Error::Invalid(Box::new(fault))
        };
        let mesh = Mesh::new(data).map_err(|e| {
            refused(file, e.to_string(), "a file with at least one face, finite numbers")
        })?;
        let Some(place) = place else { return Ok(mesh) };
        mesh.transformed(place.value).map_err(|e| {
            let at = Located { value: String::new(), at: place.at.clone() };
            refused(&at, e.to_string(), "a transform that can be inverted, numbers up to 1e100")
        })
    }

    /// The model `file` cut by its materials, placed.
    pub(super) fn parts(
        &mut self,
        file: &Located<String>,
        place: Option<&Located<DAffine3>>,
    ) -> Result<Vec<(Mesh, Option<Material>)>> {
        let model = self.model(file)?;
        if model.mesh.triangles.is_empty() {
            return Ok(vec![(self.placed(model.mesh, file, place)?, None)]);
        }
        let mut parts = Vec::new();
        for (data, material) in model.by_material() {
            let mesh = self.placed(data, file, place)?;
            let material = material.and_then(|index| model.materials.get(index));
            parts.push((mesh, material.map(|m| self.model_material(m))));
        }
        Ok(parts)
    }

    /// What the renderer has of a material.
    pub(super) fn model_material(&mut self, from: &ModelMaterial) -> Material {
        // What an image makes of it differs from place to place; most surfaces are no metal.
        let metal = from.metalness >= METAL && from.metalness_map.is_none();
        let diffuse = match from.colour_map.as_ref().and_then(|image| self.colour_image(image)) {
            _ if metal => Reflectance::Uniform(Rgb::ZERO),
            Some(texture) => Reflectance::Textured(texture),
            None => Reflectance::Uniform(from.colour),
        };
        let reflective = if metal { from.colour } else { from.reflective };
        Material { diffuse, reflective, roughness: from.roughness, emitted: from.emitted }
    }

    fn colour_image(&mut self, from: &ImageUse) -> Option<Texture> {
        let limits = &self.options.limits;
        let image = match &from.source {
            ImageSource::File(path) => match self.images.get(path) {
                Some(image) => Ok(Arc::clone(image)),
                None => read_colour(path, limits).map(|image| {
                    let image = Arc::new(image);
                    self.images.insert(path.clone(), Arc::clone(&image));
                    image
                }),
            },
            ImageSource::Embedded { name, bytes } => {
                read_colour_bytes(bytes, name, limits).map(Arc::<ColourImage>::new)
            }
        };
        match image {
            Ok(image) => Some(Texture { image, tile: from.tile, shift: from.shift }),
            Err(e) => {
                self.notes.push(format!("image not used: {e}"));
                None
            }
        }
    }
}
