//! Renders whose rays a [`Tracer`] traces, many at a time: the pictures are those of one ray at a time.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};

use glam::DVec3;
use rilievo::Ray;
use rilievo::surface::World;
use rilievo_render::film::Tile;
use rilievo_render::light::{Light, PointLight, SunLight};
use rilievo_render::{
    Aov, Film, Integrator, Material, RenderError, RenderOptions, RenderSettings, RenderStats, Rgb,
    SamplerKind, Scene, ShadowRay, Traced, Tracer, begin, render, resume,
};

use crate::scenes::{Builder, camera, diffuse, emitter, glowing};

/// A room with lamps of all kinds, a lit instance, a glossy ball and a mirror; 40 x 35 pixels leave tiles cut.
fn scene(settings: RenderSettings) -> Scene {
    let lamp = [DVec3::new(-0.3, -0.3, 0.99), DVec3::Y * 0.6, DVec3::X * 0.6];
    let panel = [DVec3::new(-0.9, 0.9, -0.2), DVec3::Z * 0.4, DVec3::X * 0.4];
    let gloss = Material { reflective: Rgb::splat(0.5), roughness: 0.4, ..diffuse(0.3) };
    let mirror = Material { reflective: Rgb::splat(0.9), ..diffuse(0.0) };
    let point = PointLight::new(DVec3::new(0.7, -0.5, 0.5), Rgb::splat(0.3)).unwrap();
    let sun = SunLight::new(DVec3::new(0.1, -1.0, -0.4), Rgb::splat(0.5), 3.0).unwrap();
    let open = [DVec3::new(-1.0, -1.0, -1.0), DVec3::Y * 3.0, DVec3::X * 2.0];
    Builder::default()
        .room(DVec3::new(0.0, 0.0, 0.0), 1.0, &diffuse(0.6))
        .quad(open, diffuse(0.4))
        .quad(lamp, emitter(Rgb::splat(8.0)))
        .surface(glowing(panel), emitter(Rgb::new(1.0, 2.0, 3.0)))
        .sphere(DVec3::new(0.4, 0.3, -0.6), 0.4, gloss)
        .sphere(DVec3::new(-0.4, 0.5, -0.5), 0.4, mirror)
        .background(Rgb::new(0.1, 0.2, 0.4))
        .scene(camera([0.0, -0.9, 0.0], [0.0, 0.5, -0.2], 80.0, [40, 35]), settings)
        .with_lamps(vec![Light::Point(point), Light::Sun(sun)])
}

fn settings(integrator: Integrator) -> RenderSettings {
    RenderSettings {
        integrator,
        samples: 6,
        max_depth: 4,
        glossy_samples: 5,
        diffuse_samples: 2,
        shadow_samples: 3,
        ..RenderSettings::default()
    }
}

fn options(tracer: Option<&dyn Tracer>) -> RenderOptions<'_> {
    RenderOptions { tracer, aovs: &[Aov::P, Aov::N, Aov::Steps], ..RenderOptions::default() }
}

/// All bits of a picture.
fn bits(film: &Film) -> Vec<u32> {
    let colour = film.radiance().iter().flatten();
    let layers = film.layers().iter().flat_map(|layer| layer.values());
    colour.chain(layers).map(|value| value.to_bits()).collect()
}

fn drawn(scene: &Scene, options: &RenderOptions<'_>) -> (Film, RenderStats) {
    render(scene, options).unwrap()
}

#[test]
fn paths_in_waves_are_paths_one_by_one() {
    for sampler in SamplerKind::ALL {
        let scene = scene(RenderSettings { sampler, clamp: 3.0, ..settings(Integrator::Path) });
        let (one, stats) = drawn(&scene, &options(None));
        let (many, in_waves) = drawn(&scene, &options(Some(scene.world())));
        assert!(bits(&one) == bits(&many) && one.sums() == many.sums(), "{sampler}");
        assert_eq!(stats, in_waves);
        assert!(stats.rays.shadow > 10_000 && stats.rays.diffuse > 10_000, "{stats:?}");
    }
}

