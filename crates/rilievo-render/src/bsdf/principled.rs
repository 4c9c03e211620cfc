//! The principled surface: glTF's metal and roughness with layers of OpenPBR.
//!
//! From the top: a sheen \[Estevez2017\]; a clear coat of index 1.5; then a mixture of metal, of a
//! diffuser \[Portsmouth2025\] under gloss, and of glass. Metal and gloss are one GGX lobe whose
//! reflectance is Schlick's, `F0 + (F90 - F0) (1 - cos)^5`, as in \[Khronos2021\]. A layer lets through
//! to those under it what it does not reflect in all, seen from the view (albedo scaling, as in
//! \[Andersson2024\]); so a white one neither loses nor gains in a white furnace. What several facets
//! reflect is put back \[Turquin2019\].
//!
//! The widths of gloss and coat are at least 1e-3, so that lights that are sampled show in them. With
//! `opacity` below 1 the rest of the light passes straight through.

use glam::{DVec2, DVec3, Vec3};

use super::Drawn;
use super::albedo;
use super::conductor::{reflected, several, width};
use super::diffuse::OrenNayar;
use super::frame::Side;
use super::fresnel::grazing;
use super::glass::GlassLobes;
use super::lost_slopes::{dulled, widened};
use super::microfacet::reflection;
use super::sheen::fibres;
use crate::colour::Rgb;
use crate::sampler::warp;
use crate::scene::Principled;
use crate::texture::Footprint;

/// Smallest width of gloss and coat.
const NARROWEST: f64 = 1e-3;

/// Reflectance of the coat straight on.
const COAT: f64 = 0.04;

/// What lobe is drawn; the order of `PrincipledLobes::share`.
const STRAIGHT: usize = 0;
const COATING: usize = 1;
const GLOSS: usize = 2;
const GLASS: usize = 3;
const DULL: usize = 4;

/// A principled surface at a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct PrincipledLobes {
    /// Weight and width of the coat.
    coat: (f64, f64),
    /// Reflectance of the gloss straight on and at grazing angles, with all weights.
    facing: Rgb,
    edge: Rgb,
    alpha: f64,
    glass: Option<(f64, GlassLobes)>,
    diffuse: OrenNayar,
    /// Colour over its scale, and roughness.
    sheen: (Rgb, f64),
    /// Probabilities to draw each lobe; they add up to 1.
    share: [f32; 5],
    albedo: Vec3,
    /// The share of light that passes straight through.
    open: f64,
}

impl PrincipledLobes {
    pub(super) fn new(model: &Principled, at: &Footprint, (front, view): (bool, DVec3)) -> Self {
        let cosine = view.z;
        let unit = |x: f64| x.clamp(0.0, 1.0);
        let base = model.base_colour.at(at).min(Rgb::ONE);
        let solid = unit(model.opacity.at(at));
        let mut left = solid;

        let mut sheen = (model.sheen.at(at).min(Rgb::ONE), unit(model.sheen_roughness.at(at)));
        let mut sheen_all = Rgb::ZERO;
        if sheen.0 != Rgb::ZERO {
            let all = albedo::sheen_albedo(cosine, sheen.1);
            sheen.0 *= left / all.max(1.0);
            sheen_all = sheen.0 * all;
            left -= sheen_all.max_element();
        }
        let mut coat = (unit(model.coat.at(at)), 0.0);
        let mut coat_all = 0.0;
        if coat.0 > 0.0 {
            let width = widened(width(model.coat_roughness.at(at)), at.lost_slopes);
            coat = (left * coat.0, width.max(NARROWEST));
            let [a, b] = albedo::gloss(cosine, coat.1);
            coat_all = coat.0 * (COAT * a + b);
            left -= coat_all;
        }

        let metal = unit(model.metallic.at(at));
        let clear = (1.0 - metal) * unit(model.transmission.at(at));
        let opaque = 1.0 - metal - clear;
        let rough = widened(width(model.roughness.at(at)), at.lost_slopes);
        let alpha = rough.max(NARROWEST);
        let [a, b] = albedo::gloss(cosine, alpha);
        let (mut facing, mut edge) = (Rgb::ZERO, Rgb::ZERO);
        if metal > 0.0 {
            let several = left * metal * several(base, cosine, alpha);
            facing += several * base;
            edge += several;
        }
        let mut under = Rgb::ZERO;
        if opaque > 0.0 {
            let ior = model.glass.ior();
            let straight = ((ior - 1.0) / (ior + 1.0)).powi(2);
            let weight = unit(model.specular.at(at));
            let f0 = weight * straight * model.specular_colour.at(at).min(Rgb::ONE);
            let several = several(f0, cosine, alpha);
            let gloss = several * (f0 * a + weight * b);
            facing += left * opaque * several * f0;
            edge += left * opaque * weight * several;
            under = left * opaque * (1.0 - gloss.max_element()).max(0.0) * base;
        }
        let glass = (clear > 0.0).then(|| {
            let lobes = match model.thin {
                true => GlassLobes::sheet(model.glass.ior(), base, rough, view),
                false => GlassLobes::of_table(&model.glass, base, rough, (front, view)),
            };
            (left * clear, lobes)
        });
        let roughness = dulled(unit(model.diffuse_roughness.at(at)), at.lost_slopes);
        let diffuse = OrenNayar::new(under, roughness, view);

        let gloss_all = facing * a + edge * b;
        let glass_all = glass.map_or(Rgb::ZERO, |(weight, lobes)| weight * lobes.albedo(view));
        let open = 1.0 - solid;
        let mut share = [
            open,
            coat_all,
            gloss_all.max_element(),
            glass.map_or(0.0, |(weight, _)| weight),
            under.max_element() + sheen_all.max_element(),
        ];
        let total: f64 = share.iter().sum();
        if total > 0.0 {
            share = share.map(|s| s / total);
        }
        let share = share.map(|s| s as f32);
        let albedo = (coat_all + gloss_all + glass_all + under + sheen_all + open).as_vec3();
        Self { coat, facing, edge, alpha, glass, diffuse, sheen, share, albedo, open }
    }

