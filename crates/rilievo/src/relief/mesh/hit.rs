//! From a crossing to a [`Hit`]: position, normals, uv.
//!
//! The geometric normal is that of the displaced surface itself, `S_1 x S_2` in the barycentric
//! weights of the second and third corner, so that it points to the front of the base triangle
//! wherever the surface does not fold.
//!
//! The shading normal bends the authored normal `n` by the slopes of the map \[Blinn1978\], with the tangents
//! `T` of the base at the height of the hit: `det n - o_x (T_y x n) - o_y (n x T_x)`. Where the
//! file has no normals it is the normal of the surface with smoothed slopes.

use glam::{DVec2, DVec3};

use crate::hit::Hit;
use crate::map::{Metric, NormalKind};
use crate::ray::{Part, Ray};
use crate::simd::{self, Kernel, Lanes};

use super::super::options::ShadingNormals;
use super::nearest::Candidate;
use super::patch::Heights;
use super::prism::Shape;
use super::{MeshCrossing, ReliefMesh};

/// A point of a displaced triangle.
struct Point {
    triangle: u32,
    cell: [i32; 2],
    /// Weights of the corners, at least 0.
    weights: [f64; 3],
    /// Place in the cell.
    local: [f64; 2],
    /// Height over the level.
    height: f64,
    /// Height per cell along x and y.
    slope: [f64; 2],
}

/// [`ReliefMesh::complete`], with the instructions of a level: no answer depends on it.
struct Complete<'a> {
    mesh: &'a ReliefMesh,
    ray: &'a Ray,
    crossing: &'a MeshCrossing,
}

impl Kernel for Complete<'_> {
    type Output = Hit;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Hit {
        self.mesh.completed(self.ray, self.crossing)
    }
}

impl ReliefMesh {
    /// The hit of a crossing that [`ReliefMesh::first_crossing`] found for this ray. `hit.surface`
    /// is 0.
    pub fn complete(&self, ray: &Ray, crossing: &MeshCrossing) -> Hit {
        simd::run(self.options.simd, Complete { mesh: self, ray, crossing })
    }

    #[inline(always)]
    fn completed(&self, ray: &Ray, crossing: &MeshCrossing) -> Hit {
        let MeshCrossing { t, candidate } = *crossing;
        let count = self.prisms.len() as u32;
        if candidate.item >= count {
            let hit = self.complete_wall(t, &candidate, candidate.item - count);
            return Hit { time: ray.time, ..hit };
        }
        let point = self.point_of(&candidate);
        let prism = &self.prisms[point.triangle as usize];
        let [a, b, c] = prism.corners.map(|k| self.vertices[k as usize]);
        let [u, v, w] = point.weights;
        let rise = u * a.rise + v * b.rise + w * c.rise;
        let place = u * a.base + v * b.base + w * c.base + point.height * rise;
        let along = [1, 2].map(|k| {
            let [from, to] = [prism.lattice[0], prism.lattice[k]];
            let height = point.slope[0] * (to[0] - from[0]) + point.slope[1] * (to[1] - from[1]);
            let end = if k == 1 { b } else { c };
            (end.base - a.base) + point.height * (end.rise - a.rise) + height * rise
        });
        let normal = along[0].cross(along[1]).try_normalize();
        let geometric_normal = normal.unwrap_or_else(|| self.base_normal(point.triangle));
        let (uv, tangents) = self.parametrisation(&point);
        let position = self.centre + place;
        let exact = prism.rounding(self.reach) + 4.0 * f64::EPSILON * position.length();
        Hit {
            t,
            position,
            // Off the exact point, and the exact point off the ray by rounding.
            position_error: exact,
            geometric_normal,
            shading_normal: self.shading_normal(&point, geometric_normal),
            tangents,
            uv,
            height: (point.height + f64::from(self.offsets.level)) * self.relief.heights().unit(),
            front: geometric_normal.dot(ray.direction) < 0.0,
            surface: 0,
            part: Part::TriangleCell { triangle: point.triangle, cell: point.cell },
            time: ray.time,
        }
    }

