//! What the panel `Save` does.

use std::path::{Path, PathBuf};

use eframe::egui::{TextEdit, Ui};
use rilievo_viewer::save;
use rilievo_viewer::session::{Change, Session};

use super::state::Viewer;

/// Names of files to be written, in the folder of the scene.
pub struct Saving {
    picture: String,
    map: String,
    scene: String,
    /// Files that were written here, and the one that was asked about: they may be replaced.
    mine: Vec<PathBuf>,
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
        }
    }
}

impl Viewer {
    /// Three names with a button each.
    pub fn save_panel(&mut self, ui: &mut Ui) {
        let folder = self.folder();
        ui.weak(format!(
            "in {}",
            if folder.as_os_str().is_empty() { ".".into() } else { folder.display().to_string() }
        ));
        let row = |ui: &mut Ui, name: &mut String, button: &str| {
            ui.horizontal(|ui| {
                ui.add(TextEdit::singleline(name).desired_width(150.0));
                ui.button(button).clicked()
            })
            .inner
        };
        let picture = row(ui, &mut self.saving.picture, "Picture");
        let map = row(ui, &mut self.saving.map, "Map, 16 bit");
        let scene = row(ui, &mut self.saving.scene, "Scene");
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

    fn folder(&self) -> PathBuf {
        self.session.document().path().parent().unwrap_or(Path::new("")).to_owned()
    }

    /// Whether a file may be written: one that was there before only when asked for twice.
    fn may_write(&mut self, path: &Path) -> bool {
        let known = self.saving.mine.iter().any(|mine| mine == path);
        if !known {
            self.saving.mine.push(path.to_owned());
        }
        let free = known || !path.exists();
        if !free {
            self.message = Some(format!("{} is there; once more replaces it", path.display()));
        }
        free
    }

    fn save_picture(&mut self) {
        let path = self.folder().join(&self.saving.picture);
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
        let name = self.saving.map.clone();
        let path = self.folder().join(&name);
        if !self.may_write(&path) {
            return false;
        }
        let Some(shape) = self.session.shape().map(|shape| shape.index) else { return false };
        let saved = self.worker.with_shown(|shown| {
            shown.relief(shape).map(|relief| save::map(&path, relief.heights()))
        });
        match saved.flatten() {
            None => self.message = Some("no map that can be saved".to_owned()),
            Some(Err(e)) => self.message = Some(e.to_string()),
            Some(Ok(meaning)) => {
                self.session.take_map(Path::new(&name), meaning);
                self.painted = false;
                self.need(Change::Scene);
                self.message = Some(format!("saved {}", path.display()));
            }
        }
        !self.painted
    }

    /// Saves the scene, and a painted map before it.
    pub fn save_scene(&mut self) {
        if self.painted && !self.save_map() {
            return;
        }
        let path = self.folder().join(&self.saving.scene);
        if !self.may_write(&path) {
            return;
        }
        let done = save::scene(&path, &self.session.document().text());
        if done.is_ok() {
            self.session.saved(path.clone());
            if let Ok(file) = self.session.document().parse() {
                self.watch_anew(&file);
            }
        }
        self.told(done.map(|()| format!("saved {}", path.display())));
    }

    fn told(&mut self, result: rilievo_io::Result<String>) {
        self.message = Some(result.unwrap_or_else(|e| e.to_string()));
    }
}
