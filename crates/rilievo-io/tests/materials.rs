//! Materials of scenes, of texture sets and of models' own files.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use rilievo::glam::{DVec2, DVec3};
use rilievo::map::{NormalConvention, Wrap};
use rilievo_io::Limits;
use rilievo_io::image::{write_png_grey16, write_png_rgb8};
use rilievo_io::scene::{LoadOptions, LoadedScene, SceneFile};
use rilievo_render::scene::{Metal, Model};
use rilievo_render::texture::{Channel, TileCache};
use rilievo_render::{Integrator, Material, MemoryUse, Reflectance, RenderOptions, Scene};

const PATHS: LoadOptionsOf = LoadOptionsOf(Some(Integrator::Path));
const PAPERS: LoadOptionsOf = LoadOptionsOf(None);

/// Which integrator a scene is loaded for.
#[derive(Clone, Copy)]
struct LoadOptionsOf(Option<Integrator>);

impl LoadOptionsOf {
    fn load(self, file: &SceneFile) -> LoadedScene {
        file.load(&LoadOptions { integrator: self.0, ..LoadOptions::default() }).unwrap()
    }
}

fn scene(folder: &Path, text: &str) -> SceneFile {
    let camera = "[camera]\nposition = [0, 0, 9]\nlook_at = [0, 0, 0]\nup = [0, 1, 0]\n";
    SceneFile::parse(&format!("{camera}{text}"), &folder.join("scene.toml")).unwrap()
}

fn material(scene: &Scene, surface: u32) -> &Material {
    scene.material(surface)
}

#[test]
fn every_model_of_a_scene_arrives() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let path = root.join("tests/scenes/valid/materials.toml");
    let file = SceneFile::read(&path, &Limits::default()).unwrap();
    assert!(file.references().len() == 6 && file.references().iter().all(|path| path.exists()));
    let loaded = PAPERS.load(&file);
    let scene = &loaded.scene;
    assert!(loaded.notes.is_empty(), "{:?}", loaded.notes);

    let Reflectance::Textured(paper) = &material(scene, 0).diffuse else { panic!() };
    assert_eq!((&material(scene, 0).model, material(scene, 0).roughness), (&Model::Paper, 0.2));
    let Model::Diffuse(plaster) = &material(scene, 1).model else { panic!() };
    assert_eq!((plaster.colour.value.x, plaster.roughness.value), (0.8, 0.5));
    let Model::Conductor(gold) = &material(scene, 2).model else { panic!() };
    let Metal::Index { eta, .. } = &gold.metal else { panic!() };
    assert!(eta.z > 1.0 && eta.x < 0.2 && gold.compensated);
    // In the paper's terms it reflects what it does straight on.
    let reflective = material(scene, 2).reflective;
    assert!((0.9..1.0).contains(&reflective.x) && reflective.z < 0.5, "{reflective}");
    let Model::Conductor(paint) = &material(scene, 3).model else { panic!() };
    let Metal::Colours { facing, edge } = &paint.metal else { panic!() };
    assert_eq!((facing.value, edge.value), (DVec3::new(1.0, 0.5, 0.5), DVec3::new(0.9, 0.8, 0.7)));
    let tinted = facing.texture.as_ref().unwrap();
    assert!(Arc::ptr_eq(&tinted.image, &paper.image), "one file, one image");
    let (rough, channel) = paint.roughness.texture.as_ref().unwrap();
    assert!(!Arc::ptr_eq(&rough.image, &paper.image), "numbers are no colours");
    assert_eq!((paint.roughness.value, paint.roughness.invert), (0.5, true));
    assert_eq!(*channel, Channel::Green);
    let Model::Glass(glass) = &material(scene, 4).model else { panic!() };
    assert_eq!((glass.table.ior(), glass.roughness.value), (1.33, 0.1));
    assert!(!glass.compensated);
    let Model::ThinGlass(window) = &material(scene, 5).model else { panic!() };
    assert_eq!((window.ior, window.colour.value), (1.5, DVec3::ONE));

    let car = material(scene, 6);
    let Model::Principled(model) = &car.model else { panic!() };
    let base = model.base_colour.texture.as_ref().unwrap();
    assert_eq!((base.tile, base.shift), (DVec2::splat(2.0), DVec2::new(0.5, 0.0)));
    assert!((base.turn - DVec2::Y).length() < 1e-12);
    assert_eq!(base.wrap, [Wrap::Clamp, Wrap::Mirror]);
    assert_eq!((model.metallic.value, model.coat.value, model.thin), (0.25, 1.0, true));
    assert_eq!((model.specular.value, model.opacity.value), (1.0, 0.9));
    let normals = car.normals.as_ref().unwrap();
    assert_eq!((normals.convention, normals.strength), (NormalConvention::DirectX, 0.5));
    assert!(Arc::ptr_eq(&normals.texture.image, &rough.image));
    assert!(car.emission.is_some() && car.emitted == DVec3::new(1.0, 2.0, 3.0));
    let Model::Mix(worn) = &material(scene, 7).model else { panic!() };
    assert_eq!((&worn.materials[0], &worn.materials[1]), (material(scene, 2), car));
}

