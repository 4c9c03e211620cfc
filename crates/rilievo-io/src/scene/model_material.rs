//! Materials of models' own files: MTL and glTF.
//!
//! Paths see a principled surface with every input that the file has. The paper's integrator sees base
//! colour as a number or an image, mirror reflectance and roughness; there a metal (metalness from 0.5,
//! without an image of it) reflects its base colour and diffuses nothing. An image that cannot
//! be read costs the image, not the scene; a note says so.

use rilievo_render::colour::Rgb;
use rilievo_render::scene::{Model, Principled};
use rilievo_render::texture::{Channel, ColourInput, NormalInput, NumberInput, Texture};
use rilievo_render::{Material, Reflectance};

use super::materials::Codes;
use super::resolve::Loader;
use crate::error::Result;
use crate::image::{read_colour, read_colour_bytes};
use crate::mesh::{ImageSource, ImageUse, ModelMaterial};

/// Metalness from which the paper's integrator takes a material for a metal.
const METAL: f64 = 0.5;

impl Loader<'_> {
    /// What the renderer has of a material.
    pub(super) fn model_material(&mut self, from: &ModelMaterial) -> Result<Material> {
        // What an image makes of it differs from place to place; most surfaces are no metal.
        let metal = from.metalness >= METAL && from.metalness_map.is_none();
        let colour = self.own_image(from.colour_map.as_ref(), Codes::Colour);
        let diffuse = match &colour {
            _ if metal => Reflectance::Uniform(Rgb::ZERO),
            Some(texture) => Reflectance::Textured(texture.clone()),
            None => Reflectance::Uniform(from.colour),
        };
        let reflective = if metal { from.colour } else { from.reflective };
        let mut material = Material {
            diffuse,
            reflective,
            roughness: from.roughness,
            emitted: from.emitted,
            ..Material::default()
        };
        if !self.file.traces_paths(self.options) {
            // A whole surface that shines is worse than none.
            if from.emission_map.is_some() {
                material.emitted = Rgb::ZERO;
            }
            return Ok(material);
        }
        if from.emission_map.is_some() {
            material.emission = self.own_image(from.emission_map.as_ref(), Codes::Colour);
            if material.emission.is_none() {
                material.emitted = Rgb::ZERO;
            }
        }
        if let Some((image, convention)) = &from.normal_map
            && let Some(texture) = self.own_image(Some(image), Codes::Number)
        {
            let (convention, strength) = (*convention, from.normal_strength);
            material.normals = Some(NormalInput { texture, convention, strength });
        }
        // A mirror on top of a diffuser is the paper's own.
        if from.reflective == Rgb::ZERO {
            let model = self.own_principled(from, colour)?;
            material.model = Model::Principled(Box::new(model));
        }
        Ok(material)
    }

    fn own_principled(
        &mut self,
        from: &ModelMaterial,
        colour: Option<Texture>,
    ) -> Result<Principled> {
        let mut number = |value: f64, map: Option<&ImageUse>, channel| {
            let texture = self.own_image(map, Codes::Number).map(|texture| (texture, channel));
            NumberInput { value: value.clamp(0.0, 1.0), texture, invert: false }
        };
        let roughness = number(from.roughness, from.roughness_map.as_ref(), Channel::Green);
        let metallic = number(from.metalness, from.metalness_map.as_ref(), Channel::Blue);
        let transmission = number(from.transmission, from.transmission_map.as_ref(), Channel::Red);
        let opacity = number(from.opacity, from.opacity_map.as_ref(), Channel::Red);
        let coat = number(from.coat, from.coat_map.as_ref(), Channel::Red);
        let coat_roughness =
            number(from.coat_roughness, from.coat_roughness_map.as_ref(), Channel::Green);
        let unit = |rgb: Rgb| rgb.clamp(Rgb::ZERO, Rgb::ONE);
        Ok(Principled {
            base_colour: ColourInput { value: unit(from.colour), texture: colour },
            metallic,
            roughness,
            specular: NumberInput::uniform(from.specular.clamp(0.0, 1.0)),
            specular_colour: ColourInput::uniform(unit(from.specular_colour)),
            glass: self.glass(from.ior.clamp(0.1, 10.0))?,
            transmission,
            thin: from.thin,
            opacity,
            coat,
            coat_roughness,
            sheen: ColourInput::uniform(unit(from.sheen)),
            sheen_roughness: NumberInput::uniform(from.sheen_roughness.clamp(0.0, 1.0)),
            ..Principled::new()
        })
    }

    fn own_image(&mut self, from: Option<&ImageUse>, codes: Codes) -> Option<Texture> {
        let ImageUse { source, tile, turn, shift, wrap } = from?;
        let limits = self.options.limits;
        let image = match source {
            ImageSource::File(path) => {
                self.files.push(path.clone());
                self.image_of_file((path.clone(), codes), || read_colour(path, &limits))
            }
            ImageSource::Embedded { name, bytes } => {
                self.image_once((name.clone(), codes), || read_colour_bytes(bytes, name, &limits))
            }
        };
        match image {
            Ok(image) => {
                Some(Texture { image, tile: *tile, turn: *turn, shift: *shift, wrap: *wrap })
            }
            Err(e) => {
                self.notes.push(format!("image not used: {e}"));
                None
            }
        }
    }
}
