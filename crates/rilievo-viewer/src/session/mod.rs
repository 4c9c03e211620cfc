//! [`Session`]: what is shown and what was done to it, free of window and threads.
//!
//! Every edit is an [`Action`] on the text of the scene ([`Document`]). Depth, zero and tile are keys of
//! the text like all others; that a change of them costs nothing is the business of
//! [`rilievo_io::scene::Cache`], which keeps heights and pyramids from one loading to the next.

mod action;
mod document;
mod history;
mod preset;
mod sun;

pub use action::{Action, Change, Look};
pub use document::{DisplacementKey, Document, array};
pub use history::{History, Step};
pub use preset::Preset;
pub use sun::Sun;

use std::path::{Path, PathBuf};

use glam::DVec3;
use rilievo::map::Layout;
use rilievo::relief::{Displacement, Method};
use rilievo_io::scene::SceneFile;
use rilievo_render::film::tonemap::ToneMap;
use rilievo_render::{CameraParts, RenderSettings};

use crate::save::Meaning;

/// A displaced shape as the window shows it.
#[derive(Clone, Debug, PartialEq)]
pub struct ShownShape {
    /// Its place among the shapes of the file.
    pub index: usize,
    /// Its type and number.
    pub name: String,
    /// Whether it is a terrain, which has a height of its own.
    pub terrain: bool,
    /// The map it names.
    pub map: String,
    /// How the map is laid on it, what the scene does not say filled in.
    pub displacement: Displacement,
    /// Its corners, once it is loaded, if it is a parallelogram.
    pub corners: Option<[DVec3; 4]>,
}

/// What a loaded scene says where its text is silent.
#[derive(Clone, Debug, PartialEq)]
pub struct Facts {
    /// How the map of each displaced shape is laid, by the shape's place in the file.
    pub displacements: Vec<(usize, Displacement)>,
    /// The corners of those that are parallelograms, terrain among them.
    pub corners: Vec<(usize, [DVec3; 4])>,
    /// How the first of them is walked, and how the bounds of its map are stored, if it shows a map as it
    /// is.
    pub walk: Option<(Method, Layout)>,
    /// The camera.
    pub camera: CameraParts,
    /// How to render.
    pub settings: RenderSettings,
    /// How the picture is shown.
    pub tone_map: ToneMap,
}

/// A scene that is looked at and edited.
#[derive(Debug)]
pub struct Session {
    document: Document,
    history: History,
    /// Whether it presents a map or a folder, so that presets fit.
    pub bare: bool,
    /// A model that the preset `mesh` takes.
    pub mesh: Option<PathBuf>,
    /// What bare maps are shown on.
    pub preset: Preset,
    /// What of the film is shown.
    pub look: Look,
    /// The displaced shapes.
    pub shapes: Vec<ShownShape>,
    /// Which of them sliders act on.
    pub selected: usize,
    /// Whether sliders act on all shapes with its map.
    pub together: bool,
    /// The camera.
    pub camera: CameraParts,
    /// How to render.
    pub settings: RenderSettings,
    /// How the picture is shown.
    pub tone_map: ToneMap,
    /// How reliefs are walked, as far as `[render]` says.
    pub method: Method,
    /// How bounds are stored, if it was chosen here.
    pub layout: Layout,
    /// Whether the text differs from what was read or saved.
    pub unsaved: bool,
}

/// A camera until there is one.
const SOMEWHERE: CameraParts = CameraParts {
    position: DVec3::ZERO,
    look_at: DVec3::Y,
    up: DVec3::Z,
    fov: 40.0,
    resolution: [512, 512],
};

impl Session {
    /// A session with a scene. Of one that presents a bare map (`bare`) the lamp becomes a sun.
    pub fn new(file: &SceneFile, bare: bool, mesh: Option<PathBuf>) -> Self {
        let mut document = Document::of(file);
        if bare {
            preset::prepare(&mut document);
        }
        // A camera without direction is refused when the scene is loaded.
        let camera = file.camera().map_or(SOMEWHERE, |camera| camera.parts());
        let mut session = Self {
            document,
            history: History::default(),
            bare,
            mesh,
            preset: Preset::Plane,
            look: Look::Colour,
            shapes: Vec::new(),
            selected: 0,
            together: true,
            camera,
            settings: RenderSettings::default(),
            tone_map: ToneMap::default(),
            method: Method::default(),
            layout: Layout::Default,
            unsaved: false,
        };
        session.find_shapes();
        // A model of its own has nothing that could be laid on something else.
        session.bare &= session.shapes.iter().any(|shape| shape.name.starts_with("quad"));
        session
    }

