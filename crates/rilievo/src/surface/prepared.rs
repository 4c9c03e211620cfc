//! [`PreparedQuad`]: what a quad knows beforehand of every ray.

use glam::DVec3;

use crate::accel::Aabb;
use crate::mesh::crossing::{Crossing, ShearedRay};
use crate::mesh::departure::{Departure, Plane};
use crate::ray::{Part, Ray};

use super::Quad;

/// A quad made ready for many rays: what [`Quad::meet`] finds, to the last bit, in fewer steps.
#[derive(Clone, Debug)]
pub(super) struct PreparedQuad {
    /// Coordinates of the corners, by axis.
    columns: [[f64; 4]; 3],
    /// Largest coordinates of the corners of the two triangles, without sign.
    reaches: [f64; 2],
    /// Planes of the two triangles, and of c0 c1 c3.
    planes: [Plane; 3],
    one_sided: bool,
}

impl PreparedQuad {
    pub(super) fn new(quad: &Quad) -> Self {
        let corners = quad.corners();
        let [c0, c1, c2, c3] = corners;
        let halves = [[c0, c1, c2], [c0, c2, c3]];
        Self {
            columns: [0, 1, 2].map(|axis| corners.map(|corner| corner[axis])),
            reaches: halves.map(|half| Aabb::around(half).largest_coordinate()),
            planes: [halves[0], halves[1], [c0, c1, c3]].map(|corners| Plane::through(&corners)),
            one_sided: quad.one_sided(),
        }
    }

    /// The plane of all corners of a parallelogram.
    #[inline]
    pub(super) fn plane(&self) -> &Plane {
        &self.planes[2]
    }

    /// [`Quad::meet`], for a ray that starts on the part `own` if it starts on this quad.
    #[inline]
    pub(super) fn meet(
        &self,
        (ray, sheared): (&Ray, &ShearedRay),
        own: Option<Part>,
        departure: Option<&Departure<'_>>,
    ) -> Option<(usize, Crossing)> {
        if own == Some(Part::Whole) {
            return None;
        }
        let mut best: Option<(usize, Crossing)> = None;
        for (half, crossing) in
            sheared.cross_quad(&self.columns, self.reaches).into_iter().enumerate()
        {
            let Some(crossing) = crossing else { continue };
            let passes = self.one_sided && !crossing.front;
            // A departure may move a crossing to 0, and to no other place.
            if passes || crossing.t > ray.t_max || own == Some(Part::Triangle(half as u32)) {
                continue;
            }
            let t = match departure {
                Some(departure) => {
                    let corners = self.triangle(half);
                    departure.meeting_in(&self.planes[half], ray.origin, &corners, &crossing)
                }
                None => Some(crossing.t),
            };
            let t = t.filter(|t| (0.0..=ray.t_max).contains(t));
            if let Some(t) = t.filter(|&t| best.is_none_or(|(_, c)| t < c.t)) {
                best = Some((half, Crossing { t, ..crossing }));
            }
        }
        best
    }

    fn triangle(&self, half: usize) -> [DVec3; 3] {
        let [x, y, z] = &self.columns;
        let corner = |k: usize| DVec3::new(x[k], y[k], z[k]);
        [corner(0), corner(half + 1), corner(half + 2)]
    }
}
