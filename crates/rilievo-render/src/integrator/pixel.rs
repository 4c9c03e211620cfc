//! [`PixelTracer`]: all samples of a pixel.

use glam::DVec2;
use rilievo::{Counters, Hit, Ray};

use super::aov::{LayerSum, headlight};
use super::distributed::{Distributed, Path};
use super::{Integrator, RayCounts};
use crate::colour::Rgb;
use crate::film::{Aov, PixelMut};
use crate::sampler::{Dimension, Sampler, Strand};
use crate::scene::Scene;

/// Traces pixels one after the other and counts their rays.
pub(crate) struct PixelTracer<'a> {
    scene: &'a Scene,
    pixel_centers: bool,
    rays: RayCounts,
    sums: Vec<LayerSum>,
}

impl<'a> PixelTracer<'a> {
    pub(crate) fn new(scene: &'a Scene, pixel_centers: bool) -> Self {
        Self { scene, pixel_centers, rays: RayCounts::default(), sums: Vec::new() }
    }

    /// Rays traced so far.
    pub(crate) fn rays(&self) -> RayCounts {
        self.rays
    }

    /// Takes all samples of `pixel` and writes their means to `out`.
    pub(crate) fn trace(&mut self, pixel: [u32; 2], out: &mut PixelMut<'_>) {
        let settings = self.scene.settings();
        let samples = if self.pixel_centers { 1 } else { u64::from(settings.samples) };
        let sampler = Sampler::new(settings.seed, pixel);
        let strata = sampler.strata(Dimension::Pixel, samples);
        let center = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
        self.sums.clear();
        self.sums.resize(out.layers().count(), LayerSum::EMPTY);
        let steps = out.layers().any(|(aov, _)| aov == Aov::Steps);
        let mut radiance = Rgb::ZERO;
        for index in 0..samples {
            let place = if self.pixel_centers {
                center
            } else {
                center + settings.filter.sample(strata.point(index))
            };
            let ray = self.scene.camera().ray(place.x, place.y);
            self.rays.camera += 1;
            let (hit, work) = self.first_hit(&ray, steps);
            radiance += match settings.integrator {
                Integrator::Distributed => {
                    let path = Path::from_camera(Strand { index, count: samples });
                    Distributed::new(self.scene, sampler, &mut self.rays).radiance(
                        &ray,
                        hit.as_ref(),
                        path,
                    )
                }
                Integrator::Aov => headlight(self.scene, &ray, hit.as_ref()),
            };
            for ((aov, _), sum) in out.layers().zip(&mut self.sums) {
                sum.add(aov, self.scene, hit.as_ref(), work);
            }
        }
        *out.radiance = (radiance / samples as f64).to_array().map(|channel| channel as f32);
        for ((aov, channels), sum) in out.layers().zip(&self.sums) {
            sum.store(aov, channels);
        }
    }

    /// What a ray meets, and the work it took if that is wanted.
    fn first_hit(&self, ray: &Ray, count: bool) -> (Option<Hit>, u64) {
        let world = self.scene.world();
        if count {
            let mut counters = Counters::default();
            let hit = world.closest(ray, &mut counters);
            (hit, counters.total())
        } else {
            (world.closest(ray, &mut ()), 0)
        }
    }
}
