//! [`denoise()`]: the noise of a film averaged away, edges kept.
//!
//! Non-local means with features \[Rousselle2013\]: a pixel becomes the weighted mean of the pixels
//! around it. A neighbour counts as far as the patches around both look alike, measured against
//! the variance of their means, and as far as albedo and shading normal say that both show the
//! same surface:
//!
//! - colour: `d = ((u_p - u_q)^2 - v_p - min(v_p, v_q)) / (k^2 (v_p + v_q))`, averaged over three
//!   channels and a patch, `w = exp(-max(d, 0))`;
//! - features: `w = exp(-(f_p - f_q)^2 / (k_f^2 max(t, |grad f|^2)))`, for albedo and normal;
//! - the smaller of the three counts.
//!
//! What we changed. Light is divided by the albedo before and multiplied by it after, so that a
//! texture is no part of what is averaged. Variances are those of the samples of each pixel, taken as
//! independent; of integrators that keep none they are estimated from the differences among
//! neighbours of one surface. Both are smoothed, so that pixels without a single bright path do not
//! pass for quiet ones. One buffer serves for weights and means, where the paper takes two halves of the
//! samples: half the memory, a little less noise taken away. No filter is chosen among several by
//! Stein's estimate.
//!
//! Proven: a constant stays what it is to the last bit, for means are taken of differences to the
//! pixel. Each pixel is computed by one thread in a fixed order, so threads do not show. Measured:
//! see the tests and docs/METHODS.md.

mod input;
mod tile;

use rayon::prelude::*;

use crate::film::{Aov, Film};
use input::Input;

/// The layers that are needed beside the colour.
pub const GUIDES: [Aov; 2] = [Aov::Albedo, Aov::Ns];

/// Why a film was not denoised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DenoiseError {
    /// A layer is not there.
    #[error("the layer {0} is needed to denoise a picture")]
    NoGuide(Aov),
    /// Its copies do not fit the memory.
    #[error("no memory to denoise an image of {} x {} pixels", size[0], size[1])]
    Memory {
        /// Pixels along x and y.
        size: [u32; 2],
    },
}

/// Bytes that [`denoise()`] holds for an image of so many pixels, its result included.
pub fn predicted_bytes(size: [u32; 2]) -> u64 {
    let pixel = size_of::<input::Pixel>() + size_of::<f32>() * 2 + size_of::<[f32; 3]>() * 2;
    u64::from(size[0]) * u64::from(size[1]) * pixel as u64
}

/// The radiance of a film with less noise, row by row from the top left. Pixels that are not
/// finished stay as they are. Runs on the current thread pool.
///
/// # Errors
/// [`DenoiseError`] if one of [`GUIDES`] is missing or memory runs out.
pub fn denoise(film: &Film) -> Result<Vec<[f32; 3]>, DenoiseError> {
    let input = Input::new(film)?;
    let mut out = film.radiance().to_vec();
    let width = input.size[0];
    out.par_chunks_mut(width * tile::ROWS).enumerate().for_each(|(band, rows)| {
        tile::denoise_rows(&input, band * tile::ROWS, rows);
    });
    Ok(out)
}

#[cfg(test)]
mod tests;