#[test]
fn textures_that_do_not_fit_lie_in_tiles_and_show_the_same() {
    let dir = tempfile::tempdir().unwrap();
    for (name, side) in [("a.png", 600_u32), ("b.png", 1024)] {
        let texel = |k: u32| [k, k >> 3, k >> 11].map(|x| (x.wrapping_mul(97) & 255) as u8);
        let texels: Vec<_> = (0..side * side).map(texel).collect();
        write_png_rgb8(&dir.path().join(name), [side; 2], &texels).unwrap();
    }
    let sphere = "[[shapes]]\ntype = \"sphere\"\nradius = 1\n";
    let text = |memory: &str| {
        format!(
            "resolution = [48, 48]\n[render]\nintegrator = \"path\"\nsamples = 4\nmax_depth = 2\n\
             background = [1, 1, 1]\n{memory}\n\
             [materials.a]\ntexture = {{ file = \"a.png\", tile = [3, 3] }}\n\
             [materials.b]\ntexture = \"b.png\"\n\
             {sphere}center = [0, 0, 0]\nmaterial = \"a\"\n\
             {sphere}center = [0, 0.3, 1]\nmaterial = \"b\"\n"
        )
    };
    let load = |memory| PAPERS.load(&scene(dir.path(), &text(memory)));
    let picture = |loaded: &LoadedScene, threads| {
        let options = RenderOptions { threads, ..RenderOptions::default() };
        let film = rilievo_render::render(&loaded.scene, &options).unwrap().0;
        film.radiance().iter().flatten().map(|x| x.to_bits()).collect::<Vec<_>>()
    };
    let all = load("");
    let fits = load("texture_memory = 6");
    let tiled = load("texture_memory = 1");
    assert!(all.notes.is_empty() && fits.notes.is_empty());
    // 1.4 MiB, which does not fit, and 4.
    let [note] = tiled.notes.as_slice() else { panic!("{:?}", tiled.notes) };
    assert!(note.starts_with("textures of 6 MiB do not fit texture_memory = 1: "), "{note}");
    let want = picture(&all, 1);
    assert!(want.iter().any(|&x| f32::from_bits(x) > 0.1));
    for threads in [1, 3] {
        assert!(picture(&fits, threads) == want && picture(&tiled, threads) == want);
    }
    let textures = |loaded: &LoadedScene| {
        MemoryUse::predict(&loaded.scene, &RenderOptions { threads: 1, ..RenderOptions::default() })
            .textures
    };
    assert_eq!(textures(&all), textures(&fits));
    assert_eq!(textures(&tiled), (1 << 20) + TileCache::SLACK);
}

#[test]
fn an_image_that_fitted_goes_to_the_file_with_one_that_does_not() {
    let dir = tempfile::tempdir().unwrap();
    for (name, side) in [("a.png", 16_u32), ("b.png", 700)] {
        let texels = vec![[200, 100, 50]; (side * side) as usize];
        write_png_rgb8(&dir.path().join(name), [side; 2], &texels).unwrap();
    }
    let sphere = "[[shapes]]\ntype = \"sphere\"\ncenter = [0, 0, 0]\nradius = 1\n";
    let text = format!(
        "[render]\ntexture_memory = 1\n[materials.a]\ntexture = \"a.png\"\n[materials.b]\n\
         texture = \"b.png\"\n{sphere}material = \"a\"\n{sphere}material = \"b\"\n"
    );
    let loaded = PAPERS.load(&scene(dir.path(), &text));
    let image = |surface| {
        let Reflectance::Textured(texture) = &loaded.scene.material(surface).diffuse else {
            panic!()
        };
        Arc::clone(&texture.image)
    };
    let [a, b] = [0, 1].map(image);
    assert!(Arc::ptr_eq(a.cache().unwrap(), b.cache().unwrap()));
    assert_eq!((a.width(), b.width()), (16, 700));
    assert_eq!(a.texel(3, 3), b.texel(690, 3));
}

