//! Base meshes for the suites, with uv and normals.

mod pot;

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DVec2, DVec3};
use rilievo::mesh::{Mesh, MeshData, Triangle, solids};

use crate::random::Random;

/// A mesh of some shape.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    /// A unit sphere of subdivided triangles; longitude and latitude for uv, each triangle on its own.
    Icosphere(u32),
    /// A torus of radii 1 and 0.4 of so many steps around and across.
    Torus(u32, u32),
    /// The cube `[-1, 1]^3` with hard edges: each side shows the map whole, turned its own way.
    Cube,
    /// The icosphere, each triangle shown a random, mirrored or overlapping piece of the map.
    Folded(u64),
    /// The model of `scenes/spot`: closed, with uv seams, thin ears and legs.
    Spot,
    /// A closed pot with neck, lid and knob, turned in so many steps, and a handle: a body with a hole.
    Pot(u32),
    /// An open strip of long thin triangles, bent like a trough.
    Trough,
    /// Two triangles over a quad that is no parallelogram, not flat.
    Quad,
}

impl Base {
    /// The mesh.
    ///
    /// # Panics
    /// Never: all shapes are valid.
    pub fn mesh(self) -> Mesh {
        Mesh::new(self.data()).expect("shapes are valid")
    }

    /// The mesh, placed.
    ///
    /// # Panics
    /// If the transform cannot be inverted.
    pub fn placed(self, place: DAffine3) -> Mesh {
        self.mesh().transformed(place).expect("shapes are valid")
    }

    /// Whether it has no border.
    pub fn is_closed(self) -> bool {
        !matches!(self, Self::Trough | Self::Quad)
    }

    /// Whether many triangles meet in a point of which each shows another part of the map. The walls between them meet
    /// in a line there.
    pub fn has_poles(self) -> bool {
        matches!(self, Self::Pot(_))
    }

    fn data(self) -> MeshData {
        match self {
            Self::Icosphere(levels) => {
                let (positions, triangles) = icosphere(levels);
                let uv = |p: DVec3, near: f64| {
                    let mut u = p.y.atan2(p.x) / TAU + 0.5;
                    u += (near - u).round();
                    DVec2::new(u, p.z.clamp(-1.0, 1.0).asin() / PI + 0.5)
                };
                spread(positions, &triangles, |_, corners| {
                    let middle = corners[0] + corners[1] + corners[2];
                    let near = uv(middle, 0.5).x;
                    corners.map(|p| uv(p, near))
                })
            }
            Self::Folded(seed) => {
                let (positions, triangles) = icosphere(1);
                spread(positions, &triangles, |index, _| {
                    let mut random = Random::new(&[seed, index as u64]);
                    [(); 3].map(|()| DVec2::new(random.range(-1.5, 1.5), random.range(-1.5, 1.5)))
                })
            }
            Self::Torus(around, across) => torus(around, across),
            Self::Cube => cube(),
            Self::Pot(around) => pot::pot(around),
            Self::Trough => trough(),
            Self::Spot => spot(),
            Self::Quad => {
                let positions = vec![
                    DVec3::new(-1.0, -1.0, 0.0),
                    DVec3::new(1.2, -0.8, 0.1),
                    DVec3::new(0.9, 1.0, -0.2),
                    DVec3::new(-0.7, 0.8, 0.2),
                ];
                let uvs = vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
                let triangle = |c: [u32; 3]| Triangle { positions: c, normals: None, uvs: Some(c) };
                let triangles = vec![triangle([0, 1, 2]), triangle([0, 2, 3])];
                MeshData { positions, normals: Vec::new(), uvs, triangles }
            }
        }
    }
}

/// The octahedron cut in four so many times, on the unit sphere, turned a little.
fn icosphere(levels: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let turn = glam::DMat3::from_euler(glam::EulerRot::XYZ, 0.3, 0.2, 0.1);
    let MeshData { positions, triangles, .. } = solids::subdivided_sphere(levels);
    let positions = positions.into_iter().map(|p| turn * p).collect();
    (positions, triangles.iter().map(|triangle| triangle.positions).collect())
}

