//! Linear RGB and the sRGB transfer curve of \[Stokes1996\].

use glam::DVec3;

/// Linear, scene-referred RGB with the primaries of sRGB: a reflectance, or a radiance in
/// W/(sr m^2).
pub type Rgb = DVec3;

/// The sRGB code value, in `[0, 1]`, of a linear value; values outside `[0, 1]` are clamped and
/// NaN becomes 0.
pub fn srgb_from_linear(linear: f64) -> f64 {
    let x = if linear.is_nan() { 0.0 } else { linear.clamp(0.0, 1.0) };
    if x <= 0.003_130_8 {
        12.92 * x
    } else {
        // 1.055 x^(1/2.4) - 0.055, written so that 1 goes to exactly 1.
        1.0 + 1.055 * (x.powf(1.0 / 2.4) - 1.0)
    }
}

/// The linear value of an sRGB code value in `[0, 1]`.
pub fn linear_from_srgb(code: f64) -> f64 {
    if code <= 0.040_45 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// Whether every channel is finite and at least 0.
pub(crate) fn is_radiance(rgb: Rgb) -> bool {
    rgb.is_finite() && rgb.min_element() >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn curves_are_inverse_and_meet_the_standard() {
        for code in 0..=255 {
            let x = f64::from(code) / 255.0;
            assert!((srgb_from_linear(linear_from_srgb(x)) - x).abs() < 1e-6, "{code}");
        }
        assert!((linear_from_srgb(0.5) - 0.214_041).abs() < 1e-6);
        assert_eq!(srgb_from_linear(f64::NAN), 0.0);
        assert_eq!(srgb_from_linear(7.0), 1.0);
        assert_eq!(srgb_from_linear(-1.0), 0.0);
    }
}
