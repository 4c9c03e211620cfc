//! [`Backend`]: what renders a pass.

use std::sync::atomic::AtomicBool;

use rilievo_render::{Film, RenderError, RenderOptions, Scene};

use crate::passes::Pass;

/// What renders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Backend {
    /// The processor, with so many threads; 0 takes one per processor.
    Cpu {
        /// Threads.
        threads: usize,
    },
}

impl Backend {
    /// Renders a scene that has the camera and the settings of the pass; `watch` sees the film on its way,
    /// `cancel` stops it within a row of a tile.
    ///
    /// # Errors
    /// As [`rilievo_render::render()`].
    pub fn render(
        self,
        scene: &Scene,
        pass: &Pass,
        watch: &(dyn Fn(&Film) + Sync),
        cancel: &AtomicBool,
    ) -> Result<Film, RenderError> {
        match self {
            Self::Cpu { threads } => {
                let options = RenderOptions {
                    threads,
                    pixel_centers: pass.centers,
                    aovs: &pass.layers,
                    watch,
                    cancel,
                    ..RenderOptions::default()
                };
                rilievo_render::render(scene, &options).map(|(film, _)| film)
            }
        }
    }
}
