//! The flags of `rilievo bake`.

use std::path::PathBuf;

use clap::{Args, Subcommand};
use rilievo::map::{DistanceBits, DistanceKind, Layout, NormalConvention, NormalKind};

use super::{MapMeaning, Talk, value};

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

pub(super) const EXAMPLES: &str = "\
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
