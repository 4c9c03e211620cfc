//! [`render()`]: tiles over threads, in passes over the image; progress, cancellation.
//!
//! Every number of a pixel is a function of scene, seed, pixel and sample index alone, and a tile is
//! copied into the film whole; so the film's bytes do not depend on the number of threads or their
//! timing.
//!
//! Integrators that are sums of independent paths ([`Integrator::sums`]) go over the image again and
//! again, up to 1, 4, 16, 64 and then every 64 samples a pixel, so that a render that is stopped
//! leaves the whole image at fewer samples. Sums are exact, so such a film may be stopped, kept,
//! continued ([`resume`]), split by samples and by windows and joined ([`crate::film::join()`]): the
//! result is that of one run, bit for bit. The paper's integrator divides its strata among all
//! samples of a pixel and adds in floating point, in order; it takes all samples of a pixel at once
//! and can be stopped, continued, split and joined by whole pixels.
//!
//! With `max_error` a tile of 16 x 16 pixels takes no more samples once the root mean square of its
//! pixels' standard errors is at most so large a share of that of their values, each counted as no
//! darker than [`FLOOR`]. The question is asked at 64 samples and then each time their number has
//! doubled, and answered by the tile's own sums, so the answer does not depend on threads, stops and
//! windows (which therefore must not cut tiles). Asking few times keeps the bias small that stopping
//! at lucky moments brings: what stops has on average seen slightly too few bright paths.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::film::{Aov, Film, FilmError, Layer, Tile};
use crate::integrator::{Integrator, PixelTracer, RayCounts};
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
    /// The pixels to render; all of them by default.
    pub crop: Option<Tile>,
    /// The samples to take, from the first of two absolute indices up to the second; all of the
    /// scene's by default.
    pub samples: Option<[u32; 2]>,
    /// Relative error at which a tile has samples enough; none by default.
    pub max_error: Option<f64>,
    /// Told (camera rays done, camera rays in all) after every tile, from any thread.
    pub progress: &'a (dyn Fn(u64, u64) + Sync),
    /// Shown the film as it stands after every tile, from any thread; nobody else writes meanwhile.
    pub watch: &'a (dyn Fn(&Film) + Sync),
    /// Set it to stop: finished tiles stay, the others are left as they were before the pass.
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
            crop: None,
            samples: None,
            max_error: None,
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
    /// Samples left out because they were not finite or too large, those of earlier runs included.
    pub refused: u64,
    /// Whether every pixel was finished.
    pub complete: bool,
}

/// Why nothing was rendered.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum RenderError {
    /// The image does not fit the memory.
    #[error(transparent)]
    Film(#[from] FilmError),
    /// A window that is empty or not in the image.
    #[error("the window {window:?} does not lie in an image of {resolution:?} pixels")]
    Window {
        /// The window.
        window: Tile,
        /// Pixels of the image.
        resolution: [u32; 2],
    },
    /// A window that cuts a tile, whose samples end together.
    #[error(
        "with a maximal error, windows begin and end at multiples of {TILE} pixels or the border"
    )]
    CutTile,
    /// Samples that are none or not among those of a pixel.
    #[error("samples {first} to {end} are not among the {samples} of a pixel")]
    Samples {
        /// The first.
        first: u32,
        /// The first not to be taken.
        end: u32,
        /// Samples of a pixel.
        samples: u32,
    },
    /// A maximal error that is no positive number, or one with part of the samples.
    #[error("a maximal error is a positive number and takes samples from the first on")]
    MaxError,
    /// The integrator takes all samples of a pixel at once.
    #[error("the integrator {integrator} takes all samples of a pixel at once")]
    AtOnce {
        /// The integrator.
        integrator: Integrator,
    },
    /// The film to be continued is one of another render.
    #[error("the film is one of another render")]
    OtherFilm,
    /// A part of a texture could not be read when it was needed.
    #[error("a texture could not be read: {0}")]
    Texture(String),
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

/// Radiance below which errors are weighed as if it were so bright.
pub const FLOOR: f64 = 0.01;

/// Samples at which a tile is first asked for its error.
const FIRST_QUESTION: u32 = 64;

/// Renders `scene`.
///
/// # Errors
/// [`RenderError`] if the options do not fit the scene or each other, the image does not fit the
/// memory, or threads cannot be started.
pub fn render(
    scene: &Scene,
    options: &RenderOptions<'_>,
) -> Result<(Film, RenderStats), RenderError> {
    resume(scene, options, begin(scene, options)?)
}

