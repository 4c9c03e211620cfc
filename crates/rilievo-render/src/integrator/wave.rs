//! Many camera rays at a time: what is traced for them goes to a [`Tracer`] in waves, the rays of one bounce after the
//! other.
//!
//! The integrators are those of one ray at a time, step by step ([`PathTracer::step`], [`Distributed::grow`]); here
//! they only wait for each other's rays. What a camera ray sees does not depend on which others are on
//! the way, nor on the number of threads: it is added up in the order of its own tree, level by level, so
//! that pictures may be split and continued here too. Paths add up as they do one by one, bit by bit.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use rilievo::Ray;

use super::distributed::{Branch, Distributed};
use super::path::{Answer, PathTracer, Question, Walk};
use super::trees::{Growth, Twig, half};
use super::{Integrator, RayCounts};
use crate::colour::Rgb;
use crate::level_of_detail::Detail;
use crate::sampler::{PixelTable, Sampler, Strand};
use crate::scene::Scene;
use crate::tracer::{CameraRay, RAYS, Seen, ShadowRay, Traced, Tracer};

/// Branches that one thread grows at a time.
const CHUNK: usize = 512;

/// Rays that may come from those of a wave, unless one camera ray has more.
pub(crate) const OFFSPRING: usize = 1 << 20;

/// What is traced, by what: in the full world, without levels of detail.
pub(crate) struct Wave<'a> {
    pub(crate) scene: &'a Scene,
    pub(crate) tracer: &'a dyn Tracer,
    /// Samples that a pixel takes in all.
    pub(crate) samples: u64,
    /// Rays that may come from those of a wave: [`OFFSPRING`]. The answer does not depend on it.
    pub(crate) offspring: usize,
    /// Set to stop.
    pub(crate) cancel: &'a AtomicBool,
}

