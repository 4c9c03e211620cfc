//! [`Viewer`]: what the window holds, and its way once a frame.

use std::sync::Arc;
use std::time::{Duration, Instant};

use eframe::egui::{self, CentralPanel, Key, Modifiers, Panel, ScrollArea, ViewportCommand};
use rilievo_gpu::Backend;
use rilievo_io::Limits;
use rilievo_io::scene::SceneFile;
use rilievo_viewer::backend::Why;
use rilievo_viewer::histogram::Histogram;
use rilievo_viewer::session::{Action, Change, Session, Step};
use rilievo_viewer::studio::{Painting, Pick};
use rilievo_viewer::watch::{Changed, Watch};
use rilievo_viewer::worker::{Event, Job, Side, Worker};

use super::hand::{Brush, Hand, Other};
use super::picture::Uploaded;
use super::saving::Saving;
use super::{Opened, canvas, panels};
use crate::args::Arguments;
use crate::journal::Journal;

/// How often files are looked at.
const LOOK: Duration = Duration::from_millis(500);

/// Everything in the window.
pub struct Viewer {
    pub session: Session,
    pub worker: Worker,
    pub journal: Journal,
    pub hand: Hand,
    pub brush: Brush,
    pub other: Other,
    /// What is to render.
    pub backend: Backend,
    /// What renders: the name of a GPU, or "cpu".
    pub renders: String,
    /// Why the CPU renders what a GPU was to.
    pub why: Option<Why>,
    /// Where the wipe is, as a share of the width.
    pub wipe: f32,
    /// Whether it is being dragged.
    pub wiping: bool,
    pub sides: [Uploaded; 2],
    pub histogram: Option<Histogram>,
    pub pick: Option<Pick>,
    /// What was said last: of what was done, or of what could not be.
    pub message: Option<Result<String, String>>,
    pub notes: Vec<String>,
    pub saving: Saving,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// Whether the map was painted since it was saved.
    pub painted: bool,
    /// What is being rendered, in words.
    pub progress: String,
    watch: Watch,
    looked: Instant,
    serial: u64,
    /// The last job, when something failed: the message goes when a later one is loaded.
    failed: Option<u64>,
    /// Of the last job: what has to be made anew.
    change: Change,
    paintings: Vec<Painting>,
    opened: bool,
    /// About the largest depth that makes sense.
    depth_of_scene: f64,
}

impl Viewer {
    pub fn new(
        context: &egui::Context,
        arguments: Arguments,
        opened: Opened,
        journal: Journal,
    ) -> Self {
        let Opened { studio, file, bare, other } = opened;
        let session = Session::new(&file, bare, arguments.mesh);
        let other = match (arguments.compare_method, other) {
            (Some(method), _) => Other::Method(method),
            (None, Some((file, bare))) => {
                let other = Session::new(&file, bare, None);
                Other::Scene(Box::new(other.document().clone()))
            }
            (None, None) => Other::Nothing,
        };
        let notify = {
            let context = context.clone();
            move || context.request_repaint()
        };
        Self {
            saving: Saving::new(&session),
            session,
            worker: Worker::start(studio, arguments.threads, notify),
            backend: arguments.backend,
            renders: String::new(),
            why: None,
            journal,
            hand: Hand::Move,
            brush: Brush::default(),
            other,
            wipe: 0.5,
            wiping: false,
            sides: Default::default(),
            histogram: None,
            pick: None,
            message: None,
            notes: Vec::new(),
            size: [0, 0],
            painted: false,
            progress: String::new(),
            watch: Watch::new(&file),
            looked: Instant::now(),
            serial: 0,
            failed: None,
            change: Change::Scene,
            paintings: Vec::new(),
            opened: false,
            depth_of_scene: 0.25,
        }
    }

