//! [`Wall`]: what closes a mesh where the two sides of an edge show different heights.
//!
//! Both sides displace the edge along the same segments, so the hole between them is exactly the
//! part `{ P(s) + h N(s) : min(h_A, h_B) <= h <= max(h_A, h_B) }` of a bilinear patch. In the sheared
//! frame of a ray it is met where `p + h n = 0`, two equations; `p x n = 0` is a quadratic in `s`, and
//! `h = -(p . n) / (n . n)`. Heights are looked up at the uv of both sides. Interval and edge are
//! closed and widened by [`OVERLAP`] and by the rounding of root and height, so a wall overlaps the
//! sheets and walls it joins.

use glam::{DVec2, DVec3};

use crate::map::HeightMap;

use super::ReliefMesh;
use super::line::MeshRay;
use super::nearest::{Candidate, Nearest};
use super::patch::Heights;
use super::vertices::Vertex;

/// By how much a wall is longer than its edge, and higher than its sides, as a fraction.
pub(super) const OVERLAP: f64 = 1.0 / (1 << 28) as f64;

/// Lattice coordinates along an edge, as one side of it shows the map.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub ends: [[f64; 2]; 2],
    /// Towards the inside of the side: which of two tiles is shown where the edge runs between them.
    pub inside: [f64; 2],
}

impl Side {
    /// The unfolded cell shown at a place along the edge, and coordinates in it.
    pub fn place(&self, s: f64) -> ([i32; 2], [f64; 2]) {
        let [a, b] = self.ends;
        let (mut cell, mut at) = ([0; 2], [0.0; 2]);
        for k in 0..2 {
            let x = a[k] + s * (b[k] - a[k]);
            let line = x.round();
            // On a line between cells, the cell on the side's own side.
            let on_line = (x - line).abs() <= 1e-9;
            let first = if on_line && self.inside[k] < 0.0 {
                line - 1.0
            } else if on_line {
                line
            } else {
                x.floor()
            };
            (cell[k], at[k]) = (first as i32, x - first);
        }
        (cell, at)
    }

    /// Height over a level that the side shows of a map.
    pub fn height(&self, heights: &HeightMap, level: f32, s: f64) -> f64 {
        let (cell, at) = self.place(s);
        Heights::new(heights.unfolded_corners(cell[0], cell[1]), level).at(at[0], at[1])
    }
}

/// A wall over an edge; it runs as the edge does in the first side's triangle.
#[derive(Clone, Debug)]
pub(super) struct Wall {
    /// Vertices.
    pub ends: [u32; 2],
    /// The triangle of the first side.
    pub triangle: u32,
    pub first: Side,
    /// Nothing at an open border, where the wall goes down to offset 0.
    pub second: Option<Side>,
    /// The part whose map the second side shows, if it is not the mesh's own.
    pub neighbour: Option<u32>,
}

/// A point of a wall and its surroundings, relative to the mesh's centre.
pub(super) struct WallPoint {
    pub position: DVec3,
    /// Unit normal towards the lower side, away from what lies below the surface.
    pub normal: DVec3,
    /// Unit, along the displacement.
    pub up: DVec3,
}

impl Wall {
    /// Heights of both sides at a place along the edge.
    pub fn heights(&self, mesh: &ReliefMesh, s: f64) -> [f64; 2] {
        let s = s.clamp(0.0, 1.0);
        let second = match (&self.second, self.neighbour) {
            (None, _) => mesh.offsets.base(),
            (Some(side), None) => mesh.height_over(side, s),
            (Some(side), Some(part)) => mesh.height_beside(part, side, s),
        };
        [mesh.height_over(&self.first, s), second]
    }

    /// Where the ray meets the wall; says whether the search is over.
    pub fn meet(&self, item: u32, mesh: &ReliefMesh, ray: &MeshRay, nearest: &mut Nearest) -> bool {
        let [a, b] = self.ends.map(|k| mesh.vertices[k as usize]);
        let [p, q] = [a, b].map(|v| ray.sheared(v.base - ray.origin));
        let [n, o] = [a, b].map(|v| ray.sheared(v.rise));
        let (p1, n1) = (q - p, o - n);
        let cross = |a: DVec3, b: DVec3| a.x * b.y - a.y * b.x;
        let (c0, c1, c2) = (cross(p, n), cross(p, n1) + cross(p1, n), cross(p1, n1));
        let size = p.abs().max(q.abs()).max_element();
        let steep = n.abs().max(o.abs()).max_element();
        let rounding = 16.0 * f64::EPSILON * size * steep;
        let mut over = false;
        for s in roots([c0, c1, c2], rounding).into_iter().flatten() {
            let slope = (c1 + 2.0 * c2 * s).abs();
            let error = OVERLAP + (rounding / slope).min(1e-6);
            if s < -error || s > 1.0 + error {
                continue;
            }
            let s = s.clamp(0.0, 1.0);
            let (at, rise) = ((p + s * p1), (n + s * n1));
            let (flat, up) = (at.truncate(), rise.truncate());
            let height = -flat.dot(up) / up.dot(up);
            let [h, g] = self.heights(mesh, s);
            let slack = OVERLAP * (mesh.offsets.half_range + (h - g).abs())
                + 32.0 * f64::EPSILON * size / up.length()
                + error * (h - g).abs();
            if !(height >= h.min(g) - slack && height <= h.max(g) + slack) {
                continue;
            }
            let t = ray.t(at.z + height * rise.z);
            if !(t >= 0.0 && t <= nearest.limit()) {
                continue;
            }
            let point = self.point(mesh, DVec2::new(s, height));
            let front = point.normal.dot(ray.direction) < 0.0;
            if front || !mesh.options.one_sided {
                let at = DVec2::new(s, height);
                over |= nearest.offer(Candidate { t, item, cell: [0, 0], at, front });
            }
        }
        over
    }

    /// The point at a place along the edge and a height.
    pub fn point(&self, mesh: &ReliefMesh, at: DVec2) -> WallPoint {
        let [a, b]: [Vertex; 2] = self.ends.map(|k| mesh.vertices[k as usize]);
        let rise = a.rise.lerp(b.rise, at.x);
        let along = (b.base - a.base) + at.y * (b.rise - a.rise);
        // Away from the first side where offsets rise along the normal.
        let outward = along.cross(rise).normalize_or(DVec3::Z);
        let [h, g] = self.heights(mesh, at.x);
        let normal = if h >= g { outward } else { -outward };
        let unit = mesh.offsets.unit.signum();
        let up = unit * rise.normalize_or_zero();
        WallPoint { position: a.base.lerp(b.base, at.x) + at.y * rise, normal, up }
    }
}

/// Real roots of `c0 + c1 s + c2 s^2`; a discriminant negative by rounding counts as 0.
fn roots([c0, c1, c2]: [f64; 3], rounding: f64) -> [Option<f64>; 2] {
    let discriminant = c1 * c1 - 4.0 * c0 * c2;
    let spare = 8.0 * rounding * (c0.abs() + c1.abs() + c2.abs());
    if discriminant < -spare {
        return [None, None];
    }
    let q = -0.5 * (c1 + discriminant.max(0.0).sqrt().copysign(c1));
    let finite = |s: f64| s.is_finite().then_some(s);
    [finite(c0 / q), finite(q / c2)]
}
