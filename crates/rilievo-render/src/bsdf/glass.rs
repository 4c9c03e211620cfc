//! Clear bodies and clear sheets.
//!
//! A body reflects and refracts at GGX facets \[Walter2007\]; both lobes are divided by the share that
//! single facets send on ([`GlassTable`](super::GlassTable)), so no light is lost \[Turquin2019\].
//! What goes through is radiance, so it is over the square of the index. The front is outside.
//!
//! A sheet has two such faces and no thickness: with all reflections between them it reflects
//! `2 F / (1 + F)` and lets the rest straight through; a rough one lets through the mirror
//! image of the lobe that it reflects.

use glam::{DVec2, DVec3};

use super::Drawn;
use super::albedo;
use super::conductor::{reflected, width};
use super::frame::Side;
use super::fresnel::clear;
use super::lost_slopes::widened;
use super::microfacet::{SMOOTH, reflection, refraction, transmitted};
use crate::colour::Rgb;
use crate::sampler::warp;
use crate::scene::{Glass, ThinGlass};
use crate::texture::Footprint;

/// A clear body or sheet at a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct GlassLobes {
    /// Factor on what goes through.
    colour: Rgb,
    /// The index there over that here; of a sheet the index in it.
    eta: f64,
    alpha: f64,
    /// Factor that puts back what several facets send on.
    several: f64,
    sheet: bool,
}

/// Indices nearer to 1 than this bend nothing.
const NO_INDEX: f64 = 1e-6;

impl GlassLobes {
    pub(super) fn body(model: &Glass, at: &Footprint, (front, view): (bool, DVec3)) -> Self {
        let alpha = widened(width(model.roughness.at(at)), at.lost_slopes);
        let mut lobes = Self::of_table(&model.table, model.colour.at(at), alpha, (front, view));
        if !model.compensated {
            lobes.several = 1.0;
        }
        lobes
    }

    pub(super) fn of_table(
        table: &super::GlassTable,
        colour: Rgb,
        alpha: f64,
        (front, view): (bool, DVec3),
    ) -> Self {
        let eta = if front { table.ior() } else { 1.0 / table.ior() };
        // Without an index facets turn nothing.
        let alpha = if (eta - 1.0).abs() < NO_INDEX { 0.0 } else { alpha };
        let several = if alpha < SMOOTH { 1.0 } else { 1.0 / table.at(front, view.z, alpha) };
        Self { colour, eta, alpha, several, sheet: false }
    }

    pub(super) fn thin(model: &ThinGlass, at: &Footprint, view: DVec3) -> Self {
        let alpha = widened(width(model.roughness.at(at)), at.lost_slopes);
        Self::sheet(model.ior, model.colour.at(at), alpha, view)
    }

    pub(super) fn sheet(eta: f64, colour: Rgb, alpha: f64, view: DVec3) -> Self {
        let several = match alpha < SMOOTH {
            true => 1.0,
            false => 1.0 / albedo::gloss(view.z, alpha).iter().sum::<f64>(),
        };
        // An index below 1 would reflect all at grazing angles: what is in a sheet comes out again.
        Self { colour, eta: eta.max(1.0 / eta), alpha, several, sheet: true }
    }

    /// The share that a facet reflects, and the cosine inside.
    #[inline]
    fn share(&self, cosine: f64) -> (f64, f64) {
        let (once, inside) = clear(cosine, self.eta);
        if self.sheet { (2.0 * once / (1.0 + once), inside) } else { (once, inside) }
    }

    pub(super) fn albedo(&self, view: DVec3) -> Rgb {
        let (share, _) = self.share(view.z);
        share + (1.0 - share) * self.colour
    }

    pub(super) fn is_delta(&self) -> bool {
        self.alpha < SMOOTH
    }

    pub(super) fn evaluate(&self, view: DVec3, side: &Side) -> (Rgb, f64) {
        let (mut value, mut pdf) = (Rgb::ZERO, 0.0);
        if self.is_delta() {
            return (value, pdf);
        }
        for light in side.both() {
            if side.is_reflection() {
                if let Some(met) = reflection(view, light, self.alpha) {
                    let (share, _) = self.share(met.cosine);
                    value += Rgb::splat(self.several * share * met.value);
                    pdf += share * met.pdf;
                }
                continue;
            }
            let (met, scale) = match self.sheet {
                true => (reflection(view, light.with_z(-light.z), self.alpha), 1.0),
                false => {
                    (refraction(view, light, self.alpha, self.eta), 1.0 / (self.eta * self.eta))
                }
            };
            if let Some(met) = met {
                let through = 1.0 - self.share(met.cosine).0;
                value += (self.several * through * met.value * scale) * self.colour;
                pdf += through * met.pdf;
            }
        }
        (value, pdf)
    }

    /// `lobe` in `[0, 1)` chooses between reflection and transmission.
    pub(super) fn sample(&self, view: DVec3, lobe: f64, u: DVec2) -> Option<Drawn> {
        let smooth = self.is_delta();
        let roughness = self.alpha.sqrt();
        let facet =
            if smooth { DVec3::Z } else { warp::square_to_visible_normal(u, view, self.alpha) };
        let cosine = view.dot(facet);
        let (share, inside) = self.share(cosine);
        if lobe < share {
            let light = if smooth { reflected(view, 0.0, u)? } else { 2.0 * cosine * facet - view };
            let delta = smooth.then_some((Rgb::ONE, share));
            return (light.z > 0.0).then_some(Drawn {
                light,
                delta,
                folds: true,
                transmitted: false,
                roughness,
            });
        }
        let (light, scale) = if self.sheet {
            let up = 2.0 * cosine * facet - view;
            (up.with_z(-up.z), 1.0)
        } else {
            (transmitted(view, facet, (cosine, inside), self.eta), 1.0 / (self.eta * self.eta))
        };
        let delta = smooth.then_some((scale * self.colour, 1.0 - share));
        let light = light.normalize();
        (light.z < 0.0).then_some(Drawn { light, delta, folds: true, transmitted: true, roughness })
    }
}
