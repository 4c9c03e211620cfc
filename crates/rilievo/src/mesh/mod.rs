//! Triangle meshes.
//!
//! A [`Mesh`] is checked once, on the way in, and then traced without further checks. Its front is
//! where its triangles run counter-clockwise. Rays meet it watertight (see `crossing`): a closed
//! mesh, whose neighbours share the positions of their common edge bit for bit, lets no ray
//! through. A ray that leaves a triangle never meets that triangle again, and is neither stopped
//! by nor lost between its neighbours (see `departure`).
//!
//! Triangles without area to rounding (height below about `1e-15` of their edges) are kept but
//! never hit; [`Mesh::degenerate`] counts them.

pub(crate) mod crossing;
mod data;
pub(crate) mod departure;
mod smooth;
pub mod solids;
pub(crate) mod triangle;

pub use data::{COORDINATE_LIMIT, Mesh, MeshData, MeshError, Triangle};

use crossing::{Crossing, Edges, ShearedRay};
use departure::Departure;

use crate::accel::Aabb;
use crate::hit::Hit;
use crate::probe::Probe;
use crate::ray::{Origin, Part, Ray};

impl Mesh {
    /// The first triangle met within `0 <= t <= t_max`; of several at the same `t`, the one with
    /// the smallest index. `hit.part` names the triangle, `hit.surface` is 0.
    pub fn closest(&self, ray: &Ray, probe: &mut impl Probe) -> Option<Hit> {
        let departure = ray.from.and_then(|from| self.departure(from));
        let (index, crossing) = self.meet(ray, departure.as_ref(), probe)?;
        Some(Hit { time: ray.time, ..self.complete(index, &crossing) })
    }

    /// The hit of one triangle within `0 <= t <= t_max`, as [`Mesh::closest`] finds it if it is the
    /// nearest.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn hit_on(&self, triangle: u32, ray: &Ray) -> Option<Hit> {
        let departure = ray.from.and_then(|from| self.departure(from));
        let test = TriangleTest::new(self, ray, departure.as_ref());
        Some(self.complete(triangle, &test.cross(triangle, ray.t_max)?))
    }

    /// Whether any triangle is met within `0 <= t <= t_max`.
    pub fn occludes(&self, ray: &Ray, probe: &mut impl Probe) -> bool {
        let departure = ray.from.and_then(|from| self.departure(from));
        self.occludes_after(ray, departure.as_ref(), probe)
    }

    /// A box around every triangle that can be hit.
    pub fn bounds(&self) -> Aabb {
        self.tree.bounds()
    }

    /// What a ray that starts at `from`, on this mesh, leaves.
    pub(crate) fn departure(&self, from: Origin) -> Option<Departure<'_>> {
        match from.part {
            Part::Triangle(index) if (index as usize) < self.data.triangles.len() => {
                Some(Departure::Triangle(self.corners(index), from.front))
            }
            _ => None,
        }
    }

    /// The triangle of the nearest hit and where it is crossed, for a ray that leaves `departure`,
    /// of this mesh or another surface.
    pub(crate) fn meet(
        &self,
        ray: &Ray,
        departure: Option<&Departure<'_>>,
        probe: &mut impl Probe,
    ) -> Option<(u32, Crossing)> {
        let test = TriangleTest::new(self, ray, departure);
        let mut best: Option<(u32, Crossing)> = None;
        self.tree.closest(ray, probe, |item, ray, _| {
            let index = self.solid[item as usize];
            if let Some(crossing) = test.cross(index, ray.t_max) {
                let ties = |&(old, c): &(u32, Crossing)| c.t == crossing.t && old < index;
                if !best.as_ref().is_some_and(ties) {
                    ray.t_max = crossing.t;
                    best = Some((index, crossing));
                }
            }
        });
        best
    }

    /// The hit behind a crossing, at time 0.
    pub(crate) fn complete(&self, index: u32, crossing: &Crossing) -> Hit {
        let point = self.point(index, &crossing.weights);
        Hit {
            t: crossing.t,
            position: point.position,
            position_error: point.position_error,
            geometric_normal: point.geometric_normal,
            shading_normal: point.shading_normal,
            tangents: point.tangents,
            uv: point.uv,
            height: 0.0,
            front: crossing.front,
            surface: 0,
            part: Part::Triangle(index),
            time: 0.0,
        }
    }

    /// [`Mesh::occludes`] for a ray that leaves `departure`, of this mesh or another surface.
    pub(crate) fn occludes_after(
        &self,
        ray: &Ray,
        departure: Option<&Departure<'_>>,
        probe: &mut impl Probe,
    ) -> bool {
        let test = TriangleTest::new(self, ray, departure);
        self.tree.any(ray, probe, |item, ray, _| {
            test.cross(self.solid[item as usize], ray.t_max).is_some()
        })
    }
}