/// The film of a render of which nothing is done.
///
/// # Errors
/// [`RenderError`] if the options do not fit the scene or each other, or the image does not fit the
/// memory.
pub fn begin(scene: &Scene, options: &RenderOptions<'_>) -> Result<Film, RenderError> {
    let (window, samples) = check(scene, options)?;
    Ok(Film::of_window(window, samples, options.aovs, scene.settings().integrator.sums())?)
}

/// The pixels and samples that a render will take.
///
/// # Errors
/// [`RenderError`] if the options do not fit the scene or each other.
pub fn check(scene: &Scene, options: &RenderOptions<'_>) -> Result<(Tile, [u32; 2]), RenderError> {
    let resolution = scene.camera().resolution();
    let settings = scene.settings();
    let window = options.crop.unwrap_or(Tile::whole(resolution));
    if !window.lies_in(resolution) {
        return Err(RenderError::Window { window, resolution });
    }
    let samples = if options.pixel_centers { 1 } else { settings.samples };
    let [first, end] = options.samples.unwrap_or([0, samples]);
    if first >= end || end > samples {
        return Err(RenderError::Samples { first, end, samples });
    }
    let integrator = settings.integrator;
    let part = [first, end] != [0, samples];
    if !integrator.sums() && (part || options.max_error.is_some()) {
        return Err(RenderError::AtOnce { integrator });
    }
    if let Some(error) = options.max_error {
        if part || !error.is_finite() || error <= 0.0 {
            return Err(RenderError::MaxError);
        }
        let whole = |at: u32, most: u32| at == most || at.is_multiple_of(TILE);
        let ends = [window.corner, window.end()];
        if !ends.iter().all(|p| (0..2).all(|axis| whole(p[axis], resolution[axis]))) {
            return Err(RenderError::CutTile);
        }
    }
    Ok((window, [first, end]))
}

/// Goes on with a film of the same render, as [`begin`] or a stopped render left it. A film of which
/// nothing is left to do comes back as it is.
///
/// # Errors
/// [`RenderError`] if the film is not one of this scene and these options as far as can be told, or
/// threads cannot be started.
pub fn resume(
    scene: &Scene,
    options: &RenderOptions<'_>,
    film: Film,
) -> Result<(Film, RenderStats), RenderError> {
    let (window, samples) = check(scene, options)?;
    let sums = scene.settings().integrator.sums();
    let blank = Film::of_window(Tile { size: [1, 1], ..window }, samples, options.aovs, sums)?;
    let layers = |film: &Film| film.layers().iter().map(Layer::aov).collect::<Vec<Aov>>();
    if (film.window(), film.samples(), film.sums().is_some()) != (window, samples, sums)
        || layers(&film) != layers(&blank)
    {
        return Err(RenderError::OtherFilm);
    }
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(thread_count(options.threads))
        .build()
        .map_err(|e| RenderError::Threads {
        threads: options.threads,
        reason: e.to_string(),
    })?;
    let [first, end] = film.samples();
    let pass = Passes { scene, options, tiles: Tiles::of(film.window()), samples: end - first };
    let shared = Shared {
        done: AtomicU64::new(film.rays_done()),
        film: Mutex::new(film),
        rays: Mutex::new(RayCounts::default()),
    };
    pool.install(|| pass.all(&shared))?;
    let film = into_inner(shared.film);
    let refused = film
        .sums()
        .map_or(0, |sums| sums.counts().iter().map(|counts| u64::from(counts.refused)).sum());
    let (rays, complete) = (into_inner(shared.rays), film.is_complete());
    Ok((film, RenderStats { rays, refused, complete }))
}

/// What all threads write to.
struct Shared {
    film: Mutex<Film>,
    rays: Mutex<RayCounts>,
    done: AtomicU64,
}

/// The tiles of a window: those of the whole image, cut by the window's border.
struct Tiles {
    window: Tile,
    /// First tile along x and y.
    first: [u32; 2],
    /// Tiles along x and y: at most 4096 each, see `Camera::MAX_RESOLUTION`.
    count: [u32; 2],
}

impl Tiles {
    fn of(window: Tile) -> Self {
        let first = window.corner.map(|at| at / TILE);
        let count = [0, 1].map(|axis| window.end()[axis].div_ceil(TILE) - first[axis]);
        Self { window, first, count }
    }

    fn len(&self) -> u32 {
        self.count[0] * self.count[1]
    }

    /// A tile, in pixels of the window.
    fn get(&self, index: u32) -> Tile {
        let place = [index % self.count[0], index / self.count[0]];
        let bound = |axis: usize, after: u32| {
            let at = (self.first[axis] + place[axis] + after) * TILE;
            at.clamp(self.window.corner[axis], self.window.end()[axis]) - self.window.corner[axis]
        };
        let corner = [bound(0, 0), bound(1, 0)];
        Tile { corner, size: [bound(0, 1) - corner[0], bound(1, 1) - corner[1]] }
    }
}

