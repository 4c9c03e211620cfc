//! Scene files: known values, and every bad scene gives the error on its first line.

use std::cell::Cell;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use proptest::prelude::*;
use rilievo::glam::{DVec2, DVec3};
use rilievo::map::{DistanceKind, DistanceMap, DistanceOptions, HeightMap, Lattice, Samples, Wrap};
use rilievo::relief::{Method, ShadingNormals};
use rilievo::surface::Surface;
use rilievo_io::image::read_colour;
use rilievo_io::scene::{LoadOptions, LoadedScene, SceneFile};
use rilievo_io::{Error, Limits, Place};
use rilievo_render::film::tonemap::View;
use rilievo_render::light::{Environment, EnvironmentPlacement, Light, PointLight, SunLight, Up};
use rilievo_render::{
    Filter, FilterKind, Integrator, Material, Projection, Reflectance, RenderSettings, SamplerKind,
};

mod displaced;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn scenes(folder: &str) -> Vec<PathBuf> {
    let folder = fs::read_dir(root().join(folder)).unwrap().map(|entry| entry.unwrap().path());
    let mut all: Vec<_> = folder.filter(|p| p.extension().is_some_and(|e| e == "toml")).collect();
    all.sort();
    all
}

fn load(path: &Path) -> Result<LoadedScene, Error> {
    SceneFile::read(path, &Limits::default())?.load(&LoadOptions::default())
}

#[test]
fn bad_scenes_give_the_error_on_their_first_line() {
    let all = scenes("tests/scenes/invalid");
    assert!(all.len() >= 40);
    let mut wrong = String::new();
    for path in all {
        let text = fs::read_to_string(&path).unwrap();
        let first = text.lines().next().unwrap();
        let want = first.strip_prefix("# error: ").unwrap_or_else(|| panic!("{path:?}: {first}"));
        let error = load(&path).err().unwrap_or_else(|| panic!("{path:?} was loaded"));
        let message = error.to_string();
        if !message.contains(want) {
            wrong += &format!("{want}\n{message}\n\n");
        }
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        assert!(message.contains(&name), "{path:?}:\n{message}");
        let place = match &error {
            Error::Invalid(fault) | Error::Unsupported(fault) => &fault.place,
            Error::Reference { fault, .. } => &fault.place,
            Error::Limit { place, .. } => place,
            Error::Io { .. } => panic!("{message}"),
        };
        assert!(matches!(place, Place::Text(_)), "{path:?}: {place:?}");
    }
    assert!(wrong.is_empty(), "{wrong}");
}

