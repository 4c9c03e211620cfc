//! [`LatticeFrame`]: what another backend needs to trace a displaced face as the CPU does, and how
//! it turns a crossing that it found into a [`Hit`].

use glam::{DMat3, DVec3};

use crate::hit::Hit;
use crate::ray::{Ray, Wall};

use super::face::ReliefFace;
use super::map_ray::Window;
use super::placement::Placement;
use super::trace::{Crossing, Place};

/// Where the height map of a [`ReliefFace`] lies in the world. Lattice space has x and y in unfolded
/// cells and z in raw heights; `lattice = lattice_from_world * (point - corner) + lattice_corner`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LatticeFrame {
    /// Lattice space from a world vector.
    pub lattice_from_world: DMat3,
    /// The face's first corner, world space.
    pub corner: DVec3,
    /// The same corner in lattice space.
    pub lattice_corner: DVec3,
    /// Lowest and highest x and y of the face in lattice space.
    pub window: [[f64; 2]; 2],
    /// Smallest and largest corner of the box in which rays are walked, lattice space.
    pub shell: [DVec3; 2],
    /// Raw heights between which rays are worth walking.
    pub culled: [f64; 2],
    /// Raw height added to the start of a ray that leaves the surface towards larger heights.
    pub lift: f64,
    /// Raw height that lies on the face.
    pub raw_zero: f64,
    /// Whether larger raw heights lie farther along the normal.
    pub rises: bool,
}

impl ReliefFace {
    /// Where the face's height map lies in the world.
    pub fn lattice_frame(&self) -> LatticeFrame {
        let placement = self.placement();
        let shell = placement.shell(self.options().closed);
        let Window { lo, hi } = placement.window;
        let (lattice_corner, _) = placement.lattice_from_world(placement.corner, DVec3::ZERO);
        let column = |axis| placement.lattice_from_world(placement.corner, axis).1;
        let rises = self.options().displacement.scale > 0.0;
        LatticeFrame {
            lattice_from_world: DMat3::from_cols(
                column(DVec3::X),
                column(DVec3::Y),
                column(DVec3::Z),
            ),
            corner: placement.corner,
            lattice_corner,
            window: [lo, hi],
            shell: [shell.low, shell.high],
            culled: shell.culled,
            lift: placement.lift(rises),
            raw_zero: placement.raw_zero,
            rises,
        }
    }

    /// The hit of a ray at world parameter `t`, at a place `local` in `[0, 1]^2` of an unfolded cell
    /// of the face's window, met from its front or its back. `hit.surface` is 0. That `t` and the
    /// place belong together is the caller's promise; the distance between them becomes part of
    /// `hit.position_error`.
    pub fn hit_in_cell(
        &self,
        ray: &Ray,
        t: f64,
        (cell, local): ([i32; 2], [f64; 2]),
        front: bool,
    ) -> Hit {
        let placement = self.placement();
        let [x, y] = local;
        let h = self.relief().heights().unfolded_corners(cell[0], cell[1]).map(f64::from);
        let (b, c) = (h[1] - h[0], h[2] - h[0]);
        let d = (h[3] - h[2]) - b;
        let raw = (h[0] + b * x) + (c + d * x) * y;
        let at = lattice_point(placement, ray, t);
        let reach = 2.0 + f64::from(cell[0]).abs() + f64::from(cell[1]).abs();
        let error = (at.z - raw).abs() + 8.0 * f64::EPSILON * reach * (b.abs() + c.abs() + d.abs());
        let lattice = [f64::from(cell[0]) + x, f64::from(cell[1]) + y];
        let place = Place::Cell { cell, local };
        self.complete(ray, &Crossing { t, lattice, raw, error, front, place })
    }

    /// The hit of a ray on an upright wall near world parameter `t`, met from the side that is clear
    /// or from the solid one. `hit.surface` is 0.
    pub fn hit_on_wall(&self, ray: &Ray, t: f64, wall: Wall, front: bool) -> Hit {
        let placement = self.placement();
        let (axis, line) = placement.wall_line(wall);
        let (origin, direction) = placement.lattice_from_world(ray.origin, ray.direction);
        let refined = (line - origin[axis]) / direction[axis];
        let t = if refined.is_finite() { refined.clamp(0.0, ray.t_max) } else { t };
        let at = origin + t * direction;
        let mut lattice = [at.x, at.y];
        lattice[axis] = line;
        let place = Place::Wall(wall);
        self.complete(ray, &Crossing { t, lattice, raw: at.z, error: 0.0, front, place })
    }
}

/// The point of a ray in lattice space.
fn lattice_point(placement: &Placement, ray: &Ray, t: f64) -> DVec3 {
    let (origin, direction) = placement.lattice_from_world(ray.origin, ray.direction);
    origin + t * direction
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::map::{HeightMap, Lattice, Samples, Wrap};
    use crate::ray::Part;
    use crate::relief::{FaceOptions, Relief};

    #[test]
    fn a_crossing_found_elsewhere_gives_the_same_hit() {
        let samples = Samples::U16((0..81u32).map(|k| (k * 7919 % 65536) as u16).collect());
        let map = HeightMap::new(9, 9, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
        let corners = [
            DVec3::new(0.3, 0.1, -0.2),
            DVec3::new(1.3, 0.2, 0.0),
            DVec3::new(1.2, 1.3, 0.1),
            DVec3::new(0.2, 1.2, -0.1),
        ];
        let options = FaceOptions { closed: true, ..FaceOptions::default() };
        let face = ReliefFace::new(corners, Arc::new(Relief::new(map)), options).unwrap();
        let frame = face.lattice_frame();
        for (k, wall) in [(0, false), (5, false), (9, true)] {
            let to = DVec3::new(0.7 + 0.02 * f64::from(k), 0.6, 0.1);
            let from = if wall { DVec3::new(-2.0, 0.5, 0.1) } else { DVec3::new(0.2, 0.4, 4.0) };
            let ray = Ray::between(from, from + 2.0 * (to - from));
            let hit = face.closest(&ray, &mut ()).expect("aimed at");
            let again = match hit.part {
                Part::Cell(i, j) => {
                    let at = frame.lattice_from_world * (hit.position - frame.corner)
                        + frame.lattice_corner;
                    let local = [at.x - f64::from(i), at.y - f64::from(j)];
                    face.hit_in_cell(&ray, hit.t, ([i, j], local), hit.front)
                }
                Part::Wall(side) => face.hit_on_wall(&ray, hit.t, side, hit.front),
                _ => panic!("no part of a face: {hit:?}"),
            };
            assert_eq!(wall, matches!(hit.part, Part::Wall(_)));
            assert!(again.position.distance(hit.position) < 1e-12, "{again:?} {hit:?}");
            assert!((again.t - hit.t).abs() < 1e-12 && again.front == hit.front);
            assert!(again.geometric_normal.distance(hit.geometric_normal) < 1e-9);
            assert!(again.position_error < 1e-11);
        }
    }
}
