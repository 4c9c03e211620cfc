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

use std::sync::atomic::AtomicBool;

use crate::film::{Aov, Film, FilmError, Layer, Tile};
use crate::integrator::{Integrator, RayCounts};
use crate::pass::{Passes, Shared, Tiles};
use crate::scene::Scene;
use crate::tracer::Tracer;

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
    /// What traces all rays in place of the CPU's threads; nothing by default. Not asked where the scene has
    /// levels of detail.
    pub tracer: Option<&'a dyn Tracer>,
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
            tracer: None,
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
    /// What was to trace the rays could not.
    #[error("{0}")]
    Tracer(String),
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
    let shared = Shared::new(film);
    pool.install(|| pass.all(&shared))?;
    let (film, rays) = shared.into_parts();
    let refused = film
        .sums()
        .map_or(0, |sums| sums.counts().iter().map(|counts| u64::from(counts.refused)).sum());
    let complete = film.is_complete();
    Ok((film, RenderStats { rays, refused, complete }))
}