impl Wave<'_> {
    /// Radiance against camera rays, given what they meet: none where first hits are all that is asked for, and once
    /// cancelled.
    ///
    /// # Errors
    /// What the tracer says.
    pub(crate) fn seen(&self, rays: &[CameraRay], found: &[Traced]) -> Result<Seen, String> {
        let mut seen = Seen::default();
        match self.scene.settings().integrator {
            Integrator::Aov => {}
            Integrator::Path => self.walk(rays, found, &mut seen)?,
            Integrator::Distributed => self.grow(rays, found, &mut seen)?,
        }
        Ok(seen)
    }

    fn is_cancelled(&self) -> bool {
        self.cancel.load(Ordering::Relaxed)
    }

    /// The nearest hits of rays, in order.
    ///
    /// # Errors
    /// What the tracer says.
    pub(crate) fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        if rays.is_empty() {
            return Ok(Vec::new());
        }
        all(rays.len(), self.tracer.closest(rays)?)
    }

    /// Whether shadow rays meet nothing.
    fn free(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        if rays.is_empty() {
            return Ok(Vec::new());
        }
        let occluded = all(rays.len(), self.tracer.occluded(rays)?)?;
        Ok(occluded.into_iter().map(|occluded| !occluded).collect())
    }

    /// All paths at once, from hit to hit.
    fn walk(&self, rays: &[CameraRay], found: &[Traced], seen: &mut Seen) -> Result<(), String> {
        let (paths, world) = (PathTracer::of_camera(self.scene), self.scene.world());
        let mut walks: Vec<Walk> =
            rays.iter().filter_map(|ray| Some(Walk::new(&ray.ray, ray.numbers?))).collect();
        // Those that go on, and what they meet.
        let mut going: Vec<(u32, Traced)> = (0..).zip(found.iter().copied()).collect();
        let mut steps: Vec<Step> = Vec::new();
        while !going.is_empty() && !self.is_cancelled() {
            let take = |(at, met): &(u32, Traced)| {
                let (mut walk, mut step) = (walks[*at as usize], Step::default());
                let ask = |_: &mut Rgb, question| step.question = Some(question);
                let met = (met.hit.as_ref(), Detail::full(world));
                let next = paths.step(&mut walk, met, &mut step.rays, ask);
                (Step { next, ..step }, walk)
            };
            let taken: Vec<(Step, Walk)> = going.par_iter().map(take).collect();
            steps.clear();
            for ((at, _), (step, walk)) in going.iter().zip(taken) {
                walks[*at as usize] = walk;
                seen.rays += step.rays;
                steps.push(step);
            }
            self.settle(&steps, &mut going, |at, question, answer| {
                walks[at as usize].radiance += paths.brought(world, question, answer);
            })?;
        }
        seen.radiance = walks.into_iter().map(|walk| walk.radiance).collect();
        Ok(())
    }

    /// Traces what the paths that go on ask for; leaves those that go on further, and what they meet.
    fn settle(
        &self,
        steps: &[Step],
        going: &mut Vec<(u32, Traced)>,
        mut add: impl FnMut(u32, &Question, Answer),
    ) -> Result<(), String> {
        let (mut shadows, mut rays, mut next) = (Vec::new(), Vec::new(), Vec::new());
        for ((at, _), step) in going.iter().zip(steps) {
            match &step.question {
                Some(Question::Free { shadow, .. }) => shadows.push(*shadow),
                Some(Question::Aimed { ray, .. }) => rays.push(*ray),
                None => {}
            }
            next.extend(step.next.map(|_| *at));
        }
        let aimed = rays.len();
        rays.extend(steps.iter().filter_map(|step| step.next));
        let (free, found) = (self.free(&shadows)?, self.closest(&rays)?);
        let (mut free, mut met) = (free.into_iter(), found[..aimed].iter());
        for ((at, _), step) in going.iter().zip(steps) {
            let Some(question) = &step.question else { continue };
            let answer = match question {
                Question::Free { .. } => Answer::Free(free.next() == Some(true)),
                Question::Aimed { .. } => Answer::Met(met.next().and_then(|found| found.hit)),
            };
            add(*at, question, answer);
        }
        *going = next.into_iter().zip(found[aimed..].iter().copied()).collect();
        Ok(())
    }

    /// All trees, level by level.
    fn grow(&self, rays: &[CameraRay], found: &[Traced], seen: &mut Seen) -> Result<(), String> {
        seen.radiance.resize(rays.len(), Rgb::ZERO);
        let settings = self.scene.settings();
        let shadows = self.scene.lights().len() as u64 * u64::from(settings.shadow_samples);
        let bounces = u64::from(settings.glossy_samples) + u64::from(settings.diffuse_samples);
        let most =
            (self.offspring as u64 / shadows.max(bounces).max(1)).clamp(1, RAYS as u64) as usize;
        for first in (0..rays.len()).step_by(most) {
            let some = first..rays.len().min(first + most);
            let roots = some.clone().map(|at| {
                let strand = Strand { index: rays[at].index, count: self.samples };
                Twig { root: at, branch: Branch::root(rays[at].ray, strand) }
            });
            let roots: Vec<Twig> = roots.collect();
            let mut groups = vec![self.level(&roots, &found[some], rays, seen)?];
            while let Some(mut twigs) = groups.pop() {
                if twigs.is_empty() || self.is_cancelled() {
                    continue;
                }
                if let Some(half) = half(&twigs, most) {
                    let rest = twigs.split_off(half);
                    groups.extend([rest, twigs]);
                    continue;
                }
                let asked: Vec<Ray> = twigs.iter().map(|twig| twig.branch.ray).collect();
                let found = self.closest(&asked)?;
                groups.push(self.level(&twigs, &found, rays, seen)?);
            }
        }
        Ok(())
    }

    /// Shades what branches meet; returns those that grow from there, camera ray by camera ray.
    fn level(
        &self,
        twigs: &[Twig],
        found: &[Traced],
        rays: &[CameraRay],
        seen: &mut Seen,
    ) -> Result<Vec<Twig>, String> {
        let lights = self.scene.lights().len();
        let grow = |(twigs, found): (&[Twig], &[Traced])| {
            let (mut table, mut pixel) = (PixelTable::new(lights), None);
            let (mut growth, mut counts) = (Growth::default(), RayCounts::default());
            for (twig, traced) in twigs.iter().zip(found) {
                let at = rays[twig.root].pixel;
                if pixel != Some(at) {
                    table.start(Sampler::new(self.scene.settings().seed, at));
                    pixel = Some(at);
                }
                growth.root = twig.root;
                let (table, rays) = (&mut table, &mut counts);
                let detail = Detail::full(self.scene.world());
                let mut tree = Distributed { scene: self.scene, detail, table, rays };
                tree.grow(&twig.branch, traced.hit.as_ref(), &mut growth);
            }
            (growth, counts)
        };
        let grown: Vec<(Growth, RayCounts)> =
            twigs.par_chunks(CHUNK).zip(found.par_chunks(CHUNK)).map(grow).collect();
        let shadows: Vec<ShadowRay> =
            grown.iter().flat_map(|(growth, _)| growth.shadow_rays()).collect();
        let free = self.free(&shadows)?;
        let (mut free, mut next) = (free.into_iter(), Vec::new());
        for (mut growth, counts) in grown {
            seen.rays += counts;
            growth.settle(&mut free, &mut seen.radiance);
            next.extend(growth.twigs);
        }
        Ok(next)
    }
}