/// One ray against triangles of one mesh.
struct TriangleTest<'a> {
    mesh: &'a Mesh,
    ray: ShearedRay,
    from: Option<Part>,
    start: glam::DVec3,
    departure: Option<&'a Departure<'a>>,
}

impl<'a> TriangleTest<'a> {
    fn new(mesh: &'a Mesh, ray: &Ray, departure: Option<&'a Departure<'a>>) -> Self {
        let from = ray.from.map(|from| from.part);
        Self { mesh, ray: ShearedRay::new(ray), from, start: ray.origin, departure }
    }

    /// The crossing with triangle `index` within `[0, t_max]`.
    #[inline]
    fn cross(&self, index: u32, t_max: f64) -> Option<Crossing> {
        if self.from == Some(Part::Triangle(index)) {
            return None;
        }
        let corners = self.mesh.corners(index);
        let edges = if self.departure.is_some() { Edges::Widened } else { Edges::Exact };
        let crossing = self.ray.cross(corners.map(|p| self.ray.vertex(p)), edges)?;
        let t = match self.departure {
            Some(departure) => departure.meeting(self.start, &corners, &crossing)?,
            None => crossing.t,
        };
        (0.0..=t_max).contains(&t).then_some(Crossing { t, ..crossing })
    }
}

#[cfg(test)]
mod tests {
    use glam::{DAffine3, DVec3};

    use super::*;
    use crate::accel::random::Random;

    /// Rays traced per solid and placement.
    const RAYS: usize = 125_000;

    fn placements() -> [DAffine3; 4] {
        let moved = DAffine3::from_translation(DVec3::new(148376.0, 1234.0, -223423.0));
        let scaled = |s: f64| DAffine3::from_scale(DVec3::splat(s));
        [DAffine3::IDENTITY, moved, moved * scaled(1e-3), scaled(1e6)]
    }

    /// Convex closed solids around `place` of the origin, front outside.
    fn solids(place: DAffine3) -> [Mesh; 2] {
        [solids::cube(), solids::subdivided_sphere(3)]
            .map(|data| Mesh::new(data).and_then(|mesh| mesh.transformed(place)).expect("valid"))
    }

    /// A target on the surface: a vertex, a point on an edge, or anything.
    fn target(mesh: &Mesh, random: &mut Random) -> DVec3 {
        let [a, b, c] = mesh.corners(random.below(mesh.data.triangles.len()) as u32);
        match random.below(4) {
            0 => a,
            1 => a.midpoint(b),
            2 => a.lerp(b, random.unit()),
            _ => a.lerp(b, random.unit()).lerp(c, random.unit()),
        }
    }

    #[test]
    fn no_ray_leaves_a_closed_mesh() {
        let mut random = Random(41);
        for place in placements() {
            for mesh in solids(place) {
                for case in 0..RAYS {
                    // Well inside; now and then where axes and diagonals run through vertices.
                    let local = 0.4 * random.cube();
                    let local = if case % 5 == 0 { (local * 4.0).round() / 4.0 } else { local };
                    let origin = place.transform_point3(local);
                    let direction = match case % 4 {
                        0 => random.direction(),
                        1 => (2.0 * random.direction()).round() + DVec3::new(0.0, 0.0, 0.1),
                        _ => target(&mesh, &mut random) - origin,
                    };
                    let ray = Ray::new(origin, direction);
                    let hit = mesh.closest(&ray, &mut ()).expect("escaped");
                    assert!(!hit.front && mesh.occludes(&ray, &mut ()));
                    let distance = hit.position.distance(ray.at(hit.t));
                    assert!(distance <= 1e-14 * (ray.origin.length() + hit.position.length()));
                }
            }
        }
    }

