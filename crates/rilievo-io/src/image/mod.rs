//! Image files: height maps, colour images, normal maps, rendered pictures.
//!
//! | format | height map | colour | named channels | written |
//! |---|---|---|---|---|
//! | PNG 1-16 bit, all colour types | yes | yes, sRGB | yes | RGB 8 and 16 bit, grey 16 bit |
//! | TIFF 8-64 bit integers, 16-64 bit floats | yes | 8, 16 bit: sRGB; floats: linear | yes | no |
//! | JPEG 8 bit | yes | yes, sRGB | yes | no |
//! | OpenEXR half, float, uint | yes: `Y`, or `Z`, or `R` alone, or `R G B` | yes, linear | yes | half and float, lines and tiles, ZIP |
//! | PFM | yes | yes, linear | yes | no |
//! | Radiance HDR | yes | yes, linear | yes | no |
//! | Esri ASCII grid, SRTM `.hgt`, `.bil` with `.hdr` | yes | no use | yes | no |
//!
//! The format is told from the first bytes, not from the name. Row 0 of what this module returns
//! as a map or a texture is the *bottom* row of the image (`v = 0`); only [`ChannelImage`], a
//! picture, keeps its top row first.
//!
//! Sizes declared in headers are checked against [`Limits`] before anything is allocated, and a
//! panic of a decoder is an error like any other.

mod channels;
mod colour;
mod exr;
mod grid;
mod height;
mod jpeg;
mod normal;
mod pfm;
mod png;
mod radiance;
mod raw;
mod read_channels;
mod source;
mod terrain;
mod tiff;
mod udim;
mod write_exr;
mod write_png;

use std::path::Path;

pub use channels::{Attribute, Channel, ChannelImage};
pub use colour::{read_colour, read_colour_bytes};
pub(crate) use exr::{ExrLines, Line};
pub use height::HeightOptions;
pub use normal::NormalOptions;
pub(crate) use source::Source;
pub use source::{ImageInfo, SampleKind};
pub use terrain::Terrain;
pub use udim::Udim;
pub(crate) use udim::{MARK, number};
pub use write_exr::{Blocks, Crop, Picture, PictureChannel, Stored, Values};
pub use write_png::{write_png_grey16, write_png_rgb8, write_png_rgb16};

use crate::error::Result;
use crate::guard::guarded;
use crate::limits::Limits;
use source::{Flow, Row, Sink};

/// The image formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// Portable Network Graphics.
    Png,
    /// TIFF and BigTIFF.
    Tiff,
    /// JPEG.
    Jpeg,
    /// OpenEXR.
    Exr,
    /// Portable float map.
    Pfm,
    /// Radiance's picture of shared exponents.
    Radiance,
    /// Esri ASCII grid.
    AsciiGrid,
    /// SRTM's heights, signed 16-bit metres.
    Hgt,
    /// Samples alone, with an Esri header beside them.
    Raw,
}

impl ImageFormat {
    /// What is read, in words.
    pub(crate) const NAMES: &'static str =
        "PNG, TIFF, JPEG, OpenEXR, PFM, Radiance HDR, Esri ASCII grid, .hgt, .bil";

    /// The format of a file that begins with `head`.
    pub fn of(head: &[u8]) -> Option<Self> {
        match head {
            [0x89, b'P', b'N', b'G', ..] => Some(Self::Png),
            [b'I', b'I', 42 | 43, 0, ..] | [b'M', b'M', 0, 42 | 43, ..] => Some(Self::Tiff),
            [0xff, 0xd8, ..] => Some(Self::Jpeg),
            [0x76, 0x2f, 0x31, 0x01, ..] => Some(Self::Exr),
            [b'P', b'F' | b'f', b'\n' | b'\r' | b' ' | b'\t', ..] => Some(Self::Pfm),
            [b'#', b'?', ..] => Some(Self::Radiance),
            [b'n' | b'N', b'c' | b'C', b'o' | b'O', b'l' | b'L', b's' | b'S', ..] => {
                Some(Self::AsciiGrid)
            }
            _ => None,
        }
    }

    /// The format of a file called `path` that begins with `head`: by its content, of formats
    /// without a mark by the ending of its name.
    pub fn of_file(head: &[u8], path: &Path) -> Option<Self> {
        Self::of(head).or_else(|| {
            let ending = path.extension()?.to_str()?.to_ascii_lowercase();
            match ending.as_str() {
                "hgt" => Some(Self::Hgt),
                "bil" | "raw" | "r16" | "r32" | "flt" => Some(Self::Raw),
                _ => None,
            }
        })
    }
}

impl std::fmt::Display for ImageFormat {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Png => "PNG",
            Self::Tiff => "TIFF",
            Self::Jpeg => "JPEG",
            Self::Exr => "OpenEXR",
            Self::Pfm => "PFM",
            Self::Radiance => "Radiance HDR",
            Self::AsciiGrid => "Esri ASCII grid",
            Self::Hgt => "SRTM heights",
            Self::Raw => "raw heights",
        })
    }
}

/// Decodes `source` into `sink`.
fn decode(mut source: Source<'_>, sink: &mut dyn Sink) -> Result<()> {
    guarded(source.context.path, move || {
        let format = source.format()?;
        let Source { context, input } = source;
        match format {
            ImageFormat::Png => png::decode(context, input, sink),
            ImageFormat::Tiff => tiff::decode(context, input, sink),
            ImageFormat::Jpeg => jpeg::decode(context, input, sink),
            ImageFormat::Exr => exr::decode(context, input, sink),
            ImageFormat::Pfm => pfm::decode(context, input, sink),
            ImageFormat::Radiance => radiance::decode(context, input, sink),
            ImageFormat::AsciiGrid => grid::decode(context, input, sink),
            ImageFormat::Hgt | ImageFormat::Raw => raw::decode(context, format, input, sink),
        }
    })
}

/// Reads the header of an image and nothing else; of an image in tiles ([`Udim`]), of the first of
/// them.
///
/// # Errors
/// As the readers, for what the header shows.
pub fn read_image_info(path: &Path, limits: &Limits) -> Result<ImageInfo> {
    if let Some(tiles) = Udim::find(path)? {
        let first = info_of(Source::open(tiles.first(), limits)?)?;
        let width = first.width.saturating_mul(tiles.columns);
        let height = first.height.saturating_mul(tiles.rows);
        return Ok(ImageInfo { width, height, ..first });
    }
    info_of(Source::open(path, limits)?)
}

/// Reads the header of an image in bytes; `name` is what errors call them.
///
/// # Errors
/// As [`read_image_info`].
pub fn read_image_info_bytes(bytes: &[u8], name: &Path, limits: &Limits) -> Result<ImageInfo> {
    info_of(Source::from_bytes(bytes, name, limits))
}

fn info_of(source: Source<'_>) -> Result<ImageInfo> {
    /// Keeps the header.
    struct Header(Option<ImageInfo>);

    impl Sink for Header {
        fn begin(&mut self, info: &ImageInfo) -> Result<Flow> {
            self.0 = Some(*info);
            Ok(Flow::Stop)
        }

        fn row(&mut self, _: u32, _: Row<'_>) {}
    }

    let mut header = Header(None);
    let context = source.context;
    decode(source, &mut header)?;
    header.0.ok_or_else(|| context.damaged("no header"))
}
