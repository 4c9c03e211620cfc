//! Esri ASCII grid: a header of names and numbers, then heights as text, the top row first.
//!
//! `ncols`, `nrows` and the place and size of cells are as \[Esri2016\] has them; `NODATA_value` names
//! the number that stands where nothing was measured.

use super::ImageFormat;
use super::source::{Context, Flow, ImageInfo, Input, Row, SampleKind, Sink};
use crate::error::{Error, Place, Result};

/// Longest word that is read, in bytes.
const LONGEST_WORD: usize = 64;

/// The header of a grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct GridHeader {
    pub columns: u32,
    pub rows: u32,
    /// Side of a cell along x and y.
    pub cell: [f64; 2],
    /// Left and lower border, or the centre of the lower left cell.
    pub corner: [f64; 2],
    pub void: Option<f32>,
    /// The first height, which ends the header.
    first: f32,
}

impl GridHeader {
    /// Reads the header; the input is left after the first height.
    pub fn read(context: Context<'_>, input: &mut dyn Input) -> Result<Self> {
        let mut header = Self::default();
        loop {
            let key = word(context, input)?.to_ascii_lowercase();
            if let Ok(first) = key.parse::<f32>() {
                let fault = |what, found: u32| {
                    let allowed = "a number from 1 to 4294967295";
                    Error::invalid(context.path, Place::Header, what, found.to_string(), allowed)
                };
                return match (header.columns, header.rows) {
                    (0, _) => Err(fault("ncols", 0)),
                    (_, 0) => Err(fault("nrows", 0)),
                    _ => Ok(Self { first, ..header }),
                };
            }
            let value = word(context, input)?;
            let wrong = || {
                let allowed = "a number";
                Error::invalid(context.path, Place::Header, &key, value.as_str(), allowed)
            };
            let number = value.parse::<f64>().map_err(|_| wrong())?;
            let whole = || value.parse::<u32>().map_err(|_| wrong());
            match key.as_str() {
                "ncols" => header.columns = whole()?,
                "nrows" => header.rows = whole()?,
                "cellsize" => header.cell = [number; 2],
                "dx" => header.cell[0] = number,
                "dy" => header.cell[1] = number,
                "xllcorner" | "xllcenter" => header.corner[0] = number,
                "yllcorner" | "yllcenter" => header.corner[1] = number,
                "nodata_value" => header.void = Some(number as f32),
                _ => {
                    let allowed = "ncols, nrows, xllcorner, yllcorner, xllcenter, yllcenter, \
                                   cellsize, dx, dy, NODATA_value";
                    let place = Place::Header;
                    return Err(Error::invalid(context.path, place, "key", key, allowed));
                }
            }
        }
    }

    fn info(&self) -> ImageInfo {
        ImageInfo {
            format: ImageFormat::AsciiGrid,
            width: self.columns,
            height: self.rows,
            channels: 1,
            sample: SampleKind::F32,
            file_bits: 32,
            void: self.void,
        }
    }
}

/// Decodes a grid.
pub(super) fn decode(
    context: Context<'_>,
    mut input: Box<dyn Input + '_>,
    sink: &mut dyn Sink,
) -> Result<()> {
    let header = GridHeader::read(context, &mut *input)?;
    let info = header.info();
    context.check(&info)?;
    if sink.begin(&info)? == Flow::Stop {
        return Ok(());
    }
    let mut row = vec![0.0; info.width as usize];
    let mut first = Some(header.first);
    for y in 0..info.height {
        for value in &mut row {
            *value = match first.take() {
                Some(first) => first,
                None => {
                    let text = word(context, &mut *input)?;
                    text.parse()
                        .map_err(|_| context.damaged(format!("{text:?} in row {y} is no number")))?
                }
            };
        }
        sink.row(y, Row::F32(&row));
    }
    Ok(())
}

/// The next word.
fn word(context: Context<'_>, input: &mut dyn Input) -> Result<String> {
    let mut text = String::new();
    loop {
        let bytes = input.fill_buf().map_err(|e| Error::io(context.path, e))?;
        let Some(&byte) = bytes.first() else {
            return match text.is_empty() {
                true => Err(context.damaged("the file ends before its data")),
                false => Ok(text),
            };
        };
        input.consume(1);
        match byte {
            b if b.is_ascii_whitespace() && text.is_empty() => {}
            b if b.is_ascii_whitespace() => return Ok(text),
            _ if text.len() == LONGEST_WORD => return Err(context.damaged("a word without end")),
            byte => text.push(char::from(byte)),
        }
    }
}