/// A mesh whose triangles have uv of their own; normals are the positions'.
fn spread(
    positions: Vec<DVec3>,
    triangles: &[[u32; 3]],
    uv: impl Fn(usize, [DVec3; 3]) -> [DVec2; 3],
) -> MeshData {
    let mut data = MeshData { normals: positions.clone(), positions, ..MeshData::default() };
    for (index, &corners) in triangles.iter().enumerate() {
        let first = data.uvs.len() as u32;
        data.uvs.extend(uv(index, corners.map(|p| data.positions[p as usize])));
        let uvs = Some([first, first + 1, first + 2]);
        data.triangles.push(Triangle { positions: corners, normals: Some(corners), uvs });
    }
    data
}

fn torus(around: u32, across: u32) -> MeshData {
    let mut data = MeshData::default();
    for j in 0..across {
        for i in 0..around {
            let (a, b) =
                (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
            let out = DVec3::new(a.cos(), a.sin(), 0.0);
            let normal = b.cos() * out + b.sin() * DVec3::Z;
            data.positions.push(out + 0.4 * normal);
            data.normals.push(normal);
        }
    }
    for j in 0..=across {
        for i in 0..=around {
            let uv = DVec2::new(f64::from(i) / f64::from(around), f64::from(j) / f64::from(across));
            data.uvs.push(uv * DVec2::new(2.0, 1.0));
        }
    }
    for j in 0..across {
        for i in 0..around {
            let p = |i: u32, j: u32| j % across * around + i % around;
            let t = |i: u32, j: u32| j * (around + 1) + i;
            for [a, b, c] in [[(0, 0), (1, 0), (1, 1)], [(0, 0), (1, 1), (0, 1)]] {
                let corners = [a, b, c];
                let positions = corners.map(|(x, y)| p(i + x, j + y));
                let uvs = Some(corners.map(|(x, y)| t(i + x, j + y)));
                data.triangles.push(Triangle { positions, normals: Some(positions), uvs });
            }
        }
    }
    data
}

fn cube() -> MeshData {
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let mut data = MeshData {
        positions: (0..8).map(|i| DVec3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect(),
        normals: vec![-DVec3::Z, DVec3::Z, -DVec3::Y, DVec3::Y, -DVec3::X, DVec3::X],
        uvs: vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
        triangles: Vec::new(),
    };
    let sides =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    for (number, [a, b, c, d]) in (0..).zip(sides) {
        let normals = Some([number; 3]);
        data.triangles.push(Triangle { positions: [a, b, c], normals, uvs: Some([0, 1, 2]) });
        data.triangles.push(Triangle { positions: [a, c, d], normals, uvs: Some([0, 2, 3]) });
    }
    data
}

/// Positions, uv and faces of an OBJ file that has every index.
fn spot() -> MeshData {
    let mut data = MeshData::default();
    for line in include_str!("../../scenes/spot/spot.obj").lines() {
        let mut words = line.split_whitespace();
        let key = words.next();
        let rest: Vec<&str> = words.collect();
        let number = |k: usize| rest[k].parse().expect("a number");
        match key {
            Some("v") => data.positions.push(DVec3::new(number(0), number(1), number(2))),
            Some("vt") => data.uvs.push(DVec2::new(number(0), number(1))),
            Some("f") => {
                let corners: Vec<[u32; 2]> = (rest.iter())
                    .map(|corner| {
                        let mut indices = corner.split('/').map(|i| i.parse::<u32>());
                        [(); 2].map(|()| indices.next().expect("p/t").expect("an index") - 1)
                    })
                    .collect();
                for k in 1..corners.len() - 1 {
                    let three = [corners[0], corners[k], corners[k + 1]];
                    let (positions, uvs) = (three.map(|c| c[0]), Some(three.map(|c| c[1])));
                    data.triangles.push(Triangle { positions, normals: None, uvs });
                }
            }
            _ => {}
        }
    }
    data
}

fn trough() -> MeshData {
    let mut data = MeshData::default();
    let count = 12;
    for i in 0..=count {
        let angle = PI * f64::from(i) / f64::from(count);
        for end in [-1.0, 1.0] {
            data.positions.push(DVec3::new(angle.cos(), 4.0 * end, -angle.sin()));
            data.uvs.push(DVec2::new(f64::from(i) / f64::from(count), 2.0 + end));
        }
    }
    for i in 0..count {
        let k = 2 * i;
        for c in [[k, k + 2, k + 3], [k, k + 3, k + 1]] {
            data.triangles.push(Triangle { positions: c, normals: None, uvs: Some(c) });
        }
    }
    data
}
