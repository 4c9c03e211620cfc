//! [`Light`]: the emitters that are sampled.
//!
//! Every surface with an emitting material glows from its front side, seen directly and in
//! reflections. Undisplaced quads, spheres and meshes of up to 64 triangles are also *lights* of the
//! paper's integrator ([`Light`]): diffuse surfaces receive light from them through shadow rays.
//!
//! The path integrator samples everything that emits: meshes of any size, and as `Emitter`s displaced
//! surfaces, instances, what moves, and what shines by an image.
//!
//! Lights that are no surface are points, spots and suns ([`PointLight`], [`SunLight`]), and an image
//! of the whole sky ([`Environment`]).
//!
//! `Lighting` holds all of a scene's light for the path integrator, and chooses among it.

mod bounds;
mod distribution;
mod emission;
mod emitter;
#[cfg(test)]
mod emitter_tests;
mod environment;
#[cfg(test)]
pub(crate) mod fixtures;
mod lighting;
mod punctual;
mod quad;
mod rectangle;
mod shape;
mod sphere;
mod tree;
mod triangle;
mod words;

use glam::{DVec2, DVec3};
use rilievo::surface::Surface;

use crate::colour::Rgb;

use bounds::LightBounds;
use quad::QuadView;
use sphere::Cone;

pub(crate) use emitter::Aim;
pub use environment::{Environment, EnvironmentPlacement, Up};
pub(crate) use lighting::{Drawn, Lighting, Receiver};
pub use punctual::{LightError, PointLight, SunLight};
pub use quad::QuadLight;
pub use sphere::SphereLight;
pub use triangle::TriangleLight;
pub use words::{LIGHT_WORDS, TREE_WORDS};
pub(crate) use words::{write_lighting, write_lights};

/// Most triangles of a mesh that is a light: each is sampled at every hit.
const MESH_TRIANGLES: usize = 64;

/// An emitter that is sampled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Light {
    /// A parallelogram, sampled by solid angle or area.
    Quad(QuadLight),
    /// A triangle, sampled by area.
    Triangle(TriangleLight),
    /// A sphere, sampled uniformly over the cone it fills.
    Sphere(SphereLight),
    /// A point or a spot.
    Point(PointLight),
    /// A direction, or a disc of the sky.
    Sun(SunLight),
}

/// A point of a light as seen from another point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// The point on the light.
    pub position: DVec3,
    /// Unit direction towards it.
    pub direction: DVec3,
    /// Radiance over the density of `direction`, W/m^2: times the receiver's cosine it estimates
    /// the irradiance.
    pub weight: Rgb,
    /// Density of `direction`, per steradian; 0 of a light without extent, which has but one.
    pub pdf: f64,
    /// Share of the way to `position` that must be free. It is below 1 by the rounding error of
    /// the light's own place, so that the light does not shadow itself; infinite where the light is
    /// infinitely far.
    pub clear: f64,
}

impl Light {
    /// The lights that a surface is, if its front emits and its shape can be sampled: one, two
    /// triangles for a quad that is no parallelogram, the triangles of a small mesh.
    pub(crate) fn of_surface(surface: &Surface, index: u32, emitted: Rgb) -> Vec<Self> {
        if emitted == Rgb::ZERO {
            return Vec::new();
        }
        match surface {
            Surface::Quad(quad) if quad.is_parallelogram() => {
                vec![Self::Quad(QuadLight::new(quad.corners(), index, emitted))]
            }
            Surface::Quad(quad) => {
                let [c0, c1, c2, c3] = quad.corners();
                let half = |corners| Self::Triangle(TriangleLight::new(corners, index, emitted));
                vec![half([c0, c1, c2]), half([c0, c2, c3])]
            }
            Surface::Sphere(sphere) => vec![Self::Sphere(SphereLight {
                center: sphere.center(),
                radius: sphere.radius(),
                surface: index,
                emitted,
            })],
            Surface::Mesh(mesh) if mesh.data().triangles.len() <= MESH_TRIANGLES => {
                let triangles = 0..mesh.data().triangles.len() as u32;
                triangles
                    .map(|k| Self::Triangle(TriangleLight::new(mesh.corners(k), index, emitted)))
                    .filter(|light| matches!(light, Self::Triangle(t) if t.has_area()))
                    .collect()
            }
            Surface::Mesh(_)
            | Surface::Face(_)
            | Surface::ReliefSphere(_)
            | Surface::ReliefMesh(_)
            | Surface::Instance(_)
            | Surface::Moving(_) => Vec::new(),
        }
    }

    /// Index of the light's surface in the world, if it is one.
    pub fn surface(&self) -> Option<u32> {
        match self {
            Self::Quad(quad) => Some(quad.surface),
            Self::Triangle(triangle) => Some(triangle.surface),
            Self::Sphere(sphere) => Some(sphere.surface),
            Self::Point(_) | Self::Sun(_) => None,
        }
    }

