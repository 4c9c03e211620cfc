//! Pictures by a GPU beside those of the CPU, and what had to be brought there. Without an adapter nothing is drawn, and
//! stderr says so.

use std::io::Write;
use std::path::Path;

use glam::DVec2;

use super::*;
use crate::brush::{Dab, Tool};
use crate::passes::passes;
use crate::session::{Action, Look, Session, Sun};
use crate::studio::{Painting, Shown, Touch};
use rilievo_io::scene::SceneFile;

const SCENE: &str = "[camera]\nposition = [0.5, -0.7, 0.9]\nlook_at = [0.5, 0.5, 0]\nresolution = [40, 30]\n\
     [render]\nsamples = 4\nambient = [0.2, 0.2, 0.2]\n\
     [maps.m]\nprocedural = \"studded\"\nsize = [64, 64]\nstuds = [3, 3]\n\
     [[lights]]\ntype = \"sun\"\ndirection = [1, 0.5, -0.6]\nirradiance = [3, 3, 3]\n\
     [[shapes]]\ntype = \"quad\"\ncorners = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]]\n\
     displacement = { map = \"m\", scale = 0.1 }\n";

/// A scene, edited, loaded and drawn.
struct Desk {
    studio: Studio,
    session: Session,
    shown: Shown,
    renderer: Renderer,
}

impl Desk {
    fn open(backend: Backend) -> Self {
        let studio = Studio::default();
        let file = SceneFile::parse(SCENE, Path::new("scene.toml")).unwrap();
        let mut session = Session::new(&file, false, None);
        let shown = studio.load(&file, None).unwrap();
        session.learn(&shown.facts());
        let mut renderer = Renderer::new(1, None);
        renderer.choose(backend);
        Self { studio, session, shown, renderer }
    }

    /// Does something with the text, and loads it.
    fn act(&mut self, action: Action) {
        self.session.apply(action);
        self.load();
    }

    fn load(&mut self) {
        let file = self.session.document().parse().unwrap();
        self.shown = self.studio.load(&file, None).unwrap();
        self.renderer.loaded(0);
    }

    fn paint(&mut self, painting: Painting) {
        self.renderer.let_go(&self.studio);
        let mut edits = Vec::new();
        let nothing = "[camera]\nposition = [0, -1, 0]\nlook_at = [0, 0, 0]\n";
        let file = SceneFile::parse(nothing, Path::new("scene.toml")).unwrap();
        let empty = self.studio.load(&file, None).unwrap();
        let shown = std::mem::replace(&mut self.shown, empty);
        self.studio.paint(Some(shown), &[painting], &mut edits).unwrap();
        self.renderer.take_back(&self.studio, &edits);
        self.load();
    }

    fn draw(&mut self) -> (Film, Option<Brought>) {
        let size = self.shown.scene.camera().resolution();
        let pass = passes(size, &self.shown.settings, Look::Colour).pop().unwrap();
        let never = AtomicBool::new(false);
        self.renderer.render((0, &self.shown.scene), &pass, &|_| {}, &never).unwrap()
    }

    /// Draws, and compares with what the CPU draws; what had to be brought to the GPU.
    fn compare(&mut self) -> Option<Brought> {
        let (film, brought) = self.draw();
        let options = RenderOptions { threads: 1, ..RenderOptions::default() };
        let expected = rilievo_render::render(&self.shown.scene, &options).unwrap().0;
        let differ = |(a, b): &(&[f32; 3], &[f32; 3])| (0..3).any(|k| (a[k] - b[k]).abs() > 1e-3);
        let other = film.radiance().iter().zip(expected.radiance()).filter(differ).count();
        assert!(other * 100 <= film.radiance().len(), "{other} pixels differ");
        brought
    }
}