    pub(super) fn albedo(&self) -> Rgb {
        self.albedo.as_dvec3()
    }

    /// The probability to draw a lobe.
    fn share(&self, lobe: usize) -> f64 {
        f64::from(self.share[lobe])
    }

    pub(super) fn transmits(&self) -> bool {
        self.glass.is_some() || self.open > 0.0
    }

    pub(super) fn is_delta(&self) -> bool {
        let glass = self.glass.is_none_or(|(_, lobes)| lobes.is_delta());
        glass && self.share(COATING) + self.share(GLOSS) + self.share(DULL) == 0.0
    }

    pub(super) fn evaluate(&self, view: DVec3, side: &Side) -> (Rgb, f64) {
        let (mut value, mut pdf) = (Rgb::ZERO, 0.0);
        if let Some((weight, lobes)) = &self.glass {
            let (more, density) = lobes.evaluate(view, side);
            value += *weight * more;
            pdf += self.share(GLASS) * density;
        }
        if !side.is_reflection() {
            return (value, pdf);
        }
        for light in side.both() {
            if self.share(GLOSS) > 0.0
                && let Some(met) = reflection(view, light, self.alpha)
            {
                let reflectance = self.facing + (self.edge - self.facing) * grazing(met.cosine);
                value += met.value * reflectance;
                pdf += self.share(GLOSS) * met.pdf;
            }
            if self.share(COATING) > 0.0
                && let Some(met) = reflection(view, light, self.coat.1)
            {
                let reflectance = COAT + (1.0 - COAT) * grazing(met.cosine);
                value += Rgb::splat(self.coat.0 * met.value * reflectance);
                pdf += self.share(COATING) * met.pdf;
            }
        }
        if self.share(DULL) > 0.0 {
            let (more, density) = self.diffuse.evaluate(view, side);
            value += more;
            pdf += self.share(DULL) * density;
            if self.sheen.0 != Rgb::ZERO && density > 0.0 {
                value += side.light.z * fibres(view, side.light, self.sheen.1) * self.sheen.0;
            }
        }
        (value, pdf)
    }

    pub(super) fn sample(&self, view: DVec3, lobe: f64, u: DVec2) -> Option<Drawn> {
        let mut rest = lobe;
        let mut chosen = STRAIGHT;
        while chosen < DULL && rest >= self.share(chosen) {
            rest -= self.share(chosen);
            chosen += 1;
        }
        let share = self.share(chosen);
        if share <= 0.0 {
            return None;
        }
        let gloss = |alpha: f64| {
            let light = reflected(view, alpha, u)?;
            let roughness = alpha.sqrt();
            Some(Drawn { light, delta: None, folds: true, transmitted: false, roughness })
        };
        match (chosen, &self.glass) {
            (STRAIGHT, _) => {
                let delta = Some((Rgb::splat(self.open / share), share));
                Some(Drawn { light: -view, delta, folds: true, transmitted: true, roughness: 0.0 })
            }
            (COATING, _) => gloss(self.coat.1),
            (GLOSS, _) => gloss(self.alpha),
            (GLASS, Some((weight, lobes))) => {
                let lobe = (rest / share).min(1.0 - f64::EPSILON);
                let mut drawn = lobes.sample(view, lobe, u)?;
                drawn.delta = drawn.delta.map(|(w, p)| (*weight / share * w, share * p));
                Some(drawn)
            }
            _ => {
                let light = warp::square_to_hemisphere(u);
                Some(Drawn { light, delta: None, folds: false, transmitted: false, roughness: 1.0 })
            }
        }
    }
}
