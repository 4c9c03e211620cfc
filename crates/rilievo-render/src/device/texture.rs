//! Images and textures in words.

use std::collections::HashMap;
use std::sync::Arc;

use rilievo::map::Wrap;

use super::{Uncovered, Words};
use crate::texture::{ColourImage, ImageLevel, Texture};

/// How texels lie in words.
const SRGB_CODES: u32 = 0;
const LINEAR_CODES: u32 = 1;
const FLOATS: u32 = 2;

/// The images that were written, each once, by address.
#[derive(Default)]
pub(super) struct Images {
    places: HashMap<usize, u32>,
    table: bool,
}

impl Images {
    /// Writes a texture; returns its place.
    ///
    /// # Errors
    /// [`Uncovered`] for an image that is not in memory.
    pub(super) fn texture(
        &mut self,
        words: &mut Words,
        texture: &Texture,
        coarser: bool,
    ) -> Result<u32, Uncovered> {
        let image = self.image(words, &texture.image, coarser)?;
        let place = words.place();
        words.push(image);
        for pair in [texture.tile, texture.turn, texture.shift] {
            words.float(pair.x);
            words.float(pair.y);
        }
        for wrap in texture.wrap {
            words.push(match wrap {
                Wrap::Repeat => 0,
                Wrap::Clamp => 1,
                Wrap::Mirror => 2,
            });
        }
        Ok(place)
    }

    /// Writes an image with its coarser ones if they are asked for; returns the place of its table: coding, count of
    /// levels, and for each level width, height and place.
    fn image(
        &mut self,
        words: &mut Words,
        image: &Arc<ColourImage>,
        coarser: bool,
    ) -> Result<u32, Uncovered> {
        let address = Arc::as_ptr(image).addr();
        if let Some(place) = self.places.get(&address) {
            return Ok(*place);
        }
        let Some(levels) = image.levels(coarser) else {
            return Err(Uncovered("an image that memory is too small for"));
        };
        let coding = match levels.first().and_then(ImageLevel::codes) {
            Some((_, true)) => SRGB_CODES,
            Some((_, false)) => LINEAR_CODES,
            None => FLOATS,
        };
        if coding == SRGB_CODES && !self.table {
            self.table = true;
            let place = words.place();
            words.set("SRGB_TABLE", place);
            (0..=255_u8).for_each(|code| {
                words.float(crate::colour::linear_from_srgb(f64::from(code) / 255.0));
            });
        }
        let place = words.place();
        words.push(coding);
        words.push(levels.len() as u32);
        words.fill(place, 2 + 3 * levels.len() as u32);
        for (k, level) in (0..).zip(&levels) {
            let [width, height] = level.size();
            let at = place + 2 + 3 * k;
            let texels = words.place();
            [width, height, texels].into_iter().zip(at..).for_each(|(word, at)| {
                words.set_at(at, word);
            });
            match level.codes() {
                Some((codes, _)) => {
                    codes
                        .iter()
                        .for_each(|&[r, g, b]| words.push(u32::from_le_bytes([r, g, b, 0])));
                }
                None => (0..height).for_each(|j| {
                    (0..width).for_each(|i| words.triple(level.texel(i, j)));
                }),
            }
        }
        self.places.insert(address, place);
        Ok(place)
    }
}