#[test]
fn the_cpu_renders_until_the_gpu_is_ready_and_it_tells_when() {
    let (tell, told) = channel();
    let tell = Mutex::new(tell);
    let wake: Wake = Arc::new(move || tell.lock().unwrap().send(()).unwrap());
    let mut desk = Desk::open(Backend::Cpu);
    desk.renderer = Renderer::new(1, Some(wake));
    desk.renderer.choose(Backend::Gpu);
    for _ in 0..2 {
        // It is opened, then its shaders are compiled.
        assert_eq!(desk.compare(), None);
        told.recv().unwrap();
        let ready = desk.renderer.prepare(0, &desk.shown.scene).is_some();
        assert_eq!(ready, desk.renderer.name(0) != "cpu");
        if let Some(why) = desk.renderer.take_why() {
            let _ = writeln!(std::io::stderr(), "SKIPPED, nothing was drawn: {}", why.text);
            return;
        }
    }
    // Traced there at once, and shaded by the CPU until the shaders of light are there.
    assert_eq!(desk.compare(), Some(Brought::Nothing));
    assert!(desk.renderer.renders(0).contains("while shaders are compiled"));
    told.recv().unwrap();
    assert_eq!(desk.compare(), Some(Brought::Nothing));
    assert!(desk.renderer.renders(0).contains("shaded there"));
}

/// A desk with a GPU, if there is one.
fn on_gpu() -> Option<Desk> {
    let mut desk = Desk::open(Backend::Gpu);
    if let (_, None) = desk.draw() {
        let why = desk.renderer.take_why().map_or_else(String::new, |why| why.text);
        let _ = writeln!(std::io::stderr(), "SKIPPED, nothing was drawn: {why}");
        return None;
    }
    Some(desk)
}

/// One after the other, so that shaders are compiled once.
#[test]
fn a_gpu_keeps_what_it_has_and_leaves_to_the_cpu_what_it_cannot_do() {
    let Some(mut desk) = on_gpu() else { return };
    materials_lights_and_cameras_bring_no_map_and_few_words(&mut desk);
    what_a_gpu_does_not_shade_it_traces_and_that_is_said(&mut desk);
    maps_stay_on_the_gpu_from_one_picture_to_the_next(&mut desk);
    what_a_gpu_cannot_trace_is_the_cpus_until_it_can(&mut desk);
}

fn maps_stay_on_the_gpu_from_one_picture_to_the_next(desk: &mut Desk) {
    assert_ne!(desk.renderer.name(0), "cpu");
    assert_eq!(desk.compare(), Some(Brought::Nothing));
    let camera = rilievo_render::CameraParts { fov: 35.0, ..desk.session.camera };
    // The scene as it is, with another camera.
    let file = desk.session.document().parse().unwrap();
    let same = desk.studio.load(&file, None).unwrap().scene;
    desk.shown.scene = same.with_camera(rilievo_render::Camera::new(camera).unwrap());
    assert_eq!(desk.compare(), Some(Brought::Nothing));
    for action in [Action::Depth(0.2), Action::Zero(0.5), Action::Tile([2.0, 2.0])] {
        desk.act(action.clone());
        assert_eq!(desk.compare(), Some(Brought::Numbers(0)), "{action:?}");
    }
    let mut pick = desk.shown.pick(DVec2::splat(0.5)).unwrap();
    let (at, _) = pick.map.take().unwrap();
    let dab = Dab { tool: Tool::Raise, at, radius: 9.0, strength: 0.6 };
    let touch = Painting::Touch(Touch { stroke: 1, surface: pick.surface, dab });
    let relief = Arc::as_ptr(desk.shown.relief(0).unwrap());
    desk.paint(touch);
    // Painted in place, though a GPU shows it.
    assert_eq!(Arc::as_ptr(desk.shown.relief(0).unwrap()), relief);
    let Some(Brought::Numbers(painted @ 1..)) = desk.compare() else { panic!("what was painted") };
    desk.paint(Painting::Swap(1));
    assert_eq!(desk.compare(), Some(Brought::Numbers(painted)));
    // Another map is another map, of the same size too.
    let other = SCENE.replace("studs = [3, 3]", "studs = [4, 3]");
    desk.session.reload(&SceneFile::parse(&other, Path::new("scene.toml")).unwrap());
    desk.load();
    assert_eq!(desk.compare(), Some(Brought::Maps));
}

