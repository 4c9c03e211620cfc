//! [`PixelTracer`]: all samples of a pixel.

use glam::DVec2;
use rilievo::{Counters, Hit, Ray};

use super::aov::{LayerSum, headlight};
use super::distributed::{Distributed, Path};
use super::{Integrator, RayCounts};
use crate::colour::Rgb;
use crate::film::{Aov, PixelMut};
use crate::sampler::{Dimension, PixelTable, Sampler, Strand};
use crate::scene::Scene;

/// Camera rays of a pixel that are traced as one packet.
const PACKET: usize = 16;

/// Traces pixels one after the other and counts their rays.
pub(crate) struct PixelTracer<'a> {
    scene: &'a Scene,
    pixel_centers: bool,
    rays: RayCounts,
    table: PixelTable,
    sums: Vec<LayerSum>,
    packet: Packet,
}

impl<'a> PixelTracer<'a> {
    pub(crate) fn new(scene: &'a Scene, pixel_centers: bool) -> Self {
        let table = PixelTable::new(scene.lights().len());
        let (rays, packet) = (RayCounts::default(), Packet::new());
        Self { scene, pixel_centers, rays, table, sums: Vec::new(), packet }
    }

    /// Rays traced so far.
    pub(crate) fn rays(&self) -> RayCounts {
        self.rays
    }

    /// Takes all samples of `pixel` and writes their means to `out`.
    pub(crate) fn trace(&mut self, pixel: [u32; 2], out: &mut PixelMut<'_>) {
        let settings = self.scene.settings();
        let samples = if self.pixel_centers { 1 } else { u64::from(settings.samples) };
        self.table.start(Sampler::new(settings.seed, pixel));
        self.sums.clear();
        self.sums.resize(out.layers().count(), LayerSum::EMPTY);
        let steps = out.layers().any(|(aov, _)| aov == Aov::Steps);
        let (mut radiance, mut weights) = (Rgb::ZERO, 0.0);
        for first in (0..samples).step_by(PACKET) {
            let strands = (first..samples.min(first + PACKET as u64))
                .map(|index| Strand { index, count: samples });
            self.packet.rays.clear();
            self.packet.weights.clear();
            for strand in strands.clone() {
                let (ray, weight) = self.camera_ray(pixel, strand);
                self.packet.rays.push(ray);
                self.packet.weights.push(weight);
            }
            self.rays.camera += self.packet.rays.len() as u64;
            self.packet.trace(self.scene, steps);
            for (k, strand) in strands.enumerate() {
                let (ray, hit) = (&self.packet.rays[k], self.packet.hits[k].as_ref());
                let weight = self.packet.weights[k];
                weights += weight;
                let seen = match settings.integrator {
                    Integrator::Distributed => {
                        let (table, rays) = (&mut self.table, &mut self.rays);
                        let mut tree = Distributed { scene: self.scene, table, rays };
                        tree.radiance(ray, hit, Path::from_camera(strand))
                    }
                    Integrator::Aov => headlight(self.scene, ray, hit),
                };
                radiance += weight * seen;
                if weight < 0.0 {
                    continue;
                }
                for ((aov, _), sum) in out.layers().zip(&mut self.sums) {
                    sum.add(aov, self.scene, hit, self.packet.work[k]);
                }
            }
        }
        *out.radiance = (radiance / weights).to_array().map(|channel| channel as f32);
        for ((aov, channels), sum) in out.layers().zip(&self.sums) {
            sum.store(aov, channels);
        }
    }

    /// The camera ray of a sample of `pixel`, and the sample's weight.
    fn camera_ray(&mut self, pixel: [u32; 2], strand: Strand) -> (Ray, f64) {
        let mut place = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
        let mut weight = 1.0;
        if !self.pixel_centers {
            let u = self.table.point(Dimension::Pixel, strand);
            let sample = self.scene.settings().filter.sample(strand.index, u);
            (place, weight) = (place + sample.offset, sample.weight);
        }
        (self.scene.camera().ray(place.x, place.y), weight)
    }
}

/// Camera rays of one pixel, and what they meet.
struct Packet {
    rays: Vec<Ray>,
    /// What each counts.
    weights: Vec<f64>,
    hits: [Option<Hit>; PACKET],
    /// Work that each ray took, if it was counted.
    work: [u64; PACKET],
}

impl Packet {
    fn new() -> Self {
        let (rays, weights) = (Vec::with_capacity(PACKET), Vec::with_capacity(PACKET));
        Self { rays, weights, hits: [None; PACKET], work: [0; PACKET] }
    }

    /// Finds all hits; rays whose work is wanted go one by one.
    fn trace(&mut self, scene: &Scene, count: bool) {
        let world = scene.world();
        if !count {
            let hits = &mut self.hits[..self.rays.len()];
            return world.closest_packet(&self.rays, hits, &mut ());
        }
        for (k, ray) in self.rays.iter().enumerate() {
            let mut counters = Counters::default();
            self.hits[k] = world.closest(ray, &mut counters);
            self.work[k] = counters.total();
        }
    }
}
