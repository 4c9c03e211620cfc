//! What was typed: flags, their help and the checks that need nothing but the flag itself.
//!
//! Whatever is refused here is a usage error, exit code 2, before any file is opened. What the
//! words mean is found out by `job`.

mod bake;
mod kept;
mod render;
pub mod value;

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};
use rilievo::map::{Lattice, Layout, Wrap};
use rilievo_io::image::Stored;

use crate::denoise::Denoiser;
use crate::view::ViewArgs;
pub use bake::{Bake, BakeArgs, BakeFiles, BoundsArgs, DistanceArgs, FaceSize, NormalArgs};
pub use render::RenderArgs;
use value::{ExrPath, PngPath};

/// Ray-traces displacement-mapped surfaces without tessellating them.
#[derive(Debug, Parser)]
#[command(name = "rilievo", version, propagate_version = true, after_help = HELP)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene to a picture.
    #[command(after_help = render::EXAMPLES)]
    Render(RenderArgs),
    /// Make a normal map, distance map or min-max pyramid from a height map.
    #[command(after_help = bake::EXAMPLES)]
    Bake(BakeArgs),
    /// Say what a height map, a texture set, a model, a baked map or a scene is, and the memory a render of it needs.
    #[command(after_help = INFO)]
    Info(InfoArgs),
    /// Validate a scene with all its files, or a baked map against its height map.
    #[command(after_help = CHECK)]
    Check(CheckArgs),
    /// Compare two pictures.
    #[command(after_help = DIFF)]
    Diff(DiffArgs),
    /// Join parts of a render, done apart by --sample-range or --crop, into the picture of one run.
    #[command(after_help = MERGE)]
    Merge(MergeArgs),
    /// Look at a scene, a height map or a texture set in a window, and edit its relief.
    #[command(disable_help_flag = true, disable_version_flag = true)]
    View(ViewArgs),
}

/// How much is said.
#[derive(Clone, Copy, Debug, Args)]
pub struct Talk {
    /// Print one JSON object as the last line of standard output.
    #[arg(long, help_heading = render::WATCH)]
    pub json: bool,
    /// No progress and no report on standard error; errors are still printed.
    #[arg(long, short, help_heading = render::WATCH)]
    pub quiet: bool,
}

/// How the samples of a height map file are meant.
#[derive(Clone, Copy, Debug, Args)]
pub struct MapMeaning {
    /// Where samples sit.
    #[arg(long, default_value = "texel", value_parser = value::lattice())]
    pub grid: Lattice,
    /// What lies beyond the border.
    #[arg(long, default_value = "repeat", value_parser = value::wrap())]
    pub wrap: Wrap,
    /// Black is high.
    #[arg(long)]
    pub invert: bool,
}

#[derive(Debug, Args)]
pub struct InfoArgs {
    /// Height map, baked map, scene, model or folder of a texture set.
    pub file: PathBuf,
    /// Normal map to compare the height map with: which way green points, how well both agree.
    #[arg(long, value_name = "NORMALMAP")]
    pub normals: Option<PathBuf>,
    /// Pixels of the render whose memory is predicted [default: the scene's, or 512x512].
    #[arg(long, value_name = "WxH", value_parser = value::resolution)]
    pub resolution: Option<[u32; 2]>,
    /// How the bounds of that render are stored [default: each map's own, or default].
    #[arg(long, value_parser = value::layout())]
    pub layout: Option<Layout>,
    #[command(flatten)]
    pub meaning: MapMeaning,
    #[command(flatten)]
    pub talk: Talk,
}

#[derive(Debug, Args)]
pub struct CheckArgs {
    /// Scene, model, folder of a texture set, or baked map.
    pub file: PathBuf,
    /// The height map that the baked map was made from.
    #[arg(long, value_name = "HEIGHTMAP")]
    pub map: Option<PathBuf>,
    /// The height map was read with black as high when the map was baked.
    #[arg(long, requires = "map")]
    pub invert: bool,
    #[command(flatten)]
    pub talk: Talk,
}

