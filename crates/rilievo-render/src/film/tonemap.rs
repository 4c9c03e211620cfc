//! [`ToneMap`]: from linear radiance to display codes, at the border only.

use crate::colour::srgb_from_linear;
use crate::film::Film;

/// How values above the display's white are brought down.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Cut off at white: below it the picture is linear light.
    #[default]
    Clamp,
    /// A rational curve fitted to the ACES film look, each channel alone \[Narkowicz2015\].
    Filmic,
}

/// Exposure, curve, then the sRGB transfer curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// Stops: radiance is multiplied by 2 to this power.
    pub exposure: f64,
    /// The curve.
    pub curve: ToneCurve,
}

impl ToneMap {
    /// The display value, in `[0, 1]`, of a linear one.
    pub fn display(&self, linear: f64) -> f64 {
        let x = linear * self.exposure.exp2();
        let shown = match self.curve {
            ToneCurve::Clamp => x,
            ToneCurve::Filmic => {
                // The quotient tends to 2.51 / 2.43; an infinite x would give NaN.
                let x = x.clamp(0.0, 1e6);
                x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
            }
        };
        srgb_from_linear(shown)
    }

    /// 8-bit sRGB codes of a pixel.
    pub fn rgb8(&self, linear: [f32; 3]) -> [u8; 3] {
        linear.map(|c| (self.display(f64::from(c)) * 255.0 + 0.5) as u8)
    }

    /// 8-bit sRGB codes of an image, row by row from the top left.
    pub fn image8(&self, film: &Film) -> Vec<[u8; 3]> {
        film.radiance().iter().map(|&rgb| self.rgb8(rgb)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_codes() {
        let plain = ToneMap::default();
        assert_eq!(plain.rgb8([0.0, 1.0, 0.215_861]), [0, 255, 128]);
        assert_eq!(plain.rgb8([f32::NAN, f32::INFINITY, -1.0]), [0, 255, 0]);
        let darker = ToneMap { exposure: -1.0, ..plain };
        assert_eq!(darker.rgb8([2.0, 0.431_722, 0.0]), [255, 128, 0]);
    }

    #[test]
    fn filmic_rises_and_ends_at_white() {
        let filmic = ToneMap { exposure: 0.0, curve: ToneCurve::Filmic };
        let codes: Vec<u8> = (0..200).map(|i| filmic.rgb8([i as f32 * 0.1; 3])[0]).collect();
        assert!(codes.windows(2).all(|pair| pair[0] <= pair[1]));
        assert_eq!((codes[0], codes[199]), (0, 255));
        assert_eq!(filmic.rgb8([f32::NAN, f32::INFINITY, -1.0]), [0, 255, 0]);
    }
}