    /// The light as seen from `point`; nothing where its front is not seen from there.
    #[inline]
    pub fn view(&self, point: DVec3) -> Option<LightView<'_>> {
        let shape = match self {
            Self::Quad(quad) => Shape::Quad(quad, quad.view(point)?),
            Self::Triangle(triangle) => Shape::Triangle(triangle),
            Self::Sphere(sphere) => Shape::Sphere(sphere, sphere.view(point)?),
            Self::Point(light) => Shape::Point(light),
            Self::Sun(sun) => Shape::Sun(sun),
        };
        Some(LightView { point, shape })
    }

    /// Density with which [`LightView::sample`] from `point` gives a unit `direction` that meets the
    /// light's front at `distance`, per steradian.
    pub(crate) fn pdf(&self, point: DVec3, direction: DVec3, distance: f64) -> f64 {
        match self {
            Self::Quad(quad) => {
                quad.view(point).map_or(0.0, |view| quad.pdf(&view, direction, distance))
            }
            Self::Triangle(triangle) => triangle.pdf(direction, distance),
            Self::Sphere(sphere) => sphere.view(point).map_or(0.0, |cone| cone.pdf()),
            Self::Point(_) | Self::Sun(_) => 0.0,
        }
    }

    /// What the light can do to a point; nothing of one that is infinitely far.
    fn bounds(&self) -> Option<LightBounds> {
        let facing = |corners: &[DVec3], normal, area, emitted| LightBounds {
            min: corners.iter().copied().fold(DVec3::INFINITY, DVec3::min),
            max: corners.iter().copied().fold(DVec3::NEG_INFINITY, DVec3::max),
            intensity: luminance(emitted) * area,
            axis: normal,
            cos_normals: 1.0,
            cos_emission: 0.0,
            held: 0.0,
            most: 0.0,
        };
        match self {
            Self::Quad(quad) => {
                let (c, [a, b], normal) = quad.frame();
                Some(facing(&[c, c + a, c + b, c + a + b], normal, quad.area(), quad.emitted()))
            }
            Self::Triangle(triangle) => {
                let (c, [a, b], normal) = triangle.frame();
                let area = 0.5 * a.cross(b).length();
                Some(facing(&[c, c + a, c + b], normal, area, triangle.emitted()))
            }
            Self::Sphere(SphereLight { center, radius, emitted, .. }) => Some(LightBounds {
                min: center - radius,
                max: center + radius,
                intensity: luminance(*emitted) * std::f64::consts::PI * radius * radius,
                axis: DVec3::Z,
                cos_normals: -1.0,
                cos_emission: 0.0,
                held: 0.0,
                most: 0.0,
            }),
            Self::Point(light) => {
                let (axis, cos_emission) = light.cone().unwrap_or((DVec3::Z, -1.0));
                Some(LightBounds {
                    min: light.position(),
                    max: light.position(),
                    intensity: luminance(light.intensity()),
                    axis,
                    cos_normals: if cos_emission < 0.0 { -1.0 } else { 1.0 },
                    cos_emission,
                    held: 0.0,
                    most: 0.0,
                })
            }
            Self::Sun(_) => None,
        }
    }
}

/// Luminance, relative.
fn luminance(rgb: Rgb) -> f64 {
    rgb.dot(DVec3::new(0.2126, 0.7152, 0.0722))
}

