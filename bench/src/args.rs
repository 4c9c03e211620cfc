//! What was typed: commands, flags, their help and the checks that need nothing but the flag.

use std::path::PathBuf;

use clap::builder::{PossibleValuesParser, TypedValueParser};
use clap::{Args, Parser, Subcommand};
use rilievo::SimdLevel;
use rilievo::map::DistanceKind;

use crate::contender::Contender;
use crate::map::{MapFile, MapName};
use crate::rays::Family;
use crate::solids::{Body, SolidFamily};
use crate::transforms::{Grid, name};

/// Measures rilievo beside its peers, on equal rays and grids.
#[derive(Debug, Parser)]
#[command(name = "rilievo-bench", version, propagate_version = true)]
pub struct Arguments {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    /// Rays a second of one thread, memory and build time, beside Embree.
    Kernels(KernelArgs),
    /// Nanoseconds a voxel of distance maps.
    Transforms(TransformArgs),
    /// Nodes, leaves, steps and nanoseconds a ray of the exact methods.
    Walks(WalkArgs),
    /// Rays a second of one thread on displaced spheres and meshes, beside Embree.
    Solids(SolidArgs),
    /// By how much ever finer triangles differ from displaced spheres and meshes, as a table.
    Refinement(RefinementArgs),
    /// Nanoseconds a sample of building pyramids.
    Build(BuildArgs),
    /// Rays a second, builds and edits on a GPU, beside triangles under a tree.
    Gpu(GpuArgs),
    /// Say what machine this is, as the machine.json of a recorded run.
    Machine,
    /// Print the tables of a recorded run, in Markdown.
    Summary(RunArgs),
    /// Draw the plots of a recorded run, as SVG.
    Plots(PlotArgs),
}

#[derive(Debug, Args)]
pub struct KernelArgs {
    /// Maps, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = MapName::ALL)]
    pub maps: Vec<MapName>,
    /// Samples a side, parted by commas.
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = size(),
          default_values_t = [512, 1024, 2048, 4096, 8192])]
    pub sizes: Vec<u32>,
    /// Families of rays, parted by commas; shadow measures single rays and packets of 8.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Family::ALL)]
    pub families: Vec<Family>,
    /// Contenders, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Contender::ALL)]
    pub contenders: Vec<Contender>,
    /// SIMD level of rilievo's kernel [default: the fastest of this processor].
    #[arg(long, value_name = "LEVEL", value_parser = simd())]
    pub simd: Option<SimdLevel>,
    /// Passes after the one that warms up; the median counts.
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u16).range(1..))]
    pub passes: u16,
    /// Scene units of height 1 over the unit square; real maps divide it by their repetitions.
    #[arg(long, value_name = "Z", default_value_t = 0.1, value_parser = depth)]
    pub depth: f64,
    /// A sixteenth of the rays.
    #[arg(long)]
    pub quick: bool,
    /// Most bytes that the contenders of a map may hold together, as 10G.
    #[arg(long, value_name = "BYTES", default_value = "10G", value_parser = bytes)]
    pub max_memory: u64,
    /// Embree's configuration string.
    #[cfg(feature = "embree")]
    #[arg(long, value_name = "STRING", default_value = "threads=1")]
    pub embree_config: String,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Args)]
pub struct TransformArgs {
    /// Maps, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',',
          default_values_t = [MapName::Fbm, MapName::Studded])]
    pub maps: Vec<MapName>,
    /// Grids as SIDExDEPTH in voxels, parted by commas; the map has one cell a column.
    #[arg(
        long,
        value_name = "NxD,...",
        value_delimiter = ',',
        default_value = "128x128,256x64,512x64,1024x32"
    )]
    pub grids: Vec<Grid>,
    /// Kinds of distance map, parted by commas. corrected and published take minutes on all but
    /// small grids.
    #[arg(long, value_name = "KIND,...", value_delimiter = ',', value_parser = kind(),
          default_value = "boxes")]
    pub kinds: Vec<DistanceKind>,
    /// Passes after the one that warms up; the median counts.
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = clap::value_parser!(u16).range(1..))]
    pub passes: u16,
    /// Also write each grid to MAP-NxD.npy in this folder, for peers: 0 where the surface is, else 1.
    #[arg(long, value_name = "FOLDER")]
    pub dump_grid: Option<PathBuf>,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Args)]
pub struct WalkArgs {
    /// Maps, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = MapName::ALL)]
    pub maps: Vec<MapName>,
    /// Samples a side, parted by commas.
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = size(),
          default_values_t = [1024])]
    pub sizes: Vec<u32>,
    /// Families of rays, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',',
          default_values_t = [Family::Primary, Family::Shadow, Family::Diffuse])]
    pub families: Vec<Family>,
    /// Distance maps as SIDExDEPTH in voxels, parted by commas [default: the size that maps get when
    /// nobody says].
    #[arg(long, value_name = "NxD,...", value_delimiter = ',')]
    pub grids: Vec<Grid>,
    /// Scene units of height 1 over the unit square; real maps divide it by their repetitions.
    #[arg(long, value_name = "Z", default_value_t = 0.1, value_parser = depth)]
    pub depth: f64,
    /// Passes after the one that warms up; the median counts.
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = clap::value_parser!(u16).range(1..))]
    pub passes: u16,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Args)]
