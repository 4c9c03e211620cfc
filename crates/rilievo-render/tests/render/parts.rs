//! Renders that are stopped and continued, split and joined end in the film of one run.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use glam::DVec3;
use rilievo_render::film::{Tile, join};
use rilievo_render::{
    Aov, Film, Integrator, Material, RenderError, RenderOptions, RenderSettings, Rgb, SamplerKind,
    Scene, begin, render, resume,
};

use crate::scenes::{Builder, camera, diffuse, emitter};

/// A room with a lamp and a glossy sphere; 40 x 35 pixels leave tiles cut.
fn scene(settings: RenderSettings) -> Scene {
    let lamp = [DVec3::new(-0.3, -0.3, 0.99), DVec3::Y * 0.6, DVec3::X * 0.6];
    let gloss = Material { reflective: Rgb::splat(0.5), roughness: 0.4, ..diffuse(0.3) };
    Builder::default()
        .room(DVec3::ZERO, 1.0, &diffuse(0.7))
        .quad(lamp, emitter(Rgb::splat(8.0)))
        .sphere(DVec3::new(0.4, 0.3, -0.6), 0.4, gloss)
        .scene(camera([0.0, -0.9, 0.0], [0.0, 0.5, -0.2], 80.0, [40, 35]), settings)
}

fn path(samples: u32) -> RenderSettings {
    RenderSettings { integrator: Integrator::Path, samples, ..RenderSettings::default() }
}

fn options() -> RenderOptions<'static> {
    RenderOptions { aovs: &[Aov::P, Aov::Steps, Aov::Albedo], ..RenderOptions::default() }
}

/// All bits of a picture.
fn bits(film: &Film) -> Vec<u32> {
    let colour = film.radiance().iter().flatten();
    let layers = film.layers().iter().flat_map(|layer| layer.values());
    colour.chain(layers).map(|value| value.to_bits()).collect()
}

#[track_caller]
fn assert_same(film: &Film, whole: &Film, what: &str) {
    assert!(film.is_complete(), "{what} is incomplete");
    assert!(bits(film) == bits(whole), "{what} is another picture");
    assert_eq!(film.sums(), whole.sums(), "{what} has other sums");
}

#[test]
fn a_render_stopped_many_times_ends_as_one_that_was_not() {
    let pathwise = scene(path(70));
    let paper = scene(RenderSettings { samples: 5, ..RenderSettings::default() });
    for (scene, max_error) in [(&pathwise, None), (&pathwise, Some(0.15)), (&paper, None)] {
        let whole = render(scene, &RenderOptions { max_error, ..options() }).unwrap().0;
        let mut film = begin(scene, &options()).unwrap();
        let (mut stops, mut before) = (0, 0);
        while !film.is_complete() {
            // Stops after some more rays each time, in the middle of tiles too.
            let cancel = AtomicBool::new(false);
            let rays = AtomicU64::new(before);
            let progress = |done: u64, _| {
                rays.fetch_max(done, Ordering::Relaxed);
                cancel.store(done > before + 1500, Ordering::Relaxed);
            };
            let options = RenderOptions {
                max_error,
                threads: 1 + stops % 3,
                progress: &progress,
                cancel: &cancel,
                ..options()
            };
            film = resume(scene, &options, film).unwrap().0;
            before = rays.load(Ordering::Relaxed);
            stops += 1;
        }
        assert!(stops > 2, "{stops}");
        assert_same(&film, &whole, "continued");
        // Nothing is left to do.
        let (again, stats) = resume(scene, &options(), film).unwrap();
        assert_same(&again, &whole, "finished");
        assert_eq!(stats.rays.camera, 0);
    }
}

#[test]
fn parts_join_to_one_run() {
    for sampler in SamplerKind::ALL {
        let scene = scene(RenderSettings { sampler, ..path(21) });
        let whole = render(&scene, &options()).unwrap().0;
        let part = |samples, corner: [u32; 2], end: [u32; 2]| {
            let crop = Tile { corner, size: [end[0] - corner[0], end[1] - corner[1]] };
            let options = RenderOptions { samples, crop: Some(crop), ..options() };
            render(&scene, &options).unwrap().0
        };
        let all = [40, 35];
        let ranges = [[9, 21], [0, 8], [8, 9]].map(|range| part(Some(range), [0, 0], all));
        assert_same(&join(ranges.to_vec()).unwrap(), &whole, "split by samples");
        let windows = vec![
            part(None, [13, 0], all),
            part(Some([20, 21]), [0, 0], [13, 35]),
            part(Some([0, 20]), [0, 0], [13, 35]),
        ];
        assert_same(&join(windows).unwrap(), &whole, "split by samples and windows");
    }
    let paper = scene(RenderSettings { samples: 3, ..RenderSettings::default() });
    let whole = render(&paper, &options()).unwrap().0;
    let rows = [[0, 17], [17, 35]].map(|[first, end]| {
        let crop = Some(Tile { corner: [0, first], size: [40, end - first] });
        render(&paper, &RenderOptions { crop, ..options() }).unwrap().0
    });
    assert_same(&join(rows.to_vec()).unwrap(), &whole, "the paper's, split by windows");
}

