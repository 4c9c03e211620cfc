//! [`Worker`]: the thread that loads, paints and renders, so that the window never waits.
//!
//! There is one job at a time. A new one goes before what is going on: the render stops within a row
//! of a tile, jobs that were not begun are merged ([`Job::merge`]), and the picture starts anew from its coarsest
//! pass. What comes out lies in [`Output`], the latest picture of each side and a list of events.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use glam::DVec2;
use rilievo::relief::Method;
use rilievo_io::scene::SceneFile;
use rilievo_render::{Film, Scene};

use crate::backend::Backend;
use crate::histogram::Histogram;
use crate::passes::{Frame, Pass, passes};
use crate::session::{Change, Facts, Look};
use crate::studio::{Painting, Pick, Shown, Studio};

/// How often a picture on its way is shown.
const PAUSE: Duration = Duration::from_millis(120);

/// What is shown on one side.
#[derive(Clone, Debug)]
pub struct Side {
    /// The scene.
    pub file: SceneFile,
    /// Walks every relief in place of its own method.
    pub method: Option<Method>,
    /// What has to be made anew.
    pub change: Change,
}

/// What is to be shown.
#[derive(Clone, Debug)]
pub struct Job {
    /// Counts up; events tell which job they are of.
    pub serial: u64,
    /// What is edited, and what it is compared with.
    pub sides: [Option<Side>; 2],
    /// What of the films is shown.
    pub look: Look,
    /// Pixels of the picture.
    pub size: [u32; 2],
    /// The shape whose histogram is shown.
    pub shape: usize,
    /// What is painted first, in order.
    pub paintings: Vec<Painting>,
}

impl Job {
    /// This job in place of one that was not begun: nothing that one asked for is lost.
    #[must_use]
    pub fn merge(mut self, older: Self) -> Self {
        for (side, old) in self.sides.iter_mut().zip(older.sides) {
            if let (Some(side), Some(old)) = (side, old) {
                side.change = side.change.max(old.change);
            }
        }
        let newer = std::mem::replace(&mut self.paintings, older.paintings);
        self.paintings.extend(newer);
        self
    }
}

/// What happened, in order.
#[derive(Clone, Debug)]
pub enum Event {
    /// A side was loaded.
    Loaded {
        /// The job.
        serial: u64,
        /// 0 or 1.
        side: usize,
        /// What its text need not say.
        facts: Box<Facts>,
        /// What loading had to say.
        notes: Vec<String>,
        /// How long it took.
        took: Duration,
    },
    /// The heights of the shape of the job.
    Heights(Option<Histogram>),
    /// A pass is done and its picture is there.
    Pass {
        /// The job.
        serial: u64,
        /// 0 or 1.
        side: usize,
        /// The factor of the pass.
        factor: u32,
        /// Since the job was posted.
        since: Duration,
    },
    /// Nothing is left to do.
    Done {
        /// The job.
        serial: u64,
        /// Since the job was posted.
        since: Duration,
    },
    /// A side could not be loaded, or rendered, or the map not painted.
    Failed(String),
}

/// What came out.
#[derive(Debug, Default)]
pub struct Output {
    /// The latest picture of each side.
    pub frames: [Option<Arc<Frame>>; 2],
    /// What happened since it was last asked.
    pub events: Vec<Event>,
    shown: Option<Arc<Shown>>,
}

/// What the two threads share.
struct Shared {
    inbox: Mutex<Inbox>,
    bell: Condvar,
    /// Stops the render that is going on.
    cancel: AtomicBool,
    output: Mutex<Output>,
    /// Told that there is something new in the output.
    notify: Box<dyn Fn() + Send + Sync>,
}

#[derive(Default)]
struct Inbox {
    job: Option<(Job, Instant)>,
    quit: bool,
}

