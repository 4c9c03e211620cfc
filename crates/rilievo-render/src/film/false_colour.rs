//! False colours: layers as pictures.
//!
//! The heat ramp goes from dark blue over violet and orange to pale yellow on a straight line of
//! Oklab lightness \[Ottosson2020\], so equal steps look equally large and survive in grey.

use crate::colour::{Rgb, srgb_from_linear};
use crate::film::{Aov, Layer};

/// 8-bit sRGB of the heat ramp at `x`; values outside `[0, 1]` are clamped, NaN becomes 0.
pub fn heat(x: f64) -> [u8; 3] {
    let x = if x.is_nan() { 0.0 } else { x.clamp(0.0, 1.0) };
    let lightness = 0.15 + 0.8 * x;
    // Chroma is 0.12 between the ends, where fewer colours can be shown; hue 280 to 465 degrees.
    let chroma = 0.12 * (1.0 - (2.0 * x - 1.0).powi(4)) + 0.02;
    let hue = (280.0 + 185.0 * x).to_radians();
    let rgb = linear_from_oklab(lightness, chroma * hue.cos(), chroma * hue.sin());
    rgb.to_array().map(|c| code(srgb_from_linear(c)))
}

/// A layer as an image, row by row from the top left.
///
/// Normals: `(n + 1) / 2`. UV: red and green. P, Height and Z: black to white between the smallest
/// and the largest finite value of each channel. Steps: [`heat`] from 0 to the largest value.
/// Albedo: sRGB. Pixels without a hit are black, but for Steps.
pub fn false_colour(layer: &Layer) -> Vec<[u8; 3]> {
    let channels = layer.channels();
    let pixels = layer.values().chunks_exact(channels);
    match layer.aov() {
        Aov::N | Aov::Ns => pixels.map(normal_colour).collect(),
        Aov::Uv => pixels.map(|p| [code(f64::from(p[0])), code(f64::from(p[1])), 0]).collect(),
        Aov::Albedo => pixels
            .map(|p| [p[0], p[1], p[2]].map(|c| code(srgb_from_linear(f64::from(c)))))
            .collect(),
        Aov::Steps => {
            let most = layer.values().iter().fold(1.0f32, |a, &b| a.max(b));
            pixels.map(|p| heat(f64::from(p[0] / most))).collect()
        }
        Aov::P | Aov::Height | Aov::Z => {
            let ranges: Vec<_> = (0..channels).map(|c| range(layer, c)).collect();
            let shade = |pixel: &[f32], c: usize| {
                let c = c % channels;
                let (low, high) = ranges[c];
                code((f64::from(pixel[c]) - low) / (high - low))
            };
            pixels.map(|pixel| [0, 1, 2].map(|c| shade(pixel, c))).collect()
        }
    }
}

/// Mid-grey-based colour of a unit vector; black for the zero vector of a pixel without a hit.
fn normal_colour(normal: &[f32]) -> [u8; 3] {
    if normal.iter().all(|&c| c == 0.0) {
        return [0; 3];
    }
    [normal[0], normal[1], normal[2]].map(|c| code(0.5 + 0.5 * f64::from(c)))
}

/// Smallest and largest finite value of a channel; never the same number twice.
fn range(layer: &Layer, channel: usize) -> (f64, f64) {
    let values = layer.values().iter().skip(channel).step_by(layer.channels());
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| {
            (low.min(f64::from(value)), high.max(f64::from(value)))
        });
    if low < high { (low, high) } else { (low - 1.0, low) }
}

/// The 8-bit code of a value; NaN and infinity, which mark a pixel without a hit, become 0.
fn code(value: f64) -> u8 {
    if value.is_finite() { (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8 } else { 0 }
}

/// Linear sRGB of an Oklab colour \[Ottosson2020\].
fn linear_from_oklab(lightness: f64, a: f64, b: f64) -> Rgb {
    let l = (lightness + 0.396_337_777_4 * a + 0.215_803_757_3 * b).powi(3);
    let m = (lightness - 0.105_561_345_8 * a - 0.063_854_172_8 * b).powi(3);
    let s = (lightness - 0.089_484_177_5 * a - 1.291_485_548_0 * b).powi(3);
    Rgb::new(
        4.076_741_662_1 * l - 3.307_711_591_3 * m + 0.230_969_929_2 * s,
        -1.268_438_004_6 * l + 2.609_757_401_1 * m - 0.341_319_396_5 * s,
        -0.004_196_086_3 * l - 0.703_418_614_7 * m + 1.707_614_701_0 * s,
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::linear_from_srgb;
    use crate::film::Film;

    #[test]
    fn the_heat_ramp_grows_lighter_all_the_way() {
        let luminance = |i: u32| {
            let [r, g, b] =
                heat(f64::from(i) / 64.0).map(|c| linear_from_srgb(f64::from(c) / 255.0));
            0.2126 * r + 0.7152 * g + 0.0722 * b
        };
        for i in 0..64 {
            assert!(luminance(i) < luminance(i + 1), "{i}: {:?}", heat(f64::from(i) / 64.0));
        }
        assert_eq!(heat(f64::NAN), heat(0.0));
        assert_eq!(heat(9.0), heat(1.0));
    }

    #[test]
    fn layers_as_pictures() {
        let mut film = Film::new([2, 1], &[Aov::N, Aov::P, Aov::Steps]).unwrap();
        for (aov, channels) in film.pixel_mut(1, 0).layers() {
            let value: &[f32] = match aov {
                Aov::N => &[0.0, 0.0, 1.0],
                Aov::P => &[3.0, 4.0, 5.0],
                _ => &[7.0],
            };
            channels.copy_from_slice(value);
        }
        let shown = |aov| false_colour(film.layer(aov).unwrap());
        assert_eq!(shown(Aov::N), [[0, 0, 0], [128, 128, 255]]);
        assert_eq!(shown(Aov::P), [[0, 0, 0], [255, 255, 255]]);
        assert_eq!(shown(Aov::Steps), [heat(0.0), heat(1.0)]);
    }
}
