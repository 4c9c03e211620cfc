//! The path tracer: one path a camera ray, \[Kajiya1986\] with next event estimation.
//!
//! At every hit one point of a light is sampled and one direction of the material. Both can find the
//! same light, so each is weighed by the power heuristic of the two densities \[Veach1995\]: the
//! weights of one direction add up to 1, and what only one of them can find (a light without extent, a
//! mirror, an emitter that is not sampled) counts in full. The estimate has the right mean whatever
//! the lights and the materials.
//!
//! `max_depth` bounds the bounces that reflect light other than that of emitters: 0 is emission and
//! direct light. All ways of direct light count, so with 0 an emitter still shows in a mirror; a path
//! has at most `max_depth + 2` edges. From the third bounce on a path is cut short by Russian
//! roulette, with a probability of going on that follows what it can still bring.
//!
//! `ambient` adds to no path: it stands for the light that the paper's integrator leaves out.
//!
//! Rays start by [`Hit::spawn`], on the side of the geometric normal; the two normals are the
//! material's business ([`Bsdf`]). Nothing recurses and nothing is allocated.
//!
//! A path is a [`Walk`], which is taken from hit to hit ([`PathTracer::step`]); who takes the steps traces the rays: one
//! path after the other ([`PathTracer::radiance`]), or a ray of each of many paths at a time (`wave.rs`).

#[cfg(test)]
mod tests;

use glam::DVec3;
use rilievo::surface::World;
use rilievo::{Hit, Ray};

use super::RayCounts;
use crate::bsdf::Bsdf;
use crate::colour::Rgb;
use crate::level_of_detail::Detail;
use crate::light::{Aim, Drawn, Lighting, Receiver};
use crate::sampler::PathSampler;
use crate::scene::Scene;
use crate::texture::Footprint;
use crate::tracer::ShadowRay;

/// Bounces before Russian roulette begins.
const SAFE: u32 = 2;

/// Least probability with which roulette ends a path. Without it a white furnace never ends.
const LEAST_END: f64 = 0.05;

/// The part of a pixel's width that one sample covers, for textures: as with 16 samples a pixel, however
/// many there are, so that more of them only add to what others took. Level of detail may ask for more.
const SAMPLE: f64 = 0.25;

/// Width of a camera ray's share of the picture, scene units per unit of distance.
pub(crate) fn spread(scene: &Scene) -> f64 {
    SAMPLE.max(scene.settings().lod) * scene.camera().pixel_angle()
}

/// Traces paths of one scene.
pub(super) struct PathTracer<'a> {
    scene: &'a Scene,
    lighting: &'a Lighting,
    /// Width of a camera ray's share of the picture, scene units per unit of distance.
    spread: f64,
    max_depth: u32,
    /// Whether there is more than one light.
    chooses: bool,
    /// Largest channel of what a bounce may bring; infinite where nothing is clamped.
    clamp: f64,
}

/// How the ray in hand was scattered.
#[derive(Clone, Copy)]
struct Scattered {
    at: Receiver,
    /// Density of its direction, per steradian.
    pdf: f64,
}

/// A path on its way.
#[derive(Clone, Copy)]
pub(super) struct Walk {
    /// What it has brought so far against the camera ray.
    pub(super) radiance: Rgb,
    throughput: Rgb,
    /// Unit direction of the ray in hand.
    direction: DVec3,
    /// Distance per unit of the ray's parameter.
    speed: f64,
    /// Length of the way to where the ray starts.
    distance: f64,
    /// None where nothing but the ray itself could find what it meets.
    drawn: Option<Scattered>,
    /// Bounces so far.
    depth: u32,
    sampler: PathSampler,
}

impl Walk {
    /// The path of a camera ray.
    pub(super) fn new(ray: &Ray, sampler: PathSampler) -> Self {
        Self {
            radiance: Rgb::ZERO,
            throughput: Rgb::ONE,
            direction: ray.direction.normalize(),
            speed: ray.direction.length(),
            distance: 0.0,
            drawn: None,
            depth: 0,
            sampler,
        }
    }
}

/// Whether light that was drawn arrives.
#[derive(Clone, Copy)]
pub(super) enum Question {
    /// It brings so much if nothing stands before it.
    Free { shadow: ShadowRay, brought: Rgb },
    /// It counts if the ray meets what it was aimed at.
    Aimed { ray: Ray, aimed: Aimed },
}

