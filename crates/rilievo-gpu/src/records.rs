//! What is written for the shaders to read and read from what they write: the structs of
//! `shaders/params.wgsl`, field by field in their order, in words of 32 bits.

use rilievo::glam::DVec3;
use rilievo::map::{Axis, CubeFace, Lattice, Samples, Wrap};
use rilievo::relief::{Relief, ReliefFace, ReliefMesh, ReliefSphere};
use rilievo::surface::Motion;
use rilievo::{Hit, Part, Ray, Wall};
use rilievo_render::ShadowRay;

use crate::bounds;

/// Words of a ray.
pub(crate) const RAY_WORDS: usize = 22;
/// Words of a hit.
pub(crate) const HIT_WORDS: usize = 12;
/// Words of a face.
pub(crate) const FACE_WORDS: usize = 72;
/// Words of a face before those of its map.
const FRAME_WORDS: usize = 54;
/// Words of a node.
pub(crate) const NODE_WORDS: usize = 8;
/// Words of a triangle in `numbers`: three corners, its index, and one that is unused.
pub(crate) const TRIANGLE_WORDS: usize = 20;
/// Words of a task of building a pyramid.
pub(crate) const TASK_WORDS: usize = 24;
/// Words of a task of building a distance map of kind boxes.
pub(crate) const BOX_TASK_WORDS: usize = 24;
/// Words of a task of building a distance map of another kind.
pub(crate) const NEAREST_TASK_WORDS: usize = 32;

/// The surface of a ray that leaves none, and of a hit that is none.
pub(crate) const NOTHING: u32 = u32::MAX;
/// The word of a face that is walked by fixed steps.
const MARCHED: u32 = u32::MAX - 1;
/// Bit of a side.
const FRONT: u32 = 1;
/// The kind of a wall of a displaced mesh.
const SEAM_WALL: u32 = 7;
/// Where the kind of a wall begins.
const WALL_SHIFT: u32 = 8;

/// Where a map lies on the device, in words.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct MapPlace {
    /// First word of its samples.
    pub heights: u32,
    /// First word of the table of its pyramid.
    pub bounds: u32,
}

/// How rays walk a face.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum FaceWalk {
    /// By the bounds of its map.
    Bounds,
    /// By the distance map that is told of at a word among the bounds.
    Distance(u32),
    /// By fixed steps.
    March,
}

impl FaceWalk {
    fn word(self) -> u32 {
        match self {
            Self::Bounds => NOTHING,
            Self::Distance(place) => place,
            Self::March => MARCHED,
        }
    }
}

/// Appends the fields of a struct.
pub(crate) trait Words {
    /// A float.
    fn float(&mut self, x: f32);
    /// A number as the sum of two floats; beyond their range the largest float.
    fn double(&mut self, x: f64);
    /// A vector, component by component.
    fn vector(&mut self, v: DVec3);
}

impl Words for Vec<u32> {
    fn float(&mut self, x: f32) {
        self.push(x.to_bits());
    }

    fn double(&mut self, x: f64) {
        let x = x.clamp(f64::from(f32::MIN), f64::from(f32::MAX));
        let high = x as f32;
        self.float(high);
        self.float((x - f64::from(high)) as f32);
    }

    fn vector(&mut self, v: DVec3) {
        v.to_array().into_iter().for_each(|x| self.double(x));
    }
}

/// The power of two that brings a ray's direction to a largest component of 1 to 2.
fn direction_scale(ray: &Ray) -> f64 {
    let largest = ray.direction.abs().max_element();
    // The exponent alone, of a number that is not denormal.
    let exponent = (largest.to_bits() >> 52 & 0x7ff) as i32 - 1023;
    2.0f64.powi(-exponent.clamp(-1000, 1000))
}

/// Writes a ray relative to `anchor`. One that is not valid is written with an end before its start.
pub(crate) fn write_ray(words: &mut Vec<u32>, ray: &Ray, anchor: DVec3) {
    let scale = direction_scale(ray);
    let t_max = if ray.is_valid() { ray.t_max / scale } else { -1.0 };
    words.vector(ray.origin - anchor);
    words.vector(ray.direction * scale);
    words.double(t_max);
    // NaN is 0.
    words.double(if ray.time > 0.0 { ray.time.min(1.0) } else { 0.0 });
    let (surface, leaves, line) = match ray.from {
        Some(from) => {
            let (kind, line) = match from.part {
                Part::Wall(wall) => wall_code(wall),
                Part::Triangle(index) => (0, index as i32),
                Part::TriangleCell { triangle, .. } => (0, triangle as i32),
                Part::SeamWall(wall) => (SEAM_WALL, wall as i32),
                _ => (0, 0),
            };
            let side = if from.front { FRONT } else { 0 };
            (from.surface, (kind << WALL_SHIFT) | side, line)
        }
        None => (NOTHING, 0, 0),
    };
    words.extend([surface, leaves, line as u32, 0, NOTHING, 0]);
}

