//! Displaced spheres.

use rilievo::glam::DVec3;
use rilievo::relief::ReliefSphere;

use super::ROUNDING;
use crate::records::Words;

/// Writes a displaced sphere whose six maps begin at face `first`.
pub(crate) fn write_sphere(words: &mut Vec<u32>, sphere: &ReliefSphere, anchor: DVec3, first: u32) {
    let (frame, relief) = (sphere.frame(), sphere.relief());
    let [lowest, highest] = frame.range;
    let middle = 0.5 * (lowest + highest);
    let (low, high) = relief.raw_range();
    let cells = f64::from(relief.cells());
    let flat = 1.0 + 1.0 / (cells * cells);
    let slack = 2.0f64.powi(-32) + 64.0 * ROUNDING * cells * frame.variation;
    let beneath = 1.25 * (1.0 - (1.0 - slack) / (flat * flat)) * (highest / middle).powi(2);
    // What doubles round of a start, which count from the anchor.
    let reach = (sphere.center() - anchor).length() + frame.balls[1];
    let lift = 64.0 * ROUNDING * reach / frame.balls[0]
        * (1.0 + 2.0 * 3.0f64.sqrt() * cells * frame.variation);
    words.vector(sphere.center() - anchor);
    let [inner, outer] = frame.balls;
    for x in [inner, outer, middle, frame.at_zero / middle, frame.per_raw / middle] {
        words.double(x);
    }
    words.float((frame.lift + lift) as f32);
    words.float(low.abs().max(high.abs()));
    words.float(4.0 * slack as f32);
    words.float(beneath as f32);
    words.extend([relief.cells(), first]);
}
