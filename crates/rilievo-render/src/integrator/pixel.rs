//! [`PixelTracer`]: all samples of a pixel.

use std::ops::Range;

use glam::DVec2;
use rilievo::{Coherence, Counters, Hit, Ray};

use super::aov::{LayerSum, headlight, layer_value};
use super::distributed::Branch;
use super::path::PathTracer;
use super::trees::{Room, Trees};
use super::{Integrator, RayCounts};
use crate::colour::Rgb;
use crate::film::sums::PixelSums;
use crate::film::{Aov, PixelMut};
use crate::level_of_detail::{Cone, Detail, LevelOfDetail};
use crate::sampler::{Dimension, PathSampler, PixelTable, Sampler, Strand};
use crate::scene::Scene;
use crate::tracer::{CameraRay, Traced};

/// Camera rays of a pixel that are traced as one packet.
const PACKET: usize = 16;

/// Traces pixels one after the other and counts their rays.
pub(crate) struct PixelTracer<'a> {
    scene: &'a Scene,
    pixel_centers: bool,
    rays: RayCounts,
    table: PixelTable,
    /// For the path integrator.
    paths: Option<PathTracer<'a>>,
    sums: Vec<LayerSum>,
    packet: Packet,
    /// Coarser worlds, and how wide camera rays are.
    levels: Option<(&'a LevelOfDetail, Cone)>,
    /// For the trees of the packet in hand.
    room: Room,
    /// What the next camera rays meet and see, if that was found elsewhere.
    answers: Option<Answers<'a>>,
}

/// What was found elsewhere of the camera rays to come.
struct Answers<'a> {
    found: std::slice::Iter<'a, Traced>,
    /// Radiance; none where first hits say it all.
    seen: std::slice::Iter<'a, Rgb>,
}

impl<'a> PixelTracer<'a> {
    pub(crate) fn new(scene: &'a Scene, pixel_centers: bool) -> Self {
        let table = PixelTable::new(scene.lights().len());
        let (rays, packet) = (RayCounts::default(), Packet::new());
        let paths =
            (scene.settings().integrator == Integrator::Path).then(|| PathTracer::of_camera(scene));
        let cone = Cone::of(scene.camera(), scene.settings().lod);
        let levels = scene.level_of_detail().map(|levels| (levels, cone));
        let (sums, room, answers) = (Vec::new(), Room::default(), None);
        Self { scene, pixel_centers, rays, table, paths, sums, packet, levels, room, answers }
    }

    /// A tracer whose camera rays were traced elsewhere: those of [`PixelTracer::camera_rays`], pixel by
    /// pixel. What they see is worked out from first hits where `seen` is empty.
    pub(crate) fn with_answers(self, found: &'a [Traced], seen: &'a [Rgb]) -> Self {
        Self { answers: Some(Answers { found: found.iter(), seen: seen.iter() }), ..self }
    }

    /// Rays traced so far.
    pub(crate) fn rays(&self) -> RayCounts {
        self.rays
    }

    /// Samples that a pixel takes in all.
    pub(crate) fn samples(&self) -> u64 {
        if self.pixel_centers { 1 } else { u64::from(self.scene.settings().samples) }
    }

    /// Appends the camera rays of samples of `pixel`, from the first of two absolute indices up to the
    /// second.
    pub(crate) fn camera_rays(
        &mut self,
        pixel: [u32; 2],
        range: [u32; 2],
        rays: &mut Vec<CameraRay>,
    ) {
        self.table.start(Sampler::new(self.scene.settings().seed, pixel));
        let [first, end] = range.map(u64::from);
        for first in (first..end).step_by(PACKET) {
            self.aim(pixel, [first, end]);
            for (k, (index, ray)) in (first..).zip(&self.packet.rays).enumerate() {
                let numbers = self.packet.numbers.get(k).copied();
                rays.push(CameraRay { ray: *ray, pixel, index, numbers });
            }
        }
    }

    /// Takes all samples of `pixel` and writes their means to `out`.
    pub(crate) fn trace(&mut self, pixel: [u32; 2], out: &mut PixelMut<'_>) {
        let samples = self.samples();
        self.table.start(Sampler::new(self.scene.settings().seed, pixel));
        self.sums.clear();
        self.sums.resize(out.layers().count(), LayerSum::EMPTY);
        let steps = out.layers().any(|(aov, _)| aov == Aov::Steps);
        let (mut radiance, mut weights) = (Rgb::ZERO, 0.0);
        for first in (0..samples).step_by(PACKET) {
            self.shoot(pixel, [first, samples], steps);
            self.look(first);
            for k in 0..self.packet.rays.len() {
                let weight = self.packet.weights[k];
                weights += weight;
                radiance += weight * self.packet.seen[k];
                if weight < 0.0 {
                    continue;
                }
                let (hit, work) = (self.packet.hits[k].as_ref(), self.packet.work[k]);
                for ((aov, _), sum) in out.layers().zip(&mut self.sums) {
                    sum.add(aov, self.scene, hit, work);
                }
            }
        }
        *out.radiance = (radiance / weights).to_array().map(|channel| channel as f32);
        for ((aov, channels), sum) in out.layers().zip(&self.sums) {
            sum.store(aov, channels);
        }
    }