    /// The scene as text.
    pub fn document(&self) -> &Document {
        &self.document
    }

    /// The shape that sliders act on, if any is displaced.
    pub fn shape(&self) -> Option<&ShownShape> {
        self.shapes.get(self.selected)
    }

    /// Takes over what loading the present text has shown.
    pub fn learn(&mut self, facts: &Facts) {
        for shape in &mut self.shapes {
            let fact = facts.displacements.iter().find(|(index, _)| *index == shape.index);
            if let Some((_, displacement)) = fact {
                shape.displacement = *displacement;
            }
            let fact = facts.corners.iter().find(|(index, _)| *index == shape.index);
            shape.corners = fact.map(|(_, corners)| *corners);
        }
        (self.camera, self.settings, self.tone_map) =
            (facts.camera, facts.settings, facts.tone_map);
        if let Some((method, layout)) = facts.walk {
            (self.method, self.layout) = (method, layout);
        }
    }

    /// Does what was asked and says what has to be made anew.
    pub fn apply(&mut self, action: Action) -> Change {
        let before = self.document.clone();
        let kind = std::mem::discriminant(&action);
        let change = self.edit(action.clone());
        // Where one looks is no edit of the scene, nor is what one looks at.
        let edits = !matches!(action, Action::Camera(_) | Action::Look(_));
        if edits && change != Change::None {
            self.history.text(&before, kind);
            self.unsaved = true;
        }
        change
    }

    fn edit(&mut self, action: Action) -> Change {
        match action {
            Action::Depth(depth) if depth == 0.0 || !depth.is_finite() => return Change::None,
            Action::Depth(depth) => {
                self.lay(DisplacementKey::Scale, |d| d.scale = depth);
            }
            Action::Zero(zero) => self.lay(DisplacementKey::Zero, |d| d.zero = zero),
            Action::Tile(tile) if tile.iter().any(|t| !t.is_finite() || *t <= 0.0) => {
                return Change::None;
            }
            Action::Tile(tile) => {
                self.lay(DisplacementKey::Tile, |d| d.tile = tile);
                self.document.tile_own_texture(tile);
            }
            Action::Exaggeration(factor) if !factor.is_finite() || factor <= 0.0 => {
                return Change::None;
            }
            Action::Exaggeration(factor) => {
                let Some(shape) = self.shape() else { return Change::None };
                self.document.set_exaggeration(shape.index, factor);
            }
            Action::Roughness(roughness) => {
                let Some(shape) = self.shape() else { return Change::None };
                let index = shape.index;
                let without = self.document.material(index).is_none();
                let name = self.document.own_material(index);
                if without {
                    // Of what reflects nothing there is no roughness to see.
                    self.document.set_material(&name, "reflective", array([0.04; 3]));
                }
                self.document.set_material(&name, "roughness", roughness.clamp(0.0, 1.0).into());
            }
            Action::Sun(sun) => self.document.set_sun(&sun),
            Action::Camera(camera) => {
                self.camera = camera;
                self.document.set_camera(&camera);
                return Change::Rendered;
            }
            Action::Method(method) => {
                self.method = method;
                self.document.clear_methods();
                self.document.set("render", "method", method.name());
            }
            Action::Layout(layout) => {
                self.layout = layout;
                self.document.set_layouts(layout.name());
            }
            Action::Integrator(integrator) => {
                self.settings.integrator = integrator;
                self.document.set("render", "integrator", integrator.name());
            }
            Action::Samples(samples) => {
                self.settings.samples = samples;
                self.document.set("render", "samples", i64::from(samples));
            }
            Action::Exposure(exposure) => {
                self.tone_map.exposure = exposure;
                self.document.set("render", "exposure", exposure);
                return Change::Shown;
            }
            Action::View(view) => {
                self.tone_map.view = view;
                self.document.set("render", "view", view.name());
                return Change::Shown;
            }
            Action::Look(look) => {
                self.look = look;
                return Change::Rendered;
            }
            Action::Preset(preset) => {
                if !preset::show(&mut self.document, preset, self.mesh.as_deref()) {
                    return Change::None;
                }
                self.preset = preset;
                self.find_shapes();
            }
        }
        Change::Scene
    }

