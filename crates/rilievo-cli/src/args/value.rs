//! Values of flags: text to numbers, names and paths.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::builder::{PathBufValueParser, PossibleValuesParser, TypedValueParser};
use rilievo::SimdLevel;
use rilievo::map::{
    DistanceBits, DistanceKind, Lattice, Layout, NormalConvention, NormalKind, Wrap,
};
use rilievo::relief::Method;
use rilievo_gpu::Backend;
use rilievo_io::image::Stored;
use rilievo_render::film::Tile;
use rilievo_render::film::tonemap::{ToneMap, View};
use rilievo_render::{Aov, Camera, Filter, FilterKind, Integrator, RenderSettings, SamplerKind};

use crate::name;

/// Where an EXR goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ExrPath(pub PathBuf);

impl ExrPath {
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        PathBufValueParser::new().try_map(|path| {
            let named = has_extension(&path, "exr");
            if named { Ok(Self(path)) } else { Err("the name must end in .exr") }
        })
    }
}

/// How a picture is stored, told from the name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PictureFormat {
    Exr,
    Png,
}

/// Where a picture goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PicturePath {
    pub path: PathBuf,
    pub format: PictureFormat,
}

impl PicturePath {
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        PathBufValueParser::new().try_map(|path| {
            let format = if has_extension(&path, "exr") {
                PictureFormat::Exr
            } else if has_extension(&path, "png") {
                PictureFormat::Png
            } else {
                return Err("the name must end in .exr or .png");
            };
            Ok(Self { path, format })
        })
    }
}

/// Where a PNG goes.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct PngPath(pub PathBuf);

impl PngPath {
    pub fn parser() -> impl TypedValueParser<Value = Self> {
        PathBufValueParser::new().try_map(|path| {
            if has_extension(&path, "png") {
                Ok(Self(path))
            } else {
                Err("the name must end in .png")
            }
        })
    }
}

/// Whether `path` ends in `.extension`, in capitals or not.
pub fn has_extension(path: &Path, extension: &str) -> bool {
    let found = path.extension().and_then(OsStr::to_str);
    found.is_some_and(|found| found.eq_ignore_ascii_case(extension))
}