/// The thread, as the window sees it. It ends when this is dropped.
pub struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread with what was read already; `notify` is told of everything new, from the thread.
    pub fn start(
        studio: Studio,
        backend: Backend,
        notify: impl Fn() + Send + Sync + 'static,
    ) -> Self {
        let shared = Arc::new(Shared {
            inbox: Mutex::default(),
            bell: Condvar::new(),
            cancel: AtomicBool::new(false),
            output: Mutex::default(),
            notify: Box::new(notify),
        });
        let theirs = Arc::clone(&shared);
        let thread = std::thread::spawn(move || {
            Labour { shared: theirs, studio, backend, sides: [None, None] }.run();
        });
        Self { shared, thread: Some(thread) }
    }

    /// Shows something else from now on.
    pub fn post(&self, job: Job) {
        let mut inbox = lock(&self.shared.inbox);
        let (job, since) = match inbox.job.take() {
            Some((older, since)) => (job.merge(older), since),
            None => (job, Instant::now()),
        };
        inbox.job = Some((job, since));
        self.shared.cancel.store(true, Ordering::Relaxed);
        self.shared.bell.notify_one();
    }

    /// The latest pictures, and what happened since this was last called.
    pub fn poll(&self) -> ([Option<Arc<Frame>>; 2], Vec<Event>) {
        let mut output = lock(&self.shared.output);
        (output.frames.clone(), std::mem::take(&mut output.events))
    }

    /// What lies under a point of the picture, 0 to 1 to the right and down, as it was last loaded.
    pub fn pick(&self, at: DVec2) -> Option<Pick> {
        lock(&self.shared.output).shown.as_ref()?.pick(at)
    }

    /// Does something with the scene that was last loaded, if there is one.
    pub fn with_shown<T>(&self, look: impl FnOnce(&Shown) -> T) -> Option<T> {
        // The lock is held: the thread may not find the scene in use when it wants to paint.
        lock(&self.shared.output).shown.as_deref().map(look)
    }
}

impl Drop for Worker {
    fn drop(&mut self) {
        lock(&self.shared.inbox).quit = true;
        self.shared.cancel.store(true, Ordering::Relaxed);
        self.shared.bell.notify_one();
        if let Some(thread) = self.thread.take() {
            // A panic there was told on stderr already.
            let _ = thread.join();
        }
    }
}

/// The thread, as it sees itself.
struct Labour {
    shared: Arc<Shared>,
    studio: Studio,
    backend: Backend,
    sides: [Option<Arc<Shown>>; 2],
}

impl Labour {
    fn run(mut self) {
        while let Some((job, since)) = self.wait() {
            self.work(&job, since);
        }
    }

    /// The next job; none when it is time to go.
    fn wait(&self) -> Option<(Job, Instant)> {
        let mut inbox = lock(&self.shared.inbox);
        loop {
            if inbox.quit {
                return None;
            }
            if let Some(job) = inbox.job.take() {
                self.shared.cancel.store(false, Ordering::Relaxed);
                return Some(job);
            }
            inbox = self.shared.bell.wait(inbox).unwrap_or_else(PoisonError::into_inner);
        }
    }

    fn work(&mut self, job: &Job, since: Instant) {
        let painted = !job.paintings.is_empty();
        if painted {
            self.paint(&job.paintings);
        }
        for side in 0..2 {
            let Some(wanted) = &job.sides[side] else {
                self.sides[side] = None;
                self.tell(|output| output.frames[side] = None);
                continue;
            };
            if self.sides[side].is_none() || painted || wanted.change >= Change::Scene {
                self.load(side, wanted, job);
            }
        }
        let Some(settings) = self.sides[0].as_ref().map(|shown| shown.settings) else {
            return;
        };
        for pass in passes(job.size, &settings, job.look) {
            for side in 0..2 {
                if self.sides[side].is_some() && !self.pass(side, &pass, job, since) {
                    return;
                }
            }
        }
        self.event(Event::Done { serial: job.serial, since: since.elapsed() });
    }

