//! [`Assumed`]: what is assumed of a displacement that comes without a word on its depth.
//!
//! A folder does not say how deep its displacement is, nor which height stays
//! in place. [`TextureSet::assumed`] takes 0.5 for the zero level, as these libraries make their
//! maps, and for the depth what the author's normal map says, where it agrees with the heights
//! (see [`NormalAgreement`]) and says 1 to 30 % of the map's width; otherwise 5 %. A map of numbers
//! or metres is brought to 10 % of the width from its lowest to its highest sample. All of it is
//! reported, none of it is hidden.

use std::path::Path;

use rilievo::map::{HeightMap, NormalAgreement, Samples};

use super::{TextureSet, WrittenDisplacement};
use crate::error::Result;
use crate::limits::Limits;

/// The height that stays in place without a better word for it.
const ZERO: f64 = 0.5;
/// Depth without a better word for it, in widths of the map.
const DEPTH: f64 = 0.05;
/// Depth of a map of numbers or metres from its lowest to its highest sample.
const TERRAIN_DEPTH: f64 = 0.1;
/// Depths that are believed when normals say so.
const BELIEVED: std::ops::RangeInclusive<f64> = 0.01..=0.3;
/// Correlation of slopes from which normals and heights are of the same relief.
const SAME_RELIEF: f64 = 0.5;

/// What is assumed of a set's displacement.
#[derive(Clone, Debug, PartialEq)]
pub struct Assumed {
    /// The height that stays in place.
    pub zero: f64,
    /// Displacement of a height of 1, in widths of the map.
    pub scale: f64,
    /// Whether black is high.
    pub invert: bool,
    /// Where scale and invert come from, in words.
    pub why: String,
    /// How the author's normal map agrees, if there is one.
    pub agreement: Option<NormalAgreement>,
}

impl TextureSet {
    /// What is assumed of the displacement, for heights that were read without `invert`.
    ///
    /// # Errors
    /// Of the normal map's file.
    pub fn assumed(&self, heights: &HeightMap, limits: &Limits) -> Result<Assumed> {
        let agreement = self.agreement(heights, limits)?;
        let mut assumed = Assumed::of(heights, &self.displacement()?.path);
        assumed.agreement = agreement;
        if let Some(WrittenDisplacement { scale, zero }) = self.written {
            let why = "the MaterialX file says so, a width for a unit".to_owned();
            return Ok(Assumed { scale, zero, why, ..assumed });
        }
        if is_measured(heights, &self.displacement()?.path) {
            return Ok(assumed);
        }
        if let Some(a) = agreement {
            let same = a.correlation.iter().all(|c| c.abs() >= SAME_RELIEF);
            assumed.invert = same && a.inverted;
            if !same {
                assumed.why = "the normal map is of another relief: the usual depth".to_owned();
            } else if BELIEVED.contains(&a.depth) {
                assumed.scale = a.depth;
                assumed.why = "the depth that the normal map fits".to_owned();
            } else {
                assumed.why = format!(
                    "the normal map fits a depth of {:.4}, which is not believed: the usual one",
                    a.depth
                );
            }
        }
        Ok(assumed)
    }
}

impl Assumed {
    /// What is assumed of heights alone, read from `path`.
    pub fn of(heights: &HeightMap, path: &Path) -> Self {
        let (low, high) = heights.raw_range();
        let [low, high] = [low, high].map(|raw| f64::from(raw) * heights.unit());
        let (zero, scale, why) = match is_measured(heights, path) && high > low {
            true => (
                low,
                TERRAIN_DEPTH / (high - low),
                "numbers or metres, from lowest to highest a tenth of the width",
            ),
            false => (ZERO, DEPTH, "no word on the depth: the usual one"),
        };
        Self { zero, scale, invert: false, why: why.to_owned(), agreement: None }
    }

    /// The assumptions in one line.
    pub fn describe(&self) -> String {
        let Self { zero, scale, .. } = self;
        let black = if self.invert { "; black is high, as the normal map says" } else { "" };
        format!("assumed zero {zero}, depth {scale:.6} of the width ({}){black}", self.why)
    }
}

/// Whether heights are metres or other numbers rather than shares of a depth.
fn is_measured(heights: &HeightMap, path: &Path) -> bool {
    let (low, high) = heights.raw_range();
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().to_lowercase();
    let numbers = matches!(heights.samples(), Samples::F32(_)) && (low < -1.0 || high > 2.0);
    numbers || stem.contains("metres") || stem.contains("meters")
}
