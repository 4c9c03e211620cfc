//! [`RenderJob`]: what the flags of a render mean: files opened, sizes known.

use std::cell::RefCell;
use std::path::{Path, PathBuf};

use rilievo::map::DistanceKind;
use rilievo_io::Limits;
use rilievo_io::film_file::{Fingerprint, Remainder};
use rilievo_io::image::{Blocks, Stored};
use rilievo_io::scene::{DistanceBuild, LoadOptions, LoadedScene, SceneFile};
use rilievo_render::denoise;
use rilievo_render::film::Tile;
use rilievo_render::film::tonemap::ToneMap;
use rilievo_render::{Aov, MemoryUse, RenderOptions, RenderSettings, Scene};

use crate::args::value::PictureFormat;
use crate::args::{RenderArgs, Talk};
use crate::backend::Device;
use crate::memory::predicted_bytes;
use crate::name;
use crate::outcome::Failure;
use crate::picture::{About, PictureKind};
use crate::progress::Progress;
use crate::report;
use crate::stopwatch::{Elapsed, Stopwatch};

/// A render that can start.
pub struct RenderJob {
    pub scene: Scene,
    pub kind: PictureKind,
    pub tone_map: ToneMap,
    /// Layers to render: those of the picture, and those that a denoiser needs.
    layers: Vec<Aov>,
    pub memory: MemoryUse,
    pub predicted_bytes: u64,
    /// Camera rays per pixel.
    pub samples: u32,
    /// Reading the scene and building what its methods need.
    pub build: Elapsed,
    threads: usize,
    pixel_centers: bool,
    /// How an EXR keeps samples.
    pub stored: Stored,
    /// How an EXR is cut up.
    pub blocks: Blocks,
    crop: Option<Tile>,
    sample_range: Option<[u32; 2]>,
    max_error: Option<f64>,
    /// The flags it was begun with, see [`RenderArgs::kept`].
    pub flags: String,
    /// Of the scene, the files it names and all settings.
    pub fingerprint: Fingerprint,
}

impl RenderJob {
    /// Reads the scene and builds what its methods need, distance maps on a GPU if one is asked for.
    pub fn open(args: &RenderArgs, device: &Device) -> Result<Self, Failure> {
        let watch = Stopwatch::start();
        let limits = args.max_memory.map_or_else(Limits::default, |max_bytes| Limits { max_bytes });
        let options = LoadOptions {
            limits,
            method: args.method,
            layout: args.layout,
            integrator: args.integrator,
            simd: args.simd.unwrap_or_default(),
            build_distances: &|heights, kind, options| device.distance_map(heights, kind, options),
            ..LoadOptions::default()
        };
        let file = SceneFile::present(&args.scene, &options.limits)?;
        let loaded = load_file(&file, &options, args.talk)?;
        let LoadedScene { scene, mut tone_map, files, .. } = loaded;
        tone_map = ToneMap {
            exposure: args.exposure.unwrap_or(tone_map.exposure),
            view: args.view.unwrap_or(tone_map.view),
        };
        let mut settings = *scene.settings();
        if let Some(kind) = args.filter {
            settings.filter = kind.into();
        }
        if let Some(radius) = args.filter_radius {
            settings.filter.radius = radius;
        }
        settings = RenderSettings {
            integrator: args.integrator.unwrap_or(settings.integrator),
            samples: args.samples.unwrap_or(settings.samples),
            sampler: args.sampler.unwrap_or(settings.sampler),
            seed: args.seed.unwrap_or(settings.seed),
            clamp: args.clamp.unwrap_or(settings.clamp),
            lod: args.lod.unwrap_or(settings.lod),
            ..settings
        };
        let mut scene = scene.with_settings(settings).map_err(Failure::refused)?;
        if let Some(resolution) = args.resolution {
            let camera = scene.camera().with_resolution(resolution).map_err(Failure::refused)?;
            scene = scene.with_camera(camera);
        }
        let kind = PictureKind::new(args.output.format, settings.integrator, &args.aov)
            .map_err(|why| Failure::Usage(why.to_owned()))?;
        let mut layers = kind.layers().to_vec();
        if let Some(denoiser) = args.denoise {
            denoiser.check()?;
            if !kind.has_colour() {
                return Err(Failure::Usage(
                    "a picture of layers alone has no noise to take off".into(),
                ));
            }
            layers.extend(denoise::GUIDES.iter().filter(|guide| !kind.layers().contains(guide)));
        }
        let mut job = Self {
            kind,
            layers,
            tone_map,
            memory: MemoryUse::default(),
            predicted_bytes: 0,
            samples: if args.pixel_centers { 1 } else { settings.samples },
            build: watch.elapsed(),
            threads: args.threads,
            pixel_centers: args.pixel_centers,
            stored: args.exr.unwrap_or_default(),
            blocks: args.tiles.map_or(Blocks::Lines, Blocks::Tiles),
            crop: args.part.crop,
            sample_range: args.part.sample_range,
            max_error: args.part.max_error,
            flags: args.kept(),
            fingerprint: Fingerprint::default(),
            scene,
        };
        rilievo_render::check(&job.scene, &job.options()).map_err(Failure::refused)?;
        if args.output.format == PictureFormat::Exr {
            job.fingerprint = job.fingerprint_of(&file, (args, &files))?;
        }
        job.memory = MemoryUse::predict(&job.scene, &job.options());
        let window = job.window().size;
        job.predicted_bytes = predicted_bytes(&job.memory, job.writing_bytes(args));
        if args.denoise.is_some() {
            job.predicted_bytes += denoise::predicted_bytes(window);
        }
        match args.max_memory {
            Some(most) if job.predicted_bytes > most => Err(Failure::Refused(format!(
                "this render needs about {}; --max-memory allows {}",
                report::bytes(job.predicted_bytes),
                report::bytes(most)
            ))),
            _ => Ok(job),
        }
    }

