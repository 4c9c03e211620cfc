//! The inputs of materials: constants, and constants times textures.

use glam::DVec3;
use rilievo::map::NormalConvention;

use super::{Footprint, Texture};
use crate::colour::Rgb;

/// A colour, or a texture tinted by it.
#[derive(Clone, Debug, PartialEq)]
pub struct ColourInput {
    /// The colour where there is no texture; otherwise a factor.
    pub value: Rgb,
    /// An image of colours.
    pub texture: Option<Texture>,
}

impl ColourInput {
    /// The same colour everywhere.
    pub fn uniform(value: Rgb) -> Self {
        Self { value, texture: None }
    }

    /// The mean over a footprint.
    #[inline]
    pub fn at(&self, at: &Footprint) -> Rgb {
        match &self.texture {
            None => self.value,
            Some(texture) => self.value * texture.mean(at),
        }
    }
}

/// Which number of a texel counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// The first; of a grey image the only one.
    #[default]
    Red,
    /// The second.
    Green,
    /// The third.
    Blue,
}

/// A number, or a channel of a texture scaled by it.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberInput {
    /// The number where there is no texture; otherwise a factor.
    pub value: f64,
    /// An image of numbers, and the channel that counts.
    pub texture: Option<(Texture, Channel)>,
    /// Whether 1 minus the texel counts: a map of gloss in place of roughness.
    pub invert: bool,
}

impl NumberInput {
    /// The same number everywhere.
    pub fn uniform(value: f64) -> Self {
        Self { value, texture: None, invert: false }
    }

    /// The mean over a footprint.
    #[inline]
    pub fn at(&self, at: &Footprint) -> f64 {
        let Some((texture, channel)) = &self.texture else { return self.value };
        let texel = texture.mean(at);
        let number = match channel {
            Channel::Red => texel.x,
            Channel::Green => texel.y,
            Channel::Blue => texel.z,
        };
        self.value * if self.invert { 1.0 - number } else { number }
    }
}

/// A map of normals in the tangent space of the surface it lies on.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalInput {
    /// An image whose linear channels are `0.5 + 0.5 n`.
    pub texture: Texture,
    /// Which way green points.
    pub convention: NormalConvention,
    /// Factor on the slope; 1 is as the map says, 0 is flat.
    pub strength: f64,
}

impl NormalInput {
    /// The mean normal over a footprint, before it is made unit: x along u, y along v.
    pub fn at(&self, at: &Footprint) -> DVec3 {
        let n = 2.0 * self.texture.mean(at) - 1.0;
        let y = match self.convention {
            NormalConvention::OpenGl => n.y,
            NormalConvention::DirectX => -n.y,
        };
        DVec3::new(self.strength * n.x, self.strength * y, n.z)
    }
}
