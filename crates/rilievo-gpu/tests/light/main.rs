//! Scenes shaded on a GPU by each integrator, beside the CPU's pictures: the same rays, numbers and weights, in floats. Where
//! there is no adapter nothing is drawn, and stderr says so.

mod materials;
mod room;

use std::io::Write;
use std::sync::LazyLock;

use rilievo::glam::DVec3;
use rilievo_gpu::{Gpu, GpuError, GpuScene};
use rilievo_render::light::{Environment, EnvironmentPlacement, Light, PointLight, SunLight};
use rilievo_render::{
    Aov, ColourImage, Film, Integrator, Material, RenderOptions, RenderSettings, Rgb, SamplerKind,
    Scene, Texels, render,
};

use room::{Room, Shapes};

/// One device, so that what was compiled serves all tests.
fn gpu() -> Option<&'static Gpu> {
    static GPU: LazyLock<Result<Gpu, GpuError>> = LazyLock::new(Gpu::open);
    GPU.as_ref()
        .map_err(|error| writeln!(std::io::stderr(), "SKIPPED, nothing was drawn: {error}"))
        .ok()
}

fn settings(integrator: Integrator) -> RenderSettings {
    RenderSettings { integrator, samples: 4, ..RenderSettings::default() }
}

/// Pixels of two pictures of which a channel differs by more than a share of the brighter one's largest.
fn apart(one: &Film, other: &Film, share: f32) -> usize {
    let differ = |(a, b): &(&[f32; 3], &[f32; 3])| {
        let most = a.iter().chain(b.iter()).fold(1e-3, |most: f32, x| most.max(*x));
        // What is no number differs.
        (0..3).any(|k| (a[k] - b[k]).abs().partial_cmp(&(share * most)).is_none_or(|o| o.is_gt()))
    };
    one.radiance().iter().zip(other.radiance()).filter(differ).count()
}

/// Draws a scene on both; nearly all pixels are the same to the precision of floats.
fn compare(gpu: &Gpu, name: &str, scene: &Scene) {
    let on_gpu = GpuScene::new(gpu, scene).unwrap();
    assert_eq!(on_gpu.why_not(), None, "{name}");
    let (one, stats) = render(scene, &RenderOptions::default()).unwrap();
    let options = RenderOptions { tracer: Some(&on_gpu), ..RenderOptions::default() };
    let (other, on_device) = render(scene, &options).unwrap();
    let pixels = one.radiance().len();
    let [far, near] = [1e-2, 1e-3].map(|share| apart(&one, &other, share));
    let _ = writeln!(
        std::io::stderr(),
        "{name}: of {pixels} pixels {near} differ by more than 1e-3, {far} by more than 1e-2"
    );
    // A path that a rounding sends past an edge changes its pixel.
    assert!(near * 20 <= pixels && far * 50 <= pixels, "{name}: {near} and {far} pixels differ");
    assert_eq!(stats.rays.camera, on_device.rays.camera);
    let [a, b] = [stats, on_device].map(|stats| stats.rays.total() as f64);
    assert!((a / b - 1.0).abs() < 2e-3, "{name}: {a} and {b} rays");
}

/// A point, a spot and a sun.
fn lamps() -> Vec<Light> {
    let point = |at: [f64; 3], power: f64| PointLight::new(at.into(), Rgb::splat(power)).unwrap();
    let spot = point([-1.5, -1.0, 2.5], 9.0).spot(DVec3::new(0.5, 0.3, -1.0), [10.0, 30.0]);
    let sun = SunLight::new(DVec3::new(0.3, 0.7, -1.0), Rgb::splat(1.5), 4.0);
    vec![
        Light::Point(point([1.5, -1.0, 2.0], 3.0)),
        Light::Point(spot.unwrap()),
        Light::Sun(sun.unwrap()),
    ]
}

/// A bluish sky with one bright spot.
fn sky() -> Environment {
    let texel = |k: u32| {
        let (i, j) = (k % 16, k / 16);
        let x = if (i, j) == (5, 6) { 20.0 } else { 0.2 + 0.02 * i as f32 };
        [x, 0.9 * x, 0.3 + 0.1 * j as f32]
    };
    let image = ColourImage::new(16, 8, Texels::Linear((0..128).map(texel).collect())).unwrap();
    let placement = EnvironmentPlacement { rotate: 30.0, ..EnvironmentPlacement::default() };
    Environment::new(&image, placement).unwrap()
}

/// A room that shines in every way, so that each integrator is compiled once.
fn shining() -> Room {
    let ball = Material { emitted: Rgb::new(0.5, 0.2, 0.1), ..Material::default() };
    Room { ball, shapes: Shapes::Ball, ..Room::default() }
}

