//! Level of detail: coarser maps for what is seen from afar, against the full ones.

use std::sync::Arc;

use glam::{DAffine3, DVec2, DVec3};
use rilievo::map::{HeightMap, Lattice, Procedural, Samples, Tiling, Wrap};
use rilievo::mesh::{Mesh, solids};
use rilievo::relief::{
    CubeRelief, Displacement, FaceOptions, MeshOptions, Relief, ReliefFace, ReliefMesh,
    ReliefSphere, SphereOptions,
};
use rilievo::surface::{Instance, Motion, MovingInstance, Surface};
use rilievo_render::light::{Light, SunLight};
use rilievo_render::{
    Aov, CameraParts, Film, Integrator, Material, MemoryUse, RenderOptions, RenderSettings, Rgb,
    Scene, render,
};

use crate::scenes::{Builder, camera, diffuse};

fn settings(integrator: Integrator, samples: u32, lod: f64) -> RenderSettings {
    RenderSettings { integrator, samples, lod, max_depth: 2, ..RenderSettings::default() }
}

fn noise(side: u32, lattice: Lattice) -> HeightMap {
    let noise = Procedural::Fbm { octaves: 9, seed: 5 };
    noise.height_map([side; 2], lattice, Wrap::Repeat).unwrap()
}

/// A map on the square from -1 to 1, repeated `tile` times along each side.
fn square(map: HeightMap, scale: f64, tile: f64) -> Surface {
    let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
    let corners = corners.map(|[x, y]| DVec3::new(x, y, 0.0));
    let displacement =
        Displacement { scale, zero: 0.5, tile: [tile; 2], ..Displacement::default() };
    let options = FaceOptions { displacement, ..FaceOptions::default() };
    ReliefFace::new(corners, Arc::new(Relief::new(map)), options).unwrap().into()
}

/// Surfaces under one sun.
fn sunlit(
    surfaces: Vec<(Surface, Material)>,
    view: CameraParts,
    (sun, settings): (DVec3, RenderSettings),
) -> Scene {
    let builder = surfaces.into_iter().fold(Builder::default(), |builder, (surface, material)| {
        builder.surface(surface, material)
    });
    let sun = SunLight::new(-sun, Rgb::splat(2.0), 0.5).unwrap();
    builder.scene(view, settings).with_lamps(vec![Light::Sun(sun)])
}

fn red(scene: &Scene) -> Vec<f64> {
    let (film, _) = render(scene, &RenderOptions::default()).unwrap();
    reds(&film)
}

