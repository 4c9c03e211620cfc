//! Displaced spheres, meshes and quads of two triangles.

use std::sync::Arc;

use rilievo::glam::DVec3;
use rilievo::map::{DistanceKind, Tiling};
use rilievo::relief::{Edges, Method, ShadingNormals};
use rilievo::surface::Surface;
use rilievo_io::scene::{LoadOptions, SceneFile};
use rilievo_io::{Error, Limits};

use super::{load, root};

#[test]
fn displaced_spheres_share_their_map_with_quads() {
    let path = root().join("tests/scenes/valid/displaced_spheres.toml");
    let file = SceneFile::read(&path, &Limits::default()).unwrap();
    assert!(file.references().iter().all(|path| path.exists()) && file.references().len() == 1);
    let options = LoadOptions { resampling_error: true, ..LoadOptions::default() };
    let loaded = file.load(&options).unwrap();
    let surfaces = loaded.scene.world().surfaces();
    let [
        Surface::ReliefSphere(first),
        Surface::ReliefSphere(second),
        Surface::Face(_),
        Surface::ReliefSphere(tiled),
    ] = surfaces
    else {
        panic!("{surfaces:?}");
    };
    assert_eq!((first.center(), first.radius()), (DVec3::new(1.0, 2.0, 3.0), 2.0));
    let options = first.options();
    let d = options.displacement;
    assert_eq!((d.scale, d.zero, options.method), (0.5, 0.25, Method::Dda));
    assert!(matches!(options.normals, ShadingNormals::Exact));
    assert_eq!((second.options().method, second.radius()), (Method::Pyramid, 1.0));
    assert!(matches!(second.options().normals, ShadingNormals::Map(_)));
    assert!(Arc::ptr_eq(first.relief(), second.relief()));
    let [noise, denser] = &loaded.sphere_maps[..] else { panic!("{:?}", loaded.sphere_maps) };
    assert_eq!((noise.name.as_str(), noise.size, noise.relief.cells()), ("noise", [9, 7], 4));
    assert_eq!((denser.name.as_str(), denser.relief.cells()), ("noise", 8));
    assert_eq!(tiled.relief().tiling(), Tiling { tile: [3.0, 1.5], shift: [0.5, 0.25] });
    assert!(noise.error.is_some_and(|error| 0.0 < error.rms && error.rms < error.max));
    assert_eq!(loaded.maps.len(), 1);
    let least = Limits { max_bytes: 500 };
    let error = file.load(&LoadOptions { limits: least, ..LoadOptions::default() }).unwrap_err();
    assert!(matches!(error, Error::Limit { what, .. } if what == "the map of a sphere"));
}

#[test]
fn displaced_meshes_and_quads_of_two_triangles() {
    let loaded = load(&root().join("tests/scenes/valid/displaced_mesh.toml")).unwrap();
    let [Surface::ReliefMesh(first), Surface::ReliefMesh(second)] = loaded.scene.world().surfaces()
    else {
        panic!("two displaced meshes");
    };
    let options = first.options();
    let d = options.displacement;
    assert_eq!((d.scale, d.zero, d.tile, d.shift), (0.1, 0.5, [2.0, 1.0], [0.25, 0.5]));
    assert_eq!((options.method, options.edges), (Method::Dda, Edges::Shared));
    assert!(options.closed && options.one_sided);
    assert!(first.report().seam_walls > 0 && first.report().open_edges == 0);
    assert_eq!((second.options().edges, second.report().seam_walls), (Edges::AsAuthored, 0));
    assert!(Arc::ptr_eq(first.relief(), second.relief()));
    let loaded = load(&root().join("tests/scenes/valid/displaced_trapezium.toml")).unwrap();
    let [Surface::ReliefMesh(quad)] = loaded.scene.world().surfaces() else {
        panic!("one displaced quad");
    };
    assert_eq!(quad.data().triangles.len(), 2);
}

#[test]
fn spheres_and_meshes_are_walked_by_distance() {
    for name in ["displaced_spheres", "displaced_mesh", "displaced_trapezium"] {
        let path = root().join("tests/scenes/valid").join(name).with_extension("toml");
        let file = SceneFile::read(&path, &Limits::default()).unwrap();
        let load = |method| {
            let options = LoadOptions { method: Some(method), ..LoadOptions::default() };
            file.load(&options).unwrap()
        };
        let exact = load(Method::Dda);
        for method in [Method::Distance, Method::DistanceCorrected] {
            let loaded = load(method);
            for (k, surface) in loaded.scene.world().surfaces().iter().enumerate() {
                let found = match surface {
                    Surface::ReliefSphere(sphere) => sphere.options().method,
                    Surface::ReliefMesh(mesh) => mesh.options().method,
                    Surface::Face(face) => face.options().method,
                    other => panic!("{other:?}"),
                };
                assert_eq!(found, method);
                let bounds = surface.bounds();
                let ray = rilievo::Ray::between(bounds.max + DVec3::X, bounds.centre());
                let hit = surface.closest(&ray, &mut ());
                let other = exact.scene.world().surfaces()[k].closest(&ray, &mut ());
                assert_eq!(hit.map(|hit| hit.t), other.map(|hit| hit.t), "{name}, {k}");
            }
        }
    }
}

#[test]
fn matched_edges_have_a_map_of_their_own() {
    let text = "[camera]\nposition = [2, -3, 2]\nlook_at = [0, 0, 0]\n\
        [maps.waves]\nprocedural = \"gaussian\"\nsize = [33, 33]\n\
        [[shapes]]\ntype = \"mesh\"\nfile = \"tetrahedron.obj\"\nedges = \"matched\"\nmethod = \"distance\"\n\
        displacement = { map = \"waves\", scale = 0.1 }\n";
    let path = root().join("tests/scenes/valid/inline.toml");
    let loaded = SceneFile::parse(text, &path).unwrap().load(&LoadOptions::default()).unwrap();
    let [Surface::ReliefMesh(mesh)] = loaded.scene.world().surfaces() else { panic!() };
    assert_eq!(mesh.options().edges, Edges::Shared);
    assert!(mesh.relief().heights() != loaded.maps[0].relief.heights());
    assert!(mesh.relief().distance(DistanceKind::Boxes).is_some());
    assert!(loaded.notes.iter().any(|note| note.contains("seams matched")), "{:?}", loaded.notes);
}
