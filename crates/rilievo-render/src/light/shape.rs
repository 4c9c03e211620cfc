//! [`Shape`]: how a point of an emitter is drawn that has no closed form: a relief, or a surface that
//! shines by an image.
//!
//! Densities are of directions, and a function of the receiver and of what a ray meets alone: so a ray
//! that a material has scattered finds the density with which the same meeting would have been drawn, and
//! weights agree. All is in the frame in which the surface was made.
//!
//! * [`Flat`]: a place of the base by solid angle or by an image, and the point of the relief above it.
//!   Where the base spreads by an area of 1 the surface spreads by `1 / (n . N)`.
//! * [`Shape::Ball`]: a direction in the cone that the ball around it fills; what it meets is the sample.
//!   From within the ball any direction.
//! * [`Shape::Triangles`]: a triangle by what it can bring, a point of it uniform in its weights. Sheets that fold
//!   over each other are drawn one by one.
//!
//! Upright walls have the density 0: they are found by scattered rays only, and counted in full.

use glam::{DVec2, DVec3};
use rilievo::relief::ReliefFace;
use rilievo::surface::Surface;
use rilievo::{Hit, Part};

use super::bounds::LightBounds;
use super::emission::{EmissionTable, luminance_over};
use super::quad::{QuadLight, QuadView};
use super::sphere::cone_around;
use super::tree::LightTree;
use super::{Receiver, luminance};
use crate::colour::Rgb;
use crate::sampler::warp::{square_to_cone, square_to_cone_pdf};
use crate::scene::Material;

/// Where a ray towards an emitter goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Target {
    /// A point of the emitter, or one beyond it.
    pub end: DVec3,
    /// Whether the ray must get as far as `end`: else whatever it meets first of the emitter counts.
    pub exact: bool,
}

/// How an emitter is drawn.
#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A parallelogram, displaced or not.
    Flat(Box<Flat>),
    /// What lies in a ball: a sphere, displaced or not.
    Ball {
        /// The ball's centre.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
    /// Triangles, displaced or not.
    Triangles(LightTree),
}

/// A parallelogram, and what is above it.
#[derive(Clone, Debug)]
pub(super) struct Flat {
    /// The base, moved to the middle of the offsets.
    pub(super) base: QuadLight,
    /// Half the range of the offsets.
    pub(super) half_range: f64,
    pub(super) table: Option<EmissionTable>,
}