    /// Does something and remembers what has to be made anew.
    pub fn act(&mut self, action: Action) {
        let told = match &action {
            Action::Depth(depth) => Some(("depth", *depth)),
            Action::Zero(zero) => Some(("zero", *zero)),
            Action::Roughness(roughness) => Some(("roughness", *roughness)),
            _ => None,
        };
        let change = self.session.apply(action);
        if let Some((what, value)) = told.filter(|_| change != Change::None) {
            self.journal.changed(what, value);
        }
        self.need(change);
    }

    /// Something has to be made anew.
    pub fn need(&mut self, change: Change) {
        self.change = self.change.max(change);
    }

    /// Something is painted.
    pub fn paint(&mut self, painting: Painting) {
        self.paintings.push(painting);
        self.painted = true;
        self.need(Change::Rendered);
    }

    pub fn undo(&mut self) {
        let step = self.session.undo();
        self.stepped(step);
    }

    pub fn redo(&mut self) {
        let step = self.session.redo();
        self.stepped(step);
    }

    fn stepped(&mut self, step: Option<Step>) {
        match step {
            Some(Step::Text(_)) => self.need(Change::Scene),
            Some(Step::Stroke(stroke)) => self.paint(Painting::Swap(stroke)),
            None => {}
        }
    }

    /// Files of another scene are watched from now on.
    pub fn watch_anew(&mut self, file: &SceneFile) {
        self.watch = Watch::new(file);
    }

    /// Sends the worker what has changed.
    fn post(&mut self) {
        let change = std::mem::take(&mut self.change);
        if change < Change::Rendered || self.size.contains(&0) {
            self.change = if self.size.contains(&0) { change } else { Change::None };
            return;
        }
        let file = match self.session.document().parse() {
            Ok(file) => file,
            Err(e) => {
                self.message = Some(Err(e.to_string()));
                return;
            }
        };
        let other = match &mut self.other {
            Other::Nothing => None,
            Other::Method(method) => {
                Some(Side { file: file.clone(), method: Some(*method), change })
            }
            Other::Scene(document) => {
                document.set_camera(&self.session.camera);
                match document.parse() {
                    Ok(file) => Some(Side { file, method: None, change }),
                    Err(e) => {
                        self.message = Some(Err(e.to_string()));
                        None
                    }
                }
            }
        };
        self.serial += 1;
        self.worker.post(Job {
            serial: self.serial,
            sides: [Some(Side { file, method: None, change }), other],
            look: self.session.look,
            size: self.size,
            shape: self.session.shape().map_or(0, |shape| shape.index),
            paintings: std::mem::take(&mut self.paintings),
            backend: self.backend,
        });
    }

    /// Takes what the worker has done.
    fn poll(&mut self, context: &egui::Context) {
        let (frames, events) = self.worker.poll();
        for event in events {
            self.journal.event(&event);
            match event {
                Event::Loaded { serial, side: 0, facts, notes, .. } => {
                    if serial == self.serial {
                        self.session.learn(&facts);
                    }
                    let deepest = facts.displacements.iter().map(|(_, d)| d.scale.abs());
                    let deepest = deepest.fold(0.0, f64::max);
                    if deepest > self.depth_of_scene {
                        self.depth_of_scene = (2.0 * deepest).log2().ceil().exp2();
                    }
                    self.notes = notes;
                    if self.failed.is_some_and(|at| serial > at) {
                        (self.message, self.failed) = (None, None);
                    }
                }
                Event::Loaded { .. } => {}
                Event::Heights(histogram) => self.histogram = histogram,
                Event::Pass { side: 0, factor, since, .. } => {
                    self.progress = match factor {
                        1 => format!("rendering, {:.2} s", since.as_secs_f64()),
                        factor => format!("1/{factor}, {:.2} s", since.as_secs_f64()),
                    };
                }
                Event::Pass { .. } => {}
                Event::Done { since, .. } => {
                    self.progress = format!("done in {:.2} s", since.as_secs_f64());
                }
                Event::Backend { name, why } => {
                    self.renders = name;
                    if let Some(why) = why.as_ref().filter(|why| why.loud) {
                        self.message = Some(Err(why.text.clone()));
                    }
                    self.why = why;
                }
                Event::Failed(why) => {
                    self.message = Some(Err(why));
                    self.failed = Some(self.serial);
                }
            }
        }
        let map = self.session.tone_map;
        for (uploaded, frame) in self.sides.iter_mut().zip(&frames) {
            if uploaded.show(context, frame.as_ref(), map) {
                self.journal.drawn(self.serial);
            }
        }
    }