/// Writes a ray that any hit stops, as [`write_ray`] does others.
pub(crate) fn write_shadow_ray(words: &mut Vec<u32>, shadow: &ShadowRay, anchor: DVec3) {
    write_ray(words, &shadow.ray, anchor);
    let end = words.len();
    words[end - 2] = shadow.exempt.unwrap_or(NOTHING);
    words[end - 1] = 1;
}

/// Kind and line of a wall.
fn wall_code(wall: Wall) -> (u32, i32) {
    match wall {
        Wall::LowU => (1, 0),
        Wall::HighU => (2, 0),
        Wall::LowV => (3, 0),
        Wall::HighV => (4, 0),
        Wall::SeamU(line) => (5, line),
        Wall::SeamV(line) => (6, line),
    }
}

/// The wall of a kind and a line.
fn wall_of((kind, line): (u32, i32)) -> Wall {
    match kind {
        1 => Wall::LowU,
        2 => Wall::HighU,
        3 => Wall::LowV,
        4 => Wall::HighV,
        5 => Wall::SeamU(line),
        _ => Wall::SeamV(line),
    }
}

/// A hit as a shader wrote it.
pub(crate) struct HitRecord<'a>(pub &'a [u32]);

impl HitRecord<'_> {
    fn double(&self, at: usize) -> f64 {
        let [high, low] = [self.0[at], self.0[at + 1]].map(f32::from_bits);
        f64::from(high) + f64::from(low)
    }

    /// Index of the surface that was hit.
    pub fn surface(&self) -> Option<u32> {
        (self.0[8] != NOTHING).then_some(self.0[8])
    }

    /// Nodes and blocks looked at.
    pub fn steps(&self) -> u32 {
        self.0[10]
    }

    /// The triangle that was hit, if the surface has triangles.
    pub fn triangle(&self) -> u32 {
        self.0[6]
    }

    /// Parameter of the hit on the ray that was traced.
    pub fn t(&self, ray: &Ray) -> f64 {
        self.double(0) * direction_scale(ray)
    }

    /// The hit on a face at `t`, worked out in `f64`; the ray is in the frame of the face.
    pub fn on_face(&self, face: &ReliefFace, ray: &Ray, t: f64) -> Hit {
        let cell = [self.0[6] as i32, self.0[7] as i32];
        let front = self.0[9] & FRONT != 0;
        match self.0[9] >> WALL_SHIFT {
            0 => {
                let local = [self.double(2), self.double(4)].map(|x| x.clamp(0.0, 1.0));
                face.hit_in_cell(ray, t, (cell, local), front)
            }
            kind => face.hit_on_wall(ray, t, wall_of((kind, cell[0])), front),
        }
    }

    /// The hit on a displaced sphere at `t`, as [`HitRecord::on_face`].
    pub fn on_relief_sphere(&self, sphere: &ReliefSphere, ray: &Ray, t: f64) -> Hit {
        let face = CubeFace::ALL[(self.0[9] >> WALL_SHIFT) as usize % 6];
        let last = sphere.relief().cells() - 1;
        let cell = [self.0[6].min(last), self.0[7].min(last)];
        let local = [self.double(2), self.double(4)].map(|x| x.clamp(0.0, 1.0));
        sphere.hit_in_cell(ray, t, (face, cell, local), self.0[9] & FRONT != 0)
    }

    /// The hit on a displaced mesh at `t`, as [`HitRecord::on_face`].
    pub fn on_relief_mesh(&self, mesh: &ReliefMesh, ray: &Ray, t: f64) -> Hit {
        let (piece, front) = (self.0[11], self.0[9] & FRONT != 0);
        let (cell, at) = ([self.0[6] as i32, self.0[7] as i32], [self.double(2), self.double(4)]);
        match self.0[9] >> WALL_SHIFT {
            SEAM_WALL => mesh.hit_on_wall(ray, t, (piece, at), front),
            _ => mesh.hit_in_cell(ray, t, (piece, cell, at), front),
        }
    }
}

/// Writes a motion, the struct `Motion` of `shaders/motion.wgsl`.
pub(crate) fn write_motion(words: &mut Vec<u32>, motion: &Motion, anchor: DVec3) {
    words.vector(motion.pivot - anchor);
    words.vector(motion.translation);
    words.vector(motion.axis);
    words.double(motion.angle / std::f64::consts::TAU);
}

