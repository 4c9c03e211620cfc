//! Rays that leave a displaced mesh.
//!
//! A ray that starts on the surface is off it by rounding, and may start on either side. As with
//! faces, its start is lifted along the displacement, towards the side the ray leaves to: over one
//! base triangle, and across edges that share their normals, the surface is a graph along the
//! displacement as long as it does not fold, so no sheet beside the start can be between start and
//! lift. The lift is larger than all that start and leaf may be off by, times the steepest slope that
//! the heights under the triangle allow over one cell, so the lifted start is on the right side of
//! every sheet around it, by more than the leaf's rounding; then the sign of a root's parameter is
//! right. It is some 1e-12 of the size of the mesh.
//!
//! From a wall the start is lifted along the wall's normal, and along the displacement as well.

use glam::{DMat3, DVec2, DVec3};

use crate::ray::{Origin, Part, Ray};

use super::ReliefMesh;
use super::patch::Heights;
use super::prism::{Prism, Shape};

/// Lifts are this much larger than rounding.
const SPARE: f64 = 4.0;

impl ReliefMesh {
    /// The ray, its start lifted off this mesh if that is what it leaves.
    pub(super) fn lifted(&self, ray: &Ray) -> Ray {
        let lift = match ray.from {
            Some(Origin { part: Part::TriangleCell { triangle, cell }, front, .. }) => {
                self.lift_from_cell(ray, triangle, cell, front)
            }
            Some(Origin { part: Part::SeamWall(wall), front, .. }) => {
                self.lift_from_wall(ray, wall, front)
            }
            _ => None,
        };
        Ray { origin: ray.origin + lift.unwrap_or(DVec3::ZERO), ..*ray }
    }

    fn lift_from_cell(
        &self,
        ray: &Ray,
        triangle: u32,
        cell: [i32; 2],
        front: bool,
    ) -> Option<DVec3> {
        let prism = self.prisms.get(triangle as usize)?;
        let jacobian = self.jacobian_near(prism, cell, ray.origin - self.centre);
        let up = jacobian.z_axis.try_normalize()?;
        let side = if jacobian.determinant() < 0.0 { -1.0 } else { 1.0 };
        let side = if front { side } else { -side };
        Some(side * self.lift(prism, ray.origin) * up)
    }

    fn lift_from_wall(&self, ray: &Ray, wall: u32, front: bool) -> Option<DVec3> {
        let wall = self.walls.get(wall as usize)?;
        let [a, b] = wall.ends.map(|k| self.vertices[k as usize]);
        let start = ray.origin - self.centre;
        // Place along the edge and height: two steps of Newton from the middle are near enough.
        let mut at = DVec2::new(0.5, 0.0);
        for _ in 0..4 {
            let rise = a.rise.lerp(b.rise, at.x);
            let along = (b.base - a.base) + at.y * (b.rise - a.rise);
            let off = start - (a.base.lerp(b.base, at.x) + at.y * rise);
            let Some(step) = least_squares([along, rise], off) else { break };
            at += step;
            at.x = at.x.clamp(0.0, 1.0);
        }
        let point = wall.point(self, at);
        let lift = self.lift(self.prisms.get(wall.triangle as usize)?, ray.origin);
        let side = if front { 1.0 } else { -1.0 };
        Some(side * lift * (point.normal + point.up))
    }

    /// Length of a lift from a prism.
    fn lift(&self, prism: &Prism, start: DVec3) -> f64 {
        let rounding = prism.rounding(self.reach) + 2.0 * f64::EPSILON * start.abs().max_element();
        SPARE * rounding * (1.0 + prism.steepness())
    }

    /// Derivatives of the shell along the weights of the second and third corner and along the
    /// height, where the sheet over a cell comes nearest to `point`, which it passes but for
    /// rounding. The sheet, not the shell, is searched: a shell that folds may pass a point twice.
    fn jacobian_near(&self, prism: &Prism, cell: [i32; 2], point: DVec3) -> DMat3 {
        let [a, b, c] = prism.corners.map(|k| self.vertices[k as usize]);
        let corners = self.relief.heights().unfolded_corners(cell[0], cell[1]);
        let heights = Heights::new(corners, self.offsets.level);
        let [p, q, r] = prism.lattice.map(DVec2::from_array);
        let (e, f) = (q - p, r - p);
        let corner = DVec2::new(f64::from(cell[0]), f64::from(cell[1]));
        let near =
            16.0 * (prism.rounding(self.reach) + f64::EPSILON * self.centre.abs().max_element());
        let mut best = (f64::INFINITY, DMat3::IDENTITY);
        for start in STARTS {
            let mut weights = match prism.shape {
                Shape::Spread => {
                    let at = corner + start;
                    DVec2::from_array(prism.weights_at([at.x, at.y]))
                }
                Shape::Thread => start,
            };
            for _ in 0..STEPS {
                // Into the triangle, or near it.
                weights = weights.clamp(DVec2::ZERO, DVec2::ONE);
                weights /= (weights.x + weights.y).max(1.0);
                let local = p + weights.x * e + weights.y * f - corner;
                let local = local.clamp(DVec2::ZERO, DVec2::ONE);
                let height = heights.at(local.x, local.y);
                let slope =
                    DVec2::new(heights.b + heights.d * local.y, heights.c + heights.d * local.x);
                let rise = a.rise + weights.x * (b.rise - a.rise) + weights.y * (c.rise - a.rise);
                let base = a.base + weights.x * (b.base - a.base) + weights.y * (c.base - a.base);
                let shell = DMat3::from_cols(
                    (b.base - a.base) + height * (b.rise - a.rise),
                    (c.base - a.base) + height * (c.rise - a.rise),
                    rise,
                );
                let off = point - base - height * rise;
                if off.length() < best.0 {
                    best = (off.length(), shell);
                }
                let along =
                    [shell.x_axis + slope.dot(e) * rise, shell.y_axis + slope.dot(f) * rise];
                let Some(step) = least_squares(along, off) else { break };
                weights += step;
                if step.abs().max_element() < 1e-9 {
                    break;
                }
            }
            if best.0 <= near {
                return best.1;
            }
        }
        self.jacobian_by_height(prism, cell, &heights, point).unwrap_or(best.1)
    }
}