#[test]
fn trees_of_rays_bring_what_they_bring_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let distributed = settings(Integrator::Distributed);
    let bounces = RenderSettings { diffuse_samples: 2, max_depth: 2, ..distributed };
    let lit =
        |room: Room, settings| room.scene(settings).with_environment(sky()).with_lamps(lamps());
    compare(gpu, "first hits", &lit(Room::default(), settings(Integrator::Aov)));
    compare(gpu, "trees", &lit(Room::default(), distributed));
    compare(gpu, "bouncing trees", &lit(Room::default(), bounces));
    // Nothing that is displaced around a ball is a light here.
    compare(gpu, "trees around a displaced ball", &lit(shining(), distributed));
}

#[test]
fn what_moves_is_shaded_where_it_is() {
    let Some(gpu) = gpu() else { return };
    let ball = Material { reflective: Rgb::splat(0.5), roughness: 0.3, ..Material::default() };
    let room = Room { ball, shapes: Shapes::Ball, moves: true, ..Room::default() };
    compare(
        gpu,
        "trees in motion",
        &room.scene(settings(Integrator::Distributed)).with_lamps(lamps()),
    );
}

#[test]
fn paths_bring_what_they_bring_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let path = settings(Integrator::Path);
    let glow = Material { emitted: Rgb::new(0.5, 0.2, 0.1), ..Material::default() };
    let lit = |settings| {
        Room { ball: glow.clone(), ..Room::default() }.scene(settings).with_lamps(lamps())
    };
    compare(gpu, "paths", &lit(path));
    let sampler = SamplerKind::Independent;
    let held = RenderSettings { sampler, max_depth: 12, clamp: 0.5, ..path };
    compare(gpu, "long paths, held", &lit(held));
}

#[test]
fn materials_scatter_as_they_do_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let sampler = SamplerKind::Jittered;
    let settings = RenderSettings { sampler, ..settings(Integrator::Path) };
    for (name, room) in [("materials", materials::room()), ("clear", materials::clear_room())] {
        compare(gpu, name, &room.scene(settings).with_lamps(lamps()));
    }
}

#[test]
fn layers_mixes_and_bumps_scatter_as_they_do_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    let settings = settings(Integrator::Path);
    for (name, room) in
        [("painted", materials::painted_room()), ("repainted", materials::repainted_room())]
    {
        compare(gpu, name, &room.scene(settings).with_environment(sky()).with_lamps(lamps()));
    }
}

#[test]
fn displaced_meshes_look_as_they_do_on_the_cpu() {
    let Some(gpu) = gpu() else { return };
    for (name, integrator) in [
        ("first hits of meshes", Integrator::Aov),
        ("trees around meshes", Integrator::Distributed),
    ] {
        let room = Room { shapes: Shapes::Meshes, ..Room::default() };
        compare(gpu, name, &room.scene(settings(integrator)).with_lamps(lamps()));
    }
    let path = settings(Integrator::Path);
    let glowing = materials::glowing_room().scene(path).with_lamps(lamps());
    compare(gpu, "paths around glowing meshes", &glowing);
}

#[test]
fn the_same_seed_gives_the_same_bytes_whatever_else_is_asked_for() {
    let Some(gpu) = gpu() else { return };
    for integrator in [Integrator::Distributed, Integrator::Path] {
        let scene = Room { side: 20, ..Room::default() }.scene(settings(integrator));
        let run = |threads, aovs: &[Aov]| {
            let on_gpu = GpuScene::new(gpu, &scene).unwrap();
            let options =
                RenderOptions { tracer: Some(&on_gpu), threads, aovs, ..RenderOptions::default() };
            let film = render(&scene, &options).unwrap().0;
            film.radiance().iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>()
        };
        let alone = run(1, &[]);
        assert!(alone == run(3, &[]) && alone == run(2, &[Aov::N]), "{integrator}");
    }
}

#[test]
fn what_is_not_shaded_on_a_device_is_named_and_drawn_in_waves() {
    let Some(gpu) = gpu() else { return };
    let lamp = Material { emitted: Rgb::splat(5.0), ..materials::mix_of_mixes() };
    let wall = materials::mix_of_mixes();
    let scene = Room { wall, lamp, side: 8, ..Room::default() }.scene(settings(Integrator::Path));
    let on_gpu = GpuScene::new(gpu, &scene).unwrap();
    let why = on_gpu.why_not().map(|why| why.to_string());
    assert_eq!(why.as_deref(), Some("a mix of mixes"));
    let options = RenderOptions { tracer: Some(&on_gpu), ..RenderOptions::default() };
    let (drawn, _) = render(&scene, &options).unwrap();
    assert!(drawn.radiance().iter().flatten().any(|x| *x > 0.1));
}