#[test]
fn trees_in_waves_are_trees_one_by_one() {
    let scene = scene(settings(Integrator::Distributed));
    let (one, stats) = drawn(&scene, &options(None));
    let (many, in_waves) = drawn(&scene, &options(Some(scene.world())));
    assert_eq!(stats, in_waves);
    assert!(stats.rays.shadow > 10_000 && stats.rays.reflection > 1_000, "{stats:?}");
    // Added up in another order, in f64.
    for (a, b) in one.radiance().iter().flatten().zip(many.radiance().iter().flatten()) {
        assert!((a - b).abs() <= 1e-6 * a.abs(), "{a} {b}");
    }
    for (one, many) in one.layers().iter().zip(many.layers()) {
        let bits = |values: &[f32]| values.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert!(bits(one.values()) == bits(many.values()), "{}", one.aov());
    }
}

#[test]
fn first_hits_in_waves_are_those_of_one_ray() {
    let scene = scene(settings(Integrator::Aov));
    let (one, many) = (drawn(&scene, &options(None)), drawn(&scene, &options(Some(scene.world()))));
    assert!(bits(&one.0) == bits(&many.0));
    assert_eq!(one.1, many.1);
}

#[test]
fn what_a_pixel_sees_does_not_depend_on_what_else_is_on_the_way() {
    for integrator in [Integrator::Distributed, Integrator::Path] {
        let scene = scene(settings(integrator));
        let whole = drawn(&scene, &options(Some(scene.world()))).0;
        let crop = Tile { corner: [7, 5], size: [20, 17] };
        let options =
            RenderOptions { crop: Some(crop), threads: 1, ..options(Some(scene.world())) };
        let part = drawn(&scene, &options).0;
        for y in 0..17 {
            for x in 0..20 {
                let of_whole = whole.radiance()[((y + 5) * 40 + x + 7) as usize];
                let of_part = part.radiance()[(y * 20 + x) as usize];
                assert_eq!(of_whole, of_part, "{integrator}: {x}, {y}");
            }
        }
    }
}

/// A world that counts its questions, and fails or stops the render at one of them.
struct Failing<'a> {
    world: &'a World,
    asked: AtomicUsize,
    fails_at: usize,
    stops: Option<&'a AtomicBool>,
}

impl Failing<'_> {
    fn count(&self) -> Result<(), String> {
        if self.asked.fetch_add(1, Ordering::Relaxed) < self.fails_at {
            return Ok(());
        }
        match self.stops {
            Some(cancel) => cancel.store(true, Ordering::Relaxed),
            None => return Err("the cable was pulled".to_owned()),
        }
        Ok(())
    }
}

impl Tracer for Failing<'_> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        self.count().and_then(|()| Tracer::closest(self.world, rays))
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        self.count().and_then(|()| Tracer::occluded(self.world, rays))
    }
}

#[test]
fn what_a_tracer_says_is_why_nothing_was_rendered() {
    for integrator in Integrator::ALL {
        let scene = scene(settings(integrator));
        for fails_at in 0..if integrator == Integrator::Aov { 1 } else { 4 } {
            let asked = AtomicUsize::new(0);
            let failing = Failing { world: scene.world(), asked, fails_at, stops: None };
            let found = render(&scene, &options(Some(&failing))).map(|_| ());
            assert_eq!(found, Err(RenderError::Tracer("the cable was pulled".to_owned())));
        }
    }
}

#[test]
fn a_render_stopped_between_waves_ends_as_one_that_was_not() {
    for integrator in [Integrator::Distributed, Integrator::Path] {
        let scene = scene(settings(integrator));
        let whole = drawn(&scene, &options(Some(scene.world()))).0;
        let mut film = begin(&scene, &options(None)).unwrap();
        for fails_at in [0, 1, 3, 9, 1 << 20] {
            let cancel = AtomicBool::new(false);
            let asked = AtomicUsize::new(0);
            let failing = Failing { world: scene.world(), asked, fails_at, stops: Some(&cancel) };
            let options = RenderOptions { cancel: &cancel, ..options(Some(&failing)) };
            film = resume(&scene, &options, film).unwrap().0;
        }
        assert!(film.is_complete() && bits(&film) == bits(&whole), "{integrator}");
    }
}
