//! `rilievo render`: a scene to a picture.

use rilievo_render::{Film, RayCounts, RenderOptions, RenderStats, Tracer};
use serde::Serialize;

use crate::args::RenderArgs;
use crate::args::value::PictureFormat;
use crate::backend::{self, Device};
use crate::checkpoint::{self, Before, Checkpoints};
use crate::interrupt::Interrupt;
use crate::job::RenderJob;
use crate::live::LiveView;
use crate::memory::peak_rss_bytes;
use crate::outcome::{Failure, Outcome};
use crate::progress::Progress;
use crate::report;
use crate::stopwatch::Stopwatch;

/// The JSON object.
#[derive(Serialize)]
struct Report {
    /// Reading the scene and its files, building what its methods need.
    build_seconds: f64,
    /// Processor time of all threads; null where the system does not tell.
    build_cpu_seconds: Option<f64>,
    render_seconds: f64,
    render_cpu_seconds: Option<f64>,
    rays: Rays,
    /// Height maps and colour images.
    map_bytes: u64,
    /// What was derived from height maps to trace or shade them.
    bounds_bytes: u64,
    /// Coarser maps for level of detail, with all that belongs to them.
    level_bytes: u64,
    /// Peak memory as `rilievo info` predicts it.
    predicted_bytes: u64,
    /// Peak memory of the process; null where the system does not tell.
    peak_rss_bytes: Option<u64>,
    width: u32,
    height: u32,
    samples: u32,
    /// Share of the camera rays that need not be traced any more.
    finished: f64,
    /// Whether it went on with an unfinished picture.
    resumed: bool,
    /// Samples a pixel that were taken, in the mean.
    mean_samples: f64,
    /// Samples that were left out because they were not finite or too large.
    refused_samples: u64,
    complete: bool,
    output: String,
    /// What traced the rays: "cpu", or the name of a GPU.
    backend: String,
}

/// Rays traced, by kind.
#[derive(Serialize)]
struct Rays {
    camera: u64,
    shadow: u64,
    reflection: u64,
    diffuse: u64,
    total: u64,
}

impl From<RayCounts> for Rays {
    fn from(rays: RayCounts) -> Self {
        let RayCounts { camera, shadow, reflection, diffuse } = rays;
        Self { camera, shadow, reflection, diffuse, total: rays.total() }
    }
}

pub fn run(args: &RenderArgs) -> Result<Outcome, Failure> {
    // Maps are built by the global pool, pictures by one of their own.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(args.threads);
    pool.build_global().map_err(Failure::refused)?;
    let interrupt = Interrupt::install().map_err(Failure::Signals)?;
    check_format(args)?;
    let args = &checkpoint::with_flags_before(args)?;
    let device = Device::new(args.backend);
    let job = RenderJob::open(args, &device)?;
    let watch = Stopwatch::start();
    let film = match checkpoint::before(args, &job)? {
        Before::Nothing => None,
        Before::Film(film) => Some(film),
        Before::Picture => {
            args.talk.line(format_args!("{} is finished", args.output.path.display()));
            return Ok(Outcome::Done);
        }
    };
    let name = args.output.path.display().to_string();
    let live = LiveView::open(args.tev.as_deref(), &name, job.window().size, args.talk);
    let resumed = film.is_some();
    let begin =
        |tracer: Option<&dyn Tracer>| render(args, &job, (film, tracer), (&interrupt, &live));
    let ((film, stats, limited), backend) = backend::with_tracer(args, &device, &job.scene, begin)?;
    let rendering = watch.elapsed();
    let share = film.rays_done() as f64 / film.rays() as f64;
    let output = &args.output;
    // A picture without a single sample is worth less than the one that is there.
    let kept = share == 0.0 && output.path.exists();
    if !kept {
        let denoised = match args.denoise {
            Some(denoiser) => Some((denoiser.run(&film, args.threads)?, denoiser)),
            None => None,
        };
        let denoised = denoised.as_ref().map(|(colour, by)| (&colour[..], *by));
        checkpoint::write(&film, &job, denoised, output)?;
        live.close(denoised.map_or(film.radiance(), |(colour, _)| colour));
    }
    let [width, height] = film.resolution();
    let report = Report {
        build_seconds: job.build.seconds,
        build_cpu_seconds: job.build.cpu_seconds,
        render_seconds: rendering.seconds,
        render_cpu_seconds: rendering.cpu_seconds,
        rays: stats.rays.into(),
        map_bytes: job.memory.heights + job.memory.textures,
        bounds_bytes: job.memory.bounds,
        level_bytes: job.memory.levels,
        predicted_bytes: job.predicted_bytes,
        peak_rss_bytes: peak_rss_bytes(),
        width,
        height,
        samples: job.samples,
        finished: share,
        resumed,
        mean_samples: film.rays_taken() as f64 / film.finished().len() as f64,
        refused_samples: stats.refused,
        complete: stats.complete,
        output: output.path.display().to_string(),
        backend,
    };
    report.tell(args, kept);
    args.talk.object(&report)?;
    Ok(match interrupt.signal() {
        _ if stats.complete => Outcome::Done,
        Some(signal) => Outcome::Interrupted(signal),
        None if limited => Outcome::Limited,
        None => Outcome::Done,
    })
}

