//! [`Lighting`]: all light of a scene, for the path integrator.
//!
//! A sample of the light is: one of the infinitely far lights (suns, the environment) or the tree over
//! all others ([`LightTree`]), each equally probable; in the tree a light, by what it can bring; of the
//! light a point, by solid angle or area. The density of the sample is the product. The background
//! is not sampled: a material's own directions find it best.
//!
//! Both halves of multiple importance sampling \[Veach1995\] ask here: [`Lighting::sample`] for next
//! event estimation, [`Lighting::pdf_of_hit`] and [`Lighting::escaped`] for what a scattered ray has
//! met by itself; the two densities are of the same tree and the same receiver. Where the density of a
//! meeting is 0, as on the upright walls of a relief, such a ray counts in full.

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DVec2, DVec3};
use rilievo::surface::{Surface, World};
use rilievo::{Hit, Part};

use super::bounds::LightBounds;
use super::emitter::{Aim, Emitter};
use super::environment::Environment;
use super::shape::Shape;
use super::tree::LightTree;
use super::{Light, LightSample, SunLight, TriangleLight};
use crate::colour::Rgb;
use crate::scene::Material;

/// Most lights in the tree. Meshes beyond are drawn as a whole first.
const LIGHTS: usize = 1 << 24;

/// The point that light is sampled for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Receiver {
    /// Where it is.
    pub position: DVec3,
    /// Unit normal of the surface there, on the side the viewer is on.
    pub normal: Option<DVec3>,
    /// Whether light from behind the surface counts too.
    pub both_sides: bool,
    /// When it is.
    pub time: f64,
}

/// A sample of the light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Drawn {
    /// A point of a light, and the surface that cannot be in its way.
    Point(LightSample, Option<u32>),
    /// A ray, which counts if it meets what it was aimed at.
    Aim(Aim),
}

/// A light that a surface or a part of one is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OfSurface {
    /// None that is sampled.
    Nothing,
    /// From this one on, by the number of the part.
    From(u32),
    /// This one of the emitters.
    Emitter(u32),
}

/// A mesh whose triangles are lights.
#[derive(Clone, Copy, Debug)]
struct EvenMesh {
    /// The light that its triangle 0 is.
    first: u32,
    surface: u32,
    emitted: Rgb,
}

/// All light of a scene.
#[derive(Clone, Debug)]
pub(crate) struct Lighting {
    /// Lights by themselves: the first in the tree.
    lights: Vec<Light>,
    /// Meshes, after them.
    meshes: Vec<EvenMesh>,
    /// What has a shape, after those.
    emitters: Vec<Emitter>,
    /// The light that the first of them is.
    first_emitter: u32,
    shapes: Vec<Shape>,
    of_surface: Vec<OfSurface>,
    tree: LightTree,
    suns: Vec<SunLight>,
    environment: Option<Arc<Environment>>,
    /// Whether there is anything to choose.
    chooses: bool,
}

