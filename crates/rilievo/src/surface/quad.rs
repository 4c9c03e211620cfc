//! [`Quad`]: an undisplaced quadrilateral.
//!
//! A quad is two triangles, c0 c1 c2 and c0 c2 c3, met by the test of meshes; a parallelogram is
//! the case in which both lie in one plane and agree on uv. Edges are always widened by a few
//! roundings, so that neighbours whose common edge is not the same bit for bit, such as a wall
//! beside half of another, still do not leak.

use glam::{DVec2, DVec3};
use thiserror::Error;

use crate::accel::Aabb;
use crate::hit::Hit;
use crate::mesh::COORDINATE_LIMIT;
use crate::mesh::crossing::{Crossing, Edges, ShearedRay};
use crate::mesh::departure::Departure;
use crate::mesh::triangle::{interpolate_position, triangle_normal};
use crate::ray::{Origin, Part, Ray};

/// A quadrilateral with corners c0, c1, c2, c3: u runs from c0 to c1, v from c0 to c3, and the
/// front is where the corners run counter-clockwise, the side of `(c1 - c0) x (c3 - c0)`.
///
/// Hits on a parallelogram are [`Part::Whole`]; any other quad reports [`Part::Triangle`] 0
/// (c0 c1 c2) or 1 (c0 c2 c3), over each of which uv is linear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quad {
    corners: [DVec3; 4],
    /// Unit normals of the two triangles.
    normals: [DVec3; 2],
    parallelogram: bool,
    one_sided: bool,
}

/// Why a quad was refused.
#[derive(Clone, Copy, Debug, Error, PartialEq, Eq)]
pub enum QuadError {
    /// A corner is NaN, infinite or beyond [`COORDINATE_LIMIT`].
    #[error("corner c{0} is not finite or larger than 1e100")]
    Corner(usize),
    /// A triangle has no area to rounding.
    #[error("triangle {0} has no area")]
    Degenerate(&'static str),
}

/// Corner numbers of the two triangles, and uv of the corners.
const TRIANGLES: [[usize; 3]; 2] = [[0, 1, 2], [0, 2, 3]];
const CORNER_UV: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

impl Quad {
    /// Checks the corners. Rays from behind pass through a `one_sided` quad.
    ///
    /// # Errors
    /// See [`QuadError`].
    pub fn new(corners: [DVec3; 4], one_sided: bool) -> Result<Self, QuadError> {
        // Negated, so that NaN is refused.
        let wild = |p: &DVec3| !p.abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all();
        if let Some(i) = corners.iter().position(wild) {
            return Err(QuadError::Corner(i));
        }
        let [c0, c1, c2, c3] = corners;
        let first = triangle_normal(&[c0, c1, c2]).ok_or(QuadError::Degenerate("c0 c1 c2"))?;
        let second = triangle_normal(&[c0, c2, c3]).ok_or(QuadError::Degenerate("c0 c2 c3"))?;
        let reach = Aabb::around(corners).largest_coordinate();
        let gap = (c2 - c1) - (c3 - c0);
        let parallelogram = gap.abs().max_element() <= 8.0 * f64::EPSILON * reach;
        let normals = match triangle_normal(&[c0, c1, c3]) {
            Some(normal) if parallelogram => [normal; 2],
            _ => [first, second],
        };
        Ok(Self { corners, normals, parallelogram, one_sided })
    }

    /// c0, c1, c2, c3.
    pub fn corners(&self) -> [DVec3; 4] {
        self.corners
    }

    /// Whether c2 completes a parallelogram, to rounding.
    pub fn is_parallelogram(&self) -> bool {
        self.parallelogram
    }

    /// Whether rays from behind pass through.
    pub fn one_sided(&self) -> bool {
        self.one_sided
    }

    /// The smallest box around the corners.
    pub fn bounds(&self) -> Aabb {
        Aabb::around(self.corners)
    }

    /// The hit within `0 <= t <= t_max`. `hit.surface` is 0.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let departure = ray.from.and_then(|from| self.departure(from));
        let (half, crossing) = self.meet(ray, departure.as_ref())?;
        Some(Hit { time: ray.time, ..self.complete(half, &crossing) })
    }

    /// Whether the quad is met within `0 <= t <= t_max`.
    pub fn occludes(&self, ray: &Ray) -> bool {
        let departure = ray.from.and_then(|from| self.departure(from));
        self.meet(ray, departure.as_ref()).is_some()
    }