fn reds(film: &Film) -> Vec<f64> {
    film.radiance().iter().map(|p| f64::from(p[0])).collect()
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// Root mean square difference.
fn error(found: &[f64], wanted: &[f64]) -> f64 {
    let squares: Vec<f64> = found.iter().zip(wanted).map(|(a, b)| (a - b).powi(2)).collect();
    mean(&squares).sqrt()
}

/// A full render at few samples, one with level of detail at as few, and the full one at many: the errors of
/// both, and by how much the mean is off.
fn compared(scene: impl Fn(RenderSettings) -> Scene, few: u32, many: u32) -> [f64; 3] {
    let run = |samples, lod| red(&scene(settings(Integrator::Path, samples, lod)));
    let wanted = run(many, 0.0);
    let (full, coarse) = (run(few, 0.0), run(few, 1.0));
    let off = mean(&coarse) / mean(&wanted) - 1.0;
    [error(&full, &wanted), error(&coarse, &wanted), off]
}

#[test]
fn a_far_relief_has_less_noise_and_its_brightness() {
    // Some 40 cells of the map across a pixel, and nothing but the relief in view.
    let view = || camera([0.0, -7.0, 5.0], [0.0, 0.0, 0.0], 6.0, [32, 24]);
    let gloss = Material { reflective: Rgb::splat(0.5), roughness: 0.25, ..diffuse(0.2) };
    // The gloss is seen near its highlight: further out its tails are wider than those of the relief.
    let [aside, behind] = [DVec3::new(-0.5, 0.3, 0.8), DVec3::new(-0.1, 0.6, 0.8)];
    for (name, (material, sun), scale, less, brightness) in [
        ("matt", (diffuse(0.6), aside), 0.005, 0.65, 0.02),
        ("steep", (diffuse(0.6), aside), 0.02, 1.0, 0.06),
        ("glossy", (gloss, behind), 0.005, 0.65, 0.1),
    ] {
        let scene = |settings| {
            let relief = square(noise(256, Lattice::Texel), scale, 8.0);
            sunlit(vec![(relief, material.clone())], view(), (sun, settings))
        };
        let [full, coarse, off] = compared(scene, 4, 1024);
        let about = format!("{name}: errors {full:.5} and {coarse:.5}, mean {:+.2} %", 100.0 * off);
        assert!(coarse < less * full && off.abs() < brightness, "{about}");
    }
}

#[test]
fn a_relief_that_is_averaged_away_does_not_shadow_itself() {
    // A chess board of heights: from the first level on it is flat, to the last bit.
    let board = (0..64 * 64).map(|k| if (k / 64 + k % 64) % 2 == 0 { 0 } else { 65534 }).collect();
    let board = HeightMap::new(64, 64, Samples::U16(board), Lattice::Texel, Wrap::Repeat).unwrap();
    let view = camera([0.0, -0.5, 90.0], [0.0, 0.0, 0.0], 1.0, [16, 16]);
    for integrator in [Integrator::Path, Integrator::Distributed] {
        let settings = settings(integrator, 4, 1.0);
        let relief = square(board.clone(), 0.01, 4.0);
        let sun = DVec3::new(0.9, 0.0, 0.1);
        let scene = sunlit(vec![(relief, diffuse(0.5))], view, (sun, settings));
        let found = red(&scene);
        let all = mean(&found);
        let inside = found.iter().filter(|&&value| value > 0.0);
        assert!(
            all > 0.0 && inside.clone().all(|value| (value / all - 1.0).abs() < 0.02),
            "{found:?}"
        );
        assert_eq!(inside.count(), 16 * 16);
    }
}

#[test]
fn what_is_near_is_as_without() {
    let view = || camera([0.0, -0.1, 0.12], [0.0, 0.0, 0.02], 20.0, [24, 24]);
    for integrator in [Integrator::Distributed, Integrator::Aov] {
        let run = |lod| {
            let relief = square(noise(128, Lattice::Texel), 0.05, 1.0);
            let settings = settings(integrator, 3, lod);
            red(&sunlit(vec![(relief, diffuse(0.5))], view(), (DVec3::ONE, settings)))
        };
        assert_eq!(run(0.0), run(1.0));
    }
}

/// A cube whose every side shows all of a map.
fn cube() -> Mesh {
    let mut data = solids::cube();
    data.uvs = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from_array).to_vec();
    let side = |at: DVec3, axis: usize| {
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3].map(|k| u32::from(at[k] > 0.0));
        if v == 0 { u } else { 3 - u }
    };
    for triangle in &mut data.triangles {
        let corners = triangle.positions.map(|p| data.positions[p as usize]);
        let flat = |k: usize| corners[0][k] == corners[1][k] && corners[0][k] == corners[2][k];
        let axis = (0..3).find(|&axis| flat(axis)).unwrap();
        triangle.uvs = Some(corners.map(|corner| side(corner, axis)));
    }
    Mesh::new(data).unwrap()
}

/// Displaced surfaces of every kind, about 1 in size, with their names.
fn all_kinds() -> Vec<(&'static str, Surface)> {
    let displacement = Displacement { scale: 0.05, zero: 0.5, ..Displacement::default() };
    let relief = Arc::new(Relief::new(noise(128, Lattice::Texel)));
    let options = MeshOptions { displacement, ..MeshOptions::default() };
    let mesh: Surface = ReliefMesh::new(&cube(), relief, options).unwrap().into();
    let around = CubeRelief::new(&noise(256, Lattice::Texel), Tiling::default()).unwrap();
    let options = SphereOptions { displacement, ..SphereOptions::default() };
    let sphere: Surface = ReliefSphere::new(DVec3::ZERO, 1.0, around, options).unwrap().into();
    let turn = DAffine3::from_rotation_x(0.4) * DAffine3::from_scale(DVec3::splat(0.7));
    let instance = Instance::new(Arc::new(mesh.clone()), turn).unwrap();
    let motion = Motion::along(DVec3::new(0.1, 0.0, 0.0));
    let moving = MovingInstance::new(Arc::new(sphere.clone()), turn, motion).unwrap();
    vec![
        ("face", square(noise(128, Lattice::Vertex), 0.05, 1.0)),
        ("mesh", mesh),
        ("sphere", sphere),
        ("instance", instance.into()),
        ("moving", moving.into()),
    ]
}

