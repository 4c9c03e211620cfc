//! [`ToneMap`]: from linear radiance to display codes, at the border only.
//!
//! Exposure, then a [`View`], then the sRGB transfer curve. A view forms a picture of light that a
//! display cannot show:
//!
//! - `srgb` shows light as it is and cuts it off at white. Numbers of the picture are numbers of
//!   the film, so it is the default.
//! - `filmic` is a rational curve for each channel \[Narkowicz2015\].
//! - `aces` is a fit of ACES' reference rendering and sRGB output transforms \[Hill2016\]: saturated
//!   lights turn pale, as on film.
//! - `agx` is Sobotka's AgX \[Sobotka2022\] with the primaries of Blender and the curve fitted by
//!   \[Wrensch2023\]: 16.5 stops, hues stay longest.
//!
//! What we changed: the last number of ACES' output matrix is 1.07603, not 1.07602, so that its row
//! adds up to 1 and grey stays grey; matrices to and from Rec. 2020 have ten digits, not four.
//! Tested: greys stay grey, brighter light gives no darker code, black is black.

use std::fmt;
use std::str::FromStr;

use glam::DMat3;

use crate::colour::{Rgb, srgb_from_linear};

/// How light is brought into the range of a display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum View {
    /// As it is, cut off at white.
    #[default]
    Srgb,
    /// A rational curve fitted to the ACES film look, each channel alone.
    Filmic,
    /// A fit of the ACES reference rendering transform and the sRGB output transform.
    Aces,
    /// AgX, the look called base.
    AgX,
}

impl View {
    /// All views.
    pub const ALL: [Self; 4] = [Self::Srgb, Self::Filmic, Self::Aces, Self::AgX];

    /// The name in scene files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Filmic => "filmic",
            Self::Aces => "aces",
            Self::AgX => "agx",
        }
    }

    /// What a display shows, linear, for light without NaN, at least 0 and at most [`BRIGHTEST`].
    fn shown(self, light: Rgb) -> Rgb {
        match self {
            Self::Srgb => light,
            Self::Filmic => each(light, filmic),
            Self::Aces => ACES_OUTPUT * each(ACES_INPUT * light, aces),
            Self::AgX => {
                let log = each(AGX_INSET * (REC2020_FROM_SRGB * light), agx_log);
                let formed = AGX_OUTSET * each(log, agx_curve);
                SRGB_FROM_REC2020 * each(formed, |x| x.max(0.0).powf(2.2))
            }
        }
    }
}

impl fmt::Display for View {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that no view has.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("no view is called \"{0}\"; there are \"srgb\", \"filmic\", \"aces\" and \"agx\"")]
pub struct UnknownView(pub String);

impl FromStr for View {
    type Err = UnknownView;

    fn from_str(name: &str) -> Result<Self, UnknownView> {
        let found = Self::ALL.into_iter().find(|view| view.name() == name);
        found.ok_or_else(|| UnknownView(name.to_owned()))
    }
}

/// Exposure and view, then the sRGB transfer curve.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ToneMap {
    /// Stops: radiance is multiplied by 2 to this power.
    pub exposure: f64,
    /// How the result is brought into range.
    pub view: View,
}

/// Light above this is taken as this bright: all views are white there, and quotients of squares
/// stay finite.
const BRIGHTEST: f64 = 1e6;

impl ToneMap {
    /// Largest exposure in stops, either way.
    pub const MAX_STOPS: f64 = 100.0;

    /// The sRGB values, in `[0, 1]`, of a linear colour. NaN is shown as black.
    pub fn display(&self, linear: Rgb) -> Rgb {
        let gain = self.exposure.exp2();
        // NaN, of a channel or of zero times infinity, is not above 0.
        let bright = |x: f64| if x * gain > 0.0 { (x * gain).min(BRIGHTEST) } else { 0.0 };
        let light = each(linear, bright);
        each(self.view.shown(light), srgb_from_linear)
    }