    /// Adds the samples of `pixel` from the first of two absolute indices up to the second.
    pub(crate) fn extend(&mut self, pixel: [u32; 2], range: [u32; 2], sums: &mut PixelSums<'_>) {
        self.table.start(Sampler::new(self.scene.settings().seed, pixel));
        let steps = sums.aovs().contains(&Aov::Steps);
        let [first, end] = range.map(u64::from);
        for first in (first..end).step_by(PACKET) {
            self.shoot(pixel, [first, end], steps);
            self.look(first);
            for k in 0..self.packet.rays.len() {
                let weight = self.packet.weights[k];
                sums.add(self.packet.seen[k], weight);
                if weight > 0.0 {
                    let (hit, work) = (self.packet.hits[k].as_ref(), self.packet.work[k]);
                    sums.add_layers(hit.is_some(), |aov| layer_value(aov, self.scene, hit, work));
                }
            }
        }
    }

    /// Finds what the camera rays of one packet of samples meet: those of absolute index `first` and
    /// after, but not of `end` and beyond.
    fn shoot(&mut self, pixel: [u32; 2], range: [u64; 2], steps: bool) {
        self.aim(pixel, range);
        self.rays.camera += self.packet.rays.len() as u64;
        match &mut self.answers {
            Some(answers) => self.packet.take(&mut answers.found),
            None => self.packet.trace(self.scene, steps),
        }
        if let Some((levels, cone)) = &self.levels {
            self.packet.coarsen(levels, cone, steps);
        }
    }

    /// Makes the camera rays of one packet.
    fn aim(&mut self, pixel: [u32; 2], [first, end]: [u64; 2]) {
        let (count, settings) = (self.samples(), self.scene.settings());
        self.packet.rays.clear();
        self.packet.weights.clear();
        self.packet.numbers.clear();
        self.packet.level_numbers.clear();
        for index in first..end.min(first + PACKET as u64) {
            let mut numbers = self
                .paths
                .as_ref()
                .map(|_| PathSampler::new(settings.sampler, settings.seed, pixel, index, count));
            let u = match (self.pixel_centers, &mut numbers) {
                (true, _) => None,
                (false, Some(numbers)) => Some(CameraNumbers::of(self.scene, |_| numbers.two())),
                (false, None) => {
                    let (table, strand) = (&mut self.table, Strand { index, count });
                    Some(CameraNumbers::of(self.scene, |what| table.point(what, strand)))
                }
            };
            self.packet.level_numbers.push(u.as_ref().map_or(0.5, |numbers| numbers.level));
            let (ray, weight) = self.camera_ray(pixel, index, u);
            self.packet.rays.push(ray);
            self.packet.weights.push(weight);
            self.packet.numbers.extend(numbers);
        }
    }

    /// Finds the radiance that comes against the camera rays of a packet that begins with sample `first`.
    fn look(&mut self, first: u64) {
        let rays = self.packet.rays.len();
        self.packet.seen[..rays].fill(Rgb::ZERO);
        if let Some(answers) = self.answers.as_mut().filter(|answers| answers.seen.len() > 0) {
            for (seen, answer) in self.packet.seen[..rays].iter_mut().zip(&mut answers.seen) {
                *seen = *answer;
            }
            return;
        }
        match (self.scene.settings().integrator, &self.paths) {
            (Integrator::Path, Some(paths)) => {
                for k in 0..rays {
                    let (ray, hit) = (&self.packet.rays[k], self.packet.hits[k].as_ref());
                    let (met, numbers) = ((hit, self.detail(k)), self.packet.numbers[k]);
                    self.packet.seen[k] = paths.radiance(ray, met, numbers, &mut self.rays);
                }
            }
            (Integrator::Distributed, _) if self.levels.is_none() => self.grow(first, 0..rays),
            // Each in a world of its own.
            (Integrator::Distributed, _) => (0..rays).for_each(|k| self.grow(first, k..k + 1)),
            (Integrator::Aov | Integrator::Path, _) => {
                for k in 0..rays {
                    let (ray, hit) = (&self.packet.rays[k], self.packet.hits[k].as_ref());
                    self.packet.seen[k] = headlight(self.scene, ray, hit);
                }
            }
        }
    }

