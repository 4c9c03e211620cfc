//! A room with one surface of each kind, whose materials and lights are a test's to choose.

use std::sync::Arc;

use rilievo::glam::{DAffine3, DVec2, DVec3};
use rilievo::map::{HeightMap, Lattice, Procedural, Tiling, Wrap};
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{
    CubeRelief, Displacement, FaceOptions, MeshOptions, Relief, ReliefFace, ReliefMesh,
    ReliefSphere, ShadingNormals, SphereOptions,
};
use rilievo::surface::{Instance, Motion, MovingInstance, Quad, Sphere, Surface, World};
use rilievo_render::{
    Camera, CameraParts, ColourImage, Material, Reflectance, RenderSettings, Rgb, Scene,
    SceneParts, Texels, Texture,
};

/// What stands in the room, in the order of its surfaces: floor, back wall, lamp, ball, and a pyramid shown twice.
pub struct Room {
    pub floor: Material,
    pub wall: Material,
    pub lamp: Material,
    pub ball: Material,
    pub pyramid: Material,
    pub shapes: Shapes,
    /// Whether the ball and one of the pyramids move.
    pub moves: bool,
    pub background: Rgb,
    pub ambient: Rgb,
    pub side: u32,
}

/// What of the room is displaced beside the floor.
#[derive(Clone, Copy, PartialEq)]
pub enum Shapes {
    Plain,
    Ball,
    /// The pyramids, one of which stands in the place of the ball. The floor is flat.
    Meshes,
}

impl Default for Room {
    fn default() -> Self {
        let grey = |x: f64| Material {
            diffuse: Reflectance::Uniform(Rgb::new(x, 0.8 * x, 0.6 * x)),
            ..Material::default()
        };
        Self {
            floor: grey(0.7),
            wall: Material { diffuse: Reflectance::Textured(image(false)), ..grey(1.0) },
            lamp: Material { emitted: Rgb::new(5.0, 4.0, 3.0), ..grey(0.1) },
            ball: Material { reflective: Rgb::splat(0.4), roughness: 0.4, ..grey(0.3) },
            pyramid: grey(0.5),
            shapes: Shapes::Plain,
            moves: false,
            background: Rgb::new(0.1, 0.2, 0.3),
            ambient: Rgb::splat(0.02),
            side: 24,
        }
    }
}

/// Bright and dark checks with a ramp of colour, once over the surface and a half.
pub fn image(linear: bool) -> Texture {
    let codes: Vec<[u8; 3]> = (0..16_u8)
        .flat_map(|j| {
            (0..16_u8).map(move |i| [40 + 12 * i, 200 - 11 * j, 60 + 90 * ((i / 2 + j / 2) % 2)])
        })
        .collect();
    let texels = if linear { Texels::Linear8(codes) } else { Texels::Srgb8(codes) };
    let texture = Texture::new(Arc::new(ColourImage::new(16, 16, texels).unwrap()));
    Texture {
        tile: DVec2::new(1.5, 1.5),
        turn: DVec2::new(0.8, 0.6),
        shift: DVec2::new(0.1, 0.2),
        ..texture
    }
}

fn hills() -> HeightMap {
    let hills = Procedural::Fbm { octaves: 3, seed: 5 };
    hills.height_map_f32([17, 17], Lattice::Vertex, Wrap::Mirror).unwrap()
}

/// A pyramid over a square, with normals of its own on two sides.
fn pyramid(place: DAffine3, with_uvs: bool) -> Mesh {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let mut positions: Vec<DVec3> = corners.map(|[x, y]| DVec3::new(x, y, 0.0)).to_vec();
    positions.push(DVec3::new(0.0, 0.0, 1.5));
    positions.iter_mut().for_each(|p| *p = place.transform_point3(*p));
    let normals: Vec<DVec3> =
        positions.iter().map(|p| (*p - place.translation + 0.2 * DVec3::Z).normalize()).collect();
    let uvs = vec![DVec2::ZERO, DVec2::X, DVec2::new(0.4, 1.0)];
    let triangles = (0..4).map(|k| {
        let positions = [k, (k + 1) % 4, 4];
        let normals = (k % 2 == 0).then_some(positions);
        Triangle { positions, normals, uvs: (with_uvs || k < 2).then_some([0, 1, 2]) }
    });
    Mesh::new(MeshData { positions, normals, uvs, triangles: triangles.collect() }).unwrap()
}

