//! [`SphereFrame`]: what another backend needs to trace a displaced sphere as the CPU does, and how it
//! turns a crossing that it found into a [`Hit`].

use crate::hit::Hit;
use crate::map::CubeFace;
use crate::ray::Ray;

use super::{Radii, ReliefSphere, SphereCrossing};

/// How the raw heights of a [`ReliefSphere`] lie around its centre, scene units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereFrame {
    /// Distance from the centre at raw height 0.
    pub at_zero: f64,
    /// Change of that distance for one raw unit.
    pub per_raw: f64,
    /// Smallest and largest distance of a lattice point.
    pub range: [f64; 2],
    /// Two balls between which the surface lies, clear of both by 2^-30 of their radius.
    pub balls: [f64; 2],
    /// Largest relative change, over a cell, of a lattice point's direction over its distance.
    pub variation: f64,
    /// By how much of its distance from the centre a spawned ray's start is lifted.
    pub lift: f64,
}

impl ReliefSphere {
    /// How raw heights lie around the centre.
    pub fn frame(&self) -> SphereFrame {
        let Radii { at_zero, per_raw, lowest, highest, floor, roof, variation, .. } = self.radii;
        SphereFrame {
            at_zero,
            per_raw,
            range: [lowest, highest],
            balls: [floor, roof],
            variation,
            lift: self.lift,
        }
    }

    /// The hit of a ray at parameter `t`, at a place `local` in `[0, 1]^2` of a cell of a face, met from
    /// its front or its back. `hit.surface` is 0. That `t` and the place belong together is the
    /// caller's promise; the distance between them becomes part of `hit.position_error`.
    ///
    /// # Panics
    /// If the face has no such cell.
    pub fn hit_in_cell(
        &self,
        ray: &Ray,
        t: f64,
        (face, cell, local): (CubeFace, [u32; 2], [f64; 2]),
        front: bool,
    ) -> Hit {
        let hit = self.complete(&SphereCrossing { t, face, cell, local, gap: 0.0, front });
        let apart = hit.position.distance(ray.at(t));
        Hit { position_error: hit.position_error + apart, time: ray.time, ..hit }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::map::{HeightMap, Lattice, Samples, Tiling, Wrap};
    use crate::ray::Part;
    use crate::relief::{CubeRelief, Displacement, SphereOptions};

    #[test]
    fn a_crossing_found_elsewhere_gives_the_same_hit() {
        let samples = Samples::U16((0..128u32).map(|k| (k * 7919 % 65536) as u16).collect());
        let map = HeightMap::new(16, 8, samples, Lattice::Texel, Wrap::Repeat).unwrap();
        let relief = CubeRelief::new(&map, Tiling::default()).unwrap();
        let displacement = Displacement { scale: 0.2, ..Displacement::default() };
        let options = SphereOptions { displacement, ..SphereOptions::default() };
        let center = DVec3::new(0.3, -1.0, 2.0);
        let sphere = ReliefSphere::new(center, 0.7, Arc::clone(&relief), options).unwrap();
        let frame = sphere.frame();
        assert!(frame.balls[0] < frame.range[0] && frame.range[1] < frame.balls[1]);
        let from = center + DVec3::new(3.0, 1.0, 0.5);
        let ray = Ray::new(from, center + DVec3::new(0.1, 0.2, -0.1) - from);
        let hit = sphere.closest(&ray, &mut ()).expect("aimed at");
        let Part::CubeCell(face, i, j) = hit.part else { panic!("{hit:?}") };
        let [x, y, z] = face.to_frame(hit.position - center);
        let n = f64::from(relief.cells());
        let local = [(x, i), (y, j)].map(|(x, i)| 0.5 * n * (x / z + 1.0) - f64::from(i));
        let again = sphere.hit_in_cell(&ray, hit.t, (face, [i, j], local), hit.front);
        assert!(again.position.distance(hit.position) < 1e-12 && again.part == hit.part);
        assert!(again.shading_normal.distance(hit.shading_normal) < 1e-9);
        assert!(again.position_error < 1e-12 && again.front == hit.front);
    }
}