#[derive(Debug, Args)]
pub struct DiffArgs {
    /// First picture: EXR, PNG, TIFF, JPEG or PFM.
    pub a: PathBuf,
    /// Second picture, of the same size.
    pub b: PathBuf,
    /// Largest difference of a value that is allowed.
    #[arg(long, value_name = "X", value_parser = value::threshold)]
    pub max: Option<f64>,
    /// Largest mean difference that is allowed.
    #[arg(long, value_name = "X", value_parser = value::threshold)]
    pub mean: Option<f64>,
    /// Largest root mean square difference that is allowed.
    #[arg(long, value_name = "X", value_parser = value::threshold)]
    pub rmse: Option<f64>,
    /// Differences of a value up to this do not make a pixel differ. Largest, mean and RMSE are over
    /// all values all the same.
    #[arg(long, value_name = "X", value_parser = value::threshold)]
    pub tolerance: Option<f64>,
    /// Most pixels that may differ.
    #[arg(long, value_name = "N")]
    pub pixels: Option<u64>,
    /// Heat picture to write: pixels that differ are coloured, the largest difference is bright.
    #[arg(short, long, value_name = "HEAT.png", value_parser = PngPath::parser())]
    pub output: Option<PngPath>,
    /// Compare only this layer, as P or N; RGB is the colour [default: all channels].
    #[arg(long, value_name = "NAME")]
    pub layer: Option<String>,
    #[command(flatten)]
    pub talk: Talk,
}

#[derive(Debug, Args)]
pub struct MergeArgs {
    /// Parts, in any order: pictures that render --sample-range and render --crop wrote.
    #[arg(required = true)]
    pub parts: Vec<PathBuf>,
    /// Picture to write: all of the render, or a larger part.
    #[arg(short, long, value_name = "OUT.exr", value_parser = ExrPath::parser())]
    pub output: ExrPath,
    /// Samples of the picture, as for render.
    #[arg(long, value_name = "SAMPLES", default_value = "float", value_parser = value::stored())]
    pub exr: Stored,
    /// Take the noise off the joined picture, as render does; of parts that were rendered with
    /// --denoise or with --aov Albedo,Ns.
    #[arg(
        long, value_name = "FILTER", value_enum, num_args = 0..=1, require_equals = true,
        default_missing_value = "own"
    )]
    pub denoise: Option<Denoiser>,
    /// Cut it into square tiles, as for render.
    #[arg(long, value_name = "PIXELS", value_parser = value::tiles)]
    pub tiles: Option<u32>,
    #[command(flatten)]
    pub talk: Talk,
}

const HELP: &str = "\
Exit codes:
  0    done
  1    bad input, or a file could not be read or written
  2    usage
  3    comparison failed (diff, check)
  4    stopped by a limit, what was done is written
  130  interrupted (143: terminated), what was rendered is written

Examples:
  rilievo render scenes/relief/scene.toml -o relief.png
  rilievo info heights.png
  rilievo bake distance heights.png -o heights-distance.rlv
  rilievo diff a.exr b.exr --max 1e-6";

const MERGE: &str = "\
Parts must be of one render: the same scene, files, settings and seed. Sample ranges must follow on
each other, windows must lie side by side.

Examples:
  rilievo merge a.exr b.exr -o out.exr
  rilievo merge a.exr b.exr -o out.exr --denoise
  rilievo merge a.exr b.exr -o out.exr --exr half --tiles 64 --quiet
  rilievo merge left.exr right.exr -o out.exr --json";

const INFO: &str = "\
The kind of file is told from its content; a folder is a texture set.

Examples:
  rilievo info heights.png
  rilievo info heights.png --normals normals.png
  rilievo info textures/rock058/
  rilievo info spot.obj
  rilievo info heights.png --layout tiny --quiet
  rilievo info dem.tif --grid vertex --wrap clamp --resolution 1920x1080
  rilievo info heights-distance.rlv
  rilievo info scene.toml --json";

const CHECK: &str = "\
Exit code 3 says that a stored distance or bound is not safe, 1 that a file could not be read.

Examples:
  rilievo check scene.toml
  rilievo check heights-distance.rlv --map heights.png
  rilievo check pits-bounds.rlv --map pits.png --invert
  rilievo check dem-bounds.rlv --map dem.tif --json";

const DIFF: &str = "\
Without a threshold any difference fails, exit code 3. NaN equals NaN and differs from every
number. A pixel with a number in one picture only fails unless --pixels allows it.

Examples:
  rilievo diff a.exr b.exr
  rilievo diff a.png b.png --rmse 0.002 --pixels 20
  rilievo diff a.exr b.exr --max 0.001 --mean 1e-5
  rilievo diff a.exr b.exr --layer P --tolerance 0.01 -o heat.png --json";
