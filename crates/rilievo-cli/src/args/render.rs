//! The flags of `rilievo render`.

use std::path::PathBuf;
use std::time::Duration;

use clap::Args;
use rilievo::SimdLevel;
use rilievo::map::Layout;
use rilievo::relief::Method;
use rilievo_gpu::Backend;
use rilievo_io::image::Stored;
use rilievo_io::tev::TEV_ADDRESS;
use rilievo_render::film::Tile;
use rilievo_render::film::tonemap::View;
use rilievo_render::{Aov, FilterKind, Integrator, SamplerKind};

use super::Talk;
use super::value::{self, PicturePath};
use crate::denoise::Denoiser;

/// What flags of `render` are about, as its help groups them.
const PICTURE: &str = "Picture";
const SAMPLES: &str = "Samples";
const WALK: &str = "Walk";
const LIMITS: &str = "Limits";
const PARTS: &str = "Stopped, continued, in parts";
pub(super) const WATCH: &str = "While it runs";

#[derive(Clone, Debug, Args)]
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
    /// Largest channel of the light that one path may bring from beyond its direct light, as 10: takes
    /// bright specks away, and light with them; 0 clamps nothing [default: the scene's].
    #[arg(long, value_name = "RADIANCE", value_parser = value::clamp, help_heading = SAMPLES)]
    pub clamp: Option<f64>,
    /// Level of detail: how many pixels a camera ray stands for, 1 if no number is given. Reliefs far away
    /// are traced in coarser maps, and shaded as rough as they are; 0 traces full maps [default: the scene's].
    #[arg(
        long, value_name = "PIXELS", value_parser = value::lod, num_args = 0..=1, require_equals = true,
        default_missing_value = "1", help_heading = SAMPLES
    )]
    pub lod: Option<f64>,
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
    /// What traces all rays: gpu needs Vulkan, Metal or Direct3D 12; auto takes the CPU where there is no
    /// GPU, or only a program in its place, and where it cannot. Materials and lights are worked out on the CPU
    /// in between.
    #[arg(
        long, value_name = "BACKEND", value_parser = value::backend(), default_value = "cpu",
        help_heading = WALK
    )]
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
    /// Samples of an EXR: float, or half for colours and normals. P, UV, Z, Height and Steps stay float
    /// [default: float].
    #[arg(
        long, value_name = "SAMPLES", value_parser = value::stored(), help_heading = PICTURE
    )]
    pub exr: Option<Stored>,
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
#[derive(Clone, Debug, Args)]
pub struct PartArgs {
    /// Save the picture so far every so often, to go on from with --resume; 0 never does. EXR only.
    #[arg(long, value_name = "SECONDS", default_value = "60", value_parser = value::interval)]
    pub checkpoint: Duration,
    /// Go on with the unfinished picture that --output names, if there is one: the result is that of
    /// a render that was never stopped. The flags it was begun with need not be repeated.
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

pub(super) const EXAMPLES: &str = "\
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
  rilievo render scene.toml -o out.png --integrator path --clamp 10
  rilievo render dem.tif -o terrain.png --samples 4 --lod
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
  rilievo render scene.toml -o out.exr --samples 4096 --checkpoint 300
  rilievo render scene.toml -o out.exr --resume
  rilievo render scene.toml -o a.exr --samples 256 --sample-range 0..128
  rilievo render scene.toml -o left.exr --crop 0,0,320,400
  rilievo render scene.toml -o out.exr --integrator path --samples 4096 --max-error 0.02";
