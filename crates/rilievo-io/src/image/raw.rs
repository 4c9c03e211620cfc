//! Heights without a header of their own: SRTM's `.hgt`, and `.bil` and its like with an Esri
//! header beside it.
//!
//! * `.hgt`: signed 16-bit metres, big endian, as many rows as columns, the top row first;
//!   -32768 where nothing was measured \[Farr2007\].
//! * `.bil`, `.raw`, `.r16`, `.r32`, `.flt`: one band, described by a text file of the same name ending in
//!   `.hdr`: `NROWS`, `NCOLS`, `NBITS`, `PIXELTYPE`, `BYTEORDER`, `SKIPBYTES`, `NODATA`, `XDIM`, `YDIM`.
//!   Unsigned integers of 8 and 16 bits are codes, as in every other format; the rest are numbers.

use std::io::SeekFrom;
use std::path::Path;

use super::ImageFormat;
use super::source::{Context, Flow, ImageInfo, Input, Row, SampleKind, Sink};
use crate::error::{Error, Place, Result};

/// What `.hgt` files hold where nothing was measured.
const VOID: f32 = -32768.0;

/// How a sample is stored.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sample {
    U8,
    U16,
    I16,
    I32,
    F32,
}

/// What is known of the samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct RawHeader {
    pub columns: u32,
    pub rows: u32,
    sample: Sample,
    big_endian: bool,
    skip: u64,
    void: Option<f32>,
    /// Side of a cell along x and y, if the header says, and the centre of the upper left one.
    pub cell: Option<[f64; 2]>,
    pub corner: [f64; 2],
}

impl RawHeader {
    /// The header of the file of `context`, by its format.
    pub fn read(context: Context<'_>, format: ImageFormat, input: &mut dyn Input) -> Result<Self> {
        match format {
            ImageFormat::Hgt => Self::of_hgt(context, input),
            _ => Self::beside(context),
        }
    }

    fn of_hgt(context: Context<'_>, input: &mut dyn Input) -> Result<Self> {
        let fail = |e| Error::io(context.path, e);
        let length = input.seek(SeekFrom::End(0)).map_err(fail)?;
        input.rewind().map_err(fail)?;
        let side = (length / 2).isqrt();
        if length % 2 != 0 || side * side * 2 != length || side > u64::from(u32::MAX) {
            let allowed = "twice a square, such as 2884802 or 25934402";
            let found = format!("{length} bytes");
            return Err(Error::invalid(context.path, Place::File, "size", found, allowed));
        }
        let cell = 1.0 / (side.max(2) - 1) as f64;
        let (columns, rows) = (side as u32, side as u32);
        let (sample, void) = (Sample::I16, Some(VOID));
        let (cell, corner) = match place_of(context.path) {
            Some([longitude, latitude]) => (Some([cell; 2]), [longitude, latitude + 1.0]),
            None => (None, [0.0; 2]),
        };
        Ok(Self { columns, rows, sample, big_endian: true, skip: 0, void, cell, corner })
    }

    /// The header that lies beside a file.
    fn beside(context: Context<'_>) -> Result<Self> {
        let path = context.path.with_extension("hdr");
        let text = context.limits.read(&path)?;
        let text = String::from_utf8_lossy(&text);
        let find = |key: &str| {
            text.lines().find_map(|line| {
                let (name, value) = line.trim().split_once(char::is_whitespace)?;
                name.eq_ignore_ascii_case(key).then(|| value.trim())
            })
        };
        let fault = |key: &str, found: &str, allowed: &str| {
            Error::invalid(&path, Place::Header, key, found, allowed)
        };
        let whole = |key: &str| -> Result<Option<u32>> {
            let Some(value) = find(key) else { return Ok(None) };
            value.parse().map(Some).map_err(|_| fault(key, value, "a whole number"))
        };
        let number = |key: &str| -> Result<Option<f64>> {
            let Some(value) = find(key) else { return Ok(None) };
            let finite = value.parse::<f64>().ok().filter(|n| n.is_finite());
            finite.map(Some).ok_or_else(|| fault(key, value, "a number"))
        };
        let side = |key: &str| match whole(key)? {
            Some(side) if side > 0 => Ok(side),
            _ => Err(fault(key, find(key).unwrap_or("missing"), "a number from 1 on")),
        };
        let (columns, rows) = (side("NCOLS")?, side("NROWS")?);
        if let Some(bands @ (0 | 2..)) = whole("NBANDS")? {
            return Err(fault("NBANDS", &bands.to_string(), "1"));
        }
        let bits = whole("NBITS")?.unwrap_or(8);
        let kind = find("PIXELTYPE").unwrap_or("UNSIGNEDINT").to_ascii_uppercase();
        let sample = match (bits, kind.as_str()) {
            (8, "UNSIGNEDINT") => Sample::U8,
            (16, "UNSIGNEDINT") => Sample::U16,
            (16, "SIGNEDINT") => Sample::I16,
            (32, "SIGNEDINT") => Sample::I32,
            (32, "FLOAT") => Sample::F32,
            _ => {
                let allowed = "UNSIGNEDINT of 8 or 16 bits, SIGNEDINT of 16 or 32, FLOAT of 32";
                return Err(fault("PIXELTYPE", &format!("{kind} of {bits} bits"), allowed));
            }
        };
        let big_endian = match find("BYTEORDER").unwrap_or("I").to_ascii_uppercase().as_str() {
            "I" | "LSBFIRST" | "LSB" => false,
            "M" | "MSBFIRST" | "MSB" => true,
            other => return Err(fault("BYTEORDER", other, "I (little endian), M (big endian)")),
        };
        let cell = number("XDIM")?.zip(number("YDIM")?).map(|(x, y)| [x, y]);
        Ok(Self {
            columns,
            rows,
            sample,
            big_endian,
            skip: u64::from(whole("SKIPBYTES")?.unwrap_or(0)),
            void: number("NODATA")?.map(|void| void as f32),
            cell,
            corner: [number("ULXMAP")?.unwrap_or(0.0), number("ULYMAP")?.unwrap_or(0.0)],
        })
    }