#[test]
fn a_maximal_error_ends_tiles_early_and_says_the_truth() {
    let scene = scene(path(512));
    let run = |threads, crop| {
        let options = RenderOptions { max_error: Some(0.1), threads, crop, ..options() };
        render(&scene, &options).unwrap()
    };
    let (film, stats) = run(1, None);
    assert!(stats.complete);
    let taken: Vec<u32> = film.sums().unwrap().counts().iter().map(|c| c.taken).collect();
    let (least, most) = (taken.iter().min().unwrap(), taken.iter().max().unwrap());
    assert!(*least >= 64 && least < most, "{least} {most}");
    assert!(taken.iter().all(|n| n.is_power_of_two()));
    assert_same(&run(3, None).0, &film, "by three threads");
    let windows = [[0, 16], [16, 24]]
        .map(|[x, width]| run(2, Some(Tile { corner: [x, 0], size: [width, 35] })).0);
    assert_same(&join(windows.to_vec()).unwrap(), &film, "by windows");
    // Against many samples, the error over the image is no larger than was asked for.
    let reference = Scene::with_settings(scene, RenderSettings { seed: 9, ..path(1024) }).unwrap();
    let reference = render(&reference, &RenderOptions::default()).unwrap().0;
    let (mut errors, mut values, mut bias) = (0.0, 0.0, 0.0);
    for (a, b) in film.radiance().iter().zip(reference.radiance()) {
        let [a, b] = [a, b].map(|rgb| f64::from(rgb.iter().sum::<f32>()) / 3.0);
        errors += (a - b).powi(2);
        values += b * b;
        bias += a / b - 1.0;
    }
    let error = (errors / values).sqrt();
    assert!(error < 0.1, "{error}");
    let bias = bias / film.radiance().len() as f64;
    assert!(bias.abs() < 0.005, "{bias}");
}

#[test]
fn options_that_do_not_fit_are_refused() {
    let (pathwise, paper) = (scene(path(8)), scene(RenderSettings::default()));
    let error = |scene: &Scene, options| begin(scene, &options).unwrap_err().to_string();
    let part = RenderOptions { samples: Some([0, 4]), ..RenderOptions::default() };
    assert_eq!(
        error(&paper, part),
        "the integrator distributed takes all samples of a pixel at once"
    );
    for samples in [[4, 4], [5, 4], [0, 9]] {
        let part = RenderOptions { samples: Some(samples), ..RenderOptions::default() };
        assert!(error(&pathwise, part).contains("are not among the 8 of a pixel"));
    }
    for (corner, size) in [([0, 0], [41, 1]), ([40, 0], [1, 1]), ([3, 3], [0, 2])] {
        let crop = Some(Tile { corner, size });
        let part = RenderOptions { crop, ..RenderOptions::default() };
        assert!(error(&paper, part).contains("does not lie in an image of [40, 35]"));
    }
    let limited = RenderOptions { max_error: Some(0.1), ..RenderOptions::default() };
    assert!(error(&paper, limited).contains("at once"));
    assert!(
        error(&pathwise, RenderOptions { max_error: Some(f64::NAN), ..limited })
            .contains("positive")
    );
    assert!(
        error(&pathwise, RenderOptions { samples: Some([0, 4]), ..limited })
            .contains("from the first")
    );
    let crop = Some(Tile { corner: [0, 8], size: [40, 8] });
    assert!(error(&pathwise, RenderOptions { crop, ..limited }).contains("multiples of 16 pixels"));
    let other = begin(&paper, &RenderOptions::default()).unwrap();
    let error = resume(&pathwise, &RenderOptions::default(), other).unwrap_err();
    assert_eq!(error, RenderError::OtherFilm);
}