    /// The pixels to render.
    pub fn window(&self) -> Tile {
        self.crop.unwrap_or(Tile::whole(self.scene.camera().resolution()))
    }

    /// Whether it is a part of a picture only.
    pub fn is_part(&self) -> bool {
        self.window() != Tile::whole(self.scene.camera().resolution())
            || self.sample_range.is_some_and(|range| range != [0, self.samples])
    }

    /// What an EXR says of it.
    pub fn about(&self) -> About<'_> {
        let scene = &self.scene;
        About { camera: scene.camera(), settings: scene.settings(), samples: self.samples }
    }

    /// Bytes that writing takes beside the film, at most.
    fn writing_bytes(&self, args: &RenderArgs) -> u64 {
        let sums = self.scene.settings().integrator.sums();
        let rest = match args.output.format {
            PictureFormat::Exr if self.is_part() || !args.part.checkpoint.is_zero() => {
                Remainder::channels(&self.layers, sums)
            }
            _ => 0,
        };
        self.kind.writing_bytes(self.window().size, self.blocks, rest)
    }

    /// Two renders with one fingerprint give the same picture, and parts of it that fit together.
    fn fingerprint_of(
        &self,
        file: &SceneFile,
        (args, files): (&RenderArgs, &[PathBuf]),
    ) -> Result<Fingerprint, Failure> {
        let mut fingerprint = Fingerprint::default();
        let settings = format!(
            "{} {:?} {:?} {:?} {:?} {:?} {:?}",
            env!("CARGO_PKG_VERSION"),
            self.scene.settings(),
            self.scene.camera().resolution(),
            self.pixel_centers,
            (&self.kind, &self.layers),
            self.max_error,
            args.method
        );
        fingerprint.add(settings.as_bytes());
        fingerprint.add(file.text().as_bytes());
        // An image that is not there is noted, and counts as such.
        let files = files.iter().filter(|path| path.exists()).cloned();
        for path in file.references().into_iter().chain(files) {
            fingerprint.add_reference(&path)?;
        }
        Ok(fingerprint)
    }

    /// How to render, but for progress and stopping.
    pub fn options(&self) -> RenderOptions<'_> {
        RenderOptions {
            threads: self.threads,
            pixel_centers: self.pixel_centers,
            aovs: &self.layers,
            crop: self.crop,
            samples: self.sample_range,
            max_error: self.max_error,
            ..RenderOptions::default()
        }
    }
}

/// Reads a scene with all its files and builds the distance maps its methods need.
///
/// # Errors
/// Of the scene or any of its files.
pub fn load(path: &Path, options: &LoadOptions<'_>, talk: Talk) -> Result<LoadedScene, Failure> {
    load_file(&SceneFile::present(path, &options.limits)?, options, talk)
}

fn load_file(
    file: &SceneFile,
    options: &LoadOptions<'_>,
    talk: Talk,
) -> Result<LoadedScene, Failure> {
    let built = RefCell::new(None::<Progress>);
    let building = |build: &DistanceBuild<'_>| {
        drop(built.take());
        built.replace(Some(tell_build(build, talk)));
    };
    let loaded = file.load(&LoadOptions { building: &building, ..*options })?;
    for note in &loaded.notes {
        talk.line(format_args!("note: {note}"));
    }
    Ok(loaded)
}

/// Says which distance map is being built, and what to expect of it.
fn tell_build(build: &DistanceBuild<'_>, talk: Talk) -> Progress {
    let [x, y, z] = build.size;
    let kind = name::distance_kind(build.kind);
    if build.kind == DistanceKind::Published && (x <= build.cells[0] || y <= build.cells[1]) {
        talk.line(format_args!(
            "note: map {:?} has {} x {} samples; the published brute force is given {x} x {y} nodes",
            build.map, build.cells[0], build.cells[1]
        ));
    }
    let what = format!("building the {kind} distance map of {:?}, {x} x {y} x {z}", build.map);
    Progress::uncounted(talk.quiet, &what)
}