impl Shape {
    /// How a surface that is no instance is drawn, and its bounds; nothing if it is dark.
    pub fn of(surface: &Surface, material: &Material) -> Option<(Self, LightBounds)> {
        match surface {
            Surface::Quad(quad) if quad.is_parallelogram() => {
                let (mean, table) = EmissionTable::of(material)?;
                let base = QuadLight::new(quad.corners(), 0, Rgb::ONE);
                let flat = Flat { base, half_range: 0.0, table };
                let (_, _, normal) = base.frame();
                let bounds = quad.bounds();
                let intensity = mean * base.area();
                let bounds = bounds_of([bounds.min, bounds.max], intensity, normal, 1.0);
                Some((Self::Flat(Box::new(flat)), held(bounds, mean)))
            }
            Surface::Face(face) => {
                let (mean, table) = EmissionTable::of(material)?;
                let [corner, u, v, normal] = face.frame();
                let [low, high] = offsets(face);
                let at = corner + 0.5 * (low + high) * normal;
                let base = QuadLight::new([at, at + u, at + u + v, at + v], 0, Rgb::ONE);
                let flat = Flat { base, half_range: 0.5 * (high - low).abs(), table };
                let bounds = face.bounds();
                let intensity = mean * base.area();
                // Normals of a height field lie within a right angle of its own.
                let bounds = bounds_of([bounds.min, bounds.max], intensity, normal, 0.0);
                Some((Self::Flat(Box::new(flat)), held(bounds, mean)))
            }
            Surface::Sphere(sphere) => ball(sphere.center(), sphere.radius(), material),
            Surface::ReliefSphere(sphere) => {
                let bounds = sphere.bounds();
                ball(sphere.center(), 0.5 * (bounds.max - bounds.min).x, material)
            }
            Surface::Quad(_) | Surface::Mesh(_) | Surface::ReliefMesh(_) => {
                let all: Vec<LightBounds> = (0..triangles(surface))
                    .map(|k| triangle_bounds(surface, k, material))
                    .collect();
                let bounds = all.iter().filter(|b| b.intensity > 0.0).copied();
                let bounds = bounds.reduce(|a, b| a.union(&b))?;
                let areas = (0..triangles(surface)).filter_map(|k| corners(surface, k));
                let area: f64 = areas.map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length()).sum();
                let bounds = held(bounds, bounds.intensity / area);
                Some((Self::Triangles(LightTree::new(&all)), bounds))
            }
            Surface::Instance(_) | Surface::Moving(_) => None,
        }
    }

    /// Whether one number is needed to choose a part.
    pub fn chooses(&self) -> bool {
        matches!(self, Self::Triangles(tree) if tree.len() > 1)
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        match self {
            Self::Flat(flat) => {
                let table = flat.table.as_ref().map_or(0, EmissionTable::bytes);
                size_of_val(flat.as_ref()) as u64 + table
            }
            Self::Ball { .. } => 0,
            Self::Triangles(tree) => tree.bytes(),
        }
    }

    /// Where to look from `at`, for `choice` and `u` uniform in `[0, 1)`.
    pub fn sample(
        &self,
        surface: &Surface,
        at: &Receiver,
        choice: f64,
        u: DVec2,
    ) -> Option<Target> {
        let end = match self {
            Self::Flat(flat) => flat.point(surface, at.position, u),
            Self::Ball { center, radius } => {
                let axis = center - at.position;
                let direction = match cone_around(axis, *radius) {
                    Some((world_from_cone, height)) => world_from_cone * square_to_cone(u, height),
                    None => square_to_cone(u, 2.0),
                };
                let end = at.position + direction * (axis.length() + 1.001 * radius);
                return Some(Target { end, exact: false });
            }
            Self::Triangles(tree) => {
                let (index, _, _) = tree.choose(at, choice)?;
                let root = u.x.sqrt();
                let [v, w] = [root * (1.0 - u.y), root * u.y];
                point(surface, index, [1.0 - root, v, w])?
            }
        };
        Some(Target { end, exact: true })
    }

    /// Density of the directions of [`Self::sample`] from `at` at what a ray from there has met, on its
    /// front, per steradian.
    pub fn pdf(&self, surface: &Surface, at: &Receiver, met: &Hit) -> f64 {
        let over_area = match self {
            Self::Flat(flat) => match (surface, met.part) {
                (_, Part::Wall(_)) => 0.0,
                (Surface::Face(face), _) => {
                    let [_, _, _, normal] = face.frame();
                    flat.pdf(at.position, met.uv) * met.geometric_normal.dot(normal).abs()
                }
                _ => flat.pdf(at.position, met.uv),
            },
            Self::Ball { center, radius } => {
                return match cone_around(center - at.position, *radius) {
                    Some((_, height)) => square_to_cone_pdf(DVec3::Z, height),
                    None => square_to_cone_pdf(DVec3::Z, 2.0),
                };
            }
            Self::Triangles(tree) => match met.part {
                Part::Triangle(index) | Part::TriangleCell { triangle: index, .. } => {
                    // Twice the weights' area, which is a half.
                    let spread = match surface {
                        Surface::ReliefMesh(mesh) => mesh.spread(met),
                        _ => corners(surface, index).map(|[a, b, c]| (b - a).cross(c - a).length()),
                    };
                    spread.map_or(0.0, |spread| 2.0 * tree.probability(at, index) / spread)
                }
                _ => 0.0,
            },
        };
        let way = met.position - at.position;
        let squared = way.length_squared();
        let pdf = over_area * squared * squared.sqrt() / way.dot(met.geometric_normal).abs();
        if pdf.is_finite() { pdf } else { 0.0 }
    }
}

impl Flat {
    /// The view of the base, where it is good for drawing places of it: in the shell, light comes from
    /// all around and not from the foot of the receiver.
    fn view(&self, from: DVec3) -> QuadView {
        let (corner, _, normal) = self.base.frame();
        let height = (from - corner).dot(normal);
        match self.base.view(from) {
            Some(view) if height > 2.0 * self.half_range => view,
            _ => QuadView::Area,
        }
    }

    /// A point of the surface.
    fn point(&self, surface: &Surface, from: DVec3, u: DVec2) -> DVec3 {
        let uv = match &self.table {
            Some(table) => table.sample(u),
            None => self.base.place(&self.view(from), u),
        };
        match surface {
            Surface::Face(face) => face_point(face, uv),
            _ => self.base.at(uv),
        }
    }

    /// Density of the places of the base, per square scene unit.
    fn pdf(&self, from: DVec3, uv: DVec2) -> f64 {
        let place = match &self.table {
            Some(table) => return table.pdf(uv) / self.base.area(),
            None => self.base.at(uv),
        };
        let (_, _, normal) = self.base.frame();
        match self.view(from) {
            QuadView::Area => 1.0 / self.base.area(),
            view => {
                let way = place - from;
                let (squared, cosine) = (way.length_squared(), way.normalize().dot(normal).abs());
                self.base.pdf(&view, way, squared.sqrt()) * cosine / squared
            }
        }
    }
}

/// The point of a displaced parallelogram above a place of its base.
fn face_point(face: &ReliefFace, uv: DVec2) -> DVec3 {
    let [corner, u, v, normal] = face.frame();
    let d = face.options().displacement;
    let at = [uv.x * d.tile[0] + d.shift[0], uv.y * d.tile[1] + d.shift[1]];
    let offset = d.scale * (face.relief().heights().height_at(at[0], at[1]) - d.zero);
    corner + uv.x * u + uv.y * v + offset * normal
}

