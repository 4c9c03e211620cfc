//! What moves is, at each time, what stands there; and its box holds all of it.

use std::f64::consts::{PI, TAU};

use super::*;
use crate::accel::random::Random;
use crate::hit::Hit;
use crate::map::{HeightMap, Lattice, Procedural, Tiling, Wrap};
use crate::mesh::{Mesh, MeshData, Triangle, solids};
use crate::ray::{Coherence, Ray};
use crate::relief::{
    CubeRelief, Displacement, FaceOptions, MeshOptions, Relief, ReliefFace, ReliefMesh,
    ReliefSphere, SphereOptions,
};
use crate::surface::{Instance, Quad, Sphere, World};

fn heights(wrap: Wrap) -> HeightMap {
    Procedural::Fbm { octaves: 5, seed: 7 }.height_map_f32([33, 33], Lattice::Vertex, wrap).unwrap()
}

/// One of each kind, about [0, 1]^3.
fn prototypes() -> [Arc<Surface>; 6] {
    let square = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let displacement = Displacement { scale: 0.2, ..Displacement::default() };
    let relief = Arc::new(Relief::new(heights(Wrap::Clamp)));
    let triangle = |k: [u32; 3]| Triangle { positions: k, normals: None, uvs: Some(k) };
    let roof = MeshData {
        positions: square.map(|p| p + p.x * p.y * DVec3::Z).to_vec(),
        normals: Vec::new(),
        uvs: square.map(|p| p.truncate()).to_vec(),
        triangles: vec![triangle([0, 1, 3]), triangle([1, 2, 3])],
    };
    let (flat, roof) = (Mesh::new(solids::cube()).unwrap(), Mesh::new(roof).unwrap());
    let options = MeshOptions { displacement, ..MeshOptions::default() };
    let roof = ReliefMesh::new(&roof, Arc::clone(&relief), options).unwrap();
    let options = FaceOptions { displacement, closed: true, ..FaceOptions::default() };
    let face = ReliefFace::new(square, relief, options).unwrap();
    let options = SphereOptions { displacement, ..SphereOptions::default() };
    let around = CubeRelief::new(&heights(Wrap::Repeat), Tiling::default()).unwrap();
    let ball = ReliefSphere::new(DVec3::splat(0.5), 0.4, around, options).unwrap();
    let sphere = Sphere::new(DVec3::splat(0.5), 0.4).unwrap();
    let quad = Quad::new(square, false).unwrap();
    [quad.into(), sphere.into(), flat.into(), face.into(), ball.into(), roof.into()].map(Arc::new)
}

fn begins() -> [DAffine3; 3] {
    let turned = DAffine3::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 1.1);
    let stretch = DAffine3::from_scale(DVec3::new(1.5, 0.5, -2.0));
    let moved = DAffine3::from_translation(DVec3::new(1500.0, -800.0, 40.0));
    [DAffine3::IDENTITY, turned * stretch, moved * turned]
}

fn motion(random: &mut Random, most: f64) -> Motion {
    Motion {
        translation: 2.0 * random.cube(),
        pivot: 2.0 * random.cube(),
        axis: random.cube(),
        angle: most * (2.0 * random.unit() - 1.0),
    }
}

/// The same but for the time, which a surface at rest does not have.
fn at_rest(hit: Option<Hit>) -> Option<Hit> {
    hit.map(|hit| Hit { time: 0.0, ..hit })
}

#[test]
fn at_a_time_it_is_an_instance_in_that_place() {
    let mut random = Random(41);
    for prototype in prototypes() {
        let mut hits = 0;
        for case in 0..300 {
            let begin = begins()[case % 3];
            let motion = motion(&mut random, 9.0);
            let moving = MovingInstance::new(Arc::clone(&prototype), begin, motion).unwrap();
            let time = [0.0, 1.0, random.unit()][case / 3 % 3];
            let place = moving.world_from_local(time);
            let still = Instance::new(Arc::clone(&prototype), place).unwrap();
            let (moving, still) = (Surface::from(moving), Surface::from(still));
            assert!(moving.bounds().contains(&Aabb::around([still.bounds().centre()])));
            for _ in 0..20 {
                let at = place.transform_point3(DVec3::splat(0.5) + 0.4 * random.cube());
                let from = at + 3.0 * random.direction();
                let ray = Ray { time, ..Ray::new(from, at - from) };
                let hit = moving.closest(&ray, &mut ());
                assert_eq!(at_rest(hit), at_rest(still.closest(&ray, &mut ())));
                assert_eq!(moving.occludes(&ray, &mut ()), hit.is_some());
                let Some(hit) = hit else { continue };
                hits += 1;
                let next = hit.spawn(random.direction());
                assert_eq!((hit.time, next.time), (time, time));
                let found = moving.closest(&next, &mut ());
                assert_eq!(at_rest(found), at_rest(still.closest(&next, &mut ())));
            }
        }
        assert!(hits > 1000, "{hits}");
    }
}