    fn info(&self, format: ImageFormat) -> ImageInfo {
        let (sample, file_bits) = match self.sample {
            Sample::U8 => (SampleKind::U8, 8),
            Sample::U16 => (SampleKind::U16, 16),
            Sample::I16 => (SampleKind::F32, 16),
            Sample::I32 | Sample::F32 => (SampleKind::F32, 32),
        };
        let (width, height) = (self.columns, self.rows);
        ImageInfo { format, width, height, channels: 1, sample, file_bits, void: self.void }
    }
}

/// Longitude and latitude of the lower left corner by a name such as `N40W106.hgt`.
fn place_of(path: &Path) -> Option<[f64; 2]> {
    let name = path.file_stem()?.to_str()?.get(..7)?.to_ascii_uppercase();
    let degrees = |range: std::ops::Range<usize>| name.get(range)?.parse::<f64>().ok();
    let sign = |at: usize, plus: &str, minus: &str| match name.get(at..=at)? {
        s if s == plus => Some(1.0),
        s if s == minus => Some(-1.0),
        _ => None,
    };
    let latitude = sign(0, "N", "S")? * degrees(1..3)?;
    Some([sign(3, "E", "W")? * degrees(4..7)?, latitude])
}

/// Decodes heights without a header of their own.
pub(super) fn decode(
    context: Context<'_>,
    format: ImageFormat,
    mut input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let header = RawHeader::read(context, format, &mut *input)?;
    let info = header.info(format);
    context.check(&info)?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    input.seek(SeekFrom::Start(header.skip)).map_err(|e| Error::io(context.path, e))?;
    let bytes = match header.sample {
        Sample::U8 => 1,
        Sample::U16 | Sample::I16 => 2,
        Sample::I32 | Sample::F32 => 4,
    };
    let width = info.width as usize;
    let (mut raw, mut codes, mut numbers) =
        (vec![0; width * bytes], vec![0; width], vec![0.0; width]);
    for y in 0..info.height {
        input.read_exact(&mut raw).map_err(|e| context.damaged(format!("row {y}: {e}")))?;
        if header.big_endian {
            raw.chunks_exact_mut(bytes).for_each(<[u8]>::reverse);
        }
        let two = raw.chunks_exact(2).map(|b| [b[0], b[1]]);
        let four = raw.chunks_exact(4).map(|b| [b[0], b[1], b[2], b[3]]);
        match header.sample {
            Sample::U8 => {
                sink.row(y, Row::U8(&raw));
                continue;
            }
            Sample::U16 => {
                codes.iter_mut().zip(two).for_each(|(to, b)| *to = u16::from_le_bytes(b));
                sink.row(y, Row::U16(&codes));
                continue;
            }
            Sample::I16 => fill(&mut numbers, two, |b| f32::from(i16::from_le_bytes(b))),
            Sample::I32 => fill(&mut numbers, four, |b| i32::from_le_bytes(b) as f32),
            Sample::F32 => fill(&mut numbers, four, f32::from_le_bytes),
        }
        sink.row(y, Row::F32(&numbers));
    }
    Ok(())
}

fn fill<T>(to: &mut [f32], from: impl Iterator<Item = T>, number: impl Fn(T) -> f32) {
    to.iter_mut().zip(from).for_each(|(to, from)| *to = number(from));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_tiles_say_where_they_lie() {
        let of = |name: &str| place_of(Path::new(name));
        assert_eq!(of("N40W106.hgt"), Some([-106.0, 40.0]));
        assert_eq!(of("dir/s05e012.SRTMGL1.hgt"), Some([12.0, -5.0]));
        for name in ["N40.hgt", "tile.hgt", "X40W106.hgt", "N4oW106.hgt", "N40\u{e9}106.hgt"] {
            assert_eq!(of(name), None, "{name}");
        }
    }
}