/// A light as seen from a point: what all samples from there share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightView<'a> {
    point: DVec3,
    shape: Shape<'a>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Shape<'a> {
    Quad(&'a QuadLight, QuadView),
    Triangle(&'a TriangleLight),
    Sphere(&'a SphereLight, Cone),
    Point(&'a PointLight),
    Sun(&'a SunLight),
}

impl LightView<'_> {
    /// The point of the light for `u` in `[0, 1)^2`; nothing where rounding hides its front.
    #[inline]
    pub fn sample(&self, u: DVec2) -> Option<LightSample> {
        match &self.shape {
            Shape::Quad(quad, view) => quad.sample(self.point, view, u),
            Shape::Triangle(triangle) => triangle.sample(self.point, u),
            Shape::Sphere(sphere, cone) => Some(sphere.sample(self.point, cone, u)),
            Shape::Point(light) => light.sample(self.point),
            Shape::Sun(sun) => Some(sun.sample(self.point, u)),
        }
    }
}

/// The share of the way from `from` to `to` that lies before the plane through `to` with unit
/// normal `normal`, whatever way coordinates were rounded.
fn clear_share(from: DVec3, to: DVec3, normal: DVec3) -> f64 {
    let across = (to - from).dot(normal).abs();
    let rounding = 32.0 * f64::EPSILON * (from.abs().max_element() + to.abs().max_element());
    1.0 - (rounding / across + 4.0 * f64::EPSILON).min(0.5)
}

#[cfg(test)]
mod tests {
    use rilievo::mesh::{Mesh, MeshData, Triangle};

    use super::*;
    use crate::sampler::chi_square::independent_points;

    /// Mean of `cosine * weight` over independent samples and its standard error.
    fn irradiance(light: &Light, point: DVec3, normal: DVec3) -> (f64, f64) {
        let n = 200_000;
        let (mut sum, mut squares) = (0.0, 0.0);
        let view = light.view(point).unwrap();
        for u in independent_points(n) {
            let Some(sample) = view.sample(u) else {
                continue;
            };
            let way = sample.position - point;
            assert!((way.normalize() - sample.direction).length() < 1e-9);
            assert!(sample.clear > 0.49 && sample.clear < 1.0);
            let value = (sample.direction.dot(normal) * sample.weight.x).max(0.0);
            sum += value;
            squares += value * value;
        }
        let mean = sum / f64::from(n);
        (mean, ((squares / f64::from(n) - mean * mean) / f64::from(n)).sqrt())
    }

    /// Irradiance at the origin, facing +z, from radiance 2 over x in [0, 2] and y in [0, 3].
    fn corner_formula(height: f64) -> f64 {
        let (a, b) = (2.0 / height, 3.0 / height);
        let half = |a: f64, b: f64| a / a.hypot(1.0) * (b / a.hypot(1.0)).atan();
        half(a, b) + half(b, a)
    }

    fn parallelogram(corners: [[f64; 2]; 4], height: f64) -> Light {
        let corners = corners.map(|[x, y]| DVec3::new(x, y, height));
        Light::Quad(QuadLight::new(corners, 0, Rgb::splat(2.0)))
    }

    #[test]
    fn parallel_rectangle() {
        // Close, where samples go by solid angle, and far, where they go by area.
        for height in [0.1, 1.5, 500.0] {
            let light = parallelogram([[0.0, 0.0], [0.0, 3.0], [2.0, 3.0], [2.0, 0.0]], height);
            let expected = corner_formula(height);
            let (mean, error) = irradiance(&light, DVec3::ZERO, DVec3::Z);
            let bound = 4.0 * error + 1e-9 * expected;
            assert!((mean - expected).abs() < bound, "{mean} +- {error}, not {expected}");
            assert!(error < 0.01 * expected);
            // From above, its back is seen.
            assert!(light.view(DVec3::Z * (height + 1.0)).is_none());
        }
    }

    #[test]
    fn a_small_mesh_is_its_triangles() {
        let corners = [[0.0, 0.0], [0.0, 3.0], [2.0, 3.0], [2.0, 0.0]];
        let positions = corners.map(|[x, y]| DVec3::new(x, y, 1.5)).to_vec();
        let triangle = |positions| Triangle { positions, normals: None, uvs: None };
        let mut triangles = vec![triangle([0, 1, 2]), triangle([0, 2, 3]), triangle([1, 1, 2])];
        let data = MeshData { positions, triangles: triangles.clone(), ..MeshData::default() };
        let lights = |data| Light::of_surface(&Mesh::new(data).unwrap().into(), 7, Rgb::splat(2.0));
        let found = lights(data.clone());
        assert_eq!(found.len(), 2);
        let (mut mean, mut error) = (0.0, 0.0);
        for light in &found {
            let (part, part_error) = irradiance(light, DVec3::ZERO, DVec3::Z);
            (mean, error) = (mean + part, error + part_error);
            assert_eq!(light.surface(), Some(7));
        }
        let expected = corner_formula(1.5);
        assert!((mean - expected).abs() < 4.0 * error, "{mean} +- {error}, not {expected}");
        triangles.resize(MESH_TRIANGLES + 1, triangles[0]);
        assert!(lights(MeshData { triangles, ..data }).is_empty());
    }

    #[test]
    fn mirrored_parallelograms() {
        // Not rectangles: sampled by area.
        let left = parallelogram([[0.0, 0.0], [-1.0, 3.0], [1.0, 3.0], [2.0, 0.0]], 1.0);
        let right = parallelogram([[0.0, 0.0], [1.0, 3.0], [3.0, 3.0], [2.0, 0.0]], 1.0);
        // Each is the other's mirror image at x = 1.
        let (a, a_error) = irradiance(&left, DVec3::ZERO, DVec3::Z);
        let (b, b_error) = irradiance(&right, DVec3::X * 2.0, DVec3::Z);
        assert!((a - b).abs() < 4.0 * a_error.hypot(b_error), "{a} {b}");
    }

    #[test]
    fn sphere_in_front() {
        let center = DVec3::new(1.0, 2.0, 5.0);
        for radius in [1e-4, 0.5, 4.0] {
            let emitted = Rgb::splat(3.0);
            let light = Light::Sphere(SphereLight { center, radius, surface: 0, emitted });
            let normal = DVec3::new(1.0, 1.0, 3.0).normalize();
            // The whole sphere is above the horizon while its sine is below the cosine.
            let cosine = center.normalize().dot(normal);
            assert!(radius / center.length() < cosine);
            let expected =
                std::f64::consts::PI * 3.0 * radius * radius * cosine / center.length_squared();
            let (mean, error) = irradiance(&light, DVec3::ZERO, normal);
            let bound = 4.0 * error + 1e-9 * expected;
            assert!((mean - expected).abs() < bound, "{mean} +- {error}, not {expected}");
        }
        let emitted = Rgb::ONE;
        let light = Light::Sphere(SphereLight { center, radius: 1.0, surface: 0, emitted });
        assert!(light.view(center + 0.5).is_none());
    }
}