#[test]
fn places_share_what_they_show() {
    let loaded = load(&root().join("tests/scenes/valid/instances.toml")).unwrap();
    let surfaces = loaded.scene.world().surfaces();
    let prototypes: Vec<_> = (surfaces.iter())
        .map(|surface| match surface {
            Surface::Instance(instance) => instance.prototype(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert_eq!(prototypes.len(), 3 + 7 + 2);
    assert!(Arc::ptr_eq(prototypes[0], prototypes[1]));
    let (Surface::Face(own), Surface::Face(changed)) =
        (prototypes[0].as_ref(), prototypes[2].as_ref())
    else {
        panic!("{prototypes:?}");
    };
    assert!(Arc::ptr_eq(own.relief(), changed.relief()));
    let d = changed.options().displacement;
    assert_eq!((d.scale, d.zero, d.tile, d.shift), (0.2, 0.5, [2.0; 2], [0.5, 0.0]));
    for pair in prototypes[3..10].windows(2) {
        assert!(Arc::ptr_eq(pair[0], pair[1]));
    }
    // Strewn over a square at height 1, and half to one and a half times as large.
    for surface in &surfaces[3..10] {
        let (bounds, size) = (surface.bounds(), surface.bounds().max - surface.bounds().min);
        let centre = bounds.centre();
        assert!(centre.abs().max_element() < 1.01 && (centre.z - 1.0).abs() < 0.01, "{centre}");
        assert!((0.1..0.4).contains(&size.z), "{size}");
    }
    // What a place adds, its share of the tree and its material included.
    let place = size_of::<Surface>() + size_of::<rilievo::surface::Instance>();
    assert!(place + 2 * 128 + 8 < 1024, "{place}");
}

#[test]
fn the_gallery_is_loaded() {
    let folders = fs::read_dir(root().join("scenes")).unwrap();
    let gallery = folders.map(|entry| entry.unwrap().path().join("scene.toml"));
    let gallery: Vec<_> = gallery.filter(|path| path.exists()).collect();
    assert!(!gallery.is_empty());
    for path in gallery {
        let file = SceneFile::read(&path, &Limits::default()).unwrap_or_else(|e| panic!("{e}"));
        assert!(file.references().iter().all(|p| p.exists()), "{path:?}");
        // The largest map of the gallery needs no distance map, so this is quick.
        let loaded = file.load(&LoadOptions::default()).unwrap_or_else(|e| panic!("{e}"));
        assert!(!loaded.scene.world().surfaces().is_empty());
    }
}

#[test]
fn an_f_stop_is_that_of_a_small_camera() {
    let loaded = load(&root().join("tests/scenes/valid/orthographic.toml")).unwrap();
    let camera = loaded.scene.camera();
    assert_eq!(camera.projection(), Projection::Orthographic { height: 2.5 });
    // 40 degrees over 24 mm: a focal length of 33 mm, an opening of 11.8 mm at f/2.8.
    let edge = camera.sample(4.0, 4.0, DVec2::new(0.0, 0.5), 0.0).origin;
    let radius = (edge - camera.ray(4.0, 4.0).origin).length();
    let focal = 0.012 / 20_f64.to_radians().tan();
    assert!((radius - 0.5 * focal / 2.8).abs() < 1e-12 && (radius - 0.0059).abs() < 1e-4);
}

#[test]
fn shapes_move_as_they_are_told() {
    let loaded = load(&root().join("tests/scenes/valid/moving.toml")).unwrap();
    let scene = &loaded.scene;
    assert!(scene.moves() && !scene.camera().moves());
    let half = scene.camera().sample(1.0, 1.0, DVec2::ZERO, 0.5);
    assert_eq!((scene.camera().ray(1.0, 1.0).time, half.time), (0.25, 0.5));
    let surfaces = scene.world().surfaces();
    assert_eq!(surfaces.len(), 1 + 3 + 3);
    let moving = |index: usize| match &surfaces[index] {
        Surface::Moving(moving) => moving,
        other => panic!("{other:?}"),
    };
    let near = |a: DVec3, b: DVec3| assert!((a - b).length() < 1e-12, "{a} {b}");
    let at = |index, time, p| moving(index).world_from_local(time).transform_point3(p);
    // Two turns about the middle of the quad, while it falls by its own width.
    near(at(0, 0.0, DVec3::X), DVec3::X);
    near(at(0, 0.25, DVec3::new(0.3, 0.5, 0.0)), DVec3::new(0.3, 0.5, -0.25));
    near(at(0, 0.25, DVec3::ZERO), DVec3::new(0.0, 1.0, -0.25));
    // Scattered: all share the prototype, and turn where they are.
    for index in 1..4 {
        let place = moving(index).world_from_local(0.0);
        let turned = place.inverse() * moving(index).world_from_local(1.0);
        near(turned.transform_point3(DVec3::ZERO), DVec3::ZERO);
        near(turned.transform_point3(DVec3::new(1.0, 1.0, 0.0)), DVec3::new(1.0, 1.0, 0.0));
        assert!(Arc::ptr_eq(moving(index).prototype(), moving(1).prototype()));
    }
    assert!(matches!(surfaces[4], Surface::Instance(_)));
    // In its own place by default, else about the pivot.
    near(at(5, 1.0, DVec3::new(0.5, 0.0, 0.0)), DVec3::new(1.0, 0.0, 3.0));
    near(at(6, 1.0, DVec3::ZERO), DVec3::new(1.0, 2.0, 5.0));
}

#[test]
fn every_key_arrives() {
    let loaded = load(&root().join("tests/scenes/valid/everything.toml")).unwrap();
    let scene = &loaded.scene;
    let camera = scene.camera().parts();
    assert_eq!(camera.position, DVec3::new(0.5, -1.4, 1.3));
    assert_eq!(
        (camera.up, camera.fov, camera.resolution),
        (DVec3::new(0.0, 0.1, 1.0), 35.0, [24, 16])
    );
    assert!(scene.camera().has_lens() && scene.camera().moves());
    let want = RenderSettings {
        integrator: Integrator::Aov,
        samples: 2,
        shadow_samples: 2,
        glossy_samples: 3,
        diffuse_samples: 2,
        max_depth: 1,
        clamp: 12.5,
        lod: 0.5,
        seed: i64::MAX as u64,
        sampler: SamplerKind::Jittered,
        filter: Filter { kind: FilterKind::Tent, radius: 1.5 },
    };
    assert_eq!(*scene.settings(), want);
    assert_eq!(scene.background(), DVec3::new(0.1, 0.2, 0.3));
    assert_eq!(scene.ambient(), DVec3::splat(0.01));
    assert_eq!((loaded.tone_map.exposure, loaded.tone_map.view), (-1.5, View::Filmic));

    let lamps = &scene.lights()[scene.lights().len() - 3..];
    let point = PointLight::new(DVec3::Z * 3.0, DVec3::new(5.0, 4.0, 3.0)).unwrap();
    let spot = PointLight::new(DVec3::Z * 4.0, DVec3::splat(9.0)).unwrap();
    let spot = spot.spot(DVec3::NEG_Z, [10.0, 30.0]).unwrap();
    let sun = SunLight::new(DVec3::new(1.0, 0.0, -1.0), DVec3::splat(2.0), 0.5).unwrap();
    assert_eq!(lamps, [Light::Point(point), Light::Point(spot), Light::Sun(sun)]);
    let image = root().join("tests/data/png/valid/basn2c08.png");
    let image = read_colour(&image, &Limits::default()).unwrap();
    let scale = DVec3::new(2.0, 1.0, 0.5);
    let placement = EnvironmentPlacement { scale, rotate: -30.0, up: Up::Y };
    assert_eq!(scene.environment(), Environment::new(&image, placement).as_ref());

    // Only maps that shapes use are there.
    let names: Vec<_> = loaded.maps.iter().map(|m| m.name.as_str()).collect();
    assert_eq!(names, ["file", "noise"]);
    let relief = &loaded.maps[0].relief;
    assert_eq!(relief.distance(DistanceKind::Boxes).unwrap().size(), [8, 8, 4]);
    assert!(relief.distance(DistanceKind::Corrected).is_none());
    let heights = relief.heights();
    assert_eq!((heights.x().lattice(), heights.x().wrap()), (Lattice::Vertex, Wrap::Mirror));
    assert_eq!(heights.raw(0, 31), 65535.0, "the file's top left sample is 0, inverted");
    let noise = loaded.maps[1].relief.heights();
    assert!(matches!(noise.samples(), Samples::F32(_)));
    assert_eq!((noise.width(), noise.height()), (9, 7));

    let surfaces = scene.world().surfaces();
    let [
        Surface::Face(first),
        Surface::Face(second),
        Surface::Quad(third),
        Surface::Sphere(ball),
        Surface::Mesh(mesh),
    ] = surfaces
    else {
        panic!("{surfaces:?}");
    };
    let options = first.options();
    assert_eq!((options.method, options.closed, options.one_sided), (Method::Distance, true, true));
    let d = options.displacement;
    assert_eq!((d.scale, d.zero, d.tile, d.shift), (0.08, 0.5, [2.0, 2.0], [0.25, 0.0]));
    assert!(matches!(options.normals, ShadingNormals::Exact));
    assert_eq!((second.options().method, second.options().closed), (Method::Dda, false));
    assert!(matches!(second.options().normals, ShadingNormals::Map(_)));
    assert!(!third.is_parallelogram());
    assert_eq!((ball.center(), ball.radius()), (DVec3::Z, 0.5));
    // Scaled by 2, turned 90 degrees about x, then about z, then moved.
    let [a, b, c] = mesh.corners(0);
    let near = |p: DVec3, q: DVec3| (p - q).length() < 1e-12;
    assert!(near(a, DVec3::new(1.0, 2.0, 3.0)));
    assert!(near(b, DVec3::new(1.0, 4.0, 3.0)), "{b}");
    assert!(near(c, DVec3::new(1.0, 2.0, 5.0)), "{c}");

    let Reflectance::Textured(painted) = &scene.material(0).diffuse else { panic!() };
    let Reflectance::Textured(papered) = &scene.material(1).diffuse else { panic!() };
    assert_eq!((papered.tile, papered.shift), (DVec2::new(2.0, 3.0), DVec2::new(0.5, 0.0)));
    assert!(Arc::ptr_eq(&painted.image, &papered.image), "one file, one image");
    assert_eq!(*scene.material(2), Material::default());
    let plain = scene.material(3);
    assert_eq!((plain.roughness, plain.emitted), (0.2, DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(plain, scene.material(4));
}

#[test]
fn what_is_not_said_has_the_documented_default() {
    let loaded = load(&root().join("tests/scenes/valid/least.toml")).unwrap();
    assert_eq!(*loaded.scene.settings(), RenderSettings::default());
    let camera = loaded.scene.camera().parts();
    assert_eq!((camera.fov, camera.resolution), (40.0, [512, 512]));
    assert_eq!((loaded.scene.background(), loaded.scene.ambient()), (DVec3::ZERO, DVec3::ZERO));
    assert!(loaded.maps.is_empty() && loaded.scene.world().surfaces().is_empty());

    let text = "[camera]\nposition = [0, 0, 2]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n\
        [maps.f]\nfile = \"../../data/png/valid/basn0g08.png\"\n[maps.p]\nprocedural = \"tent\"\n\
        [[shapes]]\ntype = \"quad\"\ncorners = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\ndisplacement = { map = \"f\" }\n\
        [[shapes]]\ntype = \"quad\"\ncorners = [[2,0,0],[3,0,0],[3,1,0],[2,1,0]]\ndisplacement = { map = \"p\" }\n";
    let path = root().join("tests/scenes/valid/inline.toml");
    let loaded = SceneFile::parse(text, &path).unwrap().load(&LoadOptions::default()).unwrap();
    let axis = |map: usize| *loaded.maps[map].relief.heights().x();
    assert_eq!((axis(0).lattice(), axis(0).wrap()), (Lattice::Texel, Wrap::Repeat));
    assert_eq!((axis(1).lattice(), axis(1).wrap()), (Lattice::Vertex, Wrap::Repeat));
    assert_eq!(axis(1).samples(), 256);
    let Surface::Face(face) = &loaded.scene.world().surfaces()[0] else { panic!() };
    assert_eq!(face.options().displacement, rilievo::relief::Displacement::default());
    assert_eq!(face.options().method, Method::Pyramid);
    assert!(matches!(face.options().normals, ShadingNormals::Smooth));
}

#[test]
fn a_method_of_the_caller_wins_and_brings_its_distance_map() {
    let path = root().join("tests/scenes/valid/everything.toml");
    let file = SceneFile::read(&path, &Limits::default()).unwrap();
    for (method, kind) in [
        (Method::DistanceCorrected, DistanceKind::Corrected),
        (Method::DistancePublished, DistanceKind::Published),
    ] {
        let built = Cell::new(0);
        let build = |heights: &HeightMap, kind, options: &DistanceOptions| {
            built.set(built.get() + 1);
            DistanceMap::from_height(heights, kind, options)
        };
        let options =
            LoadOptions { method: Some(method), build_distances: &build, ..LoadOptions::default() };
        let loaded = file.load(&options).unwrap();
        assert!(loaded.maps.iter().all(|m| m.relief.distance(kind).is_some()));
        assert_eq!(built.get(), loaded.maps.len(), "the caller builds them");
        let Surface::Face(face) = &loaded.scene.world().surfaces()[0] else { panic!() };
        assert_eq!(face.options().method, method);
    }
}

#[test]
fn files_that_are_no_scene_are_errors() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.toml");
    let read = || SceneFile::read(&path, &Limits { max_bytes: 1000 }).unwrap_err();
    assert!(matches!(read(), Error::Io { .. }));
    fs::write(&path, b"[camera]\n# \xff\n").unwrap();
    assert!(read().to_string().contains("line 2 that is not UTF-8"));
    fs::write(&path, vec![b'#'; 1001]).unwrap();
    assert!(matches!(read(), Error::Limit { .. }));
    let deep = format!("a = {}1{}\n", "[".repeat(100_000), "]".repeat(100_000));
    assert!(SceneFile::parse(&deep, &path).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 500, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_text_never_panics(cuts in prop::collection::vec((any::<u16>(), any::<char>()), 1..6)) {
        let text = include_str!("../../../../tests/scenes/valid/everything.toml");
        let mut letters: Vec<char> = text.chars().collect();
        for (at, letter) in cuts {
            let at = usize::from(at) % letters.len();
            letters[at] = letter;
        }
        let text: String = letters.into_iter().collect();
        if let Err(error) = SceneFile::parse(&text, Path::new("a.toml")) {
            prop_assert!(error.to_string().starts_with("a.toml:"));
        }
    }
}
