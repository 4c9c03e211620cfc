//! [`Lighting`]: all light of a scene, for the path integrator.
//!
//! A sample of the light is: one of the infinitely far lights (suns, the environment) or the tree over
//! all others ([`LightTree`]), each equally probable; in the tree a light, by what it can bring; of the
//! light a point, by solid angle or area. The density of the sample is the product. The background
//! is not sampled: a material's own directions find it best.
//!
//! Both halves of multiple importance sampling \[Veach1995\] ask here: [`Lighting::sample`] for next
//! event estimation, [`Lighting::pdf_of_hit`] and [`Lighting::escaped`] for what a scattered ray has
//! met by itself. An emitter that cannot be sampled has the density 0 there, so such a ray counts in
//! full; the two densities are of the same tree and the same receiver.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rilievo::surface::{Surface, World};
use rilievo::{Hit, Part};

use super::bounds::LightBounds;
use super::environment::Environment;
use super::tree::LightTree;
use super::{Light, LightSample, SunLight, TriangleLight};
use crate::colour::Rgb;

/// Most lights in the tree. Meshes beyond only glow.
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
}

/// A light that a surface or a part of one is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum OfSurface {
    /// None that is sampled.
    Nothing,
    /// From this one on, by the number of the part.
    From(u32),
}

/// A mesh whose triangles are lights.
#[derive(Clone, Copy, Debug)]
struct Emitter {
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
    meshes: Vec<Emitter>,
    of_surface: Vec<OfSurface>,
    tree: LightTree,
    suns: Vec<SunLight>,
    environment: Option<Arc<Environment>>,
}

impl Lighting {
    /// The light of surfaces, by what each emits, of `lamps` and an environment.
    pub(crate) fn new(
        world: &World,
        emitted: impl Fn(u32) -> Rgb,
        lamps: &[Light],
        environment: Option<Arc<Environment>>,
    ) -> Self {
        let mut all = Self {
            lights: Vec::new(),
            meshes: Vec::new(),
            of_surface: vec![OfSurface::Nothing; world.surfaces().len()],
            tree: LightTree::default(),
            suns: Vec::new(),
            environment,
        };
        for lamp in lamps {
            match lamp {
                Light::Sun(sun) => all.suns.push(*sun),
                lamp => all.lights.push(*lamp),
            }
        }
        let mut meshes = Vec::new();
        for (index, surface) in world.surfaces().iter().enumerate() {
            let (place, index) = (index, index as u32);
            match surface {
                Surface::Mesh(mesh) if emitted(index) != Rgb::ZERO => meshes.push((mesh, index)),
                surface => {
                    let own = Light::of_surface(surface, index, emitted(index));
                    if !own.is_empty() {
                        all.of_surface[place] = OfSurface::From(all.lights.len() as u32);
                        all.lights.extend(own);
                    }
                }
            }
        }
        let bounds_of = |light: &Light| light.bounds().unwrap_or(NO_LIGHT);
        let mut bounds: Vec<LightBounds> = all.lights.iter().map(bounds_of).collect();
        for (mesh, surface) in meshes {
            let (emitted, count) = (emitted(surface), mesh.data().triangles.len());
            if bounds.len() + count > LIGHTS {
                continue;
            }
            let first = bounds.len() as u32;
            all.of_surface[surface as usize] = OfSurface::From(first);
            all.meshes.push(Emitter { first, surface, emitted });
            bounds.extend((0..count as u32).map(|k| {
                let light = TriangleLight::new(mesh.corners(k), surface, emitted);
                if light.has_area() { bounds_of(&Light::Triangle(light)) } else { NO_LIGHT }
            }));
        }
        all.tree = LightTree::new(&bounds);
        all
    }

    /// Bytes held, without the environment's.
    pub(crate) fn bytes(&self) -> u64 {
        let own = size_of_val(self.lights.as_slice()) + size_of_val(self.of_surface.as_slice());
        own as u64 + self.tree.bytes()
    }

    /// Whether there is more than one light to choose from.
    pub(crate) fn chooses(&self) -> bool {
        self.infinite() + self.tree.len() > 1
    }

