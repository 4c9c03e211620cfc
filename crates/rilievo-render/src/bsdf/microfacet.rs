//! The GGX distribution of microfacet normals with Smith's masking \[Walter2007\].
//!
//! Everything here is in local coordinates with the macroscopic normal at +z.

use std::f64::consts::PI;

use glam::DVec3;

/// Density of directions `light` reflected from `view` (`view.z >= 0`) by visible normals of width
/// `alpha` (see [`crate::sampler::warp::square_to_visible_normal`]), per steradian. It integrates
/// to 1 over the whole sphere.
#[inline]
pub(super) fn reflected_pdf(view: DVec3, light: DVec3, alpha: f64) -> f64 {
    let Some(normal) = (view + light).try_normalize() else { return 0.0 };
    if normal.z <= 0.0 {
        return 0.0;
    }
    // D G1(view) / (4 view.z), the cosine of view and normal cancels.
    let a2 = alpha * alpha;
    let spread = (view.z * view.z + a2 * view.truncate().length_squared()).sqrt();
    0.5 * distribution(normal, alpha) / (view.z + spread)
}

/// Density of microfacet normals over the projected area, per steradian.
#[inline]
pub(super) fn distribution(normal: DVec3, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let slope = normal.truncate().length_squared() / a2 + normal.z * normal.z;
    1.0 / (PI * a2 * slope * slope)
}
