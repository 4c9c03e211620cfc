//! [`Material`]: how a surface answers light.

use std::sync::Arc;

use glam::DVec2;

use super::model::{Conductor, Metal, Mix, Model, Principled};
use crate::colour::{Rgb, is_radiance};
use crate::texture::{ColourImage, ColourInput, Footprint, NormalInput, Texture};

/// A diffuse reflectance.
#[derive(Clone, Debug, PartialEq)]
pub enum Reflectance {
    /// The same everywhere.
    Uniform(Rgb),
    /// Looked up at the hit's uv.
    Textured(Texture),
}

impl Reflectance {
    /// The reflectance at `uv`.
    pub fn at(&self, uv: DVec2) -> Rgb {
        match self {
            Self::Uniform(rgb) => *rgb,
            Self::Textured(texture) => texture.lookup(uv),
        }
    }

    /// The mean reflectance over a footprint.
    pub fn mean(&self, at: &Footprint) -> Rgb {
        match self {
            Self::Uniform(rgb) => *rgb,
            Self::Textured(texture) => texture.mean(at),
        }
    }
}

/// The material of a surface. Both sides reflect alike; only the front emits.
///
/// `model` says how light is scattered. `diffuse`, `reflective` and `roughness` are the whole of the
/// paper's model; of any other they are what [`crate::Integrator::Distributed`] shows in its place, and
/// [`Material::of_model`] derives them.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Diffuse reflectance (Lambert).
    pub diffuse: Reflectance,
    /// Share of the light from around the mirror direction that is reflected.
    pub reflective: Rgb,
    /// Spread of that reflection, 0 to 1: 0 is a mirror, otherwise a GGX lobe with
    /// `alpha = roughness^2` (see [`crate::sampler::warp`]).
    pub roughness: f64,
    /// Radiance sent out from the front side, W/(sr m^2).
    pub emitted: Rgb,
    /// Factor on `emitted`, from place to place.
    pub emission: Option<Texture>,
    /// How light is scattered.
    pub model: Model,
    /// Normals finer than those of the surface, displaced or not, in its tangent space.
    pub normals: Option<NormalInput>,
}

impl Default for Material {
    /// A grey diffuser of reflectance 0.5, without gloss or emission.
    fn default() -> Self {
        Self {
            diffuse: Reflectance::Uniform(Rgb::splat(0.5)),
            reflective: Rgb::ZERO,
            roughness: 0.0,
            emitted: Rgb::ZERO,
            emission: None,
            model: Model::Paper,
            normals: None,
        }
    }
}

/// Why a material was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// A colour has a channel that is negative, NaN or infinite.
    #[error("{part} is [{}, {}, {}]; channels must be finite and at least 0", found.x, found.y, found.z)]
    Colour {
        /// The part of the material: `diffuse`, `reflective` or `emitted`.
        part: &'static str,
        /// The value found.
        found: Rgb,
    },
    /// The roughness is not in `[0, 1]`.
    #[error("roughness is {found}; it must be between 0 and 1")]
    Roughness {
        /// The value found.
        found: f64,
    },
    /// An input of a model is not in `[0, 1]`.
    #[error("{part} is [{}, {}, {}]; it must be between 0 and 1", found.x, found.y, found.z)]
    Share {
        /// The input.
        part: &'static str,
        /// The value found, three times if it is a number.
        found: Rgb,
    },
    /// An index of refraction is out of range.
    #[error("the index of refraction is {found}; it must be between 0.1 and 10")]
    Ior {
        /// The value found.
        found: f64,
    },
    /// A texture's tile, turn or shift is NaN or infinite.
    #[error("texture tile, turn and shift must be finite")]
    Texture,
}