/// Writes a face whose map lies at `place`; `anchor` is that of the rays.
pub(crate) fn write_face(
    words: &mut Vec<u32>,
    face: &ReliefFace,
    (place, walk): (MapPlace, FaceWalk),
    anchor: DVec3,
) {
    let frame = face.lattice_frame();
    let by_row = frame.lattice_from_world.transpose();
    [by_row.x_axis, by_row.y_axis, by_row.z_axis].into_iter().for_each(|row| words.vector(row));
    words.vector(frame.corner - anchor);
    words.vector(frame.lattice_corner);
    frame.window.as_flattened().iter().for_each(|&x| words.double(x));
    frame.shell.into_iter().for_each(|corner| words.vector(corner));
    frame.culled.into_iter().for_each(|z| words.double(z));
    let options = face.options();
    let flags = [frame.rises, options.closed, options.one_sided];
    write_map(words, face.relief(), place, [frame.lift, frame.raw_zero], flags);
    words.push(walk.word());
}

/// Writes a map that is no face's in the place of a face; the frame stays empty.
pub(crate) fn write_map_alone(words: &mut Vec<u32>, relief: &Relief, place: MapPlace) {
    words.resize(words.len() + FRAME_WORDS, 0);
    write_map(words, relief, place, [0.0; 2], [false; 3]);
    words.push(NOTHING);
}

/// Writes what of a face is its map's, but for distances.
fn write_map(
    words: &mut Vec<u32>,
    relief: &Relief,
    place: MapPlace,
    [lift, raw_zero]: [f64; 2],
    [rises, closed, one_sided]: [bool; 3],
) {
    let map = relief.heights();
    let (low, high) = map.raw_range();
    let code = relief.pyramid().code();
    for x in [low, high, low.abs().max(high.abs()), lift as f32, code.base, code.step] {
        words.float(x);
    }
    words.float(raw_zero as f32);
    let floats = matches!(map.samples(), Samples::F32(_));
    let flags = [rises, closed, one_sided, floats];
    words.push(flags.into_iter().zip(0..).map(|(flag, bit)| u32::from(flag) << bit).sum());
    words.extend([map.width(), map.height(), map.x().cells(), map.y().cells()]);
    words.extend(unfolding(map.x()));
    words.extend([place.heights, place.bounds, bounds::levels(map)]);
}

/// Appends a node with a box from `low` to `high`, rounded outward.
pub(crate) fn write_node(words: &mut Vec<u32>, (low, high): (DVec3, DVec3), content: [u32; 2]) {
    let margin = f64::from(f32::EPSILON) * low.abs().max(high.abs()).max_element();
    low.to_array().into_iter().for_each(|x| words.float(((x - margin) as f32).next_down()));
    high.to_array().into_iter().for_each(|x| words.float(((x + margin) as f32).next_up()));
    words.extend(content);
}

/// Whether samples are texels, and the wrap.
fn unfolding(axis: &Axis) -> [u32; 2] {
    let wrap = match axis.wrap() {
        Wrap::Repeat => 0,
        Wrap::Clamp => 1,
        Wrap::Mirror => 2,
    };
    [u32::from(axis.lattice() == Lattice::Texel), wrap]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn doubles_keep_48_bits() {
        let mut words = Vec::new();
        for x in [1.0 / 3.0, -1e7 / 7.0, 0.0, 6.02e23] {
            words.clear();
            words.double(x);
            let back = HitRecord(&words).double(0);
            assert!((back - x).abs() <= x.abs() * 2.0f64.powi(-48));
        }
        words.clear();
        words.double(f64::INFINITY);
        assert_eq!(HitRecord(&words).double(0), f64::from(f32::MAX));
    }

    #[test]
    fn directions_are_scaled_by_powers_of_two() {
        for direction in [DVec3::new(1e-9, -3.0, 2.0), DVec3::splat(1e100), DVec3::X * 1e-30] {
            let ray = Ray::new(DVec3::ZERO, direction);
            let largest = (direction * direction_scale(&ray)).abs().max_element();
            assert!((1.0..2.0).contains(&largest), "{largest}");
        }
    }

    #[test]
    fn walls_are_read_back() {
        for wall in
            [Wall::LowU, Wall::HighU, Wall::LowV, Wall::HighV, Wall::SeamU(-3), Wall::SeamV(17)]
        {
            assert_eq!(wall_of(wall_code(wall)), wall);
        }
    }
}
