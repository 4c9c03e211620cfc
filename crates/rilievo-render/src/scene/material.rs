//! [`Material`]: how a surface answers light.

use glam::DVec2;

use crate::colour::{Rgb, is_radiance};
use crate::texture::Texture;

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
}

/// The material of a surface. Both sides reflect alike; only the front emits.
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
}

impl Default for Material {
    /// A grey diffuser of reflectance 0.5, without gloss or emission.
    fn default() -> Self {
        Self {
            diffuse: Reflectance::Uniform(Rgb::splat(0.5)),
            reflective: Rgb::ZERO,
            roughness: 0.0,
            emitted: Rgb::ZERO,
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
    /// A texture's tile or shift is NaN or infinite.
    #[error("texture tile and shift must be finite")]
    Texture,
}

impl Material {
    /// Whether the front side sends out light.
    pub fn emits(&self) -> bool {
        self.emitted != Rgb::ZERO
    }

    /// Checks every part.
    ///
    /// # Errors
    /// [`MaterialError`] names the first part that is out of range.
    pub fn check(&self) -> Result<(), MaterialError> {
        let colour = |part, found| {
            if is_radiance(found) { Ok(()) } else { Err(MaterialError::Colour { part, found }) }
        };
        match &self.diffuse {
            Reflectance::Uniform(rgb) => colour("diffuse", *rgb)?,
            Reflectance::Textured(texture) => {
                if !(texture.tile.is_finite() && texture.shift.is_finite()) {
                    return Err(MaterialError::Texture);
                }
            }
        }
        colour("reflective", self.reflective)?;
        colour("emitted", self.emitted)?;
        if !(0.0..=1.0).contains(&self.roughness) {
            return Err(MaterialError::Roughness { found: self.roughness });
        }
        Ok(())
    }
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
