//! The sheen of fibres that stand up from a surface \[Estevez2017\].

use std::f64::consts::TAU;

use glam::DVec3;

/// Cosines below this shadow no less, so that the albedo has no peak at grazing angles.
const FLATTEST: f64 = 0.05;

/// `f` of white fibres: the sine distribution with the shadowing of \[Neubelt2013\].
pub(super) fn fibres(view: DVec3, light: DVec3, roughness: f64) -> f64 {
    let Some(normal) = (view + light).try_normalize() else { return 0.0 };
    let exponent = 1.0 / (roughness * roughness).max(0.01);
    let sine = normal.truncate().length_squared().sqrt().min(1.0);
    let distribution = (2.0 + exponent) * sine.powf(exponent) / TAU;
    let (v, l) = (view.z.max(FLATTEST), light.z.max(FLATTEST));
    distribution / (4.0 * (v + l - v * l))
}