#[test]
fn a_world_at_a_time_is_one_of_instances() {
    let mut random = Random(43);
    // Flat neighbours ask how the surface lies that a ray leaves, and one relief goes without a tree.
    let floor = |z: f64| {
        let corners = [[-9.0, -9.0], [9.0, -9.0], [9.0, 9.0], [-9.0, 9.0]];
        Surface::from(Quad::new(corners.map(|[x, y]| DVec3::new(x, y, z)), false).unwrap())
    };
    let prototypes = prototypes();
    for case in 0..60 {
        let time = random.unit();
        let (mut moving, mut still) =
            (vec![floor(-1.0), floor(2.0)], vec![floor(-1.0), floor(2.0)]);
        for prototype in prototypes.iter().cycle().skip(case).take(1 + case % 7) {
            let motion = motion(&mut random, 4.0);
            let way = MovingInstance::new(Arc::clone(prototype), DAffine3::IDENTITY, motion);
            let way = way.unwrap();
            let place = way.world_from_local(time);
            still.push(Instance::new(Arc::clone(prototype), place).unwrap().into());
            moving.push(way.into());
        }
        if case % 2 == 0 {
            for world in [&mut moving, &mut still] {
                world.push(prototypes[3].as_ref().clone());
            }
        }
        let (moving, still) = (World::new(moving), World::new(still));
        assert!(moving.moves() && !still.moves());
        let rays: Vec<_> = (0..200)
            .map(|_| Ray { time, ..Ray::new(4.0 * random.cube(), random.direction()) })
            .collect();
        let mut together = vec![None; rays.len()];
        moving.closest_each((&rays, Coherence::Incoherent), &mut together, &mut ());
        for (ray, found) in rays.into_iter().zip(together) {
            let mut ray = ray;
            assert_eq!(found, moving.closest(&ray, &mut ()));
            for _ in 0..4 {
                let hit = moving.closest(&ray, &mut ());
                assert_eq!(at_rest(hit), at_rest(still.closest(&ray, &mut ())));
                assert_eq!(moving.occluded(&ray, &mut ()), still.occluded(&ray, &mut ()));
                let Some(hit) = hit else { break };
                ray = hit.spawn(random.direction());
            }
        }
    }
}

#[test]
fn the_box_holds_the_surface_at_all_times() {
    let mut random = Random(47);
    for prototype in prototypes() {
        for case in 0..400 {
            let begin = begins()[case % 3];
            let most = [0.1, 3.0, TAU, 50.0, 5000.0][case % 5];
            let mut motion = motion(&mut random, most);
            match case % 4 {
                0 => motion.translation = DVec3::ZERO,
                1 => motion.axis = [DVec3::X, DVec3::Y, DVec3::Z][case % 3],
                _ => {}
            }
            let moving = MovingInstance::new(Arc::clone(&prototype), begin, motion).unwrap();
            let bounds = moving.bounds();
            let mut met = Aabb::EMPTY;
            for k in 0..200 {
                let time = if k < 100 { f64::from(k) / 99.0 } else { random.unit() };
                let now = Aabb::around(moving.hull(time));
                assert!(bounds.contains(&now), "{motion:?} {time}: {bounds:?} {now:?}");
                met = met.union(now);
            }
            if most <= 3.0 {
                let size = (met.max - met.min).max_element();
                let over = (met.min - bounds.min).max(bounds.max - met.max).max_element();
                assert!(over < 0.01 * size, "{motion:?}: {over} of {size}");
            }
        }
    }
}

#[test]
fn the_box_of_a_turn_is_not_that_of_its_ends() {
    let [quad, ..] = prototypes();
    let motion = Motion { angle: TAU, ..Motion::along(DVec3::ZERO) };
    let moving = MovingInstance::new(quad, DAffine3::IDENTITY, motion).unwrap();
    assert!((moving.world_from_local(1.0).matrix3.x_axis - DVec3::X).length() < 1e-14);
    let Aabb { min, max } = moving.bounds();
    // A corner goes round at a distance of the square root of 2.
    for edge in [-min.x, -min.y, max.x, max.y] {
        assert!((2f64.sqrt()..1.42).contains(&edge), "{edge}");
    }
    assert!(max.z - min.z < 2e-3);
}