    /// 8-bit sRGB codes of a pixel.
    pub fn rgb8(&self, linear: [f32; 3]) -> [u8; 3] {
        let shown = self.display(Rgb::from_array(linear.map(f64::from)));
        shown.to_array().map(|c| (c * 255.0 + 0.5) as u8)
    }

    /// 8-bit sRGB codes of the pixels of an image, in their order.
    pub fn image8(&self, pixels: &[[f32; 3]]) -> Vec<[u8; 3]> {
        pixels.iter().map(|&rgb| self.rgb8(rgb)).collect()
    }
}

fn each(rgb: Rgb, curve: impl Fn(f64) -> f64) -> Rgb {
    Rgb::from_array(rgb.to_array().map(curve))
}

/// Narkowicz' curve.
fn filmic(x: f64) -> f64 {
    x * (2.51 * x + 0.03) / (x * (2.43 * x + 0.59) + 0.14)
}

/// Hill's curve, between his two matrices.
fn aces(x: f64) -> f64 {
    (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081)
}

/// From 10 stops below middle grey, 0.18, to 6.5 above, as 0 to 1.
fn agx_log(x: f64) -> f64 {
    let stops = (x.max(1e-10) / 0.18).log2();
    ((stops + 10.0) / 16.5).clamp(0.0, 1.0)
}

/// Wrensch's polynomial for the curve, whose result is a display code of gamma 2.2.
fn agx_curve(x: f64) -> f64 {
    let coefficients = [15.5, -40.14, 31.96, -6.868, 0.4298, 0.1191, -0.00232];
    coefficients.into_iter().fold(0.0, |sum, c| sum * x + c)
}

/// A matrix by its rows.
const fn rows([x, y, z]: [[f64; 3]; 3]) -> DMat3 {
    DMat3::from_cols_array(&[x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]])
}

/// Linear sRGB to the space of Hill's curve.
const ACES_INPUT: DMat3 =
    rows([[0.59719, 0.35458, 0.04823], [0.076, 0.90834, 0.01566], [0.0284, 0.13383, 0.83777]]);

/// Back to linear sRGB.
const ACES_OUTPUT: DMat3 = rows([
    [1.60475, -0.53108, -0.07367],
    [-0.10208, 1.10813, -0.00605],
    [-0.00327, -0.07276, 1.07603],
]);

/// Of light, ITU-R BT.2087.
const REC2020_FROM_SRGB: DMat3 = rows([
    [0.627_403_895_9, 0.329_283_038_4, 0.043_313_065_7],
    [0.069_097_289_4, 0.919_540_395_1, 0.011_362_315_5],
    [0.016_391_438_9, 0.088_013_307_9, 0.895_595_253_2],
]);

/// Its inverse.
const SRGB_FROM_REC2020: DMat3 = rows([
    [1.660_491_002_1, -0.587_641_138_8, -0.072_849_863_3],
    [-0.124_550_474_5, 1.132_899_897_1, -0.008_349_422_6],
    [-0.018_150_763_4, -0.100_578_898_0, 1.118_729_661_4],
]);

/// Draws colours towards grey before the curve.
const AGX_INSET: DMat3 = rows([
    [0.856_627_153_315_983, 0.095_121_240_538_158_8, 0.048_251_606_145_858_3],
    [0.137_318_972_929_847, 0.761_241_990_602_591, 0.101_439_036_467_562],
    [0.111_898_212_999_95, 0.076_799_418_603_190_3, 0.811_302_368_396_859],
]);

/// Takes some of that back after it; not the inverse.
const AGX_OUTSET: DMat3 = rows([
    [1.127_100_581_814_436_8, -0.110_606_643_096_603_23, -0.016_493_938_717_834_573],
    [-0.141_329_763_498_438_3, 1.157_823_702_216_272, -0.016_493_938_717_834_257],
    [-0.141_329_763_498_438_26, -0.110_606_643_096_602_94, 1.251_936_406_595_040_5],
]);