/// One of a closed set, by name; the names are listed in help and errors.
fn named<T: Copy + Send + Sync + 'static, const N: usize>(
    names: [(&'static str, T); N],
) -> impl TypedValueParser<Value = T> {
    PossibleValuesParser::new(names.map(|entry| entry.0)).try_map(move |name| {
        let found = names.iter().find(|entry| entry.0 == name);
        found.map(|entry| entry.1).ok_or("no such name")
    })
}

pub fn method() -> impl TypedValueParser<Value = Method> {
    PossibleValuesParser::new(Method::ALL.map(Method::name)).try_map(|name| name.parse::<Method>())
}

pub fn layout() -> impl TypedValueParser<Value = Layout> {
    PossibleValuesParser::new(Layout::ALL.map(Layout::name)).try_map(|name| name.parse::<Layout>())
}

pub fn simd() -> impl TypedValueParser<Value = SimdLevel> {
    let names: Vec<_> = SimdLevel::available().iter().map(|level| level.name()).collect();
    PossibleValuesParser::new(names).try_map(|name| name.parse::<SimdLevel>())
}

pub fn integrator() -> impl TypedValueParser<Value = Integrator> {
    let names = Integrator::ALL.map(Integrator::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<Integrator>())
}

pub fn sampler() -> impl TypedValueParser<Value = SamplerKind> {
    let names = SamplerKind::ALL.map(SamplerKind::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<SamplerKind>())
}

pub fn aov() -> impl TypedValueParser<Value = Aov> {
    PossibleValuesParser::new(Aov::ALL.map(Aov::name)).try_map(|name| name.parse::<Aov>())
}

pub fn backend() -> impl TypedValueParser<Value = Backend> {
    PossibleValuesParser::new(Backend::ALL.map(Backend::name)).try_map(|name| name.parse())
}

pub fn filter() -> impl TypedValueParser<Value = FilterKind> {
    let names = FilterKind::ALL.map(FilterKind::name);
    PossibleValuesParser::new(names).try_map(|name| name.parse::<FilterKind>())
}

/// Pixels from a pixel's centre to the border of its filter.
pub fn filter_radius(text: &str) -> Result<f64, String> {
    let most = Filter::MAX_RADIUS;
    let found = text.parse().ok().filter(|&x: &f64| x > 0.0 && x <= most);
    found.ok_or_else(|| format!("expected pixels above 0, at most {most}"))
}

pub fn view() -> impl TypedValueParser<Value = View> {
    PossibleValuesParser::new(View::ALL.map(View::name)).try_map(|name| name.parse::<View>())
}

pub fn stored() -> impl TypedValueParser<Value = Stored> {
    named([("half", Stored::Half), ("float", Stored::Float)])
}

/// Pixels along a side of a tile.
pub fn tiles(text: &str) -> Result<u32, String> {
    let found = text.parse().ok().filter(|n| (16..=4096).contains(n));
    found.ok_or_else(|| "expected 16 to 4096 pixels".to_owned())
}

pub fn lattice() -> impl TypedValueParser<Value = Lattice> {
    named([Lattice::Texel, Lattice::Vertex].map(|lattice| (name::lattice(lattice), lattice)))
}

pub fn wrap() -> impl TypedValueParser<Value = Wrap> {
    named([Wrap::Repeat, Wrap::Clamp, Wrap::Mirror].map(|wrap| (name::wrap(wrap), wrap)))
}

pub fn normal_kind() -> impl TypedValueParser<Value = NormalKind> {
    named([
        ("exact", NormalKind::Exact),
        ("smooth", NormalKind::Smooth),
        ("published", NormalKind::Published),
    ])
}

pub fn convention() -> impl TypedValueParser<Value = NormalConvention> {
    named([NormalConvention::OpenGl, NormalConvention::DirectX].map(|c| (name::convention(c), c)))
}

pub fn distance_kind() -> impl TypedValueParser<Value = DistanceKind> {
    let kinds = [DistanceKind::Published, DistanceKind::Boxes, DistanceKind::Corrected];
    named(kinds.map(|kind| (name::distance_kind(kind), kind)))
}

pub fn bits() -> impl TypedValueParser<Value = DistanceBits> {
    named([("8", DistanceBits::U8), ("16", DistanceBits::U16)])
}

/// `A..B`: samples of a pixel by absolute index.
pub fn sample_range(text: &str) -> Result<[u32; 2], String> {
    let most = RenderSettings::MAX_SAMPLES;
    let (first, end) = text.split_once("..").unwrap_or_default();
    let range = first.parse().ok().zip(end.parse().ok());
    let found = range.filter(|(first, end)| first < end && *end <= most);
    let (first, end) = found
        .ok_or_else(|| format!("expected A..B with A below B and B at most {most}, as 0..128"))?;
    Ok([first, end])
}

/// `X0,Y0,X1,Y1`: the pixels of a window.
pub fn crop(text: &str) -> Result<Tile, String> {
    let found = parts::<u32, 4>(text, ',').filter(|[x0, y0, x1, y1]| x0 < x1 && y0 < y1);
    let [x0, y0, x1, y1] = found.ok_or("expected X0,Y0,X1,Y1 with X0 below X1, Y0 below Y1")?;
    Ok(Tile { corner: [x0, y0], size: [x1 - x0, y1 - y0] })
}

/// A radiance, or 0.
pub fn clamp(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|most: &f64| most.is_finite() && *most >= 0.0);
    found.ok_or_else(|| "expected a number of at least 0, as 10".to_owned())
}

/// Pixels, or 0.
pub fn lod(text: &str) -> Result<f64, String> {
    let allowed = 0.0..=RenderSettings::MAX_LOD;
    let found = text.parse().ok().filter(|pixels| allowed.contains(pixels));
    found
        .ok_or_else(|| format!("expected a number of pixels from 0 to {}", RenderSettings::MAX_LOD))
}

/// A relative error.
pub fn max_error(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|error: &f64| error.is_finite() && *error > 0.0);
    found.ok_or_else(|| "expected a number above 0, as 0.02".to_owned())
}

/// Seconds, or 0.
pub fn interval(text: &str) -> Result<Duration, String> {
    match text.parse::<f64>() {
        Ok(0.0) => Ok(Duration::ZERO),
        _ => seconds(text).map_err(|why| format!("{why}, or 0")),
    }
}

/// `WxH` in pixels.
pub fn resolution(text: &str) -> Result<[u32; 2], String> {
    let most = Camera::MAX_RESOLUTION;
    let found = parts::<u32, 2>(text, 'x').filter(|r| r.iter().all(|n| (1..=most).contains(n)));
    found.ok_or_else(|| format!("expected WxH with 1 to {most} pixels a side, as 640x400"))
}

/// `WxH` in scene units.
pub fn sides(text: &str) -> Result<[f64; 2], String> {
    let found = parts::<f64, 2>(text, 'x').filter(|s| s.iter().all(|&n| is_length(n)));
    found.ok_or_else(|| "expected WxH with lengths above 0, as 2x1.5".to_owned())
}

/// A length in scene units.
pub fn length(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|&n| is_length(n));
    found.ok_or_else(|| "expected a length above 0".to_owned())
}