/// Passes over the tiles of a film.
struct Passes<'a> {
    scene: &'a Scene,
    options: &'a RenderOptions<'a>,
    tiles: Tiles,
    /// Samples a pixel.
    samples: u32,
}

impl Passes<'_> {
    fn all(&self, shared: &Shared) -> Result<(), RenderError> {
        let sums = self.scene.settings().integrator.sums();
        let mut end = if sums { 1 } else { self.samples };
        loop {
            let up_to = end.min(self.samples);
            (0..self.tiles.len())
                .into_par_iter()
                .with_max_len(1)
                .try_for_each(|index| self.visit(self.tiles.get(index), up_to, shared))?;
            if up_to == self.samples || self.cancelled() {
                return Ok(());
            }
            end = if end < FIRST_QUESTION { 4 * end } else { end + FIRST_QUESTION };
        }
    }

    fn cancelled(&self) -> bool {
        self.options.cancel.load(Ordering::Relaxed)
    }

    /// Takes the samples of a tile up to `end` of the range and puts it back into the film, unless
    /// cancelled before its last row.
    fn visit(&self, tile: Tile, end: u32, shared: &Shared) -> Result<(), RenderError> {
        let Some((mut pixels, taken)) = lock(&shared.film).part(tile, end)? else {
            return Ok(());
        };
        let film_corner = self.tiles.window.corner;
        let first = pixels.samples()[0];
        let mut tracer = PixelTracer::new(self.scene, self.options.pixel_centers);
        for y in 0..tile.size[1] {
            if self.cancelled() {
                return Ok(());
            }
            for x in 0..tile.size[0] {
                let place = [tile.corner[0] + x, tile.corner[1] + y];
                let pixel = [0, 1].map(|axis| film_corner[axis] + place[axis]);
                match pixels.pixel_sums(x, y) {
                    Some(mut sums) => {
                        tracer.extend(pixel, [first + taken, first + end], &mut sums);
                    }
                    None => tracer.trace(pixel, &mut pixels.pixel_mut(x, y)),
                }
            }
        }
        if let Some(reason) = self.scene.texture_failure() {
            return Err(RenderError::Texture(reason.to_owned()));
        }
        pixels.store_sums();
        let enough = end == self.samples || self.is_good_enough(&pixels, end);
        pixels.set_finished(enough);
        let area = u64::from(tile.size[0]) * u64::from(tile.size[1]);
        let step = area * u64::from(if enough { self.samples - taken } else { end - taken });
        {
            let mut film = lock(&shared.film);
            film.insert(tile, &pixels);
            (self.options.watch)(&film);
        }
        *lock(&shared.rays) += tracer.rays();
        let done = shared.done.fetch_add(step, Ordering::Relaxed) + step;
        let [width, height] = self.tiles.window.size.map(u64::from);
        (self.options.progress)(done, width * height * u64::from(self.samples));
        Ok(())
    }

    /// Whether a tile may stop at so many samples.
    fn is_good_enough(&self, pixels: &Film, taken: u32) -> bool {
        let asked = taken >= FIRST_QUESTION && taken.is_power_of_two();
        match (self.options.max_error, pixels.sums()) {
            (Some(most), Some(sums)) if asked => sums.relative_error(FLOOR) <= most,
            _ => false,
        }
    }
}

/// A poisoned lock still guards a film of whole tiles.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

fn into_inner<T>(mutex: Mutex<T>) -> T {
    mutex.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_cover_a_window_once_on_the_grid_of_the_image() {
        for window in [
            Tile { corner: [0, 0], size: [1, 1] },
            Tile { corner: [0, 0], size: [40, 16] },
            Tile { corner: [5, 30], size: [30, 3] },
            Tile { corner: [16, 31], size: [16, 34] },
        ] {
            let tiles = Tiles::of(window);
            let mut seen = vec![0; (window.size[0] * window.size[1]) as usize];
            for tile in (0..tiles.len()).map(|index| tiles.get(index)) {
                for axis in 0..2 {
                    let start = tile.corner[axis] + window.corner[axis];
                    assert!(start == window.corner[axis] || start.is_multiple_of(TILE));
                    assert!(tile.size[axis] > 0 && start % TILE + tile.size[axis] <= TILE);
                }
                for y in tile.corner[1]..tile.end()[1] {
                    for x in tile.corner[0]..tile.end()[0] {
                        seen[(y * window.size[0] + x) as usize] += 1;
                    }
                }
            }
            assert!(seen.iter().all(|&times| times == 1), "{window:?}");
        }
    }
}
