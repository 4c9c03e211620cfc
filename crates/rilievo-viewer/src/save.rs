//! What is kept: the picture, the map, the scene. Files appear whole or not at all.

use std::io::Write;
use std::path::Path;

use rayon::prelude::*;
use rilievo::map::{HeightMap, Samples};
use rilievo_io::image::{Picture, Stored, write_png_grey16, write_png_rgb8};
use rilievo_io::{Error, Result, atomic};
use rilievo_render::film::tonemap::ToneMap;

use crate::passes::{Content, Frame};

/// sRGB codes of a frame.
pub fn codes(frame: &Frame, tone_map: &ToneMap) -> Vec<[u8; 3]> {
    match &frame.content {
        Content::Radiance(pixels) => pixels.par_iter().map(|&rgb| tone_map.rgb8(rgb)).collect(),
        Content::Codes(codes) => codes.clone(),
    }
}

/// Writes a frame: as `.exr` its radiance, otherwise the PNG of what is shown.
///
/// # Errors
/// [`Error::Io`].
pub fn picture(path: &Path, frame: &Frame, tone_map: &ToneMap) -> Result<()> {
    let exr = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("exr"));
    match &frame.content {
        Content::Radiance(pixels) if exr => {
            let [width, height] = frame.size;
            let mut picture = Picture { width, height, ..Picture::default() };
            picture.push_interleaved(&["R", "G", "B"], pixels.as_flattened(), Stored::Float);
            picture.write_exr(path)
        }
        _ => write_png_rgb8(path, frame.size, &codes(frame, tone_map)),
    }
}

/// The heights that codes of a stored map mean: `low + span * code / 65535`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meaning {
    /// Of code 0.
    pub low: f64,
    /// From code 0 to code 65535; above 0.
    pub span: f64,
}

/// Writes a map as 16-bit PNG. Maps of codes stay as they are; numbers are spread over all codes.
///
/// # Errors
/// [`Error::Io`].
pub fn map(path: &Path, map: &HeightMap) -> Result<Meaning> {
    let (width, height) = (map.width(), map.height());
    let (low, high) = map.raw_range();
    let (low, span) = (f64::from(low), f64::from(high - low).max(f64::MIN_POSITIVE));
    // A file begins at the top.
    let rows = (0..height).rev().map(|j| {
        let from = j as usize * width as usize;
        from..from + width as usize
    });
    let (codes, meaning): (Vec<u16>, _) = match map.samples() {
        Samples::U16(all) => {
            (rows.flat_map(|row| &all[row]).copied().collect(), Meaning { low: 0.0, span: 1.0 })
        }
        Samples::F32(all) => {
            let code = |h: &f32| ((f64::from(*h) - low) / span * 65535.0).round() as u16;
            (rows.flat_map(|row| &all[row]).map(code).collect(), Meaning { low, span })
        }
    };
    write_png_grey16(path, [width, height], &codes)?;
    Ok(meaning)
}

/// Writes the text of a scene.
///
/// # Errors
/// [`Error::Io`].
pub fn scene(path: &Path, text: &str) -> Result<()> {
    atomic::replace(path, |out| {
        let fail = |source| Error::Io { path: path.to_owned(), source };
        out.write_all(text.as_bytes()).map_err(fail)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use rilievo::map::{Lattice, Wrap};
    use rilievo_io::Limits;
    use rilievo_io::image::HeightOptions;

    #[test]
    fn maps_are_read_back_as_they_were() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("map.png");
        let (codes, numbers): (Vec<u16>, Vec<f32>) =
            (0..35u16).map(|k| (k * 1871, f32::from(k * 13 % 35) * 0.5 - 3.0)).unzip();
        for samples in [Samples::U16(codes), Samples::F32(numbers)] {
            let heights = HeightMap::new(7, 5, samples, Lattice::Texel, Wrap::Repeat).unwrap();
            let meaning = map(&path, &heights).unwrap();
            let back = HeightOptions::default().read(&path, &Limits::default()).unwrap();
            for (i, j) in [(0, 0), (6, 0), (3, 2), (6, 4)] {
                let [old, new] = [&heights, &back].map(|m| f64::from(m.raw(i, j)) * m.unit());
                let new = meaning.low + meaning.span * new;
                assert!((old - new).abs() <= meaning.span / 65535.0, "{old} {new}");
            }
            if let Samples::U16(_) = heights.samples() {
                assert_eq!(back.samples(), heights.samples());
            }
        }
    }
}
