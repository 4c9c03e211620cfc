//! Emitters of every kind, for tests.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec2, DVec3};
use rilievo::map::{HeightMap, Lattice, Procedural, Tiling, Wrap};
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{
    CubeRelief, Displacement, FaceOptions, MeshOptions, Relief, ReliefFace, ReliefMesh,
    ReliefSphere, SphereOptions,
};
use rilievo::surface::{Instance, Motion, MovingInstance, Quad, Sphere, Surface};

use crate::colour::Rgb;
use crate::scene::{Material, Reflectance};
use crate::texture::{ColourImage, Texels, Texture};

/// Hills; heights fill about half of [0, 1].
pub(crate) fn hills() -> HeightMap {
    let hills = Procedural::Fbm { octaves: 4, seed: 5 };
    hills.height_map_f32([33, 33], Lattice::Vertex, Wrap::Mirror).unwrap()
}

/// A square over [-1, 1]^2 at z = 0, displaced along z.
pub(crate) fn face(scale: f64) -> Surface {
    let displacement = Displacement { scale, tile: [1.5, 1.0], ..Displacement::default() };
    let options = FaceOptions { displacement, closed: true, ..FaceOptions::default() };
    let relief = Arc::new(Relief::new(hills()));
    ReliefFace::new(square(), relief, options).unwrap().into()
}

fn square() -> [DVec3; 4] {
    [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]].map(|[x, y]| DVec3::new(x, y, 0.0))
}

/// A vault of eight by eight squares of two triangles each over [-1, 1]^2, its front up.
fn vault() -> Mesh {
    let n = 8;
    let mut data = MeshData::default();
    for k in 0..(n + 1) * (n + 1) {
        let uv = DVec2::new(f64::from(k % (n + 1)), f64::from(k / (n + 1))) / f64::from(n);
        let at = 2.0 * uv - 1.0;
        data.positions.push(at.extend(0.4 * (1.0 - at.x * at.x)));
        data.uvs.push(uv);
    }
    for k in 0..n * n {
        let first = k / n * (n + 1) + k % n;
        for corners in [[0, 1, n + 2], [0, n + 2, n + 1]] {
            let corners = corners.map(|corner| first + corner);
            data.triangles.push(Triangle { positions: corners, normals: None, uvs: Some(corners) });
        }
    }
    Mesh::new(data).unwrap()
}

fn relief_mesh() -> Surface {
    let displacement = Displacement { scale: 0.4, ..Displacement::default() };
    let options = MeshOptions { displacement, ..MeshOptions::default() };
    ReliefMesh::new(&vault(), Arc::new(Relief::new(hills())), options).unwrap().into()
}

fn relief_sphere() -> Surface {
    let map = Procedural::Fbm { octaves: 4, seed: 8 };
    let map = map.height_map_f32([64, 32], Lattice::Texel, Wrap::Repeat).unwrap();
    let displacement = Displacement { scale: 0.5, zero: 0.5, ..Displacement::default() };
    let options = SphereOptions { displacement, ..SphereOptions::default() };
    let relief = CubeRelief::new(&map, Tiling::default()).unwrap();
    ReliefSphere::new(DVec3::ZERO, 0.9, relief, options).unwrap().into()
}

/// The same surface somewhere else, stretched, sheared and mirrored.
fn stands(surface: Surface) -> Surface {
    let shear = DMat3::from_cols(
        DVec3::new(-0.7, 0.1, 0.0),
        DVec3::new(0.0, 0.9, 0.2),
        DVec3::new(0.1, 0.0, 0.8),
    );
    let turn = DMat3::from_rotation_x(0.2);
    let place = DAffine3::from_mat3_translation(turn * shear, DVec3::new(0.1, -0.2, 0.1));
    Instance::new(Arc::new(surface), place).unwrap().into()
}

/// The same surface on its way: at time 0.5 a little aside and turned.
fn moves(surface: Surface) -> Surface {
    let motion = Motion {
        translation: DVec3::new(0.4, -0.3, 0.2),
        pivot: DVec3::new(0.1, 0.2, 0.0),
        axis: DVec3::new(0.1, 0.3, 1.0),
        angle: 0.8,
    };
    MovingInstance::new(Arc::new(surface), DAffine3::IDENTITY, motion).unwrap().into()
}

/// A body that shines evenly and reflects a little.
fn even() -> Material {
    let diffuse = Reflectance::Uniform(Rgb::splat(0.3));
    Material { diffuse, emitted: Rgb::new(2.0, 1.0, 0.5), ..Material::default() }
}

/// One that shines by an image, much of it black.
fn image() -> Material {
    let texel = |k: u32| {
        let (i, j) = (k % 12, k / 12);
        if (i / 3 + j / 2) % 3 == 0 { [3.0, 0.5 * (k % 5) as f32, 1.0] } else { [0.0; 3] }
    };
    let texels = Texels::Linear((0..12 * 8).map(texel).collect());
    let image = Arc::new(ColourImage::new(12, 8, texels).unwrap());
    Material { emission: Some(Texture::new(image)), ..even() }
}

/// Emitters about the origin whose fronts look up, and their names.
pub(crate) fn emitters() -> Vec<(&'static str, Surface, Material)> {
    let quad = || Surface::Quad(Quad::new(square(), false).unwrap());
    let bent = square().map(|p| p + 0.5 * p.x * p.y * DVec3::Z);
    let bent = Surface::Quad(Quad::new(bent, false).unwrap());
    let sphere = || Surface::Sphere(Sphere::new(DVec3::ZERO, 0.8).unwrap());
    vec![
        ("face", face(0.5), even()),
        ("a face that goes down", face(-0.5), even()),
        ("a face with an image", face(0.5), image()),
        ("a sphere in relief", relief_sphere(), even()),
        ("a sphere in relief with an image", relief_sphere(), image()),
        ("a mesh in relief", relief_mesh(), even()),
        ("a mesh in relief with an image", relief_mesh(), image()),
        ("a quad with an image", quad(), image()),
        ("a bent quad with an image", bent, image()),
        ("a sphere with an image", sphere(), image()),
        ("a mesh with an image", vault().into(), image()),
        ("a quad that stands", stands(quad()), even()),
        ("a sphere that stands", stands(sphere()), even()),
        ("a mesh that stands", stands(vault().into()), even()),
        ("a face that stands", stands(face(0.5)), image()),
        ("a mesh in relief that stands", stands(relief_mesh()), even()),
        ("a quad that moves", moves(quad()), even()),
        ("a face that moves", moves(face(0.5)), even()),
        ("a sphere in relief that stands", stands(relief_sphere()), image()),
    ]
}