impl ReliefMesh {
    /// The same where steps of Newton do not lead there, as on steep and twisted cells. At a height `h` of the shell
    /// the base is a level triangle, whose plane passes the point where a cubic in `h` is zero
    /// \[Ogaki2023\]; of its roots that one counts whose place in the level triangle shows the height nearest to it.
    #[cold]
    fn jacobian_by_height(
        &self,
        prism: &Prism,
        cell: [i32; 2],
        heights: &Heights,
        point: DVec3,
    ) -> Option<DMat3> {
        let [a, b, c] = prism.corners.map(|k| self.vertices[k as usize]);
        let [p, q, r] = prism.lattice.map(DVec2::from_array);
        let corner = DVec2::new(f64::from(cell[0]), f64::from(cell[1]));
        let ends = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| heights.at(x, y));
        let (low, high) = ends.iter().fold((f64::MAX, f64::MIN), |(l, h), &e| (l.min(e), h.max(e)));
        let spare = 1e-6 * (high - low) + self.height_slack;
        let (low, high) = (low - spare, high + spare);
        // Edges and the way to the point, at the low end and per share of the way to the high one.
        let level = |v: super::Vertex| v.base + low * v.rise;
        let (e, f, x) = (level(b) - level(a), level(c) - level(a), point - level(a));
        let step = high - low;
        let (de, df, dx) = (step * (b.rise - a.rise), step * (c.rise - a.rise), -step * a.rise);
        let mixed = de.cross(f) + e.cross(df);
        let cubic = [
            e.cross(f).dot(x),
            mixed.dot(x) + e.cross(f).dot(dx),
            de.cross(df).dot(x) + mixed.dot(dx),
            de.cross(df).dot(dx),
        ];
        let mut best: Option<(f64, DMat3)> = None;
        let mut take = |share: f64| {
            let (e, f, x) = (e + share * de, f + share * df, x + share * dx);
            let Some(weights) = least_squares([e, f], x) else { return };
            let at = p + weights.x * (q - p) + weights.y * (r - p) - corner;
            let height = low + share * step;
            let outside = (at - at.clamp(DVec2::ZERO, DVec2::ONE)).abs().max_element();
            let off = (heights.at(at.x, at.y) - height).abs() + outside * step;
            if best.is_none_or(|best| off < best.0) {
                let rise = a.rise + weights.x * (b.rise - a.rise) + weights.y * (c.rise - a.rise);
                best = Some((off, DMat3::from_cols(e, f, rise)));
            }
        };
        let value = |s: f64| cubic[0] + s * (cubic[1] + s * (cubic[2] + s * cubic[3]));
        for piece in 0..PIECES {
            let ends = [piece, piece + 1].map(|k| f64::from(k) / f64::from(PIECES));
            let (mut from, mut to) = (ends[0], ends[1]);
            let sign = value(from) > 0.0;
            if sign == (value(to) > 0.0) {
                continue;
            }
            for _ in 0..50 {
                let middle = 0.5 * (from + to);
                if (value(middle) > 0.0) == sign {
                    from = middle;
                } else {
                    to = middle;
                }
            }
            take(0.5 * (from + to));
        }
        best.map(|best| best.1)
    }
}

/// Parts of a cell's heights in each of which the cubic has one root at most, or two so near that either will do.
const PIECES: u32 = 32;

/// Steps of Gauss and Newton from each start.
const STEPS: usize = 12;

/// Where in a cell, or among weights, the search begins.
const STARTS: [DVec2; 5] = [
    DVec2::new(0.5, 0.5),
    DVec2::new(0.1, 0.1),
    DVec2::new(0.9, 0.1),
    DVec2::new(0.1, 0.9),
    DVec2::new(0.9, 0.9),
];

/// The factors of two vectors whose sum comes nearest to a third.
fn least_squares([u, v]: [DVec3; 2], to: DVec3) -> Option<DVec2> {
    let (uu, uv, vv) = (u.dot(u), u.dot(v), v.dot(v));
    let (x, y) = (u.dot(to), v.dot(to));
    let area = uu * vv - uv * uv;
    let step = DVec2::new(vv * x - uv * y, uu * y - uv * x) / area;
    step.is_finite().then_some(step)
}
