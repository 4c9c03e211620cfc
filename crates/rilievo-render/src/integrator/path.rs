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

use glam::DVec3;
use rilievo::surface::World;
use rilievo::{Hit, Ray};

use super::RayCounts;
use crate::bsdf::Bsdf;
use crate::colour::Rgb;
use crate::level_of_detail::Detail;
use crate::light::{Aim, Drawn, LightSample, Lighting, Receiver};
use crate::sampler::PathSampler;
use crate::scene::Scene;
use crate::texture::Footprint;

/// Bounces before Russian roulette begins.
const SAFE: u32 = 2;

/// Least probability with which roulette ends a path. Without it a white furnace never ends.
const LEAST_END: f64 = 0.05;

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

impl<'a> PathTracer<'a> {
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
        sampler: &mut PathSampler,
        rays: &mut RayCounts,
    ) -> Rgb {
        let world = detail.world;
        let mut radiance = Rgb::ZERO;
        let mut throughput = Rgb::ONE;
        let mut direction = ray.direction.normalize();
        let mut distance = ray.direction.length() * hit.map_or(0.0, |hit| hit.t);
        let mut met = hit.copied();
        // None where nothing but the ray itself could have found what it meets.
        let mut drawn: Option<Scattered> = None;
        for depth in 0.. {
            let Some(hit) = &met else {
                radiance += self.held(throughput * self.escaped(direction, drawn), depth);
                break;
            };
            let material = self.scene.material(hit.surface);
            if hit.front && material.emits() {
                let weight = drawn.map_or(1.0, |drawn| {
                    let sampled = self.lighting.pdf_of_hit(world, &drawn.at, direction, hit);
                    power(drawn.pdf, sampled)
                });
                radiance += self.held(throughput * material.emitted_at(hit.uv) * weight, depth);
            }
            if depth > self.max_depth {
                break;
            }
            let view = -direction;
            let at = Footprint {
                lost_slopes: detail.lost_slopes(hit),
                ..Footprint::of(hit, self.spread * distance)
            };
            let bsdf = Bsdf::over(material, hit, view, &at);
            let facing = if hit.front { hit.geometric_normal } else { -hit.geometric_normal };
            let both_sides = bsdf.transmits();
            let at = Receiver {
                position: hit.position,
                normal: Some(facing),
                both_sides,
                time: hit.time,
            };
            // Drawn whether or not they are used, so that every bounce has dimensions of its own.
            let choice = if self.chooses { sampler.one() } else { 0.0 };
            let (point, lobe, place) = (sampler.two(), sampler.one(), sampler.two());
            let drawn_light = match bsdf.is_delta() {
                true => None,
                false => self.lighting.sample(world, &at, choice, point),
            };
            match drawn_light {
                // A flat quad or a sphere cannot light itself.
                Some(Drawn::Point(sample, surface)) if surface != Some(hit.surface) => {
                    let (value, pdf) = bsdf.evaluate(sample.direction);
                    if value != Rgb::ZERO && self.is_free(world, hit, (&sample, surface), rays) {
                        let weight = if sample.pdf > 0.0 { power(sample.pdf, pdf) } else { 1.0 };
                        let brought = throughput * value * sample.weight * weight;
                        radiance += self.held(brought, depth + 1);
                    }
                }
                Some(Drawn::Aim(aim)) => {
                    let brought = throughput * self.aimed((world, hit, &at), &bsdf, &aim, rays);
                    radiance += self.held(brought, depth + 1);
                }
                _ => {}
            }
            let Some(scattered) = bsdf.sample(lobe, place) else { break };
            throughput *= scattered.weight;
            if depth >= SAFE {
                let go_on = throughput.max_element().min(1.0 - LEAST_END);
                if sampler.one() >= go_on {
                    break;
                }
                throughput /= go_on;
            }
            drawn = (!scattered.delta).then_some(Scattered { at, pdf: scattered.pdf });
            direction = scattered.direction;
            match scattered.roughness < 1.0 {
                true => rays.reflection += 1,
                false => rays.diffuse += 1,
            }
            met = world.closest(&hit.spawn(direction), &mut ());
            distance += met.as_ref().map_or(0.0, |hit| hit.t);
        }
        radiance
    }

    /// Whether nothing stands before a point of a light.
    #[inline]
    fn is_free(
        &self,
        world: &World,
        hit: &Hit,
        (sample, surface): (&LightSample, Option<u32>),
        rays: &mut RayCounts,
    ) -> bool {
        rays.shadow += 1;
        let ray = Ray { t_max: sample.clear, ..hit.spawn(sample.position - hit.position) };
        !match surface {
            Some(surface) => world.occluded_before(&ray, surface, &mut ()),
            None => world.occluded(&ray, &mut ()),
        }
    }

    /// What the emitter that a ray was aimed at sends back against the view.
    fn aimed(
        &self,
        (world, hit, at): (&World, &Hit, &Receiver),
        bsdf: &Bsdf,
        aim: &Aim,
        rays: &mut RayCounts,
    ) -> Rgb {
        let direction = aim.way(hit.position).normalize_or_zero();
        let (value, pdf) = bsdf.evaluate(direction);
        if value == Rgb::ZERO {
            return Rgb::ZERO;
        }
        rays.shadow += 1;
        let Some(met) = world.closest(&aim.ray(hit), &mut ()).filter(|met| aim.finds(met)) else {
            return Rgb::ZERO;
        };
        let sampled = self.lighting.pdf_of_hit(world, at, direction, &met);
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

#[cfg(test)]
mod tests {
    use glam::DVec2;
    use rilievo::surface::{Quad, Surface};

    use super::*;
    use crate::light::fixtures::emitters;
    use crate::sampler::SamplerKind;
    use crate::scene::{Camera, CameraParts, Material, SceneParts};

    /// An emitter that shines up between two grey planes.
    fn lit_from_below(surface: Surface, material: Material) -> Scene {
        let plane = |z: f64, side: f64| {
            let corners = [[-side, -side], [side, -side], [side, side], [-side, side]];
            Surface::Quad(Quad::new(corners.map(|[x, y]| DVec3::new(x, y, z)), false).unwrap())
        };
        let camera = CameraParts {
            position: DVec3::NEG_Y,
            look_at: DVec3::ZERO,
            up: DVec3::Z,
            fov: 40.0,
            resolution: [8, 8],
        };
        let settings = crate::RenderSettings { max_depth: 2, ..Default::default() };
        Scene::new(SceneParts {
            world: World::new(vec![surface, plane(2.5, 2.0), plane(-1.6, 2.0)]),
            materials: vec![material, Material::default()],
            material_of: vec![0, 1, 1],
            camera: Camera::new(camera).unwrap(),
            background: Rgb::ZERO,
            ambient: Rgb::ZERO,
            settings,
        })
        .unwrap()
    }

    /// Mean of what paths find that begin at the upper plane, and its standard error.
    fn mean(tracer: &PathTracer<'_>) -> (f64, f64) {
        let (n, mut rays) = (6000, RayCounts::default());
        let (mut sum, mut squares) = (0.0, 0.0);
        for k in 0..n {
            let mut sampler = PathSampler::new(SamplerKind::Sobol, 3, [0, 0], k, n);
            let to = 2.0 * sampler.two() - DVec2::ONE;
            let from = DVec3::new(5.0, 0.0, 2.0);
            let ray = Ray::new(from, to.extend(2.5) - from);
            let hit = tracer.scene.world().closest(&ray, &mut ());
            let full = Detail::full(tracer.scene.world());
            let found = tracer.radiance(&ray, (hit.as_ref(), full), &mut sampler, &mut rays).x;
            (sum, squares) = (sum + found, squares + found * found);
        }
        let (mean, n) = (sum / n as f64, n as f64);
        (mean, ((squares / n - mean * mean) / n).sqrt())
    }

    #[test]
    fn emitters_light_as_much_sampled_as_met_by_chance() {
        let none = Lighting::none();
        for (name, surface, material) in emitters() {
            let scene = lit_from_below(surface, material);
            let both = PathTracer::new(&scene, 0.0);
            let chance =
                PathTracer { lighting: &none, chooses: false, ..PathTracer::new(&scene, 0.0) };
            let (sampled, met) = (mean(&both), mean(&chance));
            let found = format!("{name}: {sampled:?}, by chance {met:?}");
            // Pairs of the sequence are not independent: the errors are bounds.
            assert!((sampled.0 - met.0).abs() < 4.0 * sampled.1.hypot(met.1), "{found}");
            assert!(sampled.0 > 0.0 && sampled.1 < met.1, "{found}");
        }
    }

    #[test]
    fn weights_of_two_techniques_add_up() {
        for (a, b) in [(1.0, 3.0), (1e-200, 1e200), (1e200, 1e180), (2.0, 0.0)] {
            assert!((power(a, b) + power(b, a) - 1.0).abs() < 1e-12 || b == 0.0);
        }
        assert_eq!(power(2.0, 0.0), 1.0);
    }
}
