//! The GGX distribution of microfacet normals with Smith's masking \[Walter2007\].
//!
//! Everything here is in local coordinates with the macroscopic normal at +z. Masking is that of
//! heights that are correlated, `G2 = 2 v l / (v s(l) + l s(v))` with the cosines `v`, `l` and `s`
//! of [`spread`] \[Heitz2014\]; facets are drawn as they are seen, \[Dupuy2023\].

use std::f64::consts::PI;

use glam::DVec3;

/// GGX widths below this are taken as smooth: the lobe is a single direction.
pub(super) const SMOOTH: f64 = 1e-4;

/// The cosine of `w` in the stretched frame, times its length there: `G1 = 2 |w.z| / (|w.z| + s)`.
#[inline]
fn spread(w: DVec3, alpha: f64) -> f64 {
    (w.z * w.z + alpha * alpha * w.truncate().length_squared()).sqrt()
}

/// Density of microfacet normals over the projected area, per steradian.
#[inline]
fn distribution(normal: DVec3, alpha: f64) -> f64 {
    let a2 = alpha * alpha;
    let slope = normal.truncate().length_squared() / a2 + normal.z * normal.z;
    1.0 / (PI * a2 * slope * slope)
}

/// `G2 / G1(view)`: the share of the light off a visible facet that leaves to `light`.
#[inline]
pub(super) fn masked_share(view: DVec3, light: DVec3, alpha: f64) -> f64 {
    let (v, l) = (view.z, light.z.abs());
    let s = spread(view, alpha);
    l * (v + s) / (v * spread(light, alpha) + l * s)
}

/// Density of directions `light` reflected from `view` (`view.z >= 0`) by visible normals of width
/// `alpha` (see [`crate::sampler::warp::square_to_visible_normal`]), per steradian. It integrates
/// to 1 over the whole sphere.
#[inline]
pub(super) fn reflected_pdf(view: DVec3, light: DVec3, alpha: f64) -> f64 {
    let Some(normal) = (view + light).try_normalize() else { return 0.0 };
    if normal.z <= 0.0 {
        return 0.0;
    }
    // D G1(view) / (4 view.z); the cosine of view and normal cancels.
    0.5 * distribution(normal, alpha) / (view.z + spread(view, alpha))
}

/// A direction with the facet that sends light from there to the viewer.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    /// Cosine of the view with the facet.
    pub(super) cosine: f64,
    /// `D G2 / (4 view.z)` and its like for what goes through: `f cos` without Fresnel's share.
    pub(super) value: f64,
    /// Density of the direction, without the probability to reflect or to let through.
    pub(super) pdf: f64,
}

/// Light from above that facets reflect.
#[inline]
pub(super) fn reflection(view: DVec3, light: DVec3, alpha: f64) -> Option<Met> {
    if light.z <= 0.0 {
        return None;
    }
    let normal = (view + light).try_normalize()?;
    let pdf = 0.5 * distribution(normal, alpha) / (view.z + spread(view, alpha));
    let value = pdf * masked_share(view, light, alpha);
    Some(Met { cosine: view.dot(normal), value, pdf })
}

/// Light from below that facets refract; `eta` is the index there over that here. `value` is that of
/// power: radiance is it over `eta^2`.
#[inline]
pub(super) fn refraction(view: DVec3, light: DVec3, alpha: f64, eta: f64) -> Option<Met> {
    if light.z >= 0.0 {
        return None;
    }
    let half = (view + eta * light).try_normalize()?;
    let normal = if half.z < 0.0 { -half } else { half };
    let (v, l) = (view.dot(normal), light.dot(normal));
    // Facets turned away on either side cannot be met.
    if v <= 0.0 || l >= 0.0 {
        return None;
    }
    let denominator = l + v / eta;
    // |d normal / d light| is |l| / denominator^2; visible normals have D G1 v / view.z.
    let facets = 2.0 * v * distribution(normal, alpha) / (view.z + spread(view, alpha));
    let pdf = facets * -l / (denominator * denominator);
    Some(Met { cosine: v, value: pdf * masked_share(view, light, alpha), pdf })
}

/// The direction that a facet refracts `view` to, given the cosines on both sides.
#[inline]
pub(super) fn transmitted(
    view: DVec3,
    facet: DVec3,
    (cosine, inside): (f64, f64),
    eta: f64,
) -> DVec3 {
    (cosine / eta - inside) * facet - view / eta
}
