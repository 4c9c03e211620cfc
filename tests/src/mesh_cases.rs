//! Displaced meshes to be judged: bases, maps and thicknesses, the places they are put in, and rays around them.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rilievo::Ray;
use rilievo::accel::Aabb;
use rilievo::map::{DistanceMap, DistanceOptions, HeightMap, Lattice, Metric, Wrap};
use rilievo::mesh::Mesh;
use rilievo::relief::{Displacement, Edges, MeshOptions, Method, Relief, ReliefMesh};

use crate::maps::Shape;
use crate::mesh_oracle::{Closing, MeshOracle};
use crate::meshes::Base;
use crate::random::Random;

/// A base with a map on it, of a thickness as a share of its size.
pub struct Case {
    /// What it is called.
    pub name: &'static str,
    /// What is displaced.
    pub base: Base,
    /// By what.
    pub map: HeightMap,
    /// How much of the diagonal of the base's box the map's heights span.
    pub thickness: f64,
    /// The height that stays.
    pub zero: f64,
    /// How edges are kept.
    pub edges: Edges,
    /// How often the map lies on a unit of uv.
    pub tile: [f64; 2],
}

impl Case {
    /// The displaced mesh, traced by a method.
    ///
    /// # Panics
    /// If the library refuses it.
    pub fn mesh(&self, method: Method, place: DAffine3) -> ReliefMesh {
        self.mesh_over(method, place, None)
    }

    /// Over a distance map of a size, if the method walks one; by default that of the library.
    ///
    /// # Panics
    /// If the library refuses it.
    pub fn mesh_over(&self, method: Method, place: DAffine3, size: Option<[u32; 3]>) -> ReliefMesh {
        let mesh = self.base.placed(place);
        let displacement = self.displacement(&mesh);
        let mut relief = Relief::new(self.map.clone());
        if let Some(kind) = method.distance_kind() {
            let sides = [0.3 * self::size(&mesh); 2];
            let metric = Metric::of_face(&self.map, sides, displacement.scale);
            let default = DistanceOptions::by_default(&self.map, kind, metric);
            let options = DistanceOptions { size: size.unwrap_or(default.size), ..default };
            let map = DistanceMap::from_height(&self.map, kind, &options).expect(self.name);
            relief = relief.with_distance(map).expect(self.name);
        }
        let options = MeshOptions {
            displacement,
            method,
            edges: self.edges,
            closed: true,
            ..MeshOptions::default()
        };
        ReliefMesh::new(&mesh, Arc::new(relief), options).expect(self.name)
    }

    /// All ways to trace it but the one that shows the leaf every cell.
    ///
    /// # Panics
    /// If the library refuses one.
    pub fn contenders(&self, place: DAffine3) -> Vec<(String, ReliefMesh)> {
        let mut all = vec![("pyramid".to_owned(), self.mesh(Method::Pyramid, place))];
        // Voxels of a cell, and of many cells.
        for (method, size) in [
            (Method::Distance, None),
            (Method::Distance, Some([5, 9, 4])),
            (Method::DistanceCorrected, Some([6, 7, 5])),
        ] {
            all.push((format!("{method}, {size:?}"), self.mesh_over(method, place, size)));
        }
        all
    }

    /// Its judge.
    pub fn oracle(&self, place: DAffine3) -> MeshOracle<'_> {
        let base = self.base.placed(place);
        let closing = match self.edges {
            Edges::Shared => Closing::Walls,
            Edges::AsAuthored => Closing::Authored,
        };
        MeshOracle::new(&base, &self.map, self.displacement(&base), closing)
    }

    /// Whether what it is displaced to has an inside.
    pub fn is_closed(&self) -> bool {
        self.base.is_closed() && self.edges != Edges::AsAuthored
    }

    fn displacement(&self, base: &Mesh) -> Displacement {
        let scale = self.thickness * size(base);
        Displacement { scale, zero: self.zero, tile: self.tile, shift: [0.1, -0.3] }
    }
}

/// The diagonal of a mesh's box.
pub fn size(mesh: &Mesh) -> f64 {
    let bounds = mesh.bounds();
    (bounds.max - bounds.min).length()
}