    /// By how much the displaced surface spreads at a hit: its area for an area of 1 of the weights of
    /// the second and third corner, square scene units. Nothing on walls and on triangles whose uv
    /// span no area.
    ///
    /// With `S = P + h N` and `h` the height, `S_v x S_w . N = (P_v + h N_v) x (P_w + h N_w) . N`: slopes
    /// of the map add only along `N`. So the length of the cross product follows from the normal of
    /// the hit, which lies along it.
    pub fn spread(&self, hit: &Hit) -> Option<f64> {
        let Part::TriangleCell { triangle, .. } = hit.part else { return None };
        let prism = self.prisms.get(triangle as usize)?;
        if prism.shape == Shape::Thread {
            return None;
        }
        let uvs = self.data.triangles[triangle as usize].uvs?;
        let [a, b, c] = uvs.map(|uv| self.data.uvs[uv as usize]);
        let (g, h, to) = (b - a, c - a, hit.uv - a);
        let area = g.perp_dot(h);
        let (v, w) = (to.perp_dot(h) / area, g.perp_dot(to) / area);
        let height = hit.height / self.relief.heights().unit() - f64::from(self.offsets.level);
        let [a, b, c] = prism.corners.map(|k| self.vertices[k as usize]);
        let rise = (1.0 - v - w) * a.rise + v * b.rise + w * c.rise;
        let along = [b, c].map(|end| (end.base - a.base) + height * (end.rise - a.rise));
        let spread = (along[0].cross(along[1]).dot(rise) / hit.geometric_normal.dot(rise)).abs();
        spread.is_finite().then_some(spread)
    }

    #[inline(never)]
    fn complete_wall(&self, t: f64, candidate: &Candidate, index: u32) -> Hit {
        let wall = &self.walls[index as usize];
        let point = wall.point(self, candidate.at);
        let triangle = &self.data.triangles[wall.triangle as usize];
        let prism = &self.prisms[wall.triangle as usize];
        let corner = |end: u32| prism.corners.iter().position(|&k| k == end);
        let uv_of = |end: usize| match (triangle.uvs, corner(wall.ends[end])) {
            (Some(uvs), Some(k)) => self.data.uvs[uvs[k] as usize],
            // Of a wall inside of the triangle, from where it shows the map.
            _ => self.uv_at(wall.first.ends[end]),
        };
        let uv = uv_of(0).lerp(uv_of(1), candidate.at.x);
        let corners = triangle.positions.map(|p| self.data.positions[p as usize]);
        let position = self.centre + point.position;
        Hit {
            t,
            position,
            position_error: 64.0 * f64::EPSILON * self.reach
                + 4.0 * f64::EPSILON * position.length(),
            geometric_normal: point.normal,
            shading_normal: point.normal,
            tangents: [corners[1] - corners[0], corners[2] - corners[0]],
            uv,
            height: (candidate.at.y + f64::from(self.offsets.level)) * self.relief.heights().unit(),
            front: candidate.front,
            surface: 0,
            part: Part::SeamWall(index),
            time: 0.0,
        }
    }

    /// The uv that show a place of the unfolded lattice.
    fn uv_at(&self, [x, y]: [f64; 2]) -> DVec2 {
        let (heights, shown) = (self.relief.heights(), self.options.displacement);
        let tiled = DVec2::new(heights.x().parameter(x), heights.y().parameter(y));
        (tiled - DVec2::from_array(shown.shift)) / DVec2::from_array(shown.tile)
    }

    #[inline(always)]
    fn point_of(&self, candidate: &Candidate) -> Point {
        let Candidate { item: triangle, cell, at, .. } = *candidate;
        let prism = &self.prisms[triangle as usize];
        let (weights, local) = match prism.shape {
            Shape::Spread => {
                let lattice = [f64::from(cell[0]) + at.x, f64::from(cell[1]) + at.y];
                (prism.weights_at(lattice), at.to_array())
            }
            Shape::Thread => {
                let [a, b, c] = prism.lattice;
                let along = |k: usize| at.x * (b[k] - a[k]) + at.y * (c[k] - a[k]);
                ([at.x, at.y], [0, 1].map(|k| a[k] - f64::from(cell[k]) + along(k)))
            }
        };
        let [v, w] = weights.map(|w| w.clamp(0.0, 1.0));
        let corners = self.relief.heights().unfolded_corners(cell[0], cell[1]);
        let heights = Heights::new(corners, self.offsets.level);
        let local = local.map(|x| x.clamp(0.0, 1.0));
        Point {
            triangle,
            cell,
            weights: [(1.0 - v - w).max(0.0), v, w],
            local,
            height: heights.at(local[0], local[1]),
            slope: [heights.b + heights.d * local[1], heights.c + heights.d * local[0]],
        }
    }

