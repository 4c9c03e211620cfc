//! [`Terrain`]: how large the cells of a height file are on the ground.
//!
//! | format | size of a cell |
//! |---|---|
//! | GeoTIFF | `ModelPixelScale`, in the linear unit of its projection, or degrees \[OGC2019\] |
//! | Esri ASCII grid | `cellsize`, or `dx` and `dy` |
//! | `.hgt` | a degree over the number of rows less one, by the place in its name |
//! | `.bil` and its like | `XDIM`, `YDIM` of the header beside it |
//!
//! Formats that do not name their unit are taken for degrees where all of the map lies within the
//! degrees of the globe and cells are smaller than one, for metres otherwise. Degrees become metres
//! at the middle latitude, by the usual series for the WGS 84 ellipsoid; over a map of a degree the
//! change of width with latitude is lost.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use tiff::decoder::Decoder;
use tiff::tags::Tag;

use super::ImageFormat;
use super::grid::GridHeader;
use super::raw::RawHeader;
use super::source::Source;
use super::udim::Udim;
use crate::error::{Error, Result};
use crate::guard::guarded;
use crate::limits::Limits;

/// Tags of GeoTIFF and GDAL.
const PIXEL_SCALE: u16 = 33550;
const TIE_POINT: u16 = 33922;
const GEO_KEYS: u16 = 34735;
pub(super) const GDAL_NODATA: u16 = 42113;
/// Keys of the directory: kind of coordinates, linear unit, vertical unit.
const MODEL_TYPE: u16 = 1024;
const LINEAR_UNIT: u16 = 3076;
const VERTICAL_UNIT: u16 = 4099;
/// Kind of coordinates that are degrees.
const GEOGRAPHIC: u16 = 2;

/// The ground under a height map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Terrain {
    /// Metres from one sample to the next along u and v.
    pub cell: [f64; 2],
    /// Metres of a unit of height: 1, but for maps in feet. Of codes, a unit is a code.
    pub metre: f64,
    /// Latitude of the middle, degrees, if the file's cells are degrees.
    pub latitude: Option<f64>,
}

impl Terrain {
    /// What `path` says of the ground; none if it is no height file with a place.
    ///
    /// # Errors
    /// Of the file or its header.
    pub fn read(path: &Path, limits: &Limits) -> Result<Option<Self>> {
        // Tiles of a texture lie on uv, not on the ground.
        if Udim::find(path)?.is_some() {
            return Ok(None);
        }
        let mut source = Source::open(path, limits)?;
        let format = source.format()?;
        let Source { context, mut input } = source;
        match format {
            ImageFormat::Tiff => guarded(path, || of_tiff(path)),
            ImageFormat::AsciiGrid => {
                let h = GridHeader::read(context, &mut *input)?;
                let middle = [0, 1]
                    .map(|k| h.corner[k] + 0.5 * h.cell[k] * f64::from([h.columns, h.rows][k]));
                Ok(of_unknown(h.cell, middle))
            }
            ImageFormat::Hgt | ImageFormat::Raw => {
                let h = RawHeader::read(context, format, &mut *input)?;
                let middle = |cell: [f64; 2]| {
                    let half = [h.columns, h.rows].map(|n| 0.5 * f64::from(n));
                    [h.corner[0] + half[0] * cell[0], h.corner[1] - half[1] * cell[1]]
                };
                Ok(h.cell.and_then(|cell| of_unknown(cell, middle(cell))))
            }
            _ => Ok(None),
        }
    }

    fn of_metres(cell: [f64; 2], metre: f64) -> Option<Self> {
        let cell = cell.map(f64::abs);
        let sound = cell.iter().chain([&metre]).all(|c| c.is_finite() && *c > 0.0);
        sound.then_some(Self { cell, metre, latitude: None })
    }

    fn of_degrees(cell: [f64; 2], latitude: f64, metre: f64) -> Option<Self> {
        let turn = latitude.to_radians();
        let cosine = |k: f64| (k * turn).cos();
        let across = 111_412.84 * cosine(1.0) - 93.5 * cosine(3.0) + 0.118 * cosine(5.0);
        let along = 111_132.92 - 559.82 * cosine(2.0) + 1.175 * cosine(4.0);
        let ground = Self::of_metres([cell[0] * across, cell[1] * along], metre)?;
        Some(Self { latitude: Some(latitude), ..ground })
    }
}

