//! What the panel `Save` does.

use std::path::{Path, PathBuf};

use eframe::egui::{Id, Modal, TextEdit, Ui, ViewportCommand};
use rilievo_viewer::save;
use rilievo_viewer::session::{Change, Session};

use super::state::Viewer;

/// Paths of files to be written; relative ones start from the folder of the scene.
pub struct Saving {
    picture: String,
    map: String,
    scene: String,
    /// Files that were written here, and the one that was asked about: they may be replaced.
    mine: Vec<PathBuf>,
    /// Whether the window is to be closed, and it is asked what becomes of the edits.
    closing: bool,
}

impl Saving {
    /// Names beside what is shown.
    pub fn new(session: &Session) -> Self {
        let path = session.document().path();
        let stem = path.file_stem().unwrap_or_default().to_string_lossy();
        let scene =
            if session.bare { "scene.toml".to_owned() } else { format!("{stem}-edited.toml") };
        Self {
            picture: "picture.png".to_owned(),
            map: "painted.png".to_owned(),
            scene,
            mine: Vec::new(),
            closing: false,
        }
    }
}

impl Viewer {
    /// Three paths with a button each.
    pub fn save_panel(&mut self, ui: &mut Ui) {
        let folder = self.folder();
        let shown = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
        ui.weak(format!("in {}, or anywhere by a whole path", shown.display()));
        let Self { saving, journal, .. } = self;
        let mut row = |ui: &mut Ui, (name, path): (&'static str, &mut String), button: &str| {
            ui.horizontal(|ui| {
                let scale = ui.ctx().pixels_per_point();
                let field = TextEdit::singleline(path).desired_width(150.0);
                journal.widget(name, ui.add(field).rect, scale);
                let response = ui.button(button);
                journal.widget(button_of(name), response.rect, scale);
                response.clicked()
            })
            .inner
        };
        let picture = row(ui, ("picture path", &mut saving.picture), "Picture");
        let map = row(ui, ("map path", &mut saving.map), "Map, 16 bit");
        let scene = row(ui, ("scene path", &mut saving.scene), "Scene");
        if picture {
            self.save_picture();
        }
        if map {
            self.save_map();
        }
        if scene {
            self.save_scene();
        }
        ui.weak("A painted map is saved first; the scene then names it.");
    }

    /// The folder of the scene, without steps that lead nowhere.
    fn folder(&self) -> PathBuf {
        let path = self.session.document().path();
        path.parent().unwrap_or(Path::new("")).components().collect()
    }

    /// Where a path of the panel leads.
    fn target(&self, path: &str) -> PathBuf {
        self.folder().join(path.trim()).components().collect()
    }

    /// Whether there is something that closing the window would lose.
    fn unsaved(&self) -> bool {
        self.session.unsaved || self.painted
    }

    /// When the window is to be closed with edits that are not saved, asks first.
    pub fn close(&mut self, ui: &Ui) {
        let context = ui.ctx();
        if context.input(|input| input.viewport().close_requested()) && self.unsaved() {
            self.saving.closing = true;
            context.send_viewport_cmd(ViewportCommand::CancelClose);
        }
        if !self.saving.closing {
            return;
        }
        let mut journal = |name, response: &eframe::egui::Response| {
            self.journal.widget(name, response.rect, context.pixels_per_point());
        };
        let question = Modal::new(Id::unique("closing")).show(context, |ui| {
            ui.label("What was edited is not saved.");
            ui.horizontal(|ui| {
                ["save and close", "close without saving", "go on"].map(|name| {
                    let response = ui.button(name);
                    journal(name, &response);
                    response.clicked()
                })
            })
            .inner
        });
        let [save, lose, stay] = question.inner;
        if save {
            self.save_scene();
        }
        // What could not be saved is told below the picture.
        if stay || save || question.should_close() {
            self.saving.closing = false;
        }
        if lose || save && !self.unsaved() {
            self.session.unsaved = false;
            self.painted = false;
            context.send_viewport_cmd(ViewportCommand::Close);
        }
    }

    /// Whether a file may be written: one that was there before only when asked for twice.
    fn may_write(&mut self, path: &Path) -> bool {
        let known = self.saving.mine.iter().any(|mine| mine == path);
        if !known {
            self.saving.mine.push(path.to_owned());
        }
        let free = known || !path.exists();
        if !free {
            let there = format!("{} is there; once more replaces it", path.display());
            self.message = Some(Err(there));
        }
        free
    }

    fn save_picture(&mut self) {
        let path = self.target(&self.saving.picture);
        if !self.may_write(&path) {
            return;
        }
        let Some(frame) = self.frame().cloned() else { return };
        let done = save::picture(&path, &frame, &self.session.tone_map);
        let state = if frame.complete { "" } else { ", which is not done yet" };
        self.told(done.map(|()| format!("saved {}{state}", path.display())));
    }

    /// Saves the map of the selected shape, and lets the scene name the file; whether it did.
    pub fn save_map(&mut self) -> bool {
        let name = self.saving.map.trim().to_owned();
        let path = self.target(&name);
        if !self.may_write(&path) {
            return false;
        }
        let Some(shape) = self.session.shape().map(|shape| shape.index) else { return false };
        let saved = self.worker.with_shown(|shown| {
            shown.relief(shape).map(|relief| save::map(&path, relief.heights()))
        });
        match saved.flatten() {
            None => self.message = Some(Err("no map that can be saved".to_owned())),
            Some(Err(e)) => self.message = Some(Err(e.to_string())),
            Some(Ok(meaning)) => {
                self.session.take_map(Path::new(&name), meaning);
                self.painted = false;
                self.need(Change::Scene);
                self.message = Some(Ok(format!("saved {}", path.display())));
            }
        }
        !self.painted
    }

    /// Saves the scene, and a painted map before it.
    pub fn save_scene(&mut self) {
        if self.painted && !self.save_map() {
            return;
        }
        let path = self.target(&self.saving.scene);
        if !self.may_write(&path) {
            return;
        }
        let Some(document) = self.session.document().moved(&path) else {
            let why = "the files that the scene names cannot be named from there";
            self.message = Some(Err(format!("{}: {why}", path.display())));
            return;
        };
        let done = save::scene(&path, &document.text());
        if done.is_ok() {
            self.session.saved(document);
            if let Ok(file) = self.session.document().parse() {
                self.watch_anew(&file);
            }
            // From its new folder the paths above would lead elsewhere.
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            self.saving.scene = name.into_owned();
        }
        self.told(done.map(|()| format!("saved {}", path.display())));
    }

    fn told(&mut self, result: rilievo_io::Result<String>) {
        self.message = Some(result.map_err(|e| e.to_string()));
    }
}

/// What the journal calls the button beside a path.
fn button_of(path: &str) -> &'static str {
    match path {
        "picture path" => "save picture",
        "map path" => "save map",
        _ => "save scene",
    }
}