    /// The world that camera ray `k` of the packet goes on in.
    fn detail(&self, k: usize) -> Detail<'a> {
        let world = self.scene.world();
        match &self.levels {
            Some((levels, _)) => levels.detail(world, self.packet.levels[k]),
            None => Detail::full(world),
        }
    }

    /// Grows the trees of some camera rays of the packet, which go on in the same world.
    fn grow(&mut self, first: u64, some: Range<usize>) {
        let (count, detail) = (self.samples(), self.detail(some.start));
        let Self { scene, table, rays, room, packet, .. } = self;
        let strands = (first + some.start as u64..).map(|index| Strand { index, count });
        let roots = packet.rays[some.clone()].iter().zip(strands);
        let roots = roots.map(|(ray, strand)| Branch::root(*ray, strand));
        let mut trees = Trees { scene, detail, table, rays, room };
        trees.grow(roots, &packet.hits[some.clone()], &mut packet.seen[some]);
    }

    /// The camera ray of sample `index` of `pixel`, at its centre or where `numbers` say, and the
    /// sample's weight.
    fn camera_ray(
        &self,
        pixel: [u32; 2],
        index: u64,
        numbers: Option<CameraNumbers>,
    ) -> (Ray, f64) {
        let camera = self.scene.camera();
        let place = DVec2::new(f64::from(pixel[0]) + 0.5, f64::from(pixel[1]) + 0.5);
        let Some(CameraNumbers { filter, lens, time, .. }) = numbers else {
            return (camera.ray(place.x, place.y), 1.0);
        };
        let sample = self.scene.settings().filter.sample(index, filter);
        let place = place + sample.offset;
        (camera.sample(place.x, place.y, lens, time), sample.weight)
    }
}

/// What a camera ray depends on, beside its pixel.
struct CameraNumbers {
    filter: DVec2,
    lens: DVec2,
    time: f64,
    /// Decides between two levels of detail.
    level: f64,
}

impl CameraNumbers {
    /// As many numbers as a scene asks for: a pinhole where nothing moves needs those of the filter
    /// only.
    fn of(scene: &Scene, mut draw: impl FnMut(Dimension) -> DVec2) -> Self {
        let filter = draw(Dimension::Pixel);
        let lens =
            if scene.camera().has_lens() { draw(Dimension::Lens) } else { DVec2::splat(0.5) };
        let time = if scene.moves() { draw(Dimension::Time).x } else { 0.0 };
        let levels = scene.settings().lod > 0.0;
        let level = if levels { draw(Dimension::Level).x } else { 0.0 };
        Self { filter, lens, time, level }
    }
}

/// Camera rays of one pixel, and what they meet.
struct Packet {
    rays: Vec<Ray>,
    /// What each counts.
    weights: Vec<f64>,
    /// The numbers of each ray's path, if there are paths.
    numbers: Vec<PathSampler>,
    /// The number of each ray that decides between two levels of detail.
    level_numbers: Vec<f64>,
    /// The level of each hit, 0 for the full world.
    levels: [usize; PACKET],
    hits: [Option<Hit>; PACKET],
    /// Radiance against each.
    seen: [Rgb; PACKET],
    /// Work that each ray took, if it was counted.
    work: [u64; PACKET],
}

impl Packet {
    fn new() -> Self {
        Self {
            rays: Vec::with_capacity(PACKET),
            weights: Vec::with_capacity(PACKET),
            numbers: Vec::with_capacity(PACKET),
            level_numbers: Vec::with_capacity(PACKET),
            levels: [0; PACKET],
            hits: [None; PACKET],
            seen: [Rgb::ZERO; PACKET],
            work: [0; PACKET],
        }
    }

    /// Takes the next answers as those of its rays.
    fn take(&mut self, found: &mut std::slice::Iter<'_, Traced>) {
        for (k, Traced { hit, work }) in found.take(self.rays.len()).enumerate() {
            (self.hits[k], self.work[k]) = (*hit, *work);
        }
    }

    /// Goes over to what its rays meet at the level of detail that their hits ask for.
    fn coarsen(&mut self, levels: &LevelOfDetail, cone: &Cone, count: bool) {
        for (k, ray) in self.rays.iter().enumerate() {
            self.levels[k] = 0;
            let Some(hit) = &mut self.hits[k] else { continue };
            let width = (cone, self.level_numbers[k]);
            if count {
                let mut counters = Counters::default();
                (*hit, self.levels[k]) = levels.choose(ray, *hit, width, &mut counters);
                self.work[k] += counters.total();
            } else {
                (*hit, self.levels[k]) = levels.choose(ray, *hit, width, &mut ());
            }
        }
    }

    /// Finds all hits; rays whose work is wanted go one by one.
    fn trace(&mut self, scene: &Scene, count: bool) {
        let world = scene.world();
        if !count {
            let hits = &mut self.hits[..self.rays.len()];
            return world.closest_each((&self.rays, Coherence::Coherent), hits, &mut ());
        }
        for (k, ray) in self.rays.iter().enumerate() {
            let mut counters = Counters::default();
            self.hits[k] = world.closest(ray, &mut counters);
            self.work[k] = counters.total();
        }
    }
}