    /// Looks whether files have changed on the disk.
    fn look_at_files(&mut self, context: &egui::Context) {
        context.request_repaint_after(LOOK);
        if self.looked.elapsed() < LOOK {
            return;
        }
        self.looked = Instant::now();
        match self.watch.look() {
            Some(Changed::Scene) if !self.session.bare => {
                match SceneFile::read(self.session.document().path(), &Limits::default()) {
                    Ok(file) if file.text() == self.session.document().text() => {}
                    Ok(_) if self.session.unsaved => {
                        let why = "the scene file has changed; what was edited here is kept";
                        self.message = Some(Err(why.to_owned()));
                    }
                    Ok(file) => {
                        self.session.reload(&file);
                        self.watch_anew(&file);
                        self.need(Change::Scene);
                    }
                    Err(e) => self.message = Some(Err(e.to_string())),
                }
            }
            Some(_) => self.need(Change::Scene),
            None => {}
        }
    }

    fn keys(&mut self, ui: &egui::Ui) {
        if ui.input_mut(|input| input.consume_key(Modifiers::COMMAND, Key::Q)) {
            ui.ctx().send_viewport_cmd(ViewportCommand::Close);
        }
        if ui.ctx().egui_wants_keyboard_input() {
            return;
        }
        let pressed = |modifiers: Modifiers, key: Key| {
            ui.input_mut(|input| input.consume_key(modifiers, key))
        };
        if pressed(Modifiers::COMMAND, Key::Z) {
            self.undo();
        }
        if pressed(Modifiers::COMMAND, Key::Y) {
            self.redo();
        }
        if pressed(Modifiers::COMMAND, Key::S) {
            self.save_scene();
        }
        for (key, hand) in [Key::Num1, Key::Num2, Key::Num3].into_iter().zip(Hand::ALL) {
            if pressed(Modifiers::NONE, key) {
                self.hand = hand;
            }
        }
    }

    /// The histogram is that of another shape from now on.
    pub fn histogram_anew(&mut self) {
        let shape = self.session.shape().map_or(0, |shape| shape.index);
        self.histogram = self.worker.with_shown(|shown| shown.histogram(shape)).flatten();
    }

    /// Where the slider of the depth ends: half the extent of the scene, or beyond what is there.
    pub fn deepest(&self) -> f64 {
        let depth = self.session.shape().map_or(0.0, |shape| shape.displacement.scale.abs());
        // Steps of two, so that the slider stays where it is while it is dragged.
        let most = self.depth_of_scene.max(0.25);
        if depth <= most { most } else { (depth.log2().ceil()).exp2() }
    }

    /// The frame that is shown on the edited side.
    pub fn frame(&self) -> Option<&Arc<rilievo_viewer::passes::Frame>> {
        self.sides[0].frame()
    }
}

impl eframe::App for Viewer {
    fn ui(&mut self, ui: &mut egui::Ui, _frame: &mut eframe::Frame) {
        let context = ui.ctx().clone();
        if !self.opened {
            self.opened = true;
            self.journal.opened();
        }
        self.poll(&context);
        self.look_at_files(&context);
        self.keys(ui);
        self.close(ui);
        Panel::bottom("status").show(ui, |ui| panels::status(self, ui));
        Panel::left("controls").exact_size(290.0).resizable(false).show(ui, |ui| {
            ScrollArea::vertical().show(ui, |ui| panels::controls(self, ui));
        });
        CentralPanel::default().show(ui, |ui| canvas::show(self, ui));
        if context.input(|input| input.pointer.any_released()) {
            self.session.settle();
        }
        self.post();
    }
}
