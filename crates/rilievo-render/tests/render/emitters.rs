//! Emitters in relief, instances and images as lights of paths, where the radiance is known.

use std::f64::consts::PI;
use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rilievo::map::{HeightMap, Lattice, Samples, Tiling, Wrap};
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{
    CubeRelief, Displacement, FaceOptions, MeshOptions, Relief, ReliefFace, ReliefMesh,
    ReliefSphere, SphereOptions,
};
use rilievo::surface::{Instance, Quad, Sphere, Surface};
use rilievo_render::texture::{ColourImage, Texels, Texture};
use rilievo_render::{Material, Rgb};

use crate::closed_forms::{FLOOR, ceiling, rectangle_irradiance};
use crate::paths::{at_the_origin, check, paths};
use crate::scenes::{Builder, diffuse, emitter};

/// Heights of one half.
fn half() -> HeightMap {
    let codes = Samples::F32(vec![0.5; 513 * 257]);
    HeightMap::new(513, 257, codes, Lattice::Texel, Wrap::Repeat).unwrap()
}

/// By which the surfaces below are moved.
fn displacement() -> Displacement {
    Displacement { scale: 0.5, zero: 0.0, ..Displacement::default() }
}

/// The corners of a rectangle by a corner and two edges.
fn corners([corner, u, v]: [DVec3; 3]) -> [DVec3; 4] {
    [corner, corner + u, corner + u + v, corner + v]
}

fn check_over_a_floor(name: &str, surface: Surface, material: Material, irradiance: f64) {
    let scene = Builder::default()
        .quad(FLOOR, diffuse(0.8))
        .surface(surface, material)
        .scene(at_the_origin(), paths(64, 0));
    check(name, &scene, 0.8 / PI * irradiance, 1e-2);
}

#[test]
fn a_relief_of_one_height_is_a_lamp_moved() {
    // A quarter further down.
    let (high, low) = (1.75, 1.5);
    let irradiance = 3.0 * rectangle_irradiance([0.0, 2.0], [-1.0, 0.5], low);
    let lamp = emitter(Rgb::splat(3.0));
    let base = corners(ceiling([0.0, 2.0], [-1.0, 0.5], high));
    let relief = Arc::new(Relief::new(half()));
    let options = FaceOptions { displacement: displacement(), ..FaceOptions::default() };
    let face = ReliefFace::new(base, Arc::clone(&relief), options).unwrap();
    check_over_a_floor("face", face.into(), lamp.clone(), irradiance);

    let triangle = |positions| Triangle { positions, normals: None, uvs: Some(positions) };
    let data = MeshData {
        positions: base.to_vec(),
        uvs: vec![glam::DVec2::ZERO, glam::DVec2::X, glam::DVec2::ONE, glam::DVec2::Y],
        triangles: vec![triangle([0, 1, 2]), triangle([0, 2, 3])],
        ..MeshData::default()
    };
    let options = MeshOptions { displacement: displacement(), ..MeshOptions::default() };
    let mesh = ReliefMesh::new(&Mesh::new(data).unwrap(), relief, options).unwrap();
    check_over_a_floor("mesh", mesh.into(), lamp.clone(), irradiance);

    // Made elsewhere, of another size.
    let place = DAffine3::from_translation(DVec3::new(1.0, 2.0, 3.0))
        * DAffine3::from_rotation_y(0.7)
        * DAffine3::from_scale(DVec3::new(2.0, 0.5, -3.0));
    let [x, y] = [[0.0, 2.0], [-1.0, 0.5]];
    // A mirror keeps the front of a quad, and turns the order in which its corners are seen.
    let [a, b, c, d] = corners(ceiling(x, y, low)).map(|p| place.inverse().transform_point3(p));
    let quad: Surface = Quad::new([a, d, c, b], false).unwrap().into();
    let standing = Instance::new(Arc::new(quad), place).unwrap();
    check_over_a_floor("instance", standing.into(), lamp, irradiance);
}

#[test]
fn a_sphere_of_one_height_is_a_larger_sphere() {
    let center = DVec3::new(1.0, 0.0, 3.0);
    let irradiance = PI * 4.0 * 0.25 * (3.0 / 10.0_f64.sqrt()) / 10.0;
    let lamp = emitter(Rgb::splat(4.0));
    let relief = CubeRelief::new(&half(), Tiling::default()).unwrap();
    let options = SphereOptions { displacement: displacement(), ..SphereOptions::default() };
    let sphere = ReliefSphere::new(center, 0.25, relief, options).unwrap();
    check_over_a_floor("in relief", sphere.into(), lamp.clone(), irradiance);

    let place = DAffine3::from_translation(center) * DAffine3::from_scale(DVec3::splat(0.1));
    let small = Arc::new(Sphere::new(DVec3::ZERO, 5.0).unwrap().into());
    let standing = Instance::new(small, place).unwrap();
    check_over_a_floor("instance", standing.into(), lamp, irradiance);
}

#[test]
fn an_image_lights_as_its_texels_do() {
    // Black but for the right half, of which the upper one is twice as bright; texels are mixed, so
    // there are many, and what is lost at a border is won beyond it.
    let (n, mut texels) = (256, Vec::new());
    for k in 0..n * n {
        let (i, j) = (k % n, k / n);
        let light = if i < n / 2 { 0.0 } else { f32::from(1 + u8::from(j >= n / 2)) };
        texels.push([light, 0.0, 0.0]);
    }
    let image = Arc::new(ColourImage::new(n, n, Texels::Linear(texels)).unwrap());
    let material = Material { emission: Some(Texture::new(image)), ..emitter(Rgb::splat(3.0)) };
    let [corner, u, v] = ceiling([0.0, 2.0], [-1.0, 0.5], 1.5);
    // u of a ceiling runs along y, v along x: see `ceiling`.
    let part = |a: [f64; 2], b: [f64; 2]| {
        let ends = [corner + a[0] * u + b[0] * v, corner + a[1] * u + b[1] * v];
        let span = |k: usize| [ends[0][k].min(ends[1][k]), ends[0][k].max(ends[1][k])];
        3.0 * rectangle_irradiance(span(0), span(1), 1.5)
    };
    let irradiance = part([0.5, 1.0], [0.0, 0.5]) + 2.0 * part([0.5, 1.0], [0.5, 1.0]);
    let quad = Quad::new(corners([corner, u, v]), false).unwrap();
    check_over_a_floor("image", quad.into(), material, irradiance);
}