/// Its sides show other heights along their edges, so walls stand there, and around its open base.
fn displaced_pyramid(place: DAffine3) -> Surface {
    let displacement =
        Displacement { scale: 0.25, zero: 0.2, tile: [2.0, 1.5], ..Default::default() };
    let options =
        MeshOptions { displacement, normals: ShadingNormals::Smooth, ..Default::default() };
    let mesh = pyramid(place, true);
    ReliefMesh::new(&mesh, Arc::new(Relief::new(hills())), options).unwrap().into()
}

fn quad(corners: [[f64; 3]; 4]) -> Surface {
    Quad::new(corners.map(DVec3::from), false).unwrap().into()
}

impl Room {
    /// The room under settings.
    pub fn scene(self, settings: RenderSettings) -> Scene {
        let floor = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]];
        let displacement =
            Displacement { scale: 0.5, zero: 0.5, tile: [1.5, 1.0], ..Default::default() };
        let normals = ShadingNormals::Smooth;
        let options = FaceOptions { displacement, normals, closed: true, ..Default::default() };
        let corners = floor.map(|[x, y]| DVec3::new(x, y, 0.0));
        let face = ReliefFace::new(corners, Arc::new(Relief::new(hills())), options).unwrap();
        let center = DVec3::new(-0.8, 0.3, 0.9);
        let ball: Surface = match self.shapes {
            Shapes::Plain => Sphere::new(center, 0.6).unwrap().into(),
            Shapes::Meshes => {
                let place = DAffine3::from_translation(center - 0.5 * DVec3::Z);
                displaced_pyramid(place * DAffine3::from_scale(DVec3::splat(0.5)))
            }
            Shapes::Ball => {
                let map = Procedural::Fbm { octaves: 3, seed: 9 };
                let map: HeightMap =
                    map.height_map_f32([32, 16], Lattice::Texel, Wrap::Repeat).unwrap();
                let displacement = Displacement { scale: 0.15, ..Default::default() };
                let normals = ShadingNormals::Smooth;
                let options = SphereOptions { displacement, normals, ..Default::default() };
                let relief = CubeRelief::new(&map, Tiling::default()).unwrap();
                ReliefSphere::new(center, 0.5, relief, options).unwrap().into()
            }
        };
        let motion = Motion {
            translation: DVec3::new(0.5, 0.1, 0.2),
            pivot: center + DVec3::X,
            axis: DVec3::new(0.3, 1.0, 0.2),
            angle: 0.7,
        };
        let moved = |surface: Surface| match self.moves {
            true => {
                MovingInstance::new(Arc::new(surface), DAffine3::IDENTITY, motion).unwrap().into()
            }
            false => surface,
        };
        let meshes = self.shapes == Shapes::Meshes;
        let shown = Arc::new(match meshes {
            true => displaced_pyramid(DAffine3::IDENTITY),
            false => pyramid(DAffine3::IDENTITY, false).into(),
        });
        let stood = |x: f64, size: f64| -> Surface {
            let turned = DAffine3::from_rotation_z(0.4 + x);
            let place = DAffine3::from_translation(DVec3::new(x, -0.2, 0.35));
            let sized = DAffine3::from_scale(DVec3::new(size, size, 1.4 * size));
            Instance::new(Arc::clone(&shown), place * turned * sized).unwrap().into()
        };
        let surfaces = vec![
            if meshes { quad(floor.map(|[x, y]| [x, y, 0.0])) } else { face.into() },
            quad([[-2.0, 2.0, 0.0], [2.0, 2.0, 0.0], [2.0, 2.0, 3.0], [-2.0, 2.0, 3.0]]),
            quad([[-0.7, -0.5, 3.0], [-0.7, 0.8, 3.0], [0.7, 0.8, 3.0], [0.7, -0.5, 3.0]]),
            moved(ball),
            moved(stood(0.9, 0.5)),
            stood(0.1, 0.25),
        ];
        let camera = CameraParts {
            position: DVec3::new(0.3, -5.0, 2.0),
            look_at: DVec3::new(0.0, 0.0, 1.1),
            up: DVec3::Z,
            fov: 42.0,
            resolution: [self.side; 2],
        };
        Scene::new(SceneParts {
            world: World::new(surfaces),
            materials: vec![self.floor, self.wall, self.lamp, self.ball, self.pyramid],
            material_of: vec![0, 1, 2, 3, 4, 4],
            camera: Camera::new(camera).unwrap().with_shutter([0.2, 0.9]).unwrap(),
            background: self.background,
            ambient: self.ambient,
            settings,
        })
        .unwrap()
    }
}
