//! What was typed: flags, their help and the checks that need nothing but the flag itself.
//!
//! Whatever is refused here is a usage error, exit code 2, before any file is opened. What the
//! words mean is found out by `job`.

pub mod value;

use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand, ValueEnum};
use rilievo::SimdLevel;
use rilievo::map::{
    DistanceBits, DistanceKind, Lattice, Layout, NormalConvention, NormalKind, Wrap,
};
use rilievo::relief::Method;
use rilievo_io::image::Stored;
use rilievo_io::tev::TEV_ADDRESS;
use rilievo_render::film::Tile;
use rilievo_render::film::tonemap::View;
use rilievo_render::{Aov, FilterKind, Integrator, SamplerKind};

use crate::denoise::Denoiser;
use value::{ExrPath, PicturePath, PngPath};

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
    #[command(after_help = RENDER)]
    Render(RenderArgs),
    /// Make a normal map, distance map or min-max pyramid from a height map.
    #[command(after_help = BAKE)]
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
}

/// What flags of `render` are about, as its help groups them.
const PICTURE: &str = "Picture";
const SAMPLES: &str = "Samples";
const WALK: &str = "Walk";
const LIMITS: &str = "Limits";
const PARTS: &str = "Stopped, continued, in parts";
const WATCH: &str = "While it runs";

