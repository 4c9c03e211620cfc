//! Displaced meshes.

use std::sync::Arc;

use rilievo::Ray;
use rilievo::glam::{DAffine3, DVec3};
use rilievo::map::{HeightMap, Lattice, Layout, Wrap};
use rilievo::relief::{Displacement, Edges, MeshOptions, Relief, ReliefMesh};
use rilievo::surface::{Instance, Surface, World};
use rilievo_gpu::GpuWorld;
use rilievo_tests::maps::Shape;
use rilievo_tests::meshes::Base;
use rilievo_tests::random::Random;

use crate::pair::{Pair, Tally, asked, gpu};

/// A base with a map on it, of a thickness as a share of its size.
struct Case {
    name: &'static str,
    base: Base,
    map: HeightMap,
    thickness: f64,
    zero: f64,
    edges: Edges,
    tile: [f64; 2],
    one_sided: bool,
}

impl Case {
    fn mesh(&self, place: DAffine3, layout: Layout) -> ReliefMesh {
        let mesh = self.base.placed(place);
        let bounds = mesh.bounds();
        let displacement = Displacement {
            scale: self.thickness * (bounds.max - bounds.min).length(),
            zero: self.zero,
            tile: self.tile,
            shift: [0.1, -0.3],
        };
        let relief = Relief::with_layout(self.map.clone(), layout);
        let (edges, one_sided) = (self.edges, self.one_sided);
        let options =
            MeshOptions { displacement, edges, one_sided, closed: true, ..MeshOptions::default() };
        ReliefMesh::new(&mesh, Arc::new(relief), options).expect(self.name)
    }
}

fn cases() -> Vec<Case> {
    let texel = |shape: Shape, size, wrap| shape.codes(size, Lattice::Texel, wrap);
    let repeat = Wrap::Repeat;
    let case = |name, base, map, thickness| Case {
        name,
        base,
        map,
        thickness,
        zero: 0.5,
        edges: Edges::Shared,
        tile: [1.0, 1.0],
        one_sided: false,
    };
    vec![
        case("torus", Base::Torus(12, 8), texel(Shape::Fbm(1), [48, 32], repeat), 0.03),
        case("thin", Base::Torus(12, 8), texel(Shape::White(2), [48, 32], repeat), 0.001),
        case("thick", Base::Torus(9, 6), texel(Shape::Fbm(3), [40, 24], repeat), 0.3),
        Case {
            zero: 2.0,
            one_sided: true,
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
            ..case("authored", Base::Cube, texel(Shape::Fbm(6), [20, 13], repeat), 0.1)
        },
        case("folded", Base::Folded(7), texel(Shape::Fbm(8), [16, 12], repeat), 0.05),
        case("trough", Base::Trough, texel(Shape::Ripple, [24, 40], repeat), 0.05),
        Case {
            tile: [5.0, 7.0],
            ..case("quad", Base::Quad, texel(Shape::White(9), [5, 4], repeat), 0.04)
        },
        case("large", Base::Quad, texel(Shape::Fbm(18), [512, 512], repeat), 0.04),
        case("coarse", Base::Torus(20, 14), texel(Shape::White(10), [4, 3], repeat), 0.05),
        case("spot", Base::Spot, texel(Shape::Fbm(11), [96, 96], repeat), 0.01),
        case("flat", Base::Icosphere(1), texel(Shape::Flat(0.7), [9, 9], repeat), 0.05),
        case("deep", Base::Icosphere(1), texel(Shape::Fbm(12), [40, 20], repeat), 0.3),
        case("film", Base::Spot, texel(Shape::White(13), [64, 64], repeat), 0.001),
        case("fur", Base::Spot, texel(Shape::Fbm(14), [48, 48], Wrap::Mirror), 0.2),
        matched(case("matched", Base::Spot, texel(Shape::Fbm(17), [64, 64], repeat), 0.02)),
    ]
}

/// A case whose map is baked towards equal heights at seams.
fn matched(case: Case) -> Case {
    let mesh = case.mesh(DAffine3::IDENTITY, Layout::Default);
    Case { map: mesh.matched_heights(4), ..case }
}

fn places() -> [DAffine3; 4] {
    let far = DVec3::new(148376.0, 1234.0, -223423.0);
    let turn = DAffine3::from_rotation_x(0.7) * DAffine3::from_rotation_z(-0.4);
    [
        DAffine3::IDENTITY,
        DAffine3::from_translation(far) * turn,
        DAffine3::from_translation(far) * DAffine3::from_scale(DVec3::splat(1e-3)),
        DAffine3::from_scale(DVec3::splat(1e6)) * turn,
    ]
}

/// A ray from around or inside a box towards what is in it.
fn ray(centre: DVec3, half: DVec3, random: &mut Random) -> Ray {
    let inside = |random: &mut Random, far: f64| {
        centre + half * far * DVec3::from_array([(); 3].map(|()| random.range(-1.0, 1.0)))
    };
    let origin = match random.integer(0, 3) {
        0 => centre + 3.0 * half.length() * random.direction(),
        1 => inside(random, 1.5),
        _ => inside(random, 1.0),
    };
    let mut ray = Ray::between(origin, inside(random, 0.9));
    ray.t_max = if random.one_in(4) { random.unit() } else { f64::INFINITY };
    ray
}

#[test]
fn hits_on_displaced_meshes_are_those_of_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let mut tally = Tally::default();
    let count = asked("RILIEVO_RAYS", 120);
    let chosen = std::env::var("RILIEVO_CASE").ok();
    for (index, case) in (0..).zip(cases()).step_by(asked("RILIEVO_STEP", 1) as usize) {
        if chosen.as_ref().is_some_and(|name| name != case.name) {
            continue;
        }
        let place = places()[index as usize % 4];
        let layout = if index % 2 == 0 { Layout::Default } else { Layout::Tiny };
        let mesh = case.mesh(place, layout);
        // Every other one in a place of its own, mirrored and stretched.
        let mesh = Surface::from(mesh);
        let surface = if index % 3 == 2 {
            let place = DAffine3::from_scale(DVec3::new(-1.0, 1.5, 1.2))
                * DAffine3::from_translation(0.3 * (mesh.bounds().max - mesh.bounds().min));
            Surface::from(Instance::new(Arc::new(mesh), place).expect("it can be undone"))
        } else {
            mesh
        };
        let bounds = surface.bounds();
        let (centre, half) = (bounds.centre(), 0.5 * (bounds.max - bounds.min));
        let world = World::new(vec![surface]);
        let on_gpu = GpuWorld::new(&gpu, &world).expect("a displaced mesh can be traced");
        let name = case.name.to_owned();
        let pair = Pair { name, world: &world, on_gpu, centre, size: 2.0 * half.length() };
        let rays: Vec<Ray> =
            (0..count).map(|k| ray(centre, half, &mut Random::new(&[5, index, k]))).collect();
        pair.judge(&rays, &mut Random::new(&[6, index]), &mut tally);
    }
    tally.report("displaced meshes");
}