pub struct SolidArgs {
    /// Base surfaces, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Body::ALL)]
    pub bodies: Vec<Body>,
    /// Maps, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',',
          default_values_t = [MapName::Fbm, MapName::Moss, MapName::RoofingTiles])]
    pub maps: Vec<MapName>,
    /// More maps as NAME=FILE, parted by commas; repeated where `--size` is larger, as thick as
    /// `--thickness` says.
    #[arg(long, value_name = "NAME=FILE,...", value_delimiter = ',')]
    pub map_files: Vec<MapFile>,
    /// Samples a side.
    #[arg(long, value_name = "N", value_parser = size(), default_value_t = 2048)]
    pub size: u32,
    /// Families of rays, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = SolidFamily::ALL)]
    pub families: Vec<SolidFamily>,
    /// Thickness between the lowest and the highest offset, as shares of the body's size, parted by
    /// commas; of real maps it is divided by their repetitions.
    #[arg(long, value_name = "T,...", value_delimiter = ',', value_parser = depth,
          default_values_t = [0.001, 0.01, 0.03, 0.1, 0.2])]
    pub thickness: Vec<f64>,
    /// Pixels a side of the image that makes the rays.
    #[arg(long, value_name = "N", default_value_t = 512,
          value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub side: u32,
    /// Passes after the one that warms up; the median counts.
    #[arg(long, value_name = "N", default_value_t = 3,
          value_parser = clap::value_parser!(u16).range(1..))]
    pub passes: u16,
    /// Embree's configuration string.
    #[cfg(feature = "embree")]
    #[arg(long, value_name = "STRING", default_value = "threads=1")]
    pub embree_config: String,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Args)]
pub struct RefinementArgs {
    /// Base surfaces, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = Body::ALL)]
    pub bodies: Vec<Body>,
    /// The map.
    #[arg(long, value_enum, default_value = "moss")]
    pub map: MapName,
    /// Samples a side.
    #[arg(long, value_name = "N", value_parser = size(), default_value_t = 256)]
    pub size: u32,
    /// Families of rays that look for the nearest hit, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',',
          default_values_t = [SolidFamily::Primary, SolidFamily::Inside])]
    pub families: Vec<SolidFamily>,
    /// Thickness between the lowest and the highest offset, as a share of the body's size.
    #[arg(long, value_name = "T", value_parser = depth, default_value_t = 0.03)]
    pub thickness: f64,
    /// Parts that the side of a texel is cut into, parted by commas.
    #[arg(long, value_name = "N,...", value_delimiter = ',',
          value_parser = clap::value_parser!(u32).range(1..=64), default_values_t = [1, 2, 4, 8])]
    pub densities: Vec<u32>,
    /// Pixels a side of the image that makes the rays.
    #[arg(long, value_name = "N", default_value_t = 256,
          value_parser = clap::value_parser!(u32).range(16..=4096))]
    pub side: u32,
    /// Embree's configuration string.
    #[cfg(feature = "embree")]
    #[arg(long, value_name = "STRING", default_value = "threads=1")]
    pub embree_config: String,
}

#[derive(Debug, Args)]
pub struct BuildArgs {
    /// Maps, parted by commas.
    #[arg(long, value_enum, value_delimiter = ',', default_values_t = [MapName::Gaussian])]
    pub maps: Vec<MapName>,
    /// Samples a side, parted by commas.
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = size(),
          default_values_t = [1024, 2048, 4096, 8192, 16384])]
    pub sizes: Vec<u32>,
    /// Passes after the one that warms up; the median counts.
    #[arg(long, value_name = "N", default_value_t = 5,
          value_parser = clap::value_parser!(u16).range(1..))]
    pub passes: u16,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Args)]