#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Scene file (TOML), the folder of a texture set, a model (OBJ, PLY, glTF, GLB) or a height map.
    pub scene: PathBuf,
    /// Picture to write: .exr (linear, layers, metadata) or .png (8-bit sRGB).
    #[arg(
        short, long, value_name = "OUT.{exr,png}", value_parser = PicturePath::parser(),
        help_heading = PICTURE
    )]
    pub output: PicturePath,
    /// Camera rays per pixel [default: the scene's].
    #[arg(long, value_name = "N", value_parser = value::samples, help_heading = SAMPLES)]
    pub samples: Option<u32>,
    /// Pixels, as 640x400 [default: the scene's].
    #[arg(long, value_name = "WxH", value_parser = value::resolution, help_heading = PICTURE)]
    pub resolution: Option<[u32; 2]>,
    /// What is estimated [default: the scene's].
    #[arg(long, value_parser = value::integrator(), help_heading = SAMPLES)]
    pub integrator: Option<Integrator>,
    /// Where the numbers of paths come from [default: the scene's]. The integrator distributed takes
    /// its own.
    #[arg(long, value_parser = value::sampler(), help_heading = SAMPLES)]
    pub sampler: Option<SamplerKind>,
    /// How rays are walked through every relief [default: each shape's own]. Distance maps that a
    /// method needs are built before rendering.
    #[arg(long, value_parser = value::method(), help_heading = WALK)]
    pub method: Option<Method>,
    /// How the bounds of every map are stored: default (0.27 byte a texel) or tiny (0.15) [default:
    /// each map's own]. The picture does not depend on it.
    #[arg(long, value_parser = value::layout(), help_heading = WALK)]
    pub layout: Option<Layout>,
    /// Vector instructions of the walk [default: the fastest this processor has]. The picture does
    /// not depend on it.
    #[arg(long, value_name = "LEVEL", value_parser = value::simd(), help_heading = WALK)]
    pub simd: Option<SimdLevel>,
    /// What does the work.
    #[arg(long, value_enum, default_value_t = Backend::Cpu, help_heading = WALK)]
    pub backend: Backend,
    /// Threads; 0 takes one per processor. The picture does not depend on it.
    #[arg(
        long, value_name = "N", default_value = "0", value_parser = value::threads,
        help_heading = LIMITS
    )]
    pub threads: usize,
    /// Seed of every random choice [default: the scene's].
    #[arg(long, value_name = "N", help_heading = SAMPLES)]
    pub seed: Option<u64>,
    /// Layers of the first hit to store beside the colour, parted by commas. Alone with the
    /// integrator aov: all of them in an EXR; the first as the picture in a PNG.
    #[arg(
        long, value_name = "LAYERS", value_delimiter = ',', value_parser = value::aov(),
        help_heading = PICTURE
    )]
    pub aov: Vec<Aov>,
    /// Pixel filter [default: the scene's].
    #[arg(long, value_parser = value::filter(), help_heading = SAMPLES)]
    pub filter: Option<FilterKind>,
    /// Radius of the filter [default: the scene's; of --filter 0.5, 1, 1.5, 2, 1.5].
    #[arg(long, value_name = "PIXELS", value_parser = value::filter_radius, help_heading = SAMPLES)]
    pub filter_radius: Option<f64>,
    /// Samples of an EXR: float, or half for colours and normals. P, UV, Z, Height and Steps stay float.
    #[arg(
        long, value_name = "SAMPLES", default_value = "float", value_parser = value::stored(),
        help_heading = PICTURE
    )]
    pub exr: Stored,
    /// Cut an EXR into square tiles of so many pixels a side [default: lines].
    #[arg(long, value_name = "PIXELS", value_parser = value::tiles, help_heading = PICTURE)]
    pub tiles: Option<u32>,
    /// Take the noise off: an own filter, or oidn (Intel Open Image Denoise). An EXR keeps the noisy
    /// colour beside it, as Noisy.R, G and B, and the layers Albedo and Ns.
    #[arg(
        long, value_name = "FILTER", value_enum, num_args = 0..=1, require_equals = true,
        default_missing_value = "own", help_heading = PICTURE
    )]
    pub denoise: Option<Denoiser>,
    /// How a PNG shows light beyond white [default: the scene's].
    #[arg(long, value_parser = value::view(), help_heading = PICTURE)]
    pub view: Option<View>,
    /// Exposure of a PNG in stops [default: the scene's].
    #[arg(
        long, value_name = "STOPS", allow_negative_numbers = true, value_parser = value::exposure,
        help_heading = PICTURE
    )]
    pub exposure: Option<f64>,
    /// One ray through the centre of each pixel: no jitter, no filter, whatever --samples says.
    #[arg(long, help_heading = SAMPLES)]
    pub pixel_centers: bool,
    /// Refuse to render if more memory than this would be needed, as 512M or 2G.
    #[arg(long, value_name = "BYTES", value_parser = value::bytes, help_heading = LIMITS)]
    pub max_memory: Option<u64>,
    /// Stop rendering after this time, save what is done, exit with 4.
    #[arg(long, value_name = "SECONDS", value_parser = value::seconds, help_heading = LIMITS)]
    pub time_limit: Option<Duration>,
    /// Show the picture on its way in the viewer tev, at --tev=HOST:PORT or where tev listens by
    /// default, 127.0.0.1:14158.
    #[arg(
        long, value_name = "HOST:PORT", num_args = 0..=1, require_equals = true,
        default_missing_value = TEV_ADDRESS, help_heading = WATCH
    )]
    pub tev: Option<String>,
    #[command(flatten, next_help_heading = PARTS)]
    pub part: PartArgs,
    #[command(flatten)]
    pub talk: Talk,
}

/// Renders that are stopped and continued, or done in parts.
#[derive(Debug, Args)]
pub struct PartArgs {
    /// Save the picture so far every so often, to go on from with --resume; 0 never does. EXR only.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value::interval)]
    pub checkpoint: Duration,
    /// Go on with the unfinished picture that --output names, if there is one: the result is that of
    /// a render that was never stopped.
    #[arg(long)]
    pub resume: bool,
    /// Take only the samples A to B - 1 of each pixel; rilievo merge joins them. For the integrator
    /// path.
    #[arg(long, value_name = "A..B", value_parser = value::sample_range)]
    pub sample_range: Option<[u32; 2]>,
    /// Render only the pixels from X0 to X1 - 1 and Y0 to Y1 - 1; rilievo merge joins them.
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = value::crop)]
    pub crop: Option<Tile>,
    /// Stop a tile of 16 x 16 pixels before --samples once its relative error is estimated below
    /// this, as 0.02. For the integrator path.
    #[arg(long, value_name = "E", value_parser = value::max_error)]
    pub max_error: Option<f64>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    Cpu,
    Gpu,
}