#[cfg(test)]
mod tests {
    use super::*;

    fn maps() -> impl Iterator<Item = ToneMap> {
        View::ALL.into_iter().map(|view| ToneMap { exposure: 0.0, view })
    }

    #[test]
    fn known_codes() {
        let plain = ToneMap::default();
        assert_eq!(plain.rgb8([0.0, 1.0, 0.215_861]), [0, 255, 128]);
        let darker = ToneMap { exposure: -1.0, ..plain };
        assert_eq!(darker.rgb8([2.0, 0.431_722, 0.0]), [255, 128, 0]);
    }

    #[test]
    fn greys_stay_grey_and_never_fall_from_black_to_white() {
        for map in maps() {
            let codes: Vec<_> = (-120..100)
                .map(|stop| map.rgb8([(f32::from(stop as i16) * 0.1).exp2(); 3]))
                .collect();
            assert!(codes.iter().all(|[r, g, b]| r == g && g == b), "{}", map.view);
            assert!(codes.is_sorted(), "{}", map.view);
            assert_eq!(map.rgb8([0.0; 3]), [0; 3], "{}", map.view);
            assert_eq!(codes[219], [255; 3], "{}", map.view);
            assert_eq!(map.rgb8([f32::NAN; 3]), [0; 3], "{}", map.view);
            assert_eq!(map.rgb8([f32::INFINITY; 3]), [255; 3], "{}", map.view);
            assert_eq!(map.rgb8([-1.0; 3]), [0; 3], "{}", map.view);
        }
    }

    #[test]
    fn curves_rise_all_the_way() {
        // Finer than any code: the curves themselves, before codes are rounded.
        let rises = |curve: fn(f64) -> f64, end: f64| {
            let values: Vec<_> = (0..=10_000).map(|i| curve(end * f64::from(i) / 1e4)).collect();
            values.is_sorted()
        };
        assert!(rises(filmic, 100.0) && rises(aces, 100.0) && rises(agx_curve, 1.0));
    }

    #[test]
    fn published_values() {
        // AgX: middle grey is put on half of the display's code, within the error of the fit.
        assert!((agx_curve(agx_log(0.18)) - 0.5).abs() < 0.004);
        // ACES: middle grey is a tenth of white; 16.3 times as bright is all but white.
        assert!((aces(0.18) - 0.1).abs() < 0.01);
        assert!((aces(0.18 * 2f64.powf(6.5)) - 0.98).abs() < 0.02);
        // Narkowicz: 1 goes to 0.8.
        assert!((filmic(1.0) - 0.8038).abs() < 1e-4);
        // Sums of rows: what makes greys stay grey.
        let matrices =
            [ACES_INPUT, ACES_OUTPUT, REC2020_FROM_SRGB, SRGB_FROM_REC2020, AGX_INSET, AGX_OUTSET];
        for matrix in matrices {
            assert!((matrix * Rgb::ONE - Rgb::ONE).abs().max_element() < 1e-9, "{matrix}");
        }
        let there_and_back = SRGB_FROM_REC2020 * REC2020_FROM_SRGB - DMat3::IDENTITY;
        assert!(there_and_back.to_cols_array().iter().all(|x| x.abs() < 1e-8));
    }

    #[test]
    fn a_bright_red_light_turns_pale_under_the_film_views_only() {
        let red = [50.0, 0.0, 0.0];
        for map in maps() {
            let [r, g, b] = map.rgb8(red);
            let pale = matches!(map.view, View::Aces | View::AgX);
            assert_eq!(pale, g.min(b) > 10, "{}: {r} {g} {b}", map.view);
        }
    }

    #[test]
    fn names_are_read_back() {
        for view in View::ALL {
            assert_eq!(view.to_string().parse(), Ok(view));
        }
        assert!("clamp".parse::<View>().is_err());
    }
}