    /// Takes the scenes apart, so that heights are changed in place.
    fn paint(&mut self, paintings: &[Painting]) {
        self.tell(|output| output.shown = None);
        self.sides[1] = None;
        let shown = self.sides[0].take().and_then(Arc::into_inner);
        if let Err(e) = self.studio.paint(shown, paintings) {
            self.event(Event::Failed(e.to_string()));
        }
    }

    fn load(&mut self, side: usize, wanted: &Side, job: &Job) {
        let begin = Instant::now();
        match self.studio.load(&wanted.file, wanted.method) {
            Ok(mut shown) => {
                let facts = Box::new(shown.facts());
                let notes = std::mem::take(&mut shown.notes);
                let heights = (side == 0).then(|| shown.histogram(job.shape));
                self.sides[side] = Some(Arc::new(shown));
                let took = begin.elapsed();
                self.event(Event::Loaded { serial: job.serial, side, facts, notes, took });
                if let Some(heights) = heights {
                    self.event(Event::Heights(heights));
                }
            }
            Err(e) => self.event(Event::Failed(e.to_string())),
        }
    }

    /// Renders a pass of one side and shows it; `false` if there is something else to do.
    fn pass(&mut self, side: usize, pass: &Pass, job: &Job, since: Instant) -> bool {
        if side == 0 {
            // What is picked from is not to be in two places while it is changed.
            self.tell(|output| output.shown = None);
        }
        let (Some(shown), Some(wanted)) = (self.sides[side].take(), &job.sides[side]) else {
            return true;
        };
        let Some(shown) = Arc::into_inner(shown).and_then(|shown| aimed(shown, wanted, pass))
        else {
            self.event(Event::Failed("the camera or the settings cannot be used".to_owned()));
            return false;
        };
        let shown = Arc::new(shown);
        self.sides[side] = Some(Arc::clone(&shown));
        if side == 0 {
            self.tell(|output| output.shown = Some(Arc::clone(&shown)));
        }
        let coarser = lock(&self.shared.output).frames[side].clone();
        // The first pass lies over nothing: what is there shows something else.
        let coarser = coarser.filter(|_| pass.factor == 1);
        let last_shown = Mutex::new(Instant::now());
        let shared = self.shared.as_ref();
        let watch = |film: &Film| {
            let (Some(coarser), mut last) = (&coarser, lock(&last_shown)) else { return };
            if last.elapsed() > PAUSE && !shared.cancel.load(Ordering::Relaxed) {
                *last = Instant::now();
                let frame = Arc::new(coarser.under(film));
                drop(last);
                shared.tell(|output| output.frames[side] = Some(frame));
            }
        };
        let film = self.backend.render(&shown.scene, pass, &watch, &self.shared.cancel);
        if self.shared.cancel.load(Ordering::Relaxed) {
            return false;
        }
        match film {
            Ok(film) => {
                let frame = Arc::new(Frame::of(&film, job.look, pass));
                self.tell(|output| output.frames[side] = Some(frame));
                let (serial, factor) = (job.serial, pass.factor);
                self.event(Event::Pass { serial, side, factor, since: since.elapsed() });
                true
            }
            Err(e) => {
                self.event(Event::Failed(e.to_string()));
                false
            }
        }
    }

    fn event(&self, event: Event) {
        self.tell(|output| output.events.push(event));
    }

    fn tell(&self, change: impl FnOnce(&mut Output)) {
        self.shared.tell(change);
    }
}

impl Shared {
    fn tell(&self, change: impl FnOnce(&mut Output)) {
        change(&mut lock(&self.output));
        (self.notify)();
    }
}

/// The scene with the camera of the text at the resolution of a pass, and its settings.
fn aimed(shown: Shown, wanted: &Side, pass: &Pass) -> Option<Shown> {
    let camera = wanted.file.camera().ok()?.with_resolution(pass.size).ok()?;
    let scene: Scene = shown.scene.with_camera(camera).with_settings(pass.settings).ok()?;
    Some(Shown { scene, ..shown })
}

/// A poisoned lock still guards what was put there whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