    /// A point of a light and the light's surface, for `choice` and `u` uniform in `[0, 1)`; nothing
    /// where the light brings nothing. Weight and density count the choice of the light.
    #[inline]
    pub(crate) fn sample(
        &self,
        world: &World,
        at: &Receiver,
        choice: f64,
        u: DVec2,
    ) -> Option<(LightSample, Option<u32>)> {
        let groups = self.groups();
        let scaled = choice * groups as f64;
        // `choice` is below 1, and so few groups do not round up.
        let group = (scaled as usize).min(groups.checked_sub(1)?);
        let (sample, probability, surface) = if group < self.suns.len() {
            (self.suns[group].sample(at.position, u), 1.0, None)
        } else if group < self.infinite() {
            (self.environment.as_ref()?.sample(at.position, u)?, 1.0, None)
        } else {
            let (light, probability) = self.tree.choose(at, scaled - group as f64)?;
            let (sample, exempt) = self.sample_of(world, light, at.position, u)?;
            (sample, probability, exempt)
        };
        let probability = probability / groups as f64;
        let (weight, pdf) = (sample.weight / probability, sample.pdf * probability);
        Some((LightSample { weight, pdf, ..sample }, surface))
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
        let Emitter { first, surface, emitted } = *self.meshes.get(after.checked_sub(1)?)?;
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
        let Some(OfSurface::From(first)) = self.of_surface.get(hit.surface as usize) else {
            return 0.0;
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
    fn groups(&self) -> usize {
        self.infinite() + usize::from(!self.tree.is_empty())
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
};

#[cfg(test)]
mod tests {
    use std::cell::Cell;
    use std::f64::consts::TAU;

    use rilievo::Ray;
    use rilievo::mesh::{Mesh, MeshData, Triangle};
    use rilievo::surface::{Quad, Sphere};

    use super::*;
    use crate::light::EnvironmentPlacement;
    use crate::sampler::chi_square::{chi_square_z, independent_points};
    use crate::texture::{ColourImage, Texels};

    /// Lights of every kind that has a size, none before another as seen from the origin.
    fn world() -> World {
        let quad = |corners: [[f64; 3]; 4]| {
            Surface::Quad(Quad::new(corners.map(DVec3::from_array), false).unwrap())
        };
        let positions =
            [[-2.0, 1.0, -1.0], [-2.0, -1.0, -1.0], [-2.0, -1.0, 1.0], [-2.0, 1.0, 1.2]];
        let triangle = |positions| Triangle { positions, normals: None, uvs: None };
        let data = MeshData {
            positions: positions.map(DVec3::from_array).to_vec(),
            triangles: vec![triangle([0, 2, 1]), triangle([0, 3, 2])],
            ..MeshData::default()
        };
        World::new(vec![
            // A rectangle, near and large; a parallelogram; any quad; a mesh; a ball.
            quad([[-1.0, -1.0, 1.0], [-1.0, 1.0, 1.0], [1.0, 1.0, 1.0], [1.0, -1.0, 1.0]]),
            quad([[-1.0, -1.0, -2.0], [1.0, -1.0, -2.0], [1.5, 1.0, -2.0], [-0.5, 1.0, -2.0]]),
            quad([[3.0, -1.0, -1.0], [3.0, -1.5, 1.0], [3.0, 1.0, 1.2], [3.0, 1.0, -1.0]]),
            Surface::Mesh(Mesh::new(data).unwrap()),
            Surface::Sphere(Sphere::new(DVec3::new(0.0, 4.0, 0.0), 2.0).unwrap()),
        ])
    }

    #[test]
    fn directions_follow_the_density_that_is_told() {
        const CELLS: usize = 20;
        const FINE: usize = 40;
        const SAMPLES: u32 = 200_000;
        let world = world();
        let texels = (0..8 * 4).map(|k| [0.1 + (k % 5) as f32; 3]).collect();
        let sky = ColourImage::new(8, 4, Texels::Linear(texels)).unwrap();
        let sky = Environment::new(&sky, EnvironmentPlacement::default()).unwrap();
        let sun = SunLight::new(DVec3::Y, Rgb::ONE, 60.0).unwrap();
        let emitted = |surface| Rgb::splat(1.0 + f64::from(surface));
        let lamps = [Light::Sun(sun)];
        let all = Lighting::new(&world, emitted, &lamps, Some(Arc::new(sky)));
        assert_eq!((all.infinite(), all.tree.len()), (2, 7));
        let at = Receiver { position: DVec3::ZERO, normal: None, both_sides: false };

        let cell = |d: DVec3| {
            let turn = (d.y.atan2(d.x) / TAU).rem_euclid(1.0);
            let place = |x: f64| ((x * CELLS as f64) as usize).min(CELLS - 1);
            place(0.5 + 0.5 * d.z) * CELLS + place(turn)
        };
        let mut observed = vec![0.0; CELLS * CELLS];
        let points: Vec<DVec2> = independent_points(2 * SAMPLES).collect();
        for pair in points.chunks_exact(2) {
            let (sample, _) = all.sample(&world, &at, pair[0].x, pair[1]).expect("seen");
            assert!(sample.pdf > 0.0 && sample.weight.min_element() > 0.0);
            observed[cell(sample.direction)] += 1.0;
        }
        let mut expected = vec![0.0; CELLS * CELLS];
        let n = CELLS * FINE;
        for k in 0..n * n {
            let z = -1.0 + 2.0 * ((k / n) as f64 + 0.5) / n as f64;
            let (sin, cos) = (TAU * ((k % n) as f64 + 0.5) / n as f64).sin_cos();
            let level = (1.0 - z * z).sqrt();
            let d = DVec3::new(level * cos, level * sin, z);
            let density = Cell::new(0.0);
            all.escaped(d, |pdf| {
                density.set(density.get() + pdf);
                1.0
            });
            if let Some(hit) = world.closest(&Ray::new(DVec3::ZERO, d), &mut ()) {
                assert!(hit.front, "{d}");
                density.set(density.get() + all.pdf_of_hit(&world, &at, d, &hit));
            }
            expected[cell(d)] += density.get() * 2.0 * TAU / (n * n) as f64 * f64::from(SAMPLES);
        }
        let total = expected.iter().sum::<f64>() / f64::from(SAMPLES);
        assert!((total - 1.0).abs() < 2e-3, "the density integrates to {total}");
        let z = chi_square_z(&observed, &expected);
        assert!(z < 4.0, "chi-square is {z} deviations too large");
    }
}