/// What a ray towards an emitter is for.
#[derive(Clone, Copy)]
pub(super) struct Aimed {
    aim: Aim,
    at: Receiver,
    direction: DVec3,
    /// Of the material for that direction, and the density with which it finds it.
    value: Rgb,
    pdf: f64,
    throughput: Rgb,
    depth: u32,
}

/// What became of the ray of a [`Question`].
#[derive(Clone, Copy)]
pub(super) enum Answer {
    /// Whether it met nothing.
    Free(bool),
    /// What it met first.
    Met(Option<Hit>),
}

impl<'a> PathTracer<'a> {
    /// For the camera rays of `scene`.
    pub(super) fn of_camera(scene: &'a Scene) -> Self {
        Self::new(scene, spread(scene))
    }

    /// For `scene`; `spread` is the angle between camera rays of neighbouring samples, radian.
    pub(super) fn new(scene: &'a Scene, spread: f64) -> Self {
        let settings = scene.settings();
        let clamp = if settings.clamp > 0.0 { settings.clamp } else { f64::INFINITY };
        let (lighting, max_depth) = (scene.lighting(), settings.max_depth);
        Self { scene, lighting, spread, max_depth, chooses: lighting.chooses(), clamp }
    }

    /// An estimate of the radiance that comes against a camera ray, given what it meets, in which world.
    pub(super) fn radiance(
        &self,
        ray: &Ray,
        (hit, detail): (Option<&Hit>, Detail<'_>),
        sampler: PathSampler,
        rays: &mut RayCounts,
    ) -> Rgb {
        let world = detail.world;
        let (mut walk, mut met) = (Walk::new(ray, sampler), hit.copied());
        loop {
            let light = |radiance: &mut Rgb, question: Question| {
                let answer = match &question {
                    Question::Free { shadow, .. } => Answer::Free(!shadow.is_occluded(world)),
                    Question::Aimed { ray, .. } => Answer::Met(world.closest(ray, &mut ())),
                };
                *radiance += self.brought(world, &question, answer);
            };
            let Some(next) = self.step(&mut walk, (met.as_ref(), detail), rays, light) else {
                break;
            };
            met = world.closest(&next, &mut ());
        }
        walk.radiance
    }

    /// Goes on from what the ray in hand meets. Asks at most one question, of light that may come straight from an
    /// emitter to there: what it [brings](PathTracer::brought) is to be added to the radiance, now or before the next
    /// step. Returns the next ray, none at the path's end.
    #[inline]
    pub(super) fn step(
        &self,
        walk: &mut Walk,
        (met, detail): (Option<&Hit>, Detail<'_>),
        rays: &mut RayCounts,
        ask: impl FnOnce(&mut Rgb, Question),
    ) -> Option<Ray> {
        let world = detail.world;
        let (depth, direction, drawn) = (walk.depth, walk.direction, walk.drawn);
        let Some(hit) = met else {
            let escaped = walk.throughput * self.escaped(direction, drawn);
            walk.radiance += self.held(escaped, depth);
            return None;
        };
        walk.distance += walk.speed * hit.t;
        let material = self.scene.material(hit.surface);
        if hit.front && material.emits() {
            let weight = drawn.map_or(1.0, |drawn| {
                let sampled = self.lighting.pdf_of_hit(world, &drawn.at, direction, hit);
                power(drawn.pdf, sampled)
            });
            let emitted = walk.throughput * material.emitted_at(hit.uv) * weight;
            walk.radiance += self.held(emitted, depth);
        }
        if depth > self.max_depth {
            return None;
        }
        let over = Footprint {
            lost_slopes: detail.lost_slopes(hit),
            ..Footprint::of(hit, self.spread * walk.distance)
        };
        let bsdf = Bsdf::over(material, hit, -direction, &over);
        let facing = if hit.front { hit.geometric_normal } else { -hit.geometric_normal };
        let both_sides = bsdf.transmits();
        let at =
            Receiver { position: hit.position, normal: Some(facing), both_sides, time: hit.time };
        // Drawn whether or not they are used, so that every bounce has dimensions of its own.
        let sampler = &mut walk.sampler;
        let choice = if self.chooses { sampler.one() } else { 0.0 };
        let (point, lobe, place) = (sampler.two(), sampler.one(), sampler.two());
        let drawn_light = match bsdf.is_delta() {
            true => None,
            false => self.lighting.sample(world, &at, choice, point),
        };
        let question = drawn_light.and_then(|drawn| self.question((hit, at), &bsdf, drawn, walk));
        if let Some(question) = question {
            rays.shadow += 1;
            ask(&mut walk.radiance, question);
        }
        let scattered = bsdf.sample(lobe, place)?;
        walk.throughput *= scattered.weight;
        if depth >= SAFE {
            let go_on = walk.throughput.max_element().min(1.0 - LEAST_END);
            if walk.sampler.one() >= go_on {
                return None;
            }
            walk.throughput /= go_on;
        }
        walk.drawn = (!scattered.delta).then_some(Scattered { at, pdf: scattered.pdf });
        walk.direction = scattered.direction;
        walk.speed = 1.0;
        walk.depth += 1;
        match scattered.roughness < 1.0 {
            true => rays.reflection += 1,
            false => rays.diffuse += 1,
        }
        Some(hit.spawn(scattered.direction))
    }

    /// What there is to ask about light that was drawn, if it can bring anything.
    #[inline]
    fn question(
        &self,
        (hit, at): (&Hit, Receiver),
        bsdf: &Bsdf,
        drawn: Drawn,
        walk: &Walk,
    ) -> Option<Question> {
        match drawn {
            // A flat quad or a sphere cannot light itself.
            Drawn::Point(_, surface) if surface == Some(hit.surface) => None,
            Drawn::Point(sample, exempt) => {
                let (value, pdf) = bsdf.evaluate(sample.direction);
                if value == Rgb::ZERO {
                    return None;
                }
                let weight = if sample.pdf > 0.0 { power(sample.pdf, pdf) } else { 1.0 };
                let brought = walk.throughput * value * sample.weight * weight;
                let brought = self.held(brought, walk.depth + 1);
                let way = hit.spawn(sample.position - hit.position);
                let shadow = ShadowRay { ray: Ray { t_max: sample.clear, ..way }, exempt };
                Some(Question::Free { shadow, brought })
            }
            Drawn::Aim(aim) => {
                let direction = aim.way(hit.position).normalize_or_zero();
                let (value, pdf) = bsdf.evaluate(direction);
                let (throughput, depth) = (walk.throughput, walk.depth);
                let ray = aim.ray(hit);
                let aimed = Aimed { aim, at, direction, value, pdf, throughput, depth };
                (value != Rgb::ZERO).then_some(Question::Aimed { ray, aimed })
            }
        }
    }

    /// What light of a question brings against the camera ray.
    #[inline]
    pub(super) fn brought(&self, world: &World, question: &Question, answer: Answer) -> Rgb {
        match (question, answer) {
            (Question::Free { brought, .. }, Answer::Free(true)) => *brought,
            (Question::Aimed { aimed, .. }, Answer::Met(Some(met))) => {
                let sent = self.sent_back(world, aimed, &met);
                self.held(aimed.throughput * sent, aimed.depth + 1)
            }
            _ => Rgb::ZERO,
        }
    }

    /// What the emitter that a ray was aimed at sends back against the view, given what the ray met.
    fn sent_back(&self, world: &World, aimed: &Aimed, met: &Hit) -> Rgb {
        let Aimed { aim, at, direction, value, pdf, .. } = *aimed;
        if !aim.finds(met) {
            return Rgb::ZERO;
        }
        let sampled = self.lighting.pdf_of_hit(world, &at, direction, met);
        if sampled <= 0.0 {
            return Rgb::ZERO;
        }
        let emitted = self.scene.material(met.surface).emitted_at(met.uv);
        value * emitted * (power(sampled, pdf) / sampled)
    }

    /// Radiance that comes against a ray that meets nothing.
    fn escaped(&self, direction: DVec3, drawn: Option<Scattered>) -> Rgb {
        let weight = |sampled| drawn.map_or(1.0, |drawn| power(drawn.pdf, sampled));
        self.scene.background() + self.lighting.escaped(direction, weight)
    }

    /// What a bounce brings, no more than is allowed.
    #[inline]
    fn held(&self, brought: Rgb, bounces: u32) -> Rgb {
        let largest = brought.max_element();
        // Emission and direct light are never held.
        if bounces <= 1 || largest <= self.clamp {
            brought
        } else {
            brought * (self.clamp / largest)
        }
    }
}

/// The power heuristic: the weight of a sample of density `own` where another technique finds it with
/// density `other`.
#[inline]
fn power(own: f64, other: f64) -> f64 {
    // As a ratio, so that squares of large densities do not overflow.
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}