impl Material {
    /// A material without emission that scatters light by `model`. In the paper's terms a glossy
    /// dielectric reflects what it does straight on, a metal (metalness from 0.5, without a texture of
    /// it) its colour; nothing goes through. A mix is the mean of its parts where they are
    /// uniform, or its first part.
    pub fn of_model(model: Model) -> Self {
        let colour = |input: &ColourInput| match &input.texture {
            None => Reflectance::Uniform(input.value),
            Some(texture) => Reflectance::Textured(texture.clone()),
        };
        let none = Reflectance::Uniform(Rgb::ZERO);
        let (diffuse, reflective, roughness) = match &model {
            Model::Paper => return Self::default(),
            Model::Diffuse(d) => (colour(&d.colour), Rgb::ZERO, 0.0),
            Model::Conductor(Conductor { metal, roughness, .. }) => {
                let facing = match metal {
                    Metal::Colours { facing, .. } => facing.value,
                    Metal::Index { eta, k } => {
                        let (near, far) = (*eta - 1.0, *eta + 1.0);
                        (near * near + k * k) / (far * far + k * k)
                    }
                };
                (none, facing, roughness.value)
            }
            Model::Glass(g) => (none, Rgb::splat(facing(g.table.ior())), g.roughness.value),
            Model::ThinGlass(g) => {
                let once = facing(g.ior);
                (none, Rgb::splat(2.0 * once / (1.0 + once)), g.roughness.value)
            }
            Model::Principled(p) if p.metallic.value >= 0.5 && p.metallic.texture.is_none() => {
                (none, p.base_colour.value, p.roughness.value)
            }
            Model::Principled(p) => {
                let Principled { specular, specular_colour, roughness, .. } = p.as_ref();
                let gloss = facing(p.glass.ior()) * specular.value * specular_colour.value;
                (colour(&p.base_colour), gloss, roughness.value)
            }
            Model::Mix(mix) => {
                let Mix { materials: [a, b], share } = mix.as_ref();
                let t = share.value;
                let diffuse = match (&a.diffuse, &b.diffuse) {
                    (Reflectance::Uniform(a), Reflectance::Uniform(b)) => {
                        Reflectance::Uniform(a.lerp(*b, t))
                    }
                    _ => a.diffuse.clone(),
                };
                let roughness = a.roughness + t * (b.roughness - a.roughness);
                (diffuse, a.reflective.lerp(b.reflective, t), roughness)
            }
        };
        Self { diffuse, reflective, roughness, model, ..Self::default() }
    }

    /// Whether the front side sends out light.
    pub fn emits(&self) -> bool {
        self.emitted != Rgb::ZERO
    }

    /// Radiance sent out from the front side at `uv`.
    pub fn emitted_at(&self, uv: DVec2) -> Rgb {
        match &self.emission {
            None => self.emitted,
            Some(texture) => self.emitted * texture.lookup(uv),
        }
    }

    /// Radiance of the front if it is the same everywhere, else black.
    pub(crate) fn even_emission(&self) -> Rgb {
        if self.emission.is_some() { Rgb::ZERO } else { self.emitted }
    }

    /// Its textures.
    pub(crate) fn textures(&self) -> Vec<&Texture> {
        let mut all = self.model.textures();
        if let Reflectance::Textured(texture) = &self.diffuse {
            all.push(texture);
        }
        all.extend(&self.emission);
        all.extend(self.normals.iter().map(|normals| &normals.texture));
        all
    }

    /// The same material with other images in place of its own.
    pub fn with_images(&self, change: &impl Fn(&Arc<ColourImage>) -> Arc<ColourImage>) -> Self {
        let mut changed = self.clone();
        changed.each_texture(&mut |texture| texture.image = change(&texture.image));
        changed
    }

    pub(super) fn each_texture(&mut self, visit: &mut dyn FnMut(&mut Texture)) {
        if let Reflectance::Textured(texture) = &mut self.diffuse {
            visit(texture);
        }
        self.emission.iter_mut().for_each(&mut *visit);
        self.normals.iter_mut().for_each(|normals| visit(&mut normals.texture));
        self.model.each_texture(visit);
    }

    /// Checks every part.
    ///
    /// # Errors
    /// [`MaterialError`] names the first part that is out of range.
    pub fn check(&self) -> Result<(), MaterialError> {
        let colour = |part, found| {
            if is_radiance(found) { Ok(()) } else { Err(MaterialError::Colour { part, found }) }
        };
        if let Reflectance::Uniform(rgb) = &self.diffuse {
            colour("diffuse", *rgb)?;
        }
        colour("reflective", self.reflective)?;
        colour("emitted", self.emitted)?;
        if !(0.0..=1.0).contains(&self.roughness) {
            return Err(MaterialError::Roughness { found: self.roughness });
        }
        self.model.check()?;
        match self.textures().into_iter().all(Texture::is_finite) {
            true => Ok(()),
            false => Err(MaterialError::Texture),
        }
    }
}

/// Reflectance of a clear body straight on.
fn facing(ior: f64) -> f64 {
    let r = (ior - 1.0) / (ior + 1.0);
    r * r
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_out_of_range_are_named() {
        assert_eq!(Material::default().check(), Ok(()));
        let rough = Material { roughness: 1.5, ..Material::default() };
        assert_eq!(rough.check(), Err(MaterialError::Roughness { found: 1.5 }));
        let dark = Material { emitted: Rgb::new(1.0, -1.0, 0.0), ..Material::default() };
        let message = dark.check().unwrap_err().to_string();
        assert_eq!(message, "emitted is [1, -1, 0]; channels must be finite and at least 0");
        let nan = Reflectance::Uniform(Rgb::splat(f64::NAN));
        assert!(Material { diffuse: nan, ..Material::default() }.check().is_err());
    }
}
