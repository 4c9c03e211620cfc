//! [`Job`]: what the thread is asked to show; [`Event`]: what it tells.

use std::time::Duration;

use rilievo::relief::Method;
use rilievo_gpu::Backend;
use rilievo_io::scene::SceneFile;

use crate::backend::Why;
use crate::histogram::Histogram;
use crate::session::{Change, Facts, Look};
use crate::studio::Painting;

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
    /// What renders.
    pub backend: Backend,
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
    /// Something else renders the edited side than before, or the CPU in the place of a GPU.
    Backend {
        /// The name of a GPU, or "cpu".
        name: String,
        /// Why the CPU renders what a GPU was to.
        why: Option<Why>,
    },
    /// A side could not be loaded, or rendered, or the map not painted.
    Failed(String),
}