    #[test]
    fn rays_from_the_surface_neither_leak_nor_stop() {
        let mut random = Random(43);
        for place in placements() {
            for mesh in solids(place) {
                // Below this slope a ray stays within rounding of the plane it leaves.
                let bounds = mesh.bounds();
                let grazing = 1e-13 * bounds.largest_coordinate() / (bounds.max - bounds.min).x;
                for case in 0..RAYS {
                    let centre = place.transform_point3(0.3 * random.cube());
                    let ray = Ray::new(centre, target(&mesh, &mut random) - centre);
                    let hit = mesh.closest(&ray, &mut ()).expect("escaped");
                    let direction = match case % 2 {
                        0 => random.direction(),
                        _ => target(&mesh, &mut random) - hit.position,
                    };
                    let spawned = hit.spawn(direction);
                    let outwards = spawned.from.expect("spawned").front;
                    let next = mesh.closest(&spawned, &mut ());
                    assert!(next.is_none_or(|next| next.part != hit.part), "own start");
                    if !outwards {
                        assert!(next.is_some(), "leak: {spawned:?}");
                    } else if direction.dot(hit.geometric_normal) > grazing * direction.length() {
                        assert!(next.is_none(), "stopped: {spawned:?} {next:?}");
                    }
                    assert_eq!(next.is_some(), mesh.occludes(&spawned, &mut ()));
                }
            }
        }
    }

    #[test]
    fn a_thousand_rays_from_a_thousand_hits() {
        let mut random = Random(47);
        for mesh in solids(DAffine3::IDENTITY) {
            for _ in 0..1000 {
                let ray = Ray::new(0.3 * random.cube(), random.direction());
                let hit = mesh.closest(&ray, &mut ()).expect("escaped");
                for _ in 0..1000 {
                    let spawned = hit.spawn(random.direction());
                    let next = mesh.closest(&spawned, &mut ());
                    let inwards = !spawned.from.expect("spawned").front;
                    assert_eq!(next.is_some(), inwards);
                    assert!(next.is_none_or(|next| next.part != hit.part && next.t > 0.0));
                }
            }
        }
    }

    #[test]
    fn equals_every_triangle_tried_in_turn() {
        let mut random = Random(53);
        let mut data = solids::subdivided_sphere(2);
        // A soup inside, with triangles given twice: ties go to the smaller index.
        for _ in 0..100 {
            let first = data.positions.len() as u32;
            data.positions.extend([0; 3].map(|_| 0.9 * random.cube()));
            let positions = [first, first + 1, first + 2];
            data.triangles.extend([Triangle { positions, normals: None, uvs: None }; 2]);
        }
        let mesh = Mesh::new(data).expect("valid");
        let brute = |ray: &Ray| {
            let departure = ray.from.and_then(|from| mesh.departure(from));
            let test = TriangleTest::new(&mesh, ray, departure.as_ref());
            let mut best: Option<(f64, u32)> = None;
            for &index in &mesh.solid {
                if let Some(c) = test.cross(index, ray.t_max)
                    && best.is_none_or(|(t, _)| c.t < t)
                {
                    best = Some((c.t, index));
                }
            }
            best.map(|(t, index)| (t, Part::Triangle(index)))
        };
        for case in 0..30_000 {
            let origin = 1.5 * random.cube();
            let mut ray = Ray::new(origin, target(&mesh, &mut random) - origin);
            ray.t_max = if case % 3 == 0 { 2.0 * random.unit() } else { f64::INFINITY };
            let hit = mesh.closest(&ray, &mut ());
            assert_eq!(hit.map(|hit| (hit.t, hit.part)), brute(&ray));
            assert_eq!(hit.is_some(), mesh.occludes(&ray, &mut ()));
            if let Some(hit) = hit {
                let ray = hit.spawn(random.direction());
                let next = mesh.closest(&ray, &mut ());
                assert_eq!(next.map(|hit| (hit.t, hit.part)), brute(&ray));
            }
        }
    }

    #[test]
    fn ends_of_the_ray_count() {
        let mesh = Mesh::new(solids::cube()).expect("valid");
        let down = |z: f64, t_max: f64| {
            let ray = Ray::new(DVec3::new(0.3, 0.2, z), -2.0 * DVec3::Z);
            mesh.closest(&Ray { t_max, ..ray }, &mut ()).map(|hit| hit.t)
        };
        assert_eq!(down(1.0, 9.0), Some(0.0));
        assert_eq!(down(2.0, 0.5), Some(0.5));
        assert_eq!(down(2.0, 0.49), None);
        assert_eq!(down(-1.5, 9.0), None);
    }
}