#[test]
fn turns_are_counter_clockwise_and_ways_straight() {
    let [_, sphere, ..] = prototypes();
    let motion = Motion {
        translation: DVec3::new(0.0, 0.0, 4.0),
        pivot: DVec3::new(1.0, 0.0, 0.0),
        axis: DVec3::new(0.0, 0.0, 3.0),
        angle: PI,
    };
    let moving = MovingInstance::new(sphere, DAffine3::IDENTITY, motion).unwrap();
    assert_eq!(moving.motion().axis, DVec3::Z);
    let way = |time| moving.world_from_local(time).transform_point3(DVec3::new(2.0, 0.0, 0.0));
    for (time, at) in [
        (0.0, DVec3::new(2.0, 0.0, 0.0)),
        (0.5, DVec3::new(1.0, 1.0, 2.0)),
        (1.0, DVec3::new(0.0, 0.0, 4.0)),
        (-3.0, DVec3::new(2.0, 0.0, 0.0)),
        (7.0, DVec3::new(0.0, 0.0, 4.0)),
        (f64::NAN, DVec3::new(2.0, 0.0, 0.0)),
    ] {
        assert!((way(time) - at).length() < 1e-14, "{time}: {}", way(time));
    }
    assert_eq!(moving.world_from_local(0.0), DAffine3::IDENTITY);
}

#[test]
fn a_motion_seen_from_elsewhere_is_the_same_motion() {
    let mut random = Random(53);
    for case in 0..200 {
        let motion = motion(&mut random, 7.0).checked().unwrap();
        let turn = DAffine3::from_axis_angle(random.direction(), 6.0 * random.unit());
        let size = (0.1 + random.unit()) * [1.0, -1.0][case % 2];
        let mirror = DVec3::new([1.0, -1.0][case / 2 % 2], 1.0, 1.0);
        let place =
            DAffine3::from_translation(random.cube()) * turn * DAffine3::from_scale(size * mirror);
        let (time, at) = (random.unit(), random.cube());
        let inside = place.transform_point3(motion.now_from_begin(time).transform_point3(at));
        let placed = motion.placed(&place).checked().unwrap().now_from_begin(time);
        let outside = placed.transform_point3(place.transform_point3(at));
        assert!((inside - outside).length() < 1e-13, "{inside} {outside}");
    }
}

#[test]
fn instances_are_moved_and_what_moves_is_shown_once() {
    let [_, sphere, ..] = prototypes();
    let up = DAffine3::from_translation(DVec3::Z);
    let twice = DAffine3::from_scale(DVec3::splat(2.0));
    let way = Motion::along(DVec3::X);
    let inner = Arc::new(Surface::from(Instance::new(Arc::clone(&sphere), up).unwrap()));
    let moving = MovingInstance::new(inner, twice, way).unwrap();
    assert!(Arc::ptr_eq(moving.prototype(), &sphere));
    assert_eq!(moving.world_from_local(1.0).translation, DVec3::new(1.0, 0.0, 2.0));
    let moving = Arc::new(Surface::from(moving));
    assert_eq!(Instance::new(Arc::clone(&moving), up).unwrap_err(), InstanceError::Moving);
    assert_eq!(MovingInstance::new(moving, up, way).unwrap_err(), InstanceError::Moving);
}

#[test]
fn motions_out_of_range_are_refused() {
    let [_, sphere, ..] = prototypes();
    let along = Motion::along(DVec3::X);
    let flat = DAffine3::from_scale(DVec3::new(1.0, 1.0, 0.0));
    for (begin, motion, error) in [
        (flat, along, InstanceError::Singular),
        (DAffine3::IDENTITY, Motion::along(DVec3::NAN), InstanceError::NotFinite),
        (DAffine3::IDENTITY, Motion::along(DVec3::splat(1e101)), InstanceError::NotFinite),
        (DAffine3::IDENTITY, Motion { angle: f64::NAN, ..along }, InstanceError::NotFinite),
        (DAffine3::IDENTITY, Motion { angle: 1e5, ..along }, InstanceError::TooFar),
        (
            DAffine3::IDENTITY,
            Motion { angle: 1.0, axis: DVec3::ZERO, ..along },
            InstanceError::NoAxis,
        ),
    ] {
        assert_eq!(MovingInstance::new(Arc::clone(&sphere), begin, motion).unwrap_err(), error);
    }
    let still = Motion { axis: DVec3::ZERO, ..along };
    assert!(MovingInstance::new(sphere, DAffine3::IDENTITY, still).is_ok());
}
