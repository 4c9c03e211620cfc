//! Displaced faces in a whole render.

use std::sync::Arc;

use glam::DVec3;
use rilievo::map::{HeightMap, Lattice, Samples, Wrap};
use rilievo::relief::{Displacement, FaceOptions, Method, Relief, ReliefFace};
use rilievo::surface::{Surface, World};
use rilievo_render::{
    Aov, Camera, Integrator, Material, MemoryUse, RenderOptions, RenderSettings, Rgb, Scene,
    SceneParts, render,
};

use crate::scenes::{camera, diffuse, emitter, lamp};

/// Rough heights, the same every time.
fn heights() -> HeightMap {
    let codes = (0u32..64 * 64).map(|i| (i.wrapping_mul(2_654_435_761) >> 16) as u16);
    HeightMap::new(64, 64, Samples::U16(codes.collect()), Lattice::Texel, Wrap::Repeat).unwrap()
}

/// Two displaced unit faces at right angles that share a relief, under a lamp.
fn scene(method: Method, settings: RenderSettings) -> Scene {
    let relief = Arc::new(Relief::new(heights()));
    let face = |corners: [DVec3; 4]| {
        let displacement = Displacement { scale: 0.05, ..Displacement::default() };
        let options = FaceOptions { displacement, method, closed: true, ..FaceOptions::default() };
        let face = ReliefFace::new(corners, Arc::clone(&relief), options).unwrap();
        Surface::Face(Box::new(face))
    };
    let [x, y, z] = DVec3::AXES;
    let gloss = Material { reflective: Rgb::splat(0.4), roughness: 0.3, ..diffuse(0.5) };
    Scene::new(SceneParts {
        world: World::new(vec![
            face([DVec3::ZERO, x, x + y, y]),
            face([y, x + y, x + y + z, y + z]),
            lamp([0.2, -0.5, 1.5], 0.6),
        ]),
        materials: vec![gloss, diffuse(0.7), emitter(Rgb::splat(5.0))],
        material_of: vec![0, 1, 2],
        camera: Camera::new(camera([0.5, -1.5, 1.2], [0.5, 0.6, 0.2], 45.0, [40, 40])).unwrap(),
        background: Rgb::new(0.1, 0.2, 0.3),
        ambient: Rgb::splat(0.05),
        settings,
    })
    .unwrap()
}

#[test]
fn methods_and_threads_give_the_same_bytes() {
    let settings = RenderSettings { samples: 2, ..RenderSettings::default() };
    let run = |method, threads| {
        let options = RenderOptions { threads, aovs: &[Aov::P, Aov::N], ..Default::default() };
        let (film, _) = render(&scene(method, settings), &options).unwrap();
        let layers = film.layers().iter().flat_map(|layer| layer.values());
        let values = film.radiance().iter().flatten().chain(layers);
        values.map(|value| value.to_bits()).collect::<Vec<u32>>()
    };
    let first = run(Method::Pyramid, 1);
    for (method, threads) in [(Method::Pyramid, 7), (Method::Dda, 2)] {
        assert!(run(method, threads) == first, "{method} on {threads} threads");
    }
}

#[test]
fn every_value_is_finite_and_steps_are_counted() {
    let settings = RenderSettings { samples: 4, ..RenderSettings::default() };
    let options = RenderOptions { aovs: &[Aov::Steps, Aov::Height], ..RenderOptions::default() };
    let (film, stats) = render(&scene(Method::Pyramid, settings), &options).unwrap();
    assert!(film.radiance().iter().flatten().all(|c| c.is_finite() && *c >= 0.0));
    let [steps, heights] = [Aov::Steps, Aov::Height].map(|aov| film.layer(aov).unwrap().values());
    for (steps, height) in steps.iter().zip(heights) {
        assert!((0.0..=1.0).contains(height) && (*height == 0.0 || *steps > 0.0));
    }
    assert!(heights.iter().filter(|&&height| height > 0.0).count() > 500);
    assert!(stats.rays.shadow > 0 && stats.rays.reflection > 0);
}

#[test]
fn shared_maps_are_predicted_once() {
    let settings =
        RenderSettings { integrator: Integrator::Aov, samples: 1, ..RenderSettings::default() };
    let options = RenderOptions { threads: 2, aovs: &[Aov::P], ..RenderOptions::default() };
    let memory = MemoryUse::predict(&scene(Method::Pyramid, settings), &options);
    assert_eq!(memory.heights, 2 * 64 * 64);
    assert!(memory.bounds > 0 && memory.bounds < memory.heights);
    assert_eq!(memory.film, 40 * 40 * (12 + 1 + 12));
    assert!(memory.total() > memory.heights + memory.bounds + memory.film);
}
