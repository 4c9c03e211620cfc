//! [`Bsdf`]: a material at one hit, ready to be asked.
//!
//! [`Bsdf::new`] looks every texture up and builds the frame of the shading normal, once a hit;
//! [`Bsdf::evaluate`] and [`Bsdf::sample`] then work on numbers alone, in local coordinates with the
//! shading normal at +z. Nothing is allocated.
//!
//! Two normals: which side a direction lies on is the geometric one's to say, the lobes stand around
//! the shading one (`frame`). A diffuse lobe ends where either plane ends it. What a specular lobe
//! sends to the wrong side of the surface is mirrored back at its plane, so that tilted normals
//! neither lose energy nor leak light.
//!
//! A mix is the sum of both its parts, and directions are drawn from either by its share. To take one
//! part alone, chosen by a hash of the place, costs one evaluation and brings a variance that no
//! light sampling takes away: of a third of rough copper over clay eight times that of the sum.

mod albedo;
mod conductor;
mod diffuse;
mod frame;
mod fresnel;
mod glass;
mod lambert_gloss;
mod lost_slopes;
mod microfacet;
mod part;
mod principled;
mod sheen;

pub use albedo::GlassTable;
pub(crate) use albedo::{gloss_table, sheen_table};
pub(crate) use lost_slopes::widened;

use glam::{DVec2, DVec3};
use rilievo::Hit;

use part::{Drawn, Part};

use crate::colour::Rgb;
use crate::scene::{Material, Model};
use crate::texture::Footprint;

/// A material evaluated at one hit. Directions are unit vectors in world space that point away
/// from the surface.
#[derive(Clone, Copy, Debug)]
pub struct Bsdf {
    first: Part,
    /// What a mix has beside it, with its share, above 0 and below 1.
    second: Option<(Part, f64)>,
}

/// A direction drawn by [`Bsdf::sample`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Where the path goes on.
    pub direction: DVec3,
    /// `f |cos| / pdf`.
    pub weight: Rgb,
    /// Density of `direction`, per steradian, as [`Bsdf::evaluate`] gives it. If `delta`, the
    /// probability of the lobe.
    pub pdf: f64,
    /// Whether the lobe is a single direction, which no light that is sampled can meet.
    pub delta: bool,
    /// Whether the path goes through the surface.
    pub transmitted: bool,
    /// Roughness of the lobe that was drawn: 0 for a mirror, 1 for a diffuser.
    pub roughness: f64,
}

impl Bsdf {
    /// The `material` at `hit`, seen from direction `view`. `footprint` is the width that one
    /// sample covers across the ray at the hit, in scene units; 0 where it is not known. Textures
    /// are averaged over it.
    pub fn new(material: &Material, hit: &Hit, view: DVec3, footprint: f64) -> Self {
        Self::over(material, hit, view, &Footprint::of(hit, footprint))
    }

    /// [`Bsdf::new`] for all that is known of what a sample covers.
    pub fn over(material: &Material, hit: &Hit, view: DVec3, at: &Footprint) -> Self {
        let part = |material| Part::new(chosen(material, hit, at), hit, view, at);
        let Model::Mix(mix) = &material.model else {
            return Self { first: Part::new(material, hit, view, at), second: None };
        };
        let share = mix.share.at(at).clamp(0.0, 1.0);
        match &mix.materials {
            [first, _] if share == 0.0 => Self { first: part(first), second: None },
            [_, second] if share == 1.0 => Self { first: part(second), second: None },
            [first, second] => Self { first: part(first), second: Some((part(second), share)) },
        }
    }

    /// `f |cos|` for light from direction `light`, and the density with which [`Bsdf::sample`]
    /// draws it. Lobes of a single direction count for nothing in either.
    pub fn evaluate(&self, light: DVec3) -> (Rgb, f64) {
        let (value, pdf) = self.first.evaluate(light);
        match &self.second {
            None => (value, pdf),
            Some((second, share)) => {
                let (other, other_pdf) = second.evaluate(light);
                let rest = 1.0 - share;
                (rest * value + *share * other, rest * pdf + share * other_pdf)
            }
        }
    }

    /// Draws a direction by `lobe` in `[0, 1)` and `u` in `[0, 1)^2`; none where the path ends.
    pub fn sample(&self, lobe: f64, u: DVec2) -> Option<Scattered> {
        // Which part it is, and its lobe, by one number.
        let below = 1.0 - f64::EPSILON / 2.0;
        let (part, probability, lobe) = match &self.second {
            None => (&self.first, 1.0, lobe),
            Some((second, share)) if lobe < *share => (second, *share, (lobe / share).min(below)),
            Some((_, share)) => {
                let rest = 1.0 - share;
                (&self.first, rest, ((lobe - share) / rest).clamp(0.0, below))
            }
        };
        let Drawn { light: direction, delta, transmitted, roughness, .. } = part.sample(lobe, u)?;
        let (weight, pdf) = match delta {
            Some((weight, pdf)) => (weight, probability * pdf),
            None => {
                let (value, pdf) = self.evaluate(direction);
                (value / pdf, pdf)
            }
        };
        let kept = pdf > 0.0 && weight.is_finite() && weight != Rgb::ZERO;
        let delta = delta.is_some();
        kept.then_some(Scattered { direction, weight, pdf, delta, transmitted, roughness })
    }

    /// About what share of even light from all sides is sent on to the viewer.
    pub fn albedo(&self) -> Rgb {
        let albedo = self.first.albedo();
        match &self.second {
            None => albedo,
            Some((second, share)) => albedo.lerp(second.albedo(), *share),
        }
    }

    /// Whether light from behind the surface can reach the viewer.
    pub fn transmits(&self) -> bool {
        self.parts().any(Part::transmits)
    }

    /// Whether every lobe is a single direction: light that is sampled adds nothing.
    pub fn is_delta(&self) -> bool {
        self.parts().all(Part::is_delta)
    }

    fn parts(&self) -> impl Iterator<Item = &Part> {
        [Some(&self.first), self.second.as_ref().map(|(part, _)| part)].into_iter().flatten()
    }
}

/// The part that counts at a hit of what is mixed again inside of a mix. It is chosen by a hash of the
/// place, so the choice is that of chance over a pixel, and the same for every thread \[Pharr2023\].
fn chosen<'a>(mut material: &'a Material, hit: &Hit, at: &Footprint) -> &'a Material {
    let place = hit.position.to_array().map(f64::to_bits);
    let mut key = 0x6d69_7865_6400_0000_u64;
    while let Model::Mix(mix) = &material.model {
        for bits in place {
            key = (key ^ bits).wrapping_mul(0x9e37_79b9_7f4a_7c15);
            key ^= key >> 29;
        }
        key = key.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let number = (key >> 11) as f64 / 9_007_199_254_740_992.0;
        material = &mix.materials[usize::from(number < mix.share.at(at))];
    }
    material
}

#[cfg(test)]
mod tests;