/// The lowest and the highest offset of a face's heights, in one order or the other.
fn offsets(face: &ReliefFace) -> [f64; 2] {
    let (d, heights) = (face.options().displacement, face.relief().heights());
    let (low, high) = heights.raw_range();
    [low, high].map(|raw| d.scale * (f64::from(raw) * heights.unit() - d.zero))
}

fn ball(center: DVec3, radius: f64, material: &Material) -> Option<(Shape, LightBounds)> {
    let (mean, _) = EmissionTable::of(material)?;
    let intensity = mean * std::f64::consts::PI * radius * radius;
    let ends = [center - radius, center + radius];
    let bounds = bounds_of(ends, intensity, DVec3::Z, -1.0);
    Some((Shape::Ball { center, radius }, held(bounds, mean)))
}

fn bounds_of([min, max]: [DVec3; 2], intensity: f64, axis: DVec3, cos_normals: f64) -> LightBounds {
    LightBounds { min, max, intensity, axis, cos_normals, cos_emission: 0.0, held: 0.0, most: 0.0 }
}

/// An emitter that fills more than this share of what a receiver sees is found well by the directions that
/// materials scatter to, and need not be drawn more often. Measured on a glowing relief among forty lamps:
/// without it pixels of the relief have 2.4 times the variance, with it as much as by chance.
const FILLED: f64 = 0.1;

/// Bounds of an emitter of a radiance, their importance held to what light from a share of all around
/// brings.
fn held(bounds: LightBounds, radiance: f64) -> LightBounds {
    let most = FILLED * std::f64::consts::PI * radiance;
    LightBounds { held: bounds.intensity, most, ..bounds }
}

/// Triangles of a surface that is made of them.
fn triangles(surface: &Surface) -> u32 {
    match surface {
        Surface::Quad(_) => 2,
        Surface::Mesh(mesh) => mesh.data().triangles.len() as u32,
        Surface::ReliefMesh(mesh) => mesh.data().triangles.len() as u32,
        _ => 0,
    }
}

/// Corners of a base triangle.
fn corners(surface: &Surface, index: u32) -> Option<[DVec3; 3]> {
    match surface {
        Surface::Quad(quad) => {
            let [c0, c1, c2, c3] = quad.corners();
            Some(if index == 0 { [c0, c1, c2] } else { [c0, c2, c3] })
        }
        Surface::Mesh(mesh) => Some(mesh.corners(index)),
        Surface::ReliefMesh(mesh) => {
            let data = mesh.data();
            let triangle = data.triangles.get(index as usize)?;
            Some(triangle.positions.map(|p| data.positions[p as usize]))
        }
        _ => None,
    }
}

/// Uv of the corners of a base triangle.
fn uvs(surface: &Surface, index: u32) -> Option<[DVec2; 3]> {
    let data = match surface {
        Surface::Quad(_) if index == 0 => return Some([DVec2::ZERO, DVec2::X, DVec2::ONE]),
        Surface::Quad(_) => return Some([DVec2::ZERO, DVec2::ONE, DVec2::Y]),
        Surface::Mesh(mesh) => mesh.data(),
        Surface::ReliefMesh(mesh) => mesh.data(),
        _ => return None,
    };
    let uvs = data.triangles.get(index as usize)?.uvs?;
    Some(uvs.map(|uv| data.uvs[uv as usize]))
}

/// The point of a triangle at barycentric weights.
fn point(surface: &Surface, index: u32, weights: [f64; 3]) -> Option<DVec3> {
    if let Surface::ReliefMesh(mesh) = surface {
        return Some(mesh.point(index, weights));
    }
    let [a, b, c] = corners(surface, index)?;
    Some(weights[0] * a + weights[1] * b + weights[2] * c)
}

/// Bounds of a triangle, displaced or not.
fn triangle_bounds(surface: &Surface, index: u32, material: &Material) -> LightBounds {
    let [a, b, c] = corners(surface, index).unwrap_or([DVec3::ZERO; 3]);
    let across = (b - a).cross(c - a);
    // A triangle that is dark on average may hold a spark.
    let mean = match uvs(surface, index) {
        Some(uvs) => luminance_over(material, uvs) + 1e-3 * luminance(material.emitted),
        None => luminance(material.emitted_at(DVec2::ZERO)),
    };
    let (ends, cos_normals) = match surface {
        Surface::ReliefMesh(mesh) => {
            let bounds = mesh.triangle_bounds(index);
            ([bounds.min, bounds.max], 0.0)
        }
        _ => ([a.min(b).min(c), a.max(b).max(c)], 1.0),
    };
    let axis = across.normalize_or(DVec3::Z);
    bounds_of(ends, 0.5 * across.length() * mean, axis, cos_normals)
}