impl Lighting {
    /// The light of surfaces, by the material of each, of `lamps` and an environment.
    pub(crate) fn new<'a>(
        world: &World,
        material: impl Fn(u32) -> &'a Material,
        lamps: &[Light],
        environment: Option<Arc<Environment>>,
    ) -> Self {
        let mut all = Self {
            of_surface: vec![OfSurface::Nothing; world.surfaces().len()],
            environment,
            ..Self::none()
        };
        for lamp in lamps {
            match lamp {
                Light::Sun(sun) => all.suns.push(*sun),
                lamp => all.lights.push(*lamp),
            }
        }
        let (mut meshes, mut others) = (Vec::new(), Vec::new());
        for (index, surface) in (0..).zip(world.surfaces()) {
            let material = material(index);
            let even = material.even_emission();
            match surface {
                _ if !material.emits() => {}
                Surface::Mesh(mesh) if even != Rgb::ZERO => meshes.push((mesh, index)),
                Surface::Quad(_) | Surface::Sphere(_) if even != Rgb::ZERO => {
                    let own = Light::of_surface(surface, index, even);
                    all.of_surface[index as usize] = OfSurface::From(all.lights.len() as u32);
                    all.lights.extend(own);
                }
                _ => others.push(index),
            }
        }
        let bounds_of = |light: &Light| light.bounds().unwrap_or(NO_LIGHT);
        let mut bounds: Vec<LightBounds> = all.lights.iter().map(bounds_of).collect();
        for (mesh, surface) in meshes {
            let (emitted, count) = (material(surface).emitted, mesh.data().triangles.len());
            if bounds.len() + count > LIGHTS {
                others.push(surface);
                continue;
            }
            let first = bounds.len() as u32;
            all.of_surface[surface as usize] = OfSurface::From(first);
            all.meshes.push(EvenMesh { first, surface, emitted });
            bounds.extend((0..count as u32).map(|k| {
                let light = TriangleLight::new(mesh.corners(k), surface, emitted);
                if light.has_area() { bounds_of(&Light::Triangle(light)) } else { NO_LIGHT }
            }));
        }
        all.first_emitter = bounds.len() as u32;
        all.add_emitters(world, &material, &others, &mut bounds);
        all.tree = LightTree::new(&bounds);
        let parts = all.emitters.iter().any(|e| all.shapes[e.shape as usize].chooses());
        all.chooses = all.infinite() + all.tree.len() > 1 || parts;
        all
    }

    /// No light: whatever shines is found by chance.
    pub(crate) fn none() -> Self {
        Self {
            lights: Vec::new(),
            meshes: Vec::new(),
            emitters: Vec::new(),
            first_emitter: 0,
            shapes: Vec::new(),
            of_surface: Vec::new(),
            tree: LightTree::default(),
            suns: Vec::new(),
            environment: None,
            chooses: false,
        }
    }

    /// Adds surfaces that are drawn by their shapes; instances of one surface and material share one.
    fn add_emitters<'a>(
        &mut self,
        world: &World,
        material: impl Fn(u32) -> &'a Material,
        surfaces: &[u32],
        bounds: &mut Vec<LightBounds>,
    ) {
        let mut known: HashMap<(*const Surface, *const Material), Option<u32>> = HashMap::new();
        let mut bounds_of_shapes = Vec::new();
        for &index in surfaces {
            let Some(surface) = world.surfaces().get(index as usize) else { continue };
            let (made, material) = (prototype(surface), material(index));
            let shape = *known.entry((made, material)).or_insert_with(|| {
                let (shape, bounds) = Shape::of(made, material)?;
                self.shapes.push(shape);
                bounds_of_shapes.push(bounds);
                Some(self.shapes.len() as u32 - 1)
            });
            let Some(shape) = shape else { continue };
            let emitter = Emitter::new(index, shape, surface);
            bounds.push(emitter.bounds(surface, bounds_of_shapes[shape as usize]));
            self.of_surface[index as usize] = OfSurface::Emitter(self.emitters.len() as u32);
            self.emitters.push(emitter);
        }
    }

    /// Bytes held, without the environment's.
    pub(crate) fn bytes(&self) -> u64 {
        let own = size_of_val(self.lights.as_slice())
            + size_of_val(self.of_surface.as_slice())
            + size_of_val(self.emitters.as_slice());
        own as u64 + self.tree.bytes() + self.shapes.iter().map(Shape::bytes).sum::<u64>()
    }

    /// What is drawn by its shape, after all other lights of the tree, and the shapes.
    pub(super) fn emitters(&self) -> (&[Emitter], &[Shape]) {
        (&self.emitters, &self.shapes)
    }

    /// The lights of the tree, in its order.
    pub(super) fn drawn(&self, world: &World) -> Vec<Light> {
        let of_meshes = self.lights.len() as u32..self.first_emitter;
        let triangles = of_meshes.filter_map(|index| self.triangle(world, index));
        self.lights.iter().copied().chain(triangles.map(Light::Triangle)).collect()
    }

    /// For each surface the first of the lights of the tree that it is.
    pub(super) fn first_of_surfaces(&self) -> impl Iterator<Item = Option<u32>> {
        self.of_surface.iter().map(|of| match of {
            OfSurface::From(first) => Some(*first),
            OfSurface::Emitter(index) => Some(self.first_emitter + index),
            OfSurface::Nothing => None,
        })
    }

    /// The tree over all that is not infinitely far.
    pub(super) fn tree(&self) -> &LightTree {
        &self.tree
    }

    /// Whether a number is needed to choose what to sample.
    pub(crate) fn chooses(&self) -> bool {
        self.chooses
    }

    /// A sample of the light, for `choice` and `u` uniform in `[0, 1)`; nothing where the light brings
    /// nothing. Weight and density count the choice of the light.
    #[inline]
    pub(crate) fn sample(
        &self,
        world: &World,
        at: &Receiver,
        choice: f64,
        u: DVec2,
    ) -> Option<Drawn> {
        let groups = self.groups();
        let scaled = choice * groups as f64;
        // `choice` is below 1, and so few groups do not round up.
        let group = (scaled as usize).min(groups.checked_sub(1)?);
        let (sample, probability, surface) = if group < self.suns.len() {
            (self.suns[group].sample(at.position, u), 1.0, None)
        } else if group < self.infinite() {
            (self.environment.as_ref()?.sample(at.position, u)?, 1.0, None)
        } else {
            let (light, probability, rest) = self.tree.choose(at, scaled - group as f64)?;
            if let Some(emitter) = light.checked_sub(self.first_emitter) {
                let emitter = self.emitters.get(emitter as usize)?;
                return emitter.aim(self.shape(world, emitter)?, at, rest, u).map(Drawn::Aim);
            }
            let (sample, exempt) = self.sample_of(world, light, at.position, u)?;
            (sample, probability, exempt)
        };
        let probability = probability / groups as f64;
        let (weight, pdf) = (sample.weight / probability, sample.pdf * probability);
        Some(Drawn::Point(LightSample { weight, pdf, ..sample }, surface))
    }

    /// The shape of an emitter, and its surface.
    fn shape<'a>(
        &'a self,
        world: &'a World,
        emitter: &Emitter,
    ) -> Option<(&'a Shape, &'a Surface)> {
        let shape = self.shapes.get(emitter.shape as usize)?;
        Some((shape, world.surfaces().get(emitter.surface as usize)?))
    }

    /// A point of light `index`, and the surface that cannot be in its way.
    #[inline]
    fn sample_of(
        &self,
        world: &World,
        index: u32,
        point: DVec3,
        u: DVec2,
    ) -> Option<(LightSample, Option<u32>)> {
        if let Some(light) = self.lights.get(index as usize) {
            let exempt = match light {
                // No other part of the light is in the way of what is seen of it.
                Light::Quad(_) | Light::Sphere(_) => light.surface(),
                _ => None,
            };
            return Some((light.view(point)?.sample(u)?, exempt));
        }
        Some((self.triangle(world, index)?.sample(point, u)?, None))
    }

    /// The triangle of a mesh that light `index` is.
    fn triangle(&self, world: &World, index: u32) -> Option<TriangleLight> {
        let after = self.meshes.partition_point(|mesh| mesh.first <= index);
        let EvenMesh { first, surface, emitted } = *self.meshes.get(after.checked_sub(1)?)?;
        let Surface::Mesh(mesh) = world.surfaces().get(surface as usize)? else { return None };
        Some(TriangleLight::new(mesh.corners(index - first), surface, emitted))
    }

    /// Density with which [`Self::sample`] gives a unit `direction` that meets an emitter's front at
    /// `hit`, per steradian; 0 if the emitter cannot be sampled.
    #[inline]
    pub(crate) fn pdf_of_hit(
        &self,
        world: &World,
        at: &Receiver,
        direction: DVec3,
        hit: &Hit,
    ) -> f64 {
        let first = match self.of_surface.get(hit.surface as usize) {
            None | Some(OfSurface::Nothing) => return 0.0,
            Some(OfSurface::Emitter(index)) => {
                let emitter = &self.emitters[*index as usize];
                let Some(shape) = self.shape(world, emitter) else { return 0.0 };
                let chosen = self.tree.probability(at, self.first_emitter + index);
                return emitter.pdf(shape, at, hit) * chosen / self.groups() as f64;
            }
            Some(OfSurface::From(first)) => first,
        };
        let index = match hit.part {
            Part::Triangle(part) => first + part,
            _ => *first,
        };
        let distance = at.position.distance(hit.position);
        let pdf = match self.lights.get(index as usize) {
            Some(light) => light.pdf(at.position, direction, distance),
            None => match self.triangle(world, index) {
                Some(triangle) => triangle.pdf(direction, distance),
                None => return 0.0,
            },
        };
        pdf * self.tree.probability(at, index) / self.groups() as f64
    }

    /// Radiance of the infinitely far lights that comes against a unit `direction`, each weighed by
    /// `weight` of its density for [`Self::sample`], per steradian.
    #[inline]
    pub(crate) fn escaped(&self, direction: DVec3, weight: impl Fn(f64) -> f64) -> Rgb {
        let groups = self.groups() as f64;
        let mut radiance = Rgb::ZERO;
        for (seen, pdf) in self.suns.iter().filter_map(|sun| sun.seen(direction)) {
            radiance += seen * weight(pdf / groups);
        }
        if let Some(environment) = &self.environment {
            let (seen, pdf) = environment.seen(direction);
            radiance += seen * weight(pdf / groups);
        }
        radiance
    }

    /// Suns and environments that shine.
    fn infinite(&self) -> usize {
        self.suns.len() + usize::from(self.environment.as_ref().is_some_and(|e| e.shines()))
    }

    /// What is chosen from first.
    pub(super) fn groups(&self) -> usize {
        self.infinite() + usize::from(!self.tree.is_empty())
    }
}

/// The surface in its own frame: of an instance its prototype.
pub(super) fn prototype(surface: &Surface) -> &Surface {
    match surface {
        Surface::Instance(instance) => instance.prototype(),
        Surface::Moving(moving) => moving.prototype(),
        surface => surface,
    }
}

/// Never chosen.
const NO_LIGHT: LightBounds = LightBounds {
    min: DVec3::ZERO,
    max: DVec3::ZERO,
    intensity: 0.0,
    axis: DVec3::Z,
    cos_normals: 1.0,
    cos_emission: 0.0,
    held: 0.0,
    most: 0.0,
};

#[cfg(test)]
mod tests;