/// Cells of a format that names no unit.
fn of_unknown(cell: [f64; 2], middle: [f64; 2]) -> Option<Terrain> {
    let globe = middle[0].abs() <= 360.0 && middle[1].abs() < 90.0 && cell.iter().all(|c| *c < 1.0);
    match globe {
        true => Terrain::of_degrees(cell, middle[1], 1.0),
        false => Terrain::of_metres(cell, 1.0),
    }
}

fn of_tiff(path: &Path) -> Result<Option<Terrain>> {
    let damaged =
        |e: tiff::TiffError| Error::invalid(path, crate::Place::File, "content", e.to_string(), "");
    let file = File::open(path).map_err(|e| Error::io(path, e))?;
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(damaged)?;
    let (_, rows) = decoder.dimensions().map_err(damaged)?;
    // Of damaged tags nothing is known of the ground; the heights are read all the same.
    let mut numbers = |tag: u16| decoder.get_tag_f64_vec(Tag::Unknown(tag)).unwrap_or_default();
    let (scale, tie) = (numbers(PIXEL_SCALE), numbers(TIE_POINT));
    let keys = decoder.get_tag_u16_vec(Tag::Unknown(GEO_KEYS)).unwrap_or_default();
    let key = |wanted: u16| {
        // Four numbers an entry: key, 0 for a value that stands here, count, value.
        let entries = keys.chunks_exact(4).skip(1);
        entries.filter(|e| e[1] == 0).find(|e| e[0] == wanted).map(|e| e[3])
    };
    let [x, y, ..] = *scale.as_slice() else { return Ok(None) };
    let metre = unit(key(VERTICAL_UNIT));
    if key(MODEL_TYPE) == Some(GEOGRAPHIC) {
        let top = tie.get(4).copied().unwrap_or(0.0);
        let latitude = top + tie.get(1).map_or(0.0, |row| row * y) - 0.5 * f64::from(rows) * y;
        return Ok(Terrain::of_degrees([x, y], latitude, metre));
    }
    let linear = unit(key(LINEAR_UNIT));
    Ok(Terrain::of_metres([x * linear, y * linear], metre))
}

/// Metres of a linear unit by its EPSG code.
fn unit(code: Option<u16>) -> f64 {
    match code {
        Some(9002) => 0.3048,
        // US survey foot.
        Some(9003) => 1200.0 / 3937.0,
        _ => 1.0,
    }
}

/// The number of `GDAL_NODATA`, a text.
pub(super) fn void_of_text(text: &str) -> Option<f32> {
    text.trim_matches(|c: char| c.is_whitespace() || c == '\0').parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn degrees_become_metres_where_they_are() {
        // A minute of latitude is a sea mile, nearly; of longitude it shrinks by the cosine.
        let equator = Terrain::of_degrees([1.0 / 60.0; 2], 0.0, 1.0).unwrap();
        assert!((equator.cell[0] - 1855.3).abs() < 0.5 && (equator.cell[1] - 1842.9).abs() < 0.5);
        let north = Terrain::of_degrees([1.0 / 60.0; 2], 60.0, 1.0).unwrap();
        assert!((north.cell[0] / equator.cell[0] - 0.5).abs() < 0.003);
        assert_eq!(Terrain::of_degrees([1.0; 2], 90.0, f64::NAN), None);
    }

    #[test]
    fn cells_without_a_unit_are_degrees_on_the_globe_only() {
        assert!(of_unknown([1.0 / 1200.0; 2], [-105.4, 40.1]).unwrap().latitude.is_some());
        assert_eq!(of_unknown([30.0; 2], [5e5, 4e6]).unwrap().cell, [30.0; 2]);
        assert_eq!(of_unknown([0.5; 2], [5e5, 4e6]).unwrap().cell, [0.5; 2]);
        assert_eq!(of_unknown([0.0; 2], [0.0; 2]), None);
    }

    #[test]
    fn voids_are_read_from_their_text() {
        assert_eq!(void_of_text("-9999\0"), Some(-9999.0));
        assert_eq!(void_of_text(" -3.4e38 "), Some(-3.4e38));
        assert!(void_of_text("nan").unwrap().is_nan());
        assert_eq!(void_of_text("none"), None);
    }
}