#[test]
fn surfaces_of_every_kind_have_levels() {
    for (name, surface) in all_kinds() {
        let scene = |settings| {
            let view = camera([2.0, -19.0, 9.0], [0.0, 0.0, 0.0], 9.0, [20, 20]);
            let sun = DVec3::new(-0.2, -0.5, 0.6);
            sunlit(vec![(surface.clone(), diffuse(0.6))], view, (sun, settings))
        };
        let [full, coarse, off] = compared(scene, 4, 256);
        // Outlines are those of the full surface, and as noisy.
        assert!(coarse < 1.1 * full, "{name}: {coarse} {full}");
        assert!(off.abs() < 0.04, "{name}: {off}");
    }
}

#[test]
fn closed_surfaces_are_closed_at_every_level() {
    // From so far that all levels are seen, coarser and coarser ones as the rays grow wider.
    for (name, surface) in all_kinds().into_iter().filter(|(name, _)| *name != "face") {
        for lod in [1.0, 4.0, 16.0, 64.0] {
            let settings = settings(Integrator::Aov, 1, lod);
            let view = camera([1.0, -9.0, 4.0], [0.0, 0.0, 0.0], 14.0, [64, 64]);
            let scene = sunlit(vec![(surface.clone(), diffuse(1.0))], view, (DVec3::Z, settings));
            let options = RenderOptions { aovs: &[Aov::N, Aov::P], ..RenderOptions::default() };
            let (film, _) = render(&scene, &options).unwrap();
            let [normals, places] = [Aov::N, Aov::P].map(|aov| film.layer(aov).unwrap().values());
            let mut met = 0;
            for (normal, place) in normals.chunks(3).zip(places.chunks(3)) {
                let [normal, place] =
                    [normal, place].map(|v| DVec3::from_array([0, 1, 2].map(|k| f64::from(v[k]))));
                if place.is_finite() {
                    // Inner sides would show where rays get in.
                    let towards = (DVec3::new(1.0, -9.0, 4.0) - place).dot(normal);
                    assert!(towards > 0.0, "{name} at {lod} pixels: {place} {normal}");
                    met += 1;
                }
            }
            assert!(met > 400, "{name}: {met}");
        }
    }
}

#[test]
fn pictures_do_not_depend_on_threads() {
    for integrator in [Integrator::Path, Integrator::Distributed] {
        let surfaces = || {
            let kinds = all_kinds().into_iter();
            kinds.map(|(_, surface)| (surface, diffuse(0.5))).collect::<Vec<_>>()
        };
        let view = || camera([2.0, -19.0, 9.0], [0.0, 0.0, 0.0], 9.0, [20, 20]);
        let run = |threads| {
            let settings = settings(integrator, 2, 1.5);
            let scene = sunlit(surfaces(), view(), (DVec3::ONE, settings));
            let options = RenderOptions { threads, ..RenderOptions::default() };
            reds(&render(&scene, &options).unwrap().0)
        };
        assert_eq!(run(1), run(5));
    }
}

#[test]
fn levels_take_two_thirds_of_sixteen_bit_heights_and_are_predicted() {
    let predict = |lod| {
        let relief = square(noise(512, Lattice::Texel), 0.05, 1.0);
        let view = camera([0.0, -7.0, 5.0], [0.0, 0.0, 0.0], 13.0, [32, 24]);
        let settings = settings(Integrator::Aov, 1, lod);
        let scene = sunlit(vec![(relief, diffuse(0.5))], view, (DVec3::Z, settings));
        MemoryUse::predict(&scene, &RenderOptions::default())
    };
    let (off, on) = (predict(0.0), predict(1.0));
    assert_eq!((off.levels, off.heights), (0, 2 * 512 * 512));
    assert_eq!(on.total() - off.total(), on.levels);
    let share = on.levels as f64 / on.heights as f64;
    // A third for heights, a third for slopes, a third of the bounds' eighth, and small change.
    assert!(share > 0.66 && share < 0.76, "{share}");
}
