//! Normals of a displaced sphere.
//!
//! **Exact.** Over a face the surface is `Q(A, B) = n / Z` with `A = n X / Z`, `B = n Y / Z`. The gradient
//! of the gap, in the face's frame and up to length, is
//! `(Q_A, Q_B, (Q - A Q_A - B Q_B) / n)`; it points outward.
//!
//! **Smooth.** Every lattice point has the cross product of the central differences of its neighbours'
//! positions, over the edge of the face where it lies on one; between the points these are
//! interpolated. On a common edge both faces have the same normals.

use glam::DVec3;

use super::leaf::bilinear;
use super::radii::Radii;
use crate::map::{CubeFace, NormalMap, cube_direction};
use crate::relief::sphere::CubeRelief;

/// A point over a face that wants a normal.
pub(super) struct Shading<'a> {
    pub relief: &'a CubeRelief,
    pub radii: &'a Radii,
    pub face: CubeFace,
    pub cell: [u32; 2],
    pub local: [f64; 2],
}

impl Shading<'_> {
    /// The point relative to the centre, and the unit normal of the surface there.
    pub fn point_and_normal(&self) -> (DVec3, DVec3) {
        let Self { radii, face, cell, local: [x, y], .. } = *self;
        let heights = self.relief.face(face).heights();
        let q = radii.corners(cell, heights.stored_corners(cell[0], cell[1]));
        let n = f64::from(radii.cells);
        let [a, b] = [0, 1].map(|k| 2.0 * (f64::from(cell[k]) + self.local[k]) - n);
        let value = bilinear(&q, [x, y]);
        // A and B count two for a cell.
        let along_a = 0.5 * ((q[1] - q[0]) * (1.0 - y) + (q[3] - q[2]) * y);
        let along_b = 0.5 * ((q[2] - q[0]) * (1.0 - x) + (q[3] - q[1]) * x);
        let upright = (value - a * along_a - b * along_b) / n;
        let normal = face.from_frame([along_a, along_b, upright]).normalize_or(DVec3::Z);
        (face.from_frame([a, b, n]) / value, normal)
    }

    /// The smooth unit normal.
    pub fn smooth_normal(&self) -> DVec3 {
        let n = self.radii.cells;
        let corner = |di: u32, dj: u32| {
            let at = [self.cell[0] + di, self.cell[1] + dj];
            self.vertex_normal(self.face.lattice_point(n, at))
        };
        let [x, y] = self.local;
        let low = corner(0, 0).lerp(corner(1, 0), x);
        let high = corner(0, 1).lerp(corner(1, 1), x);
        low.lerp(high, y).normalize_or(DVec3::Z)
    }

    /// Normal of a point of the cube: central differences, or the mean over the three edges of a
    /// corner.
    fn vertex_normal(&self, point: [u32; 3]) -> DVec3 {
        let n = self.radii.cells;
        let on_face = |axis: usize| point[axis] == 0 || point[axis] == n;
        let step = |axis: usize, up: bool| {
            let mut to = point;
            to[axis] = if up { to[axis] + 1 } else { to[axis] - 1 };
            self.position(to)
        };
        // A step inward from the face at the end of an axis.
        let inward = |axis: usize| step(axis, point[axis] == 0);
        let outward = DVec3::from_array(cube_direction(n, point));
        let faces: u32 = (0..3).map(|axis| u32::from(on_face(axis))).sum();
        let normal = match faces {
            3 => {
                let here = self.position(point);
                let [a, b, c] = [0, 1, 2].map(|axis| inward(axis) - here);
                a.cross(b) + b.cross(c) + c.cross(a)
            }
            2 => {
                let along = (0..3).find(|&axis| !on_face(axis)).unwrap_or(0);
                let [a, b] = [(along + 1) % 3, (along + 2) % 3];
                (inward(a) - inward(b)).cross(step(along, true) - step(along, false))
            }
            _ => {
                let axis = (0..3).find(|&axis| on_face(axis)).unwrap_or(0);
                let [a, b] = [(axis + 1) % 3, (axis + 2) % 3];
                (step(a, true) - step(a, false)).cross(step(b, true) - step(b, false))
            }
        };
        let normal = normal.normalize_or(DVec3::ZERO);
        if normal.dot(outward) < 0.0 { -normal } else { normal }
    }

    /// Position of a point of the cube on the surface, relative to the centre.
    fn position(&self, point: [u32; 3]) -> DVec3 {
        let n = self.radii.cells;
        let axis = (0..3).find(|&axis| point[axis] == 0 || point[axis] == n).unwrap_or(0);
        let face = CubeFace::new(axis, point[axis] == n);
        let [i, j] = face.across().map(|axis| point[axis]);
        let raw = f64::from(self.relief.face(face).heights().raw(i, j));
        let along = DVec3::from_array(cube_direction(n, point));
        along * (self.radii.radius(raw) / along.length())
    }

    /// The normal that a normal map has at (u, v), turned into the frame of the sphere in direction
    /// `outward`, a unit vector: x to the east, y to the north.
    pub fn mapped_normal(map: &NormalMap, [u, v]: [f64; 2], outward: DVec3) -> DVec3 {
        let east = DVec3::new(-outward.y, outward.x, 0.0).try_normalize().unwrap_or(DVec3::Y);
        let north = outward.cross(east);
        let normal = map.normal_at(u, v);
        let normal = normal.x * east + normal.y * north + normal.z.max(1e-9) * outward;
        normal.normalize_or(outward)
    }
}
