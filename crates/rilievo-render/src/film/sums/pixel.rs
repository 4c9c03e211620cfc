//! [`PixelSums`]: adding a sample to a pixel.

use glam::DVec3;

use super::{COLOUR, Counts, MOST, MOST_SQUARED, SQUARE_UNITS, UNITS};
use crate::colour::Rgb;
use crate::film::Aov;

/// The sums of a pixel.
pub(crate) struct PixelSums<'a> {
    values: &'a mut [i128],
    counts: &'a mut Counts,
    aovs: &'a [Aov],
}

impl<'a> PixelSums<'a> {
    pub(super) fn new(values: &'a mut [i128], counts: &'a mut Counts, aovs: &'a [Aov]) -> Self {
        Self { values, counts, aovs }
    }

    /// The layers.
    pub(crate) fn aovs(&self) -> &[Aov] {
        self.aovs
    }

    /// Adds the colour of a sample of weight 1 or -1.
    #[inline]
    pub(crate) fn add(&mut self, radiance: Rgb, weight: f64) {
        self.counts.taken += 1;
        if !radiance.is_finite() || radiance.abs().max_element() > MOST {
            self.counts.refused += 1;
            return;
        }
        self.counts.weight += if weight < 0.0 { -1 } else { 1 };
        let signed = radiance * weight.signum();
        for (sum, channel) in self.values.iter_mut().zip(signed.to_array()) {
            *sum += (channel * UNITS) as i128;
        }
        let mean = (radiance.element_sum() / 3.0).abs().min(MOST_SQUARED);
        self.values[3] += (mean * mean * SQUARE_UNITS) as i128;
    }

    /// Adds to the layers what a sample of positive weight saw; `value` is asked for each layer.
    pub(crate) fn add_layers(&mut self, hit: bool, mut value: impl FnMut(Aov) -> Option<DVec3>) {
        self.counts.seen += 1;
        self.counts.hits += u32::from(hit);
        let mut rest = self.values[COLOUR..].iter_mut();
        for &aov in self.aovs {
            let channels = aov.channels().len();
            let value = value(aov).unwrap_or(DVec3::ZERO).to_array();
            for (sum, channel) in rest.by_ref().take(channels).zip(value) {
                // Not a number adds nothing.
                *sum += (channel.clamp(-MOST, MOST) * UNITS) as i128;
            }
        }
    }
}