/// Renders until done, stopped or out of time; says whether the time was up.
fn render(
    args: &RenderArgs,
    job: &RenderJob,
    (film, tracer): (Option<Film>, Option<&dyn Tracer>),
    (interrupt, live): (&Interrupt, &LiveView),
) -> Result<(Film, RenderStats, bool), Failure> {
    let film = match film {
        Some(film) => film,
        None => rilievo_render::begin(&job.scene, &job.options()).map_err(Failure::refused)?,
    };
    let progress = Progress::counted(args.talk.quiet, "rendering", film.rays());
    let tell = |done, total| progress.update(done, total);
    let checkpoints = Checkpoints::new(args, job);
    let watch = |film: &Film| {
        live.watch(film);
        checkpoints.watch(film);
    };
    let cancel = interrupt.flag();
    let options = RenderOptions { tracer, progress: &tell, watch: &watch, cancel, ..job.options() };
    let work = || rilievo_render::resume(&job.scene, &options, film);
    let (result, limited) = interrupt.limited(args.time_limit, work);
    drop(progress);
    let (film, stats) = result.map_err(Failure::refused)?;
    Ok((film, stats, limited))
}

/// A PNG holds no sums to go on from.
fn check_format(args: &RenderArgs) -> Result<(), Failure> {
    let part = &args.part;
    if args.output.format == PictureFormat::Png && (part.resume || part.sample_range.is_some()) {
        let why = "--resume and --sample-range keep more than a PNG holds; write an EXR";
        return Err(Failure::Usage(why.to_owned()));
    }
    Ok(())
}

impl Report {
    fn tell(&self, args: &RenderArgs, kept: bool) {
        let talk = args.talk;
        let traced = self.rays.total as f64;
        talk.line(format_args!(
            "{} x {} pixels, {} samples, {} rays in {} ({} rays a second), built in {}",
            self.width,
            self.height,
            self.samples,
            report::count(self.rays.total),
            report::duration(self.render_seconds),
            report::count((traced / self.render_seconds.max(1e-9)) as u64),
            report::duration(self.build_seconds)
        ));
        let peak = self.peak_rss_bytes.map_or("unknown".to_owned(), report::bytes);
        talk.line(format_args!(
            "memory: maps {}, bounds {}, {}predicted {}, peak {peak}",
            report::bytes(self.map_bytes),
            report::bytes(self.bounds_bytes),
            report::levels(self.level_bytes),
            report::bytes(self.predicted_bytes)
        ));
        if self.refused_samples > 0 {
            talk.line(format_args!(
                "warning: {} samples were not finite or too large and are left out",
                report::count(self.refused_samples)
            ));
        }
        let percent = 100.0 * self.finished;
        match (self.complete, kept) {
            (true, _) => talk.line(format_args!("wrote {}", self.output)),
            (false, false) => {
                talk.line(format_args!("stopped; wrote {percent:.1} % to {}", self.output));
            }
            (false, true) => {
                talk.line(format_args!("stopped before any pixel; {} is unchanged", self.output));
            }
        }
    }
}
