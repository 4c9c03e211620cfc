//! Same scene, same bytes; and what stopping leaves behind.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crate::scenes::{Builder, camera, diffuse, emitter};
use glam::DVec3;
use rilievo_render::{
    Aov, FilterKind, Integrator, Material, RenderOptions, RenderSettings, Rgb, Scene, render,
};

/// A room with a lamp, a glossy sphere and a mirror; 70 x 50 pixels leave tiles cut.
fn scene(settings: RenderSettings) -> Scene {
    let lamp = [DVec3::new(-0.3, -0.3, 0.99), DVec3::Y * 0.6, DVec3::X * 0.6];
    let gloss = Material { reflective: Rgb::splat(0.5), roughness: 0.4, ..diffuse(0.3) };
    let mirror = Material { reflective: Rgb::splat(0.9), ..diffuse(0.0) };
    Builder::default()
        .room(DVec3::ZERO, 1.0, &diffuse(0.7))
        .quad(lamp, emitter(Rgb::splat(8.0)))
        .sphere(DVec3::new(0.4, 0.3, -0.6), 0.4, gloss)
        .sphere(DVec3::new(-0.4, 0.5, -0.5), 0.4, mirror)
        .scene(camera([0.0, -0.9, 0.0], [0.0, 0.5, -0.2], 80.0, [70, 50]), settings)
}

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    for (integrator, filter) in [
        (Integrator::Distributed, FilterKind::Mitchell),
        (Integrator::Aov, FilterKind::BlackmanHarris),
    ] {
        let settings = RenderSettings {
            integrator,
            filter: filter.into(),
            samples: 3,
            diffuse_samples: 2,
            ..Default::default()
        };
        let scene = scene(settings);
        let run = |threads| {
            let options = RenderOptions { threads, aovs: &Aov::ALL, ..RenderOptions::default() };
            render(&scene, &options).unwrap()
        };
        let bits = |film: &rilievo_render::Film| -> Vec<u32> {
            let colour = film.radiance().iter().flatten();
            let layers = film.layers().iter().flat_map(|layer| layer.values());
            colour.chain(layers).map(|value| value.to_bits()).collect()
        };
        let (first, stats) = run(1);
        assert!(stats.complete && first.is_complete());
        for threads in [2, 7] {
            let (film, again) = run(threads);
            assert!(bits(&film) == bits(&first), "{threads} threads");
            assert_eq!(stats, again);
        }
    }
}

#[test]
fn another_seed_gives_another_image_of_the_same_scene() {
    let mean = |seed| {
        let settings = RenderSettings { seed, samples: 4, ..RenderSettings::default() };
        let (film, _) = render(&scene(settings), &RenderOptions::default()).unwrap();
        let sum: f64 = film.radiance().iter().map(|rgb| f64::from(rgb[0])).sum();
        sum / film.radiance().len() as f64
    };
    let (a, b) = (mean(0), mean(1));
    assert!(a != b && (a / b - 1.0).abs() < 0.05, "{a} {b}");
}

#[test]
fn progress_ends_at_the_number_of_camera_rays() {
    let seen = Mutex::new(Vec::new());
    let progress = |done, total| seen.lock().unwrap().push((done, total));
    let settings = RenderSettings { samples: 1, ..RenderSettings::default() };
    let options = RenderOptions { progress: &progress, ..RenderOptions::default() };
    render(&scene(settings), &options).unwrap();
    let seen = seen.into_inner().unwrap();
    // 5 x 4 tiles of 16 x 16.
    assert_eq!(seen.len(), 20);
    assert_eq!(seen.iter().max(), Some(&(3500, 3500)));
}

#[test]
fn stopping_keeps_finished_tiles() {
    let settings = RenderSettings { samples: 2, ..RenderSettings::default() };
    let scene = scene(settings);
    let whole = render(&scene, &RenderOptions::default()).unwrap().0;
    let cancel = AtomicBool::new(false);
    let progress = |done, _| cancel.store(done >= 2000, Ordering::Relaxed);
    let options =
        RenderOptions { progress: &progress, cancel: &cancel, ..RenderOptions::default() };
    let (film, stats) = render(&scene, &options).unwrap();
    assert!(!stats.complete && !film.is_complete());
    let finished = film.finished().iter().filter(|&&done| done).count();
    assert!((1000..3500).contains(&finished), "{finished}");
    for (i, &done) in film.finished().iter().enumerate() {
        let expected = if done { whole.radiance()[i] } else { [0.0; 3] };
        assert_eq!(film.radiance()[i], expected);
    }
}