/// How much is said.
#[derive(Clone, Copy, Debug, Args)]
pub struct Talk {
    /// Print one JSON object as the last line of standard output.
    #[arg(long, help_heading = WATCH)]
    pub json: bool,
    /// No progress and no report on standard error; errors are still printed.
    #[arg(long, short, help_heading = WATCH)]
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
pub struct BakeArgs {
    #[command(subcommand)]
    pub what: Bake,
}

#[derive(Debug, Subcommand)]
pub enum Bake {
    /// Unit normals in the metric of a face: a map file, or a PNG of 16-bit RGB.
    #[command(after_help = BAKE_NORMAL)]
    Normal(NormalArgs),
    /// Distances to the surface in three dimensions.
    #[command(after_help = BAKE_DISTANCE)]
    Distance(DistanceArgs),
    /// The min-max pyramid: bounds of the heights over blocks of cells.
    #[command(after_help = BAKE_BOUNDS)]
    Bounds(BoundsArgs),
}

#[derive(Debug, Args)]
pub struct BakeFiles {
    /// Height map: PNG, TIFF, JPEG, EXR, PFM, ASCII grid, .hgt or .bil.
    pub map: PathBuf,
    /// File to write.
    #[arg(short, long, value_name = "OUT")]
    pub output: PathBuf,
    #[command(flatten)]
    pub meaning: MapMeaning,
    #[command(flatten)]
    pub talk: Talk,
}

/// The face that derived maps are made for.
#[derive(Clone, Copy, Debug, Args)]
pub struct FaceSize {
    /// Sides of one repetition of the map, scene units.
    #[arg(long, value_name = "WxH", default_value = "1x1", value_parser = value::sides)]
    pub face: [f64; 2],
    /// Scene units between heights 0 and 1.
    #[arg(long, value_name = "D", default_value = "1", value_parser = value::length)]
    pub depth: f64,
}

#[derive(Debug, Args)]
pub struct NormalArgs {
    #[command(flatten)]
    pub files: BakeFiles,
    #[command(flatten)]
    pub face: FaceSize,
    /// How normals follow from heights.
    #[arg(long, default_value = "smooth", value_parser = value::normal_kind())]
    pub normals: NormalKind,
    /// Where green grows in a PNG: up the image (opengl) or down (directx).
    #[arg(long, default_value = "opengl", value_parser = value::convention())]
    pub convention: NormalConvention,
}

#[derive(Debug, Args)]
pub struct DistanceArgs {
    #[command(flatten)]
    pub files: BakeFiles,
    #[command(flatten)]
    pub face: FaceSize,
    /// What is stored: the paper's distances to texel points (not safe), safe boxes in linear time,
    /// or exact distances at nodes.
    #[arg(long, default_value = "boxes", value_parser = value::distance_kind())]
    pub kind: DistanceKind,
    /// Voxels or nodes along x, y and z [default: as render builds it].
    #[arg(long, value_name = "NX,NY,NZ", value_parser = value::size3)]
    pub size: Option<[u32; 3]>,
    /// Bits of a stored distance.
    #[arg(long, default_value = "16", value_parser = value::bits())]
    pub bits: DistanceBits,
}

#[derive(Debug, Args)]
pub struct BoundsArgs {
    #[command(flatten)]
    pub files: BakeFiles,
    /// How bounds are stored.
    #[arg(long, default_value = "default", value_parser = value::layout())]
    pub layout: Layout,
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

const RENDER: &str = "\
The output appears under its name whole or not at all. The first Ctrl-C stops rendering and saves
what is done; a second one kills.

Examples:
  rilievo render scene.toml -o out.png
  rilievo render textures/rock058/ -o rock.png
  rilievo render spot.obj -o spot.png
  rilievo render dem.tif -o terrain.png
  rilievo render scene.toml -o out.png --view agx --exposure -0.5
  rilievo render scene.toml -o out.png --filter blackman-harris --filter-radius 1.5
  rilievo render scene.toml -o out.exr --samples 64 --resolution 1280x800
  rilievo render scene.toml -o out.png --integrator path --sampler sobol --seed 7
  rilievo render scene.toml -o out.png --layout tiny --simd portable --backend cpu
  rilievo render scene.toml -o out.png --threads 8 --max-memory 4G --quiet
  rilievo render scene.toml -o out.exr --aov P,N,Height
  rilievo render scene.toml -o out.exr --exr half --tiles 64
  rilievo render scene.toml -o out.png --samples 16 --denoise
  rilievo render scene.toml -o out.exr --samples 1024 --tev
  rilievo render scene.toml -o out.exr --samples 16 --denoise=oidn
  rilievo render scene.toml -o hits.exr --integrator aov --pixel-centers --aov P
  rilievo render scene.toml -o steps.png --integrator aov --aov Steps --method distance
  rilievo render scene.toml -o draft.png --time-limit 10 --json
  rilievo render scene.toml -o out.exr --samples 4096 --checkpoint 300 --resume
  rilievo render scene.toml -o a.exr --samples 256 --sample-range 0..128
  rilievo render scene.toml -o left.exr --crop 0,0,320,400
  rilievo render scene.toml -o out.exr --integrator path --samples 4096 --max-error 0.02";

const MERGE: &str = "\
Parts must be of one render: the same scene, files, settings and seed. Sample ranges must follow on
each other, windows must lie side by side.

Examples:
  rilievo merge a.exr b.exr -o out.exr
  rilievo merge left.exr right.exr -o out.exr --json";

const BAKE: &str = "\
Every map is read back after writing and compared with what was meant.

Examples:
  rilievo bake normal heights.png -o normals.png --face 2x2 --depth 0.1
  rilievo bake distance heights.png -o heights-distance.rlv --size 256,256,32
  rilievo bake bounds heights.png -o heights-bounds.rlv";

const BAKE_NORMAL: &str = "\
Examples:
  rilievo bake normal heights.png -o normals.png --face 2x2 --depth 0.1
  rilievo bake normal heights.png -o normals.png --convention directx
  rilievo bake normal heights.png -o heights-normals.rlv --normals published";

const BAKE_DISTANCE: &str = "\
Examples:
  rilievo bake distance heights.png -o heights-distance.rlv
  rilievo bake distance heights.png -o exact.rlv --kind corrected --size 128,128,32 --bits 8
  rilievo bake distance dem.tif -o dem.rlv --grid vertex --wrap clamp --face 3000x3000 --depth 1";

const BAKE_BOUNDS: &str = "\
Examples:
  rilievo bake bounds heights.png -o heights-bounds.rlv
  rilievo bake bounds heights.png -o heights-bounds.rlv --layout tiny
  rilievo bake bounds dem.tif -o dem-bounds.rlv --grid vertex --wrap clamp";

const INFO: &str = "\
The kind of file is told from its content; a folder is a texture set.

Examples:
  rilievo info heights.png
  rilievo info heights.png --normals normals.png
  rilievo info textures/rock058/
  rilievo info spot.obj
  rilievo info dem.tif --grid vertex --wrap clamp --resolution 1920x1080
  rilievo info heights-distance.rlv
  rilievo info scene.toml --json";

const CHECK: &str = "\
Exit code 3 says that a stored distance or bound is not safe, 1 that a file could not be read.

Examples:
  rilievo check scene.toml
  rilievo check heights-distance.rlv --map heights.png
  rilievo check dem-bounds.rlv --map dem.tif --json";

const DIFF: &str = "\
Without a threshold any difference fails, exit code 3. NaN equals NaN and differs from every
number. A pixel with a number in one picture only fails unless --pixels allows it.

Examples:
  rilievo diff a.exr b.exr
  rilievo diff a.png b.png --rmse 0.002 --pixels 20
  rilievo diff a.exr b.exr --layer P --tolerance 0.01 -o heat.png --json";