fn materials_lights_and_cameras_bring_no_map_and_few_words(desk: &mut Desk) {
    assert!(desk.renderer.renders(0).contains("shaded there"), "{}", desk.renderer.renders(0));
    let Device::Open(gpu) = &desk.renderer.device else { panic!("a GPU") };
    let gpu = Arc::clone(gpu);
    let before = gpu.bytes_brought();
    assert!(before.maps >= 2 * 64 * 64, "{before:?}");
    let sun = Sun { azimuth: 100.0, elevation: 60.0, ..Sun::default() };
    let camera = rilievo_render::CameraParts { fov: 35.0, ..desk.session.camera };
    for action in [
        Action::Roughness(0.4),
        Action::Sun(sun),
        Action::Camera(camera),
        Action::Samples(9),
        Action::Depth(0.15),
    ] {
        let before = gpu.bytes_brought();
        desk.act(action.clone());
        desk.compare();
        let now = gpu.bytes_brought();
        assert_eq!(now.maps, before.maps, "{action:?}");
        // The numbers of one face, and blocks of what is said of light.
        assert!(now.scenes - before.scenes < 1 << 13, "{action:?}: {before:?} {now:?}");
        assert!(desk.renderer.renders(0).contains("shaded there"), "{action:?}");
    }
    // Of a scene that is as it was, the words that settings are written to.
    let before = gpu.bytes_brought();
    desk.compare();
    assert!(gpu.bytes_brought().scenes - before.scenes <= 128);
    // Layers are first hits: nothing is shaded, and what was there stays.
    let never = AtomicBool::new(false);
    let size = desk.shown.scene.camera().resolution();
    let look = Look::Layer(rilievo_render::Aov::N);
    let pass = passes(size, &desk.shown.settings, look).pop().unwrap();
    desk.renderer.render((0, &desk.shown.scene), &pass, &|_| {}, &never).unwrap();
    assert_eq!(gpu.bytes_brought().maps, before.maps);
}

fn what_a_gpu_does_not_shade_it_traces_and_that_is_said(desk: &mut Desk) {
    let wide = SCENE.replace("samples = 4", "samples = 1\nmax_depth = 40\ndiffuse_samples = 1");
    desk.session.reload(&SceneFile::parse(&wide, Path::new("scene.toml")).unwrap());
    desk.load();
    assert_eq!(desk.compare(), Some(Brought::Numbers(0)));
    let said = desk.renderer.renders(0);
    assert!(said.contains("shaded by the CPU: a tree of so many rays"), "{said}");
    desk.session.reload(&SceneFile::parse(SCENE, Path::new("scene.toml")).unwrap());
    desk.load();
    assert_eq!(desk.compare(), Some(Brought::Numbers(0)));
    assert!(desk.renderer.renders(0).contains("shaded there"));
}

fn what_a_gpu_cannot_trace_is_the_cpus_until_it_can(desk: &mut Desk) {
    let shows = |desk: &mut Desk, text: &str| {
        desk.session.reload(&SceneFile::parse(text, Path::new("scene.toml")).unwrap());
        desk.load();
    };
    shows(desk, &SCENE.replace("samples = 4", "samples = 4\nlod = 1"));
    assert_eq!(desk.draw().1, None);
    let why = desk.renderer.take_why().unwrap();
    assert!(why.loud && why.text.contains("level of detail"), "{why:?}");
    assert_eq!(desk.draw().1, None);
    assert_eq!(
        (desk.renderer.name(0).to_owned(), desk.renderer.take_why()),
        ("cpu".to_owned(), None)
    );
    // Loaded again, as while a slider is dragged, it is no news.
    desk.load();
    assert_eq!((desk.draw().1, desk.renderer.take_why()), (None, None));
    shows(desk, SCENE);
    assert_eq!(desk.compare(), Some(Brought::Maps));
}

#[test]
fn a_lost_gpu_leaves_its_work_to_the_cpu_and_says_so() {
    let Some(mut desk) = on_gpu() else { return };
    let Device::Open(gpu) = &desk.renderer.device else { panic!("a GPU") };
    gpu.device().destroy();
    desk.compare();
    let why = desk.renderer.take_why().unwrap();
    assert!(why.loud && why.text.contains("the CPU takes over"), "{why:?}");
    assert_eq!(desk.draw().1, None);
    assert_eq!(desk.renderer.name(0), "cpu");
    // Until it is asked for again.
    desk.renderer.choose(Backend::Cpu);
    desk.renderer.choose(Backend::Gpu);
    assert_eq!(desk.compare(), Some(Brought::Maps));
    assert_ne!(desk.renderer.name(0), "cpu");
}
