//! The library's own worlds before their judge.

use glam::DQuat;
use rilievo::SimdLevel;
use rilievo::map::{Lattice, Layout, Wrap};
use rilievo::relief::{Displacement, MeshOptions, Method, Relief};
use rilievo::surface::{Instance, Motion, Quad, Sphere};

use super::*;
use crate::maps::Shape;
use crate::meshes::Base;
use crate::random::Random;
use crate::{kernel, scenes, sphere};

/// A surface of every kind at random places, and three instances of each, one of which moves.
fn world(random: &mut Random) -> World {
    let scene = scenes::named("fbm 64");
    let pebble = &sphere::scenes()[1];
    let pebble = pebble.sphere(Method::Pyramid, Layout::Default, SimdLevel::detect());
    let map = Shape::Fbm(1).codes([48, 32], Lattice::Texel, Wrap::Repeat);
    let displacement = Displacement { scale: 0.2, zero: 0.5, ..Displacement::default() };
    let options = MeshOptions { displacement, ..MeshOptions::default() };
    let ring =
        ReliefMesh::new(&Base::Torus(9, 6).mesh(), Arc::new(Relief::new(map)), options).unwrap();
    let [corner, u, v] = [3.0, 1.5, 1.5].map(|size| size * random.direction());
    let quad = |one_sided| -> Surface {
        Quad::new([corner, corner + u, corner + u + 1.7 * v, corner + v], one_sided).unwrap().into()
    };
    let mut all: Vec<Surface> = vec![
        quad(false),
        quad(true),
        Sphere::new(2.0 * random.direction(), 0.8).unwrap().into(),
        Base::Torus(12, 8).mesh().into(),
        kernel::face(&scene, Method::Pyramid).into(),
        pebble.into(),
        ring.into(),
    ];
    let kinds = all.len();
    for k in 0..3 * kinds {
        let turn = DQuat::from_axis_angle(random.direction(), random.range(0.0, 6.0));
        let scale = DVec3::new(1.0, random.range(0.5, 1.5), random.sign());
        let place =
            DAffine3::from_scale_rotation_translation(scale, turn, 4.0 * random.direction());
        let prototype = Arc::new(all[k % kinds].clone());
        if k < 2 * kinds {
            all.push(Instance::new(prototype, place).unwrap().into());
            continue;
        }
        let motion = Motion {
            translation: 2.0 * random.direction(),
            axis: random.direction(),
            pivot: 3.0 * random.direction(),
            angle: random.range(-2.0, 2.0),
        };
        all.push(MovingInstance::new(prototype, place, motion).unwrap().into());
    }
    World::new(all)
}

#[test]
fn hits_in_whole_worlds_are_those_of_their_judge() {
    let (mut hits, mut excused, mut of_surface) = (0, 0, HashMap::new());
    for seed in 0..2 {
        let mut random = Random::new(&[91, seed]);
        let world = world(&mut random);
        let oracle = WorldOracle::new(&world).unwrap();
        for _ in 0..1000 {
            let [from, to] = [random.range(0.0, 9.0), 3.0].map(|size| size * random.direction());
            let (t_max, time) = (random.range(0.3, 3.0), random.unit());
            let ray = Ray { t_max, time, ..Ray::new(from, to - from) };
            let found = world.closest(&ray, &mut ());
            let same = match (&found, oracle.closest(&ray)) {
                (None, None) => true,
                (Some(hit), Some(judge)) => {
                    hit.surface == judge.surface && hit.position.distance(judge.position) <= 1e-8
                }
                _ => false,
            };
            if !same {
                assert!(oracle.excuses(&found, &ray, 1e-5), "{ray:?} {found:?}");
                excused += 1;
            }
            if let Some(hit) = found {
                hits += 1;
                *of_surface.entry(hit.surface % 7).or_insert(0) += 1;
            }
        }
    }
    assert!(hits > 800 && excused < 20, "{hits} hits, {excused} excused");
    assert!(of_surface.len() == 7 && of_surface.values().all(|&n| n >= 5), "{of_surface:?}");
}

#[test]
fn a_hit_that_is_not_there_is_not_excused() {
    let world = World::new(vec![Sphere::new(DVec3::ZERO, 1.0).unwrap().into()]);
    let oracle = WorldOracle::new(&world).unwrap();
    let ray = Ray::new(DVec3::new(0.3, 0.0, 5.0), -DVec3::Z);
    let found = world.closest(&ray, &mut ());
    assert!(oracle.excuses(&found, &ray, 1e-9) && !oracle.excuses(&None, &ray, 1e-9));
    let off = found.map(|hit| Hit { position: hit.position + 1e-4 * DVec3::Z, ..hit });
    assert!(!oracle.excuses(&off, &ray, 1e-5));
    // A nudge aside there is nothing.
    let edge = Ray::new(DVec3::new(1.0 - 1e-6, 0.0, 5.0), -DVec3::Z);
    assert!(oracle.closest(&edge).is_some() && oracle.excuses(&None, &edge, 1e-9));
}