/// As many answers as rays.
fn all<T>(asked: usize, found: Vec<T>) -> Result<Vec<T>, String> {
    match found.len() == asked {
        true => Ok(found),
        false => Err(format!("{} answers to {asked} rays", found.len())),
    }
}

/// What a path asks for next.
#[derive(Clone, Copy, Default)]
struct Step {
    question: Option<Question>,
    next: Option<Ray>,
    rays: RayCounts,
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use rilievo::surface::{Quad, Sphere, World};

    use super::*;
    use crate::integrator::PixelTracer;
    use crate::scene::{Camera, CameraParts, Material, Reflectance, SceneParts};

    /// Two glossy balls between two lamps: trees of many branches, which split at every hit.
    fn scene() -> Scene {
        let plate = |z: f64, side: f64| {
            let corners = [[-side, -1.0], [side, -1.0], [side, 1.0], [-side, 1.0]];
            Quad::new(corners.map(|[x, y]| DVec3::new(x, y, z)), false).unwrap().into()
        };
        let ball = |x: f64| Sphere::new(DVec3::new(x, 0.0, 0.0), 0.6).unwrap().into();
        let grey = Reflectance::Uniform(Rgb::splat(0.5));
        let gloss = Material { diffuse: grey, reflective: Rgb::splat(0.4), ..Material::default() };
        let lamp = Material { emitted: Rgb::ONE, ..Material::default() };
        let camera = CameraParts {
            position: DVec3::new(0.0, -4.0, 0.2),
            look_at: DVec3::ZERO,
            up: DVec3::Z,
            fov: 40.0,
            resolution: [6, 4],
        };
        let settings = crate::RenderSettings {
            integrator: Integrator::Distributed,
            samples: 2,
            max_depth: 5,
            diffuse_samples: 3,
            shadow_samples: 2,
            ..Default::default()
        };
        Scene::new(SceneParts {
            world: World::new(vec![ball(-0.7), ball(0.7), plate(1.0, -1.0), plate(-1.0, 1.0)]),
            materials: vec![Material { roughness: 0.5, ..gloss.clone() }, gloss, lamp],
            material_of: vec![0, 1, 2, 2],
            camera: Camera::new(camera).unwrap(),
            background: Rgb::new(0.1, 0.2, 0.3),
            ambient: Rgb::ZERO,
            settings,
        })
        .unwrap()
    }

    #[test]
    fn how_many_rays_go_out_at_a_time_changes_no_bit() {
        let scene = scene();
        let mut rays = Vec::new();
        let mut tracer = PixelTracer::new(&scene, false);
        for pixel in 0..24 {
            tracer.camera_rays([pixel % 6, pixel / 6], [0, 2], &mut rays);
        }
        let asked: Vec<Ray> = rays.iter().map(|ray| ray.ray).collect();
        let cancel = AtomicBool::new(false);
        let seen = |offspring| {
            let tracer = scene.world();
            let wave = Wave { scene: &scene, tracer, samples: 2, offspring, cancel: &cancel };
            let found = wave.closest(&asked).unwrap();
            wave.seen(&rays, &found).unwrap()
        };
        let all = seen(OFFSPRING);
        let lit = all.radiance.iter().filter(|rgb| **rgb != Rgb::ZERO).count();
        assert!(lit > 0 && all.rays.diffuse > 0, "{lit} lit, {:?}", all.rays);
        for offspring in [0, 50, 1000] {
            let few = seen(offspring);
            assert!(few.radiance == all.radiance && few.rays == all.rays, "{offspring}");
        }
    }
}
