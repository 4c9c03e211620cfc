//! [`render()`]: tiles over threads, progress, cancellation.
//!
//! Every number of a pixel is a function of scene, seed and pixel alone, and a tile is copied into
//! the film whole; so the film's bytes do not depend on the number of threads or their timing.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::film::{Aov, Film, FilmError, Tile};
use crate::integrator::{PixelTracer, RayCounts};
use crate::scene::Scene;

/// How to render, beyond what the scene says.
#[derive(Clone, Copy)]
pub struct RenderOptions<'a> {
    /// Threads; 0 takes one per processor.
    pub threads: usize,
    /// One ray through the centre of each pixel, no jitter, no filter, whatever `samples` says.
    pub pixel_centers: bool,
    /// Layers to keep beside the colour.
    pub aovs: &'a [Aov],
    /// Told (pixels done, pixels in all) after every tile, from any thread.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
    /// Shown the film as it stands after every tile, from any thread; nobody else writes meanwhile.
    pub watch: &'a (dyn Fn(&Film) + Sync),
    /// Set it to stop: finished tiles stay, the others are left unfinished.
    pub cancel: &'a AtomicBool,
}

/// Never set.
static NO_CANCEL: AtomicBool = AtomicBool::new(false);

impl Default for RenderOptions<'_> {
    /// All processors, jittered samples, no layers, nobody told, no stopping.
    fn default() -> Self {
        Self {
            threads: 0,
            pixel_centers: false,
            aovs: &[],
            progress: &|_, _| {},
            watch: &|_| {},
            cancel: &NO_CANCEL,
        }
    }
}

/// What a render did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct RenderStats {
    /// Rays traced, by kind.
    pub rays: RayCounts,
    /// Whether every pixel was finished.
    pub complete: bool,
}

/// Why nothing was rendered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// The image does not fit the memory.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// The threads could not be started.
    #[error("could not start {threads} threads: {reason}")]
    Threads {
        /// Threads asked for.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

/// Pixels along a side of a tile.
pub(crate) const TILE: u32 = 16;

/// The number of threads that `threads` asks for: itself, or one per processor for 0.
pub(crate) fn thread_count(threads: usize) -> usize {
    match threads {
        0 => std::thread::available_parallelism().map_or(1, std::num::NonZero::get),
        n => n,
    }
}

/// Renders `scene`.
///
/// # Errors
/// [`RenderError`] if the image does not fit the memory or threads cannot be started.
pub fn render(
    scene: &Scene,
    options: &RenderOptions<'_>,
) -> Result<(Film, RenderStats), RenderError> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(thread_count(options.threads))
        .build()
        .map_err(|e| RenderError::Threads {
        threads: options.threads,
        reason: e.to_string(),
    })?;
    let resolution = scene.camera().resolution();
    let shared = Shared {
        film: Mutex::new(Film::new(resolution, options.aovs)?),
        rays: Mutex::new(RayCounts::default()),
        done: AtomicU64::new(0),
    };
    // At most 4096 x 4096 tiles: see `Camera::MAX_RESOLUTION`.
    let columns = resolution[0].div_ceil(TILE);
    let tiles = columns * resolution[1].div_ceil(TILE);
    pool.install(|| {
        (0..tiles).into_par_iter().with_max_len(1).try_for_each(|index| {
            let corner = [index % columns * TILE, index / columns * TILE];
            let size = [0, 1].map(|axis| TILE.min(resolution[axis] - corner[axis]));
            render_tile(scene, options, Tile { corner, size }, &shared)
        })
    })?;
    let film = into_inner(shared.film);
    let stats = RenderStats { rays: into_inner(shared.rays), complete: film.is_complete() };
    Ok((film, stats))
}

/// What all threads write to.
struct Shared {
    film: Mutex<Film>,
    rays: Mutex<RayCounts>,
    done: AtomicU64,
}

/// Renders one tile and copies it into the film, unless cancelled before its last row.
fn render_tile(
    scene: &Scene,
    options: &RenderOptions<'_>,
    tile: Tile,
    shared: &Shared,
) -> Result<(), RenderError> {
    let mut pixels = Film::new(tile.size, options.aovs)?;
    let mut tracer = PixelTracer::new(scene, options.pixel_centers);
    for y in 0..tile.size[1] {
        if options.cancel.load(Ordering::Relaxed) {
            return Ok(());
        }
        for x in 0..tile.size[0] {
            let pixel = [tile.corner[0] + x, tile.corner[1] + y];
            tracer.trace(pixel, &mut pixels.pixel_mut(x, y));
        }
    }
    {
        let mut film = lock(&shared.film);
        film.insert(tile, &pixels);
        (options.watch)(&film);
    }
    *lock(&shared.rays) += tracer.rays();
    let area = u64::from(tile.size[0]) * u64::from(tile.size[1]);
    let done = shared.done.fetch_add(area, Ordering::Relaxed) + area;
    let [width, height] = scene.camera().resolution().map(u64::from);
    (options.progress)(done, width * height);
    Ok(())
}

/// A poisoned lock still guards a film of whole tiles.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn into_inner<T>(mutex: Mutex<T>) -> T {
    mutex.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}