    /// Unit normal of a base triangle; where it has no area, anything.
    pub(super) fn base_normal(&self, triangle: u32) -> DVec3 {
        let triangle = &self.data.triangles[triangle as usize];
        let [a, b, c] = triangle.positions.map(|p| self.data.positions[p as usize]);
        (b - a).cross(c - a).normalize_or(DVec3::Z)
    }

    /// Uv and (dP/du, dP/dv) of the base.
    #[inline(always)]
    fn parametrisation(&self, point: &Point) -> (DVec2, [DVec3; 2]) {
        let triangle = &self.data.triangles[point.triangle as usize];
        let [a, b, c] = triangle.positions.map(|p| self.data.positions[p as usize]);
        let (e, f) = (b - a, c - a);
        let Some(uvs) = triangle.uvs else { return (DVec2::ZERO, [e, f]) };
        let [a, b, c] = uvs.map(|uv| self.data.uvs[uv as usize]);
        let [u, v, w] = point.weights;
        let (g, h) = (b - a, c - a);
        let area = g.perp_dot(h);
        let tangents = [(h.y * e - g.y * f) / area, (g.x * f - h.x * e) / area];
        let finite = tangents.iter().all(|t| t.is_finite());
        (u * a + v * b + w * c, if finite { tangents } else { [e, f] })
    }

    /// Unit normal to shade with, on the side of the geometric one.
    #[inline(always)]
    fn shading_normal(&self, point: &Point, geometric: DVec3) -> DVec3 {
        let prism = &self.prisms[point.triangle as usize];
        if matches!(self.options.normals, ShadingNormals::Exact) || prism.shape == Shape::Thread {
            return geometric;
        }
        let sheet = prism.sheet(&self.vertices);
        let at = [0, 1].map(|k| f64::from(point.cell[k]) + point.local[k]);
        let jacobian = sheet.jacobian(DVec3::new(at[0], at[1], point.height));
        let tangents = [jacobian.x_axis, jacobian.y_axis];
        let metric =
            Metric { x: tangents[0].length(), y: tangents[1].length(), z: self.offsets.unit.abs() };
        if !metric.is_positive() {
            return geometric;
        }
        // Offsets per cell along the unit displacement.
        let [along_x, along_y] = self.shading_slopes(point, metric);
        let up = jacobian.z_axis / self.offsets.unit;
        let [tx, ty] = tangents;
        let normal = match self.authored_normal(point) {
            Some(n) => {
                let (along_x, along_y) = (along_x * up.dot(n), along_y * up.dot(n));
                n * n.dot(tx.cross(ty)) - along_x * ty.cross(n) - along_y * n.cross(tx)
            }
            None => (tx + along_x * up).cross(ty + along_y * up),
        };
        let normal = (prism.winding() * normal).try_normalize().unwrap_or(geometric);
        if normal.dot(geometric) > 0.0 { normal } else { geometric }
    }

    /// Offsets per cell along x and y, to shade with.
    #[inline(always)]
    fn shading_slopes(&self, point: &Point, metric: Metric) -> [f64; 2] {
        let heights = self.relief.heights();
        let turn = self.offsets.unit.signum();
        let slopes = |normal: DVec3, metric: Metric| {
            let z = normal.z.max(1e-9);
            [-normal.x / z * metric.x, -normal.y / z * metric.y]
        };
        let kind = |kind: NormalKind, made_in: Metric| {
            let normal = kind.direction_at(heights, made_in, point.cell, point.local);
            slopes(normal, metric).map(|slope| turn * slope)
        };
        match &self.options.normals {
            ShadingNormals::Exact => kind(NormalKind::Exact, metric),
            ShadingNormals::Smooth => kind(NormalKind::Smooth, metric),
            ShadingNormals::Published => kind(NormalKind::Published, metric),
            ShadingNormals::WrongMetric => {
                kind(NormalKind::Smooth, Metric::of_face(heights, [1.0; 2], 1.0))
            }
            ShadingNormals::Map(map) => {
                let u = heights.x().parameter(f64::from(point.cell[0]) + point.local[0]);
                let v = heights.y().parameter(f64::from(point.cell[1]) + point.local[1]);
                slopes(map.normal_at(u, v), metric)
            }
        }
    }

    /// The file's normal, interpolated.
    fn authored_normal(&self, point: &Point) -> Option<DVec3> {
        let normals = self.data.triangles[point.triangle as usize].normals?;
        let [a, b, c] = normals.map(|n| self.data.normals[n as usize].normalize_or_zero());
        let [u, v, w] = point.weights;
        (u * a + v * b + w * c).try_normalize()
    }
}