/// All cases in which a line that crosses the surface by turns goes in and out.
pub fn cases() -> Vec<Case> {
    let texel = |shape: Shape, size, wrap| shape.codes(size, Lattice::Texel, wrap);
    let case = |name, base, map, thickness| Case {
        name,
        base,
        map,
        thickness,
        zero: 0.5,
        edges: Edges::Shared,
        tile: [1.0, 1.0],
    };
    vec![
        case("torus", Base::Torus(12, 8), texel(Shape::Fbm(1), [48, 32], Wrap::Repeat), 0.03),
        case("thin", Base::Torus(12, 8), texel(Shape::White(2), [48, 32], Wrap::Repeat), 0.001),
        case("thick", Base::Torus(9, 6), texel(Shape::Fbm(3), [40, 24], Wrap::Repeat), 0.3),
        Case {
            zero: 2.0,
            ..case("inward", Base::Icosphere(2), texel(Shape::Fbm(4), [33, 17], Wrap::Clamp), 0.02)
        },
        case("sphere", Base::Icosphere(1), texel(Shape::White(5), [31, 18], Wrap::Mirror), 0.05),
        case(
            "cube",
            Base::Cube,
            Shape::Studs(4).floats([20, 13], Lattice::Vertex, Wrap::Mirror),
            0.05,
        ),
        Case {
            edges: Edges::AsAuthored,
            ..case("authored", Base::Cube, texel(Shape::Fbm(6), [20, 13], Wrap::Repeat), 0.1)
        },
        case("folded", Base::Folded(7), texel(Shape::Fbm(8), [16, 12], Wrap::Repeat), 0.05),
        case("trough", Base::Trough, texel(Shape::Ripple, [24, 40], Wrap::Repeat), 0.05),
        Case {
            tile: [5.0, 7.0],
            ..case("quad", Base::Quad, texel(Shape::White(9), [5, 4], Wrap::Repeat), 0.04)
        },
        case("coarse", Base::Torus(20, 14), texel(Shape::White(10), [4, 3], Wrap::Repeat), 0.05),
        case("spot", Base::Spot, texel(Shape::Fbm(11), [96, 96], Wrap::Repeat), 0.01),
        case("flat", Base::Icosphere(1), texel(Shape::Flat(0.7), [9, 9], Wrap::Repeat), 0.05),
        case("deep", Base::Icosphere(1), texel(Shape::Fbm(12), [40, 20], Wrap::Repeat), 0.3),
        case("film", Base::Spot, texel(Shape::White(13), [64, 64], Wrap::Repeat), 0.001),
        case("fur", Base::Spot, texel(Shape::Fbm(14), [48, 48], Wrap::Mirror), 0.2),
        case("pot", Base::Pot(14), texel(Shape::Fbm(18), [80, 64], Wrap::Repeat), 0.03),
        case("old pot", Base::Pot(10), texel(Shape::White(19), [24, 24], Wrap::Mirror), 0.12),
        matched(case("matched", Base::Spot, texel(Shape::Fbm(17), [64, 64], Wrap::Repeat), 0.02)),
        // Its ends differ: it jumps between tiles, wherever their lines run.
        Case {
            tile: [3.0, 2.0],
            ..case(
                "tiled",
                Base::Torus(8, 6),
                Shape::White(20).codes([9, 6], Lattice::Vertex, Wrap::Repeat),
                0.03,
            )
        },
    ]
}

/// Those, and one so deep over random uv that rays start within folds all over.
pub fn all_cases() -> Vec<Case> {
    let mut all = cases();
    all.push(Case {
        name: "knot",
        base: Base::Folded(15),
        map: Shape::White(16).codes([12, 16], Lattice::Texel, Wrap::Mirror),
        thickness: 0.3,
        zero: 0.5,
        edges: Edges::Shared,
        tile: [1.0, 1.0],
    });
    all
}

/// The case of a name.
///
/// # Panics
/// If there is none.
pub fn case(name: &str) -> Case {
    all_cases().into_iter().find(|case| case.name == name).expect("a case of this name")
}

/// A case whose map is baked towards equal heights at seams.
fn matched(case: Case) -> Case {
    let mesh = case.mesh(Method::Pyramid, DAffine3::IDENTITY);
    Case { map: mesh.matched_heights(4), ..case }
}

/// Moved, turned, tiny and large, as Embree's tests of watertightness place their meshes.
pub fn places() -> [DAffine3; 4] {
    let far = DVec3::new(148376.0, 1234.0, -223423.0);
    let turn = DAffine3::from_rotation_x(0.7) * DAffine3::from_rotation_z(-0.4);
    [
        DAffine3::IDENTITY,
        DAffine3::from_translation(far) * turn,
        DAffine3::from_translation(far) * DAffine3::from_scale(DVec3::splat(1e-3)),
        DAffine3::from_scale(DVec3::splat(1e6)) * turn,
    ]
}

/// A ray from around or inside the mesh towards it.
pub fn ray(mesh: &ReliefMesh, random: &mut Random) -> Ray {
    ray_towards(mesh.bounds(), random)
}

/// A ray from around or inside a box towards what is in it.
pub fn ray_towards(bounds: Aabb, random: &mut Random) -> Ray {
    let (centre, half) = (0.5 * (bounds.min + bounds.max), 0.5 * (bounds.max - bounds.min));
    let inside = |random: &mut Random, far: f64| {
        centre + half * far * DVec3::from_array([(); 3].map(|()| random.range(-1.0, 1.0)))
    };
    let origin = match random.integer(0, 3) {
        0 => centre + 3.0 * half.length() * random.direction(),
        1 => inside(random, 1.5),
        _ => inside(random, 1.0),
    };
    let mut ray = Ray::between(origin, inside(random, 0.9));
    if random.one_in(6) {
        // In a plane of two axes, or along one.
        ray.direction[random.integer(0, 2) as usize] = 0.0 * random.sign();
        ray.direction[random.integer(0, 2) as usize] *= f64::from(random.integer(0, 1));
    }
    ray.t_max = if random.one_in(4) { random.unit() } else { f64::INFINITY };
    ray
}

/// The diagonal of the box of what is displaced.
pub fn reach(mesh: &ReliefMesh) -> f64 {
    let bounds = mesh.bounds();
    (bounds.max - bounds.min).length()
}

/// A point in the box of what is displaced.
pub fn point_near(mesh: &ReliefMesh, random: &mut Random) -> DVec3 {
    let bounds = mesh.bounds();
    let at = DVec3::from_array([(); 3].map(|()| random.unit()));
    bounds.min + at * (bounds.max - bounds.min)
}

/// A point of an edge of the base, displaced by any height.
pub fn target(mesh: &ReliefMesh, random: &mut Random) -> DVec3 {
    let data = mesh.data();
    let triangle = &data.triangles[random.integer(0, data.triangles.len() as i32 - 1) as usize];
    let [a, b, c] = triangle.positions.map(|p| data.positions[p as usize]);
    let normal = (b - a).cross(c - a).normalize();
    let s = if random.one_in(3) { 0.0 } else { random.unit() };
    a.lerp(b, s) + random.range(-0.5, 0.5) * mesh.options().displacement.scale * normal
}
