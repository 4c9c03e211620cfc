//! Normals of a displaced sphere.
//!
//! **Exact.** Over a face the surface is `Q(A, B) = n / Z` with `A = n X / Z`, `B = n Y / Z`. The gradient
//! of the gap, in the face's frame and up to length, is
//! `(Q_A, Q_B, (Q - A Q_A - B Q_B) / n)`; it points outward.
//!
//! **Smooth.** Every lattice point has the normal that this gradient gives with central differences of
//! `q`, or, on the edges of the cube, the cross product of central differences of its neighbours'
//! positions on both faces; between the points these are interpolated. A point has one normal,
//! whichever face asks.

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
        let inner = self.cell.iter().all(|&c| c >= 1 && c + 1 < n);
        let corners = if inner {
            self.inner_normals()
        } else {
            [[0, 0], [1, 0], [0, 1], [1, 1]].map(|[di, dj]| {
                let at = [self.cell[0] + di, self.cell[1] + dj];
                self.vertex_normal(self.face.lattice_point(n, at))
            })
        };
        let [x, y] = self.local;
        let (low, high) = (corners[0].lerp(corners[1], x), corners[2].lerp(corners[3], x));
        low.lerp(high, y).normalize_or(DVec3::Z)
    }

    /// Normals at the corners of a cell none of which lies on an edge of the cube.
    fn inner_normals(&self) -> [DVec3; 4] {
        let n = self.radii.cells;
        let first = [self.cell[0] - 1, self.cell[1] - 1];
        let heights = self.relief.face(self.face).heights();
        let [x, y, z] = cube_direction(n, [first[0], first[1], n]);
        let mut q = [0.0; 16];
        for (k, q) in (0..).zip(&mut q) {
            let (a, b) = (x + 2.0 * f64::from(k % 4), y + 2.0 * f64::from(k / 4));
            let raw = f64::from(heights.raw(first[0] + k % 4, first[1] + k / 4));
            *q = (z * z + (a * a + b * b)).sqrt() / self.radii.radius(raw);
        }
        [5, 6, 9, 10].map(|k: usize| {
            let at = [x + 2.0 * (k % 4) as f64, y + 2.0 * (k / 4) as f64];
            let around = [q[k - 1], q[k + 1], q[k - 4], q[k + 4]];
            self.face.from_frame(gradient(n, at, q[k], around)).normalize_or(DVec3::Z)
        })
    }

    /// Normal of a point of the cube; at a corner the mean over its three edges.
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
            _ => return self.face_normal(point),
        };
        let normal = normal.normalize_or(DVec3::ZERO);
        if normal.dot(outward) < 0.0 { -normal } else { normal }
    }

    /// Normal of a point of the cube inside a face.
    fn face_normal(&self, point: [u32; 3]) -> DVec3 {
        let n = self.radii.cells;
        let face = face_of(n, point);
        let heights = self.relief.face(face).heights();
        let [i, j] = face.across().map(|axis| point[axis]);
        let q = |i: u32, j: u32| {
            let [a, b, z] = cube_direction(n, [i, j, n]);
            let radius = self.radii.radius(f64::from(heights.raw(i, j)));
            (z * z + (a * a + b * b)).sqrt() / radius
        };
        let [a, b, _] = cube_direction(n, [i, j, n]);
        let around = [q(i - 1, j), q(i + 1, j), q(i, j - 1), q(i, j + 1)];
        face.from_frame(gradient(n, [a, b], q(i, j), around)).normalize_or(DVec3::Z)
    }

    /// Position of a point of the cube on the surface, relative to the centre.
    fn position(&self, point: [u32; 3]) -> DVec3 {
        let n = self.radii.cells;
        let face = face_of(n, point);
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

/// A face that has a point of the cube.
fn face_of(n: u32, point: [u32; 3]) -> CubeFace {
    let axis = (0..3).find(|&axis| point[axis] == 0 || point[axis] == n).unwrap_or(0);
    CubeFace::new(axis, point[axis] == n)
}

/// The gradient of the gap at a lattice point of direction (a, b, n), from q there and before and after
/// it along both axes.
#[inline]
fn gradient(n: u32, [a, b]: [f64; 2], q: f64, around: [f64; 4]) -> [f64; 3] {
    // From one neighbour to the other A and B grow by 4.
    let (along_a, along_b) = (0.25 * (around[1] - around[0]), 0.25 * (around[3] - around[2]));
    [along_a, along_b, (q - a * along_a - b * along_b) / f64::from(n)]
}