#[test]
fn a_texture_set_fills_a_principled_material() {
    let dir = tempfile::tempdir().unwrap();
    let set = dir.path().join("rock");
    fs::create_dir(&set).unwrap();
    for name in ["a_Color.png", "a_NormalDX.png", "a_Roughness.png", "a_Metalness.png"] {
        write_png_rgb8(&set.join(name), [4, 4], &[[128, 128, 255]; 16]).unwrap();
    }
    let codes: Vec<u16> = (0..16).map(|k| k * 4000).collect();
    write_png_grey16(&set.join("a_Displacement.png"), [4, 4], &codes).unwrap();
    let quad =
        "[[shapes]]\ntype = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n";
    let named = format!(
        "[materials.a]\nmodel = \"principled\"\nset = \"rock/\"\nmetallic = 0\n{quad}material = \"a\"\n"
    );
    let file = scene(dir.path(), &named);
    let paths = PATHS.load(&file);
    let rock = paths.scene.material(0);
    let Model::Principled(model) = &rock.model else { panic!() };
    assert!(model.base_colour.texture.is_some() && model.roughness.texture.is_some());
    assert!(model.metallic.texture.is_none(), "the scene says it");
    assert_eq!(rock.normals.as_ref().unwrap().convention, NormalConvention::DirectX);
    // The paper's integrator shows the albedo, as before, and reads no more.
    let papers = PAPERS.load(&file);
    let plain = papers.scene.material(0);
    assert!(matches!(plain.diffuse, Reflectance::Textured(_)));
    assert_eq!(
        (&plain.model, plain.reflective, &plain.normals),
        (&Model::Paper, DVec3::ZERO, &None)
    );

    // On the relief of the set its normals are there already.
    let displaced = format!("{quad}displacement = {{ map = \"rock/\", tile = [2, 2] }}\n");
    let file = scene(dir.path(), &displaced);
    let paths = PATHS.load(&file);
    let rock = paths.scene.material(0);
    let Model::Principled(model) = &rock.model else { panic!() };
    let (rough, _) = model.roughness.texture.as_ref().unwrap();
    assert_eq!(rough.tile, DVec2::splat(2.0));
    assert!(model.metallic.texture.is_some() && rock.normals.is_none());
    let papers = PAPERS.load(&file);
    assert_eq!(papers.scene.material(0).model, Model::Paper);
}

#[test]
fn materials_of_models_are_principled_for_paths() {
    let dir = tempfile::tempdir().unwrap();
    let obj = "mtllib a.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nusemtl m\nf 1/1 2/2 3/3\n";
    fs::write(dir.path().join("a.obj"), obj).unwrap();
    let mtl = "newmtl m\nKd 0.5 0.5 1\nPr 0.25\nPm 1\nPc 0.5\nPcr 0.1\nd 0.75\nNi 1.4\n\
               map_Kd -clamp on c.png\nmap_Pm c.png\nnorm c.png\nmap_Ke c.png\n";
    fs::write(dir.path().join("a.mtl"), mtl).unwrap();
    write_png_rgb8(&dir.path().join("c.png"), [2, 2], &[[128, 128, 255]; 4]).unwrap();
    let file = scene(dir.path(), "[[shapes]]\ntype = \"mesh\"\nfile = \"a.obj\"\n");
    let paths = PATHS.load(&file);
    let shown = paths.scene.material(0);
    let Model::Principled(model) = &shown.model else { panic!() };
    assert_eq!(model.base_colour.value, DVec3::new(0.5, 0.5, 1.0));
    assert_eq!(model.base_colour.texture.as_ref().unwrap().wrap, [Wrap::Clamp; 2]);
    assert_eq!((model.roughness.value, model.coat.value, model.opacity.value), (0.25, 0.5, 0.75));
    assert_eq!((model.glass.ior(), model.coat_roughness.value), (1.4, 0.1));
    assert!(model.metallic.texture.is_some() && shown.normals.is_some());
    assert!(shown.emission.is_some() && shown.emitted == DVec3::ONE);
    let papers = PAPERS.load(&file);
    let plain = papers.scene.material(0);
    assert_eq!((&plain.model, plain.emitted, plain.roughness), (&Model::Paper, DVec3::ZERO, 0.25));
}