    /// What a ray that starts at `from`, on this quad, leaves.
    pub(crate) fn departure(&self, from: Origin) -> Option<Departure<'_>> {
        match from.part {
            Part::Whole => Some(Departure::Parallelogram(&self.corners, None, from.front)),
            Part::Triangle(half @ 0..2) => {
                Some(Departure::Triangle(self.triangle(half as usize), from.front))
            }
            _ => None,
        }
    }

    /// The hit behind a crossing of a half, at time 0.
    pub(crate) fn complete(&self, half: usize, crossing: &Crossing) -> Hit {
        let (position, position_error) =
            interpolate_position(&self.triangle(half), &crossing.weights);
        let normal = self.normals[half];
        let [a, b, c] = TRIANGLES[half];
        let [a, b, c] = [CORNER_UV[a], CORNER_UV[b], CORNER_UV[c]];
        let uv = crossing.weights[0] * a + crossing.weights[1] * b + crossing.weights[2] * c;
        let [c0, c1, c2, c3] = self.corners;
        let tangents = match (self.parallelogram, half) {
            (true, _) => [c1 - c0, c3 - c0],
            (false, 0) => [c1 - c0, c2 - c1],
            (false, _) => [c2 - c3, c3 - c0],
        };
        Hit {
            t: crossing.t,
            position,
            position_error,
            geometric_normal: normal,
            shading_normal: normal,
            tangents,
            uv: uv.clamp(DVec2::ZERO, DVec2::ONE),
            height: 0.0,
            front: crossing.front,
            surface: 0,
            part: self.part(half),
            time: 0.0,
        }
    }

    fn triangle(&self, half: usize) -> [DVec3; 3] {
        let [a, b, c] = TRIANGLES[half];
        [self.corners[a], self.corners[b], self.corners[c]]
    }

    fn part(&self, half: usize) -> Part {
        if self.parallelogram { Part::Whole } else { Part::Triangle(half as u32) }
    }

    /// The nearer crossing of the two triangles within `[0, t_max]`, the first if they tie, for a
    /// ray that leaves `departure`, this quad or another surface.
    pub(crate) fn meet(
        &self,
        ray: &Ray,
        departure: Option<&Departure<'_>>,
    ) -> Option<(usize, Crossing)> {
        let own = ray.from.map(|from| from.part);
        if own == Some(Part::Whole) {
            return None;
        }
        let sheared = ShearedRay::new(ray);
        let [a, b, c, d] = self.corners;
        let vertices = [a, b, c, d].map(|p| sheared.vertex(p));
        let mut best: Option<(usize, Crossing)> = None;
        for (half, triangle) in TRIANGLES.iter().enumerate() {
            if own == Some(Part::Triangle(half as u32)) {
                continue;
            }
            let corners = triangle.map(|i| vertices[i]);
            let Some(crossing) = sheared.cross(corners, Edges::Widened) else { continue };
            if self.one_sided && !crossing.front {
                continue;
            }
            let t = match departure {
                Some(departure) => departure.meeting(ray.origin, &self.triangle(half), &crossing),
                None => Some(crossing.t),
            };
            let t = t.filter(|t| (0.0..=ray.t_max).contains(t));
            if let Some(t) = t.filter(|&t| best.is_none_or(|(_, c)| t < c.t)) {
                best = Some((half, Crossing { t, ..crossing }));
            }
        }
        best
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::random::Random;

    fn square() -> [DVec3; 4] {
        [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y]
    }

    #[test]
    fn closed_form_on_parallelograms() {
        let mut random = Random(61);
        for _ in 0..10_000 {
            let (c0, e, f) = (random.cube(), random.cube(), random.cube());
            let corners = [c0, c0 + e, c0 + e + f, c0 + f];
            let quad = Quad::new(corners, false).expect("valid");
            assert!(quad.is_parallelogram());
            let normal = e.cross(f).normalize();
            let (u, v) = (random.unit(), random.unit());
            let target = c0 + u * e + v * f;
            let origin = target + random.direction();
            let ray = Ray::new(origin, 0.5 * (target - origin));
            let steep = ray.direction.normalize().dot(normal).abs();
            if steep * e.cross(f).length() < 1e-3 {
                continue;
            }
            let hit = quad.closest(&ray).expect("aimed at");
            assert!((hit.t - 2.0).abs() < 1e-10 && hit.position.distance(target) < 1e-10);
            assert!(hit.uv.distance(DVec2::new(u, v)) < 1e-9);
            assert!((hit.position - c0).dot(normal).abs() <= hit.position_error + 1e-15);
            assert!(hit.position_error < 1e-14);
            assert_eq!(hit.front, ray.direction.dot(normal) < 0.0);
            assert_eq!((hit.geometric_normal, hit.part), (quad.normals[0], Part::Whole));
            assert!(hit.geometric_normal.distance(normal) < 1e-10);
            assert_eq!(hit.tangents, [corners[1] - c0, corners[3] - c0]);
            assert!(quad.occludes(&ray) && !quad.occludes(&Ray { t_max: 1.9, ..ray }));
            assert!(quad.closest(&Ray::new(origin, -ray.direction)).is_none());
        }
    }

    #[test]
    fn one_sided_quads_let_rays_from_behind_through() {
        let quad = Quad::new(square(), true).expect("valid");
        let middle = DVec3::new(0.5, 0.5, 0.0);
        assert!(quad.closest(&Ray::new(middle + DVec3::Z, -DVec3::Z)).is_some_and(|h| h.front));
        assert!(quad.closest(&Ray::new(middle - DVec3::Z, DVec3::Z)).is_none());
        assert!(!quad.occludes(&Ray::new(middle - DVec3::Z, DVec3::Z)));
    }

    #[test]
    fn corners_and_border_are_closed() {
        let quad = Quad::new(square(), false).expect("valid");
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (0.5, 0.0), (1.0, 0.3)] {
            let hit = quad.closest(&Ray::new(DVec3::new(x, y, 2.0), -DVec3::Z)).expect("closed");
            assert_eq!((hit.uv, hit.t), (DVec2::new(x, y), 2.0));
        }
        assert!(quad.closest(&Ray::new(DVec3::new(1.0 + 1e-12, 0.5, 2.0), -DVec3::Z)).is_none());
        let within = Ray::new(DVec3::new(-1.0, 0.5, 0.0), DVec3::X);
        assert!(quad.closest(&within).is_none(), "edge-on");
    }

    #[test]
    fn a_bent_quad_is_two_triangles() {
        let [c0, c1, c2, c3] = square();
        let quad = Quad::new([c0, c1, c2, c3 + DVec3::Z], false).expect("valid");
        assert!(!quad.is_parallelogram());
        let down = |x, y| quad.closest(&Ray::new(DVec3::new(x, y, 3.0), -DVec3::Z)).expect("above");
        let flat = down(0.75, 0.25);
        assert_eq!((flat.part, flat.geometric_normal), (Part::Triangle(0), DVec3::Z));
        assert_eq!((flat.uv, flat.tangents), (DVec2::new(0.75, 0.25), [DVec3::X, DVec3::Y]));
        let slope = down(0.25, 0.75);
        assert_eq!((slope.part, slope.position.z), (Part::Triangle(1), 0.5));
        assert_eq!(slope.uv, DVec2::new(0.25, 0.75));
        assert_eq!(slope.tangents, [c2 - c3 - DVec3::Z, c3 + DVec3::Z]);
        // From the flat half one sees the slope, and back; never oneself.
        let next = quad.closest(&flat.spawn(slope.position - flat.position)).expect("sees it");
        assert_eq!(next.part, Part::Triangle(1));
        assert!(quad.closest(&flat.spawn(DVec3::new(0.1, 0.0, 1.0))).is_none());
    }

    #[test]
    fn bad_corners_are_refused() {
        let with = |i: usize, p: DVec3| {
            let mut corners = square();
            corners[i] = p;
            Quad::new(corners, false).expect_err("bad")
        };
        assert_eq!(with(2, DVec3::new(f64::NAN, 0.0, 0.0)), QuadError::Corner(2));
        assert_eq!(with(3, DVec3::splat(1e120)), QuadError::Corner(3));
        assert_eq!(with(1, DVec3::ZERO), QuadError::Degenerate("c0 c1 c2"));
        assert_eq!(with(3, DVec3::splat(0.0)), QuadError::Degenerate("c0 c2 c3"));
        assert_eq!(with(1, DVec3::new(0.5, 0.5, 0.0)), QuadError::Degenerate("c0 c1 c2"));
    }
}