fn is_length(n: f64) -> bool {
    n.is_finite() && n > 0.0
}

/// `NX,NY,NZ`.
pub fn size3(text: &str) -> Result<[u32; 3], String> {
    let found = parts::<u32, 3>(text, ',').filter(|s| s.iter().all(|&n| n > 0));
    found.ok_or_else(|| "expected NX,NY,NZ with counts above 0, as 256,256,32".to_owned())
}

/// Camera rays per pixel.
pub fn samples(text: &str) -> Result<u32, String> {
    let most = RenderSettings::MAX_SAMPLES;
    let found = text.parse().ok().filter(|n| (1..=most).contains(n));
    found.ok_or_else(|| format!("expected 1 to {most}"))
}

/// Stops, either way.
pub fn exposure(text: &str) -> Result<f64, String> {
    let most = ToneMap::MAX_STOPS;
    let found = text.parse().ok().filter(|x: &f64| x.abs() <= most);
    found.ok_or_else(|| format!("expected stops from -{most} to {most}"))
}

/// Threads; more than a few thousand are a slip of the hand.
pub fn threads(text: &str) -> Result<usize, String> {
    let found = text.parse().ok().filter(|&n| n <= 4096);
    found.ok_or_else(|| "expected 0 to 4096".to_owned())
}

/// Bytes, perhaps with K, M, G or T for powers of 1024.
pub fn bytes(text: &str) -> Result<u64, String> {
    let split = text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len());
    let (number, unit) = text.split_at(split);
    let shift = match unit.to_ascii_uppercase().trim_end_matches("IB").trim_end_matches('B') {
        "" => 0,
        "K" => 10,
        "M" => 20,
        "G" => 30,
        "T" => 40,
        _ => 64,
    };
    let found = number.parse::<u64>().ok().filter(|_| shift < 64);
    let found = found.and_then(|n| n.checked_mul(1 << (shift & 63)));
    found.filter(|&n| n > 0).ok_or_else(|| "expected a size above 0, as 512M or 2G".to_owned())
}

/// A span of time.
pub fn seconds(text: &str) -> Result<Duration, String> {
    let found = text.parse::<f64>().ok().filter(|&s| s > 0.0);
    let found = found.and_then(|s| Duration::try_from_secs_f64(s).ok());
    found.ok_or_else(|| "expected seconds above 0".to_owned())
}

/// A difference that is allowed.
pub fn threshold(text: &str) -> Result<f64, String> {
    let found = text.parse().ok().filter(|&x: &f64| x >= 0.0);
    found.ok_or_else(|| "expected a number of at least 0".to_owned())
}

/// `N` values parted by `separator`.
fn parts<T: std::str::FromStr, const N: usize>(text: &str, separator: char) -> Option<[T; N]> {
    let parts: Vec<T> = text.split(separator).map(str::parse).collect::<Result<_, _>>().ok()?;
    parts.try_into().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_and_nonsense_is_refused() {
        assert_eq!(resolution("640x400"), Ok([640, 400]));
        for text in ["640", "640x", "0x4", "4x0", "640x400x3", "70000x1", "-1x4", "4X4"] {
            assert!(resolution(text).is_err(), "{text}");
        }
        assert_eq!(sides("2x0.5"), Ok([2.0, 0.5]));
        assert!(sides("2x-1").is_err() && sides("infx1").is_err() && sides("NaNx1").is_err());
        assert_eq!(size3("1,2,3"), Ok([1, 2, 3]));
        assert!(size3("1,2").is_err() && size3("1,2,0").is_err());
    }

    #[test]
    fn bytes_take_binary_units() {
        for (text, want) in [("7", 7), ("1K", 1 << 10), ("3MiB", 3 << 20), ("2gb", 2 << 30)] {
            assert_eq!(bytes(text), Ok(want), "{text}");
        }
        for text in ["", "M", "1X", "-1", "0", "1.5G", "99999999999T", "1KK"] {
            assert!(bytes(text).is_err(), "{text}");
        }
    }

    #[test]
    fn times_and_thresholds_are_positive_numbers() {
        assert_eq!(seconds("1.5"), Ok(Duration::from_millis(1500)));
        for text in ["0", "-1", "NaN", "inf", "soon"] {
            assert!(seconds(text).is_err(), "{text}");
        }
        assert_eq!(threshold("0"), Ok(0.0));
        assert!(threshold("-1").is_err() && threshold("NaN").is_err());
    }

    #[test]
    fn extensions_are_told_in_any_case() {
        assert!(has_extension(Path::new("a/b.PNG"), "png"));
        assert!(!has_extension(Path::new("a.png/b"), "png"));
        assert!(!has_extension(Path::new(".png"), "png"));
    }
}