pub struct GpuArgs {
    /// The map.
    #[arg(long, value_enum, default_value = "fbm")]
    pub map: MapName,
    /// Samples a side [default: 4096; 256 on a software adapter].
    #[arg(long, value_name = "N", value_parser = size())]
    pub size: Option<u32>,
    /// Samples a side of the map that is edited [default: 8192; 512 on a software adapter].
    #[arg(long, value_name = "N", value_parser = size())]
    pub edit_size: Option<u32>,
    /// Samples a side of the map as triangles, 0 for none; halved where the device cannot bind them [default:
    /// those of the map].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=32767))]
    pub peer_size: Option<u32>,
    /// Pixels across [default: 1920; 240 on a software adapter].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub width: Option<u32>,
    /// Pixels down [default: 1080; 135 on a software adapter].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=4096))]
    pub height: Option<u32>,
    /// Slices of distance maps, parted by commas.
    #[arg(long, value_name = "N,...", value_delimiter = ',', default_values_t = [16, 32],
          value_parser = clap::value_parser!(u32).range(2..=256))]
    pub slices: Vec<u32>,
    /// Voxels or nodes a side of distance maps, at most one a sample; published ones are made by brute force and may be
    /// coarser.
    #[arg(long, value_name = "N", default_value_t = 256,
          value_parser = clap::value_parser!(u32).range(2..=2048))]
    pub grid: u32,
    /// Scene units of height 1 over the unit square; real maps divide it by their repetitions.
    #[arg(long, value_name = "Z", default_value_t = 0.1, value_parser = depth)]
    pub depth: f64,
    /// Passes after the one that warms up; the median counts.
    #[arg(long, value_name = "N", default_value_t = 9,
          value_parser = clap::value_parser!(u16).range(1..))]
    pub passes: u16,
    #[command(flatten)]
    pub output: Output,
}

#[derive(Debug, Args)]
pub struct RunArgs {
    /// Folder of a recorded run, as bench/runs/2026-11-22-epyc.
    pub run: PathBuf,
}

#[derive(Debug, Args)]
pub struct PlotArgs {
    /// Folder of a recorded run.
    pub run: PathBuf,
    /// Folder for the plots [default: the run's].
    #[arg(short, long, value_name = "FOLDER")]
    pub output: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, Args)]
pub struct Output {
    /// One JSON object a line on standard output, in place of tables.
    #[arg(long)]
    pub json: bool,
}

/// Samples a side: room for a few cells, and at most what a GRID holds.
fn size() -> clap::builder::RangedI64ValueParser<u32> {
    clap::value_parser!(u32).range(16..=32767)
}

fn kind() -> impl TypedValueParser<Value = DistanceKind> {
    let kinds = [DistanceKind::Boxes, DistanceKind::Corrected, DistanceKind::Published];
    let find = move |text: String| kinds.into_iter().find(|&kind| name(kind) == text);
    PossibleValuesParser::new(kinds.map(name))
        .try_map(move |text| find(text).ok_or("no kind of distance map"))
}

fn simd() -> impl TypedValueParser<Value = SimdLevel> {
    let names: Vec<_> = SimdLevel::available().iter().map(|level| level.name()).collect();
    PossibleValuesParser::new(names).try_map(|name| name.parse::<SimdLevel>())
}

fn depth(text: &str) -> Result<f64, String> {
    match text.parse() {
        Ok(depth) if depth > 0.0 && depth <= 10.0 => Ok(depth),
        _ => Err("a depth lies above 0 and is at most 10".to_owned()),
    }
}

/// A number of bytes with an optional unit K, M or G (powers of 1024).
fn bytes(text: &str) -> Result<u64, String> {
    let (digits, shift) = match text.char_indices().last() {
        Some((at, 'K')) => (&text[..at], 10),
        Some((at, 'M')) => (&text[..at], 20),
        Some((at, 'G')) => (&text[..at], 30),
        _ => (text, 0),
    };
    let count = digits.parse::<u64>().ok();
    let bytes = count.and_then(|n| n.checked_mul(1 << shift));
    bytes.ok_or_else(|| "a number of bytes such as 512M or 10G".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernels(words: &[&str]) -> Result<KernelArgs, clap::Error> {
        let words = ["rilievo-bench", "kernels"].iter().chain(words);
        Arguments::try_parse_from(words).map(|arguments| match arguments.command {
            Command::Kernels(args) => args,
            other => panic!("{other:?}"),
        })
    }

    #[test]
    fn lists_are_parted_by_commas_and_default_to_everything() {
        let args = kernels(&["--maps", "fbm,moss", "--sizes", "512,1024", "--json"]).unwrap();
        assert_eq!(args.maps, [MapName::Fbm, MapName::Moss]);
        assert_eq!((args.sizes.as_slice(), args.output.json), (&[512, 1024][..], true));
        assert_eq!((args.families.len(), args.contenders.len()), (5, Contender::ALL.len()));
    }

    #[test]
    fn nonsense_is_refused() {
        for words in [["--sizes", "3"], ["--depth", "0"], ["--max-memory", "1X"], ["--passes", "0"]]
        {
            assert!(kernels(&words).is_err(), "{words:?}");
        }
    }

    #[test]
    fn bytes_have_units() {
        assert_eq!(bytes("10G"), Ok(10 << 30));
        assert_eq!(bytes("77"), Ok(77));
        assert!(bytes("").is_err() && bytes("99999999999G").is_err());
    }
}
