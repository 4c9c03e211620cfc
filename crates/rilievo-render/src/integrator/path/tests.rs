//! Emitters sampled and met by chance, and the weights of both.

use glam::DVec2;
use rilievo::surface::{Quad, Surface};

use super::*;
use crate::light::fixtures::emitters;
use crate::sampler::SamplerKind;
use crate::scene::{Camera, CameraParts, Material, SceneParts};

/// An emitter that shines up between two grey planes.
fn lit_from_below(surface: Surface, material: Material) -> Scene {
    let plane = |z: f64, side: f64| {
        let corners = [[-side, -side], [side, -side], [side, side], [-side, side]];
        Surface::Quad(Quad::new(corners.map(|[x, y]| DVec3::new(x, y, z)), false).unwrap())
    };
    let camera = CameraParts {
        position: DVec3::NEG_Y,
        look_at: DVec3::ZERO,
        up: DVec3::Z,
        fov: 40.0,
        resolution: [8, 8],
    };
    let settings = crate::RenderSettings { max_depth: 2, ..Default::default() };
    Scene::new(SceneParts {
        world: World::new(vec![surface, plane(2.5, 2.0), plane(-1.6, 2.0)]),
        materials: vec![material, Material::default()],
        material_of: vec![0, 1, 1],
        camera: Camera::new(camera).unwrap(),
        background: Rgb::ZERO,
        ambient: Rgb::ZERO,
        settings,
    })
    .unwrap()
}

/// Mean of what paths find that begin at the upper plane, and its standard error.
fn mean(tracer: &PathTracer<'_>) -> (f64, f64) {
    let (n, mut rays) = (6000, RayCounts::default());
    let (mut sum, mut squares) = (0.0, 0.0);
    for k in 0..n {
        let mut sampler = PathSampler::new(SamplerKind::Sobol, 3, [0, 0], k, n);
        let to = 2.0 * sampler.two() - DVec2::ONE;
        let from = DVec3::new(5.0, 0.0, 2.0);
        let ray = Ray::new(from, to.extend(2.5) - from);
        let hit = tracer.scene.world().closest(&ray, &mut ());
        let full = Detail::full(tracer.scene.world());
        let found = tracer.radiance(&ray, (hit.as_ref(), full), sampler, &mut rays).x;
        (sum, squares) = (sum + found, squares + found * found);
    }
    let (mean, n) = (sum / n as f64, n as f64);
    (mean, ((squares / n - mean * mean) / n).sqrt())
}

#[test]
fn emitters_light_as_much_sampled_as_met_by_chance() {
    let none = Lighting::none();
    for (name, surface, material) in emitters() {
        let scene = lit_from_below(surface, material);
        let both = PathTracer::new(&scene, 0.0);
        let chance = PathTracer { lighting: &none, chooses: false, ..PathTracer::new(&scene, 0.0) };
        let (sampled, met) = (mean(&both), mean(&chance));
        let found = format!("{name}: {sampled:?}, by chance {met:?}");
        // Pairs of the sequence are not independent: the errors are bounds.
        assert!((sampled.0 - met.0).abs() < 4.0 * sampled.1.hypot(met.1), "{found}");
        assert!(sampled.0 > 0.0 && sampled.1 < met.1, "{found}");
    }
}

#[test]
fn weights_of_two_techniques_add_up() {
    for (a, b) in [(1.0, 3.0), (1e-200, 1e200), (1e200, 1e180), (2.0, 0.0)] {
        assert!((power(a, b) + power(b, a) - 1.0).abs() < 1e-12 || b == 0.0);
    }
    assert_eq!(power(2.0, 0.0), 1.0);
}