    /// Changes the displacement of the selected shape, or of all with its map, and writes `key`.
    fn lay(&mut self, key: DisplacementKey, change: impl Fn(&mut Displacement)) {
        let Some(map) = self.shape().map(|shape| shape.map.clone()) else { return };
        let (selected, together) = (self.selected, self.together);
        for (place, shape) in self.shapes.iter_mut().enumerate() {
            if place != selected && !(together && shape.map == map) {
                continue;
            }
            let d = &mut shape.displacement;
            change(d);
            let value = match key {
                DisplacementKey::Scale => d.scale.into(),
                DisplacementKey::Zero => d.zero.into(),
                DisplacementKey::Tile => array(d.tile),
            };
            self.document.set_displacement(shape.index, key, value);
        }
    }

    /// The next edit is a step of its own: the mouse was let go.
    pub fn settle(&mut self) {
        self.history.settle();
    }

    /// Notes that a stroke of the brush was painted.
    pub fn painted(&mut self, stroke: u32) {
        self.history.stroke(stroke);
        self.unsaved = true;
    }

    /// Takes the last step back; of a stroke the map must be told, which the step says.
    pub fn undo(&mut self) -> Option<Step> {
        let step = self.history.undo(&self.document)?;
        self.after(&step);
        Some(step)
    }

    /// Does the last step taken back again.
    pub fn redo(&mut self) -> Option<Step> {
        let step = self.history.redo(&self.document)?;
        self.after(&step);
        Some(step)
    }

    fn after(&mut self, step: &Step) {
        if let Step::Text(document) = step {
            // A scene that was saved elsewhere since stays there.
            let here = document.moved(self.document.path());
            self.document = here.unwrap_or_else(|| document.as_ref().clone());
            self.document.set_camera(&self.camera);
            self.find_shapes();
        }
        self.unsaved = true;
    }

    /// Takes a document in place of the present one: the file changed on the disk.
    pub fn reload(&mut self, file: &SceneFile) {
        self.document = Document::of(file);
        self.history = History::default();
        self.unsaved = false;
        self.find_shapes();
    }

    /// Lets the shapes that show the map of the selected one show the file `file`, which holds their
    /// painted map, with what was assumed of the old one written down. A terrain, whose file says more than a map can,
    /// becomes the displaced quad that it is.
    pub fn take_map(&mut self, file: &Path, meaning: Meaning) {
        let Some(shape) = self.shape() else { return };
        let name = match shape.map.trim_end_matches('/') {
            "" | "." => "painted".to_owned(),
            name => format!("{}-painted", name.trim_end_matches("-painted")),
        };
        let file = file.to_string_lossy();
        let map = shape.map.clone();
        for shape in self.shapes.iter_mut().filter(|shape| shape.map == map) {
            if let (true, Some(corners)) = (shape.terrain, shape.corners) {
                self.document.terrain_to_quad(shape.index, corners);
                shape.terrain = false;
            }
            let Displacement { scale, zero, .. } = shape.displacement;
            let (scale, zero) = (scale * meaning.span, (zero - meaning.low) / meaning.span);
            if map.ends_with('/') {
                self.document.own_material(shape.index);
            }
            self.document.set_displacement(shape.index, DisplacementKey::Scale, scale.into());
            self.document.set_displacement(shape.index, DisplacementKey::Zero, zero.into());
            self.document.set_map(shape.index, &name, &file);
            shape.map.clone_from(&name);
        }
    }

    /// The text was saved as this.
    pub fn saved(&mut self, document: Document) {
        self.document = document;
        self.find_shapes();
        self.bare = false;
        self.unsaved = false;
    }

    fn find_shapes(&mut self) {
        let old = std::mem::take(&mut self.shapes);
        let displaced = self.document.displaced().into_iter();
        self.shapes = displaced
            .map(|(index, kind, map)| {
                let known = old.iter().find(|shape| shape.index == index);
                let displacement = known.map(|shape| shape.displacement).unwrap_or_default();
                let terrain = kind == "terrain";
                let name = format!("{kind} {}", index + 1);
                let corners = known.and_then(|shape| shape.corners);
                ShownShape { index, name, terrain, map, displacement, corners }
            })
            .collect();
        self.selected = self.selected.min(self.shapes.len().saturating_sub(1));
    }
}

#[cfg(test)]
mod tests;
