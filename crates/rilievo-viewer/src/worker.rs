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
use rilievo_render::Film;

use crate::backend::Renderer;
use crate::passes::{Frame, Pass, passes};
use crate::session::Change;
use crate::studio::{Painting, Pick, Shown, Studio};

mod job;

pub use job::{Event, Job, Side};

/// How often a picture on its way is shown.
const PAUSE: Duration = Duration::from_millis(120);

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
    /// A GPU may be ready for what it was not before.
    woken: bool,
}

/// The thread, as the window sees it. It ends when this is dropped.
pub struct Worker {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl Worker {
    /// Starts the thread with what was read already and so many threads of the CPU (0: one per processor);
    /// `notify` is told of everything new, from the thread.
    pub fn start(
        studio: Studio,
        threads: usize,
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
            let waker = Arc::downgrade(&theirs);
            let wake = move || waker.upgrade().iter().for_each(|shared| shared.wake());
            let renderer = Renderer::new(threads, Some(Arc::new(wake)));
            let backend = String::new();
            Labour { shared: theirs, studio, renderer, backend, sides: [None, None] }.run();
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
    renderer: Renderer,
    /// What renders, as it was told last.
    backend: String,
    sides: [Option<Arc<Shown>>; 2],
}

impl Labour {
    fn run(mut self) {
        while let Some((job, since)) = self.wait() {
            self.work(&job, since);
        }
    }

    /// The next job; none when it is time to go.
    fn wait(&mut self) -> Option<(Job, Instant)> {
        let shared = Arc::clone(&self.shared);
        let mut inbox = lock(&shared.inbox);
        loop {
            if inbox.quit {
                return None;
            }
            if let Some(job) = inbox.job.take() {
                inbox.woken = false;
                shared.cancel.store(false, Ordering::Relaxed);
                return Some(job);
            }
            if std::mem::take(&mut inbox.woken) {
                // The picture is done; the next one is the GPU's.
                drop(inbox);
                self.prepare();
                inbox = lock(&shared.inbox);
                continue;
            }
            inbox = shared.bell.wait(inbox).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Brings what is shown to the GPU.
    fn prepare(&mut self) {
        for (side, shown) in self.sides.iter().enumerate() {
            if let Some(shown) = shown {
                self.renderer.bring_ahead(side, &shown.scene);
            }
        }
        self.tell_backend();
    }

    /// Whether what was stopped goes on: nothing else is wanted, but a GPU may take part in it now.
    fn goes_on(&self) -> bool {
        let mut inbox = lock(&self.shared.inbox);
        let goes_on = inbox.woken && inbox.job.is_none() && !inbox.quit;
        if goes_on {
            inbox.woken = false;
            self.shared.cancel.store(false, Ordering::Relaxed);
        }
        goes_on
    }

    fn work(&mut self, job: &Job, since: Instant) {
        self.renderer.choose(job.backend);
        let painted = !job.paintings.is_empty();
        if painted {
            self.paint(&job.paintings);
        }
        for side in 0..2 {
            let Some(wanted) = &job.sides[side] else {
                self.sides[side] = None;
                self.renderer.forget(side);
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
                while self.sides[side].is_some() && !self.pass(side, &pass, job, since) {
                    if !self.goes_on() {
                        return;
                    }
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
        self.renderer.let_go(&self.studio);
        let mut edits = Vec::new();
        let done = self.studio.paint(shown, paintings, &mut edits);
        self.renderer.take_back(&self.studio, &edits);
        if let Err(e) = done {
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
                self.renderer.loaded(side);
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
        let shared = Arc::clone(&self.shared);
        let watch = |film: &Film| {
            let (Some(coarser), mut last) = (&coarser, lock(&last_shown)) else { return };
            if last.elapsed() > PAUSE && !shared.cancel.load(Ordering::Relaxed) {
                *last = Instant::now();
                let frame = Arc::new(coarser.under(film));
                drop(last);
                shared.tell(|output| output.frames[side] = Some(frame));
            }
        };
        let scene = (side, &shown.scene);
        let film = self.renderer.render(scene, pass, &watch, &shared.cancel);
        if side == 0 {
            self.tell_backend();
        }
        if self.shared.cancel.load(Ordering::Relaxed) {
            return false;
        }
        match film {
            Ok((film, _)) => {
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

    /// Tells what renders, if that has changed.
    fn tell_backend(&mut self) {
        let (name, why) = (self.renderer.renders(0), self.renderer.take_why());
        if name != self.backend || why.is_some() {
            self.backend.clone_from(&name);
            self.event(Event::Backend { name, why });
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
    /// A GPU may be ready for what it was not before.
    fn wake(&self) {
        lock(&self.inbox).woken = true;
        self.cancel.store(true, Ordering::Relaxed);
        self.bell.notify_one();
    }

    fn tell(&self, change: impl FnOnce(&mut Output)) {
        change(&mut lock(&self.output));
        (self.notify)();
    }
}

/// The scene with the camera of the text at the resolution of a pass, and its settings.
fn aimed(mut shown: Shown, wanted: &Side, pass: &Pass) -> Option<Shown> {
    let camera = wanted.file.camera().ok()?.with_resolution(pass.size).ok()?;
    shown.scene = shown.scene.with_camera(camera).with_settings(pass.settings).ok()?;
    Some(shown)
}

/// A poisoned lock still guards what was put there whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
