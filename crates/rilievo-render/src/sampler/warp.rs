//! Warps of the unit square to distributions, each with its density.
//!
//! `square_to_x(u)` for uniform `u` in `[0, 1)^2` is distributed with density `square_to_x_pdf`.
//! Directions are unit vectors around +z.
//!
//! Gloss: microfacet normals of the GGX distribution, drawn in proportion to their area as seen
//! from `view` by a spherical cap \[Dupuy2023\]. Reflecting `view` about them gives directions around
//! the mirror direction. The renderer averages the light from there with equal weights: the lobe
//! integrates to 1 for any view and roughness, so a closed white furnace keeps its energy. What is
//! left out against the full model is the masking of the outgoing side.

use std::f64::consts::{FRAC_1_PI, FRAC_PI_4, PI, TAU};

use glam::{DVec2, DVec3};

/// The unit disk, uniform; concentric squares go to concentric circles \[Shirley1997\].
pub fn square_to_disk(u: DVec2) -> DVec2 {
    let p = 2.0 * u - 1.0;
    if p == DVec2::ZERO {
        return p;
    }
    if p.x.abs() > p.y.abs() {
        let (sin, cos) = sin_cos_eighth(p.y / p.x);
        p.x * DVec2::new(cos, sin)
    } else {
        let (sin, cos) = sin_cos_eighth(p.x / p.y);
        p.y * DVec2::new(sin, cos)
    }
}

/// Sine and cosine of `x` eighths of a turn, for `x` in `[-1, 1]`: Taylor's series up to the terms
/// that are below 1e-16 of the sum. A third of the cost of the library's, which must reduce any
/// angle.
#[inline]
pub(crate) fn sin_cos_eighth(x: f64) -> (f64, f64) {
    let a = FRAC_PI_4 * x;
    let q = a * a;
    let series = |terms: [f64; 8]| terms.into_iter().rev().fold(0.0, |sum, c| sum * q + c);
    let sin = series([
        1.0,
        -1.0 / 6.0,
        1.0 / 120.0,
        -1.0 / 5040.0,
        1.0 / 362_880.0,
        -1.0 / 39_916_800.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 1_307_674_368_000.0,
    ]);
    let cos = series([
        -0.5,
        1.0 / 24.0,
        -1.0 / 720.0,
        1.0 / 40_320.0,
        -1.0 / 3_628_800.0,
        1.0 / 479_001_600.0,
        -1.0 / 87_178_291_200.0,
        1.0 / 20_922_789_888_000.0,
    ]);
    (a * sin, 1.0 + q * cos)
}

/// Density of [`square_to_disk`], per unit area.
pub fn square_to_disk_pdf(p: DVec2) -> f64 {
    if p.length_squared() <= 1.0 { FRAC_1_PI } else { 0.0 }
}

/// The upper hemisphere, in proportion to the cosine with +z.
pub fn square_to_hemisphere(u: DVec2) -> DVec3 {
    let p = square_to_disk(u);
    p.extend((1.0 - p.length_squared()).max(0.0).sqrt())
}

/// Density of [`square_to_hemisphere`], per steradian.
pub fn square_to_hemisphere_pdf(direction: DVec3) -> f64 {
    direction.z.max(0.0) * FRAC_1_PI
}

/// Directions within a cone around +z, uniform. `height` is 1 minus the cosine of the half angle,
/// given so that thin cones keep their digits.
pub fn square_to_cone(u: DVec2, height: f64) -> DVec3 {
    let below = u.x * height;
    let sin = (below * (2.0 - below)).max(0.0).sqrt();
    let (sin_turn, cos_turn) = (TAU * u.y).sin_cos();
    DVec3::new(sin * cos_turn, sin * sin_turn, 1.0 - below)
}

/// Density of [`square_to_cone`], per steradian.
pub fn square_to_cone_pdf(direction: DVec3, height: f64) -> f64 {
    if 1.0 - direction.z <= height { 1.0 / (TAU * height) } else { 0.0 }
}

/// The parallelogram from `corner` along two edges, uniform.
pub fn square_to_quad(u: DVec2, corner: DVec3, edges: [DVec3; 2]) -> DVec3 {
    corner + u.x * edges[0] + u.y * edges[1]
}

/// Density of [`square_to_quad`], per unit area.
pub fn square_to_quad_pdf(edges: [DVec3; 2]) -> f64 {
    1.0 / edges[0].cross(edges[1]).length()
}

/// The triangle from `corner` along two edges, uniform.
pub fn square_to_triangle(u: DVec2, corner: DVec3, edges: [DVec3; 2]) -> DVec3 {
    let root = u.x.sqrt();
    corner + root * (1.0 - u.y) * edges[0] + root * u.y * edges[1]
}

/// Density of [`square_to_triangle`], per unit area.
pub fn square_to_triangle_pdf(edges: [DVec3; 2]) -> f64 {
    2.0 / edges[0].cross(edges[1]).length()
}

/// Microfacet normals visible from `view` (unit, `view.z >= 0`), for GGX width `alpha > 0`.
pub fn square_to_visible_normal(u: DVec2, view: DVec3, alpha: f64) -> DVec3 {
    let stretched = (view * DVec3::new(alpha, alpha, 1.0)).normalize_or(DVec3::Z);
    let z = (1.0 - u.x) * (1.0 + stretched.z) - stretched.z;
    let r = (1.0 - z * z).max(0.0).sqrt();
    let (sin, cos) = (TAU * u.y).sin_cos();
    let half = DVec3::new(r * cos, r * sin, z) + stretched;
    (half * DVec3::new(alpha, alpha, 1.0)).with_z(half.z.max(0.0)).normalize_or(DVec3::Z)
}

/// Density of [`square_to_visible_normal`], per steradian.
pub fn square_to_visible_normal_pdf(normal: DVec3, view: DVec3, alpha: f64) -> f64 {
    if normal.z <= 0.0 {
        return 0.0;
    }
    let a2 = alpha * alpha;
    let slope = normal.truncate().length_squared() / a2 + normal.z * normal.z;
    let distribution = 1.0 / (PI * a2 * slope * slope);
    let spread = (view.z * view.z + a2 * view.truncate().length_squared()).sqrt();
    // Smith masking over the view's cosine: G1(view) / view.z.
    let seen = 2.0 / (view.z + spread);
    distribution * seen * view.dot(normal).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::chi_square::{check_directions, chi_square_z, independent_points};

    #[test]
    fn disk_is_uniform() {
        let mut observed = vec![0.0; 400];
        for u in independent_points(200_000) {
            let p = square_to_disk(u);
            assert!(square_to_disk_pdf(p) > 0.0);
            let turn = (p.y.atan2(p.x) / TAU).rem_euclid(1.0);
            let cell = |x: f64| ((x * 20.0) as usize).min(19);
            observed[cell(p.length_squared()) * 20 + cell(turn)] += 1.0;
        }
        let z = chi_square_z(&observed, &[500.0; 400]);
        assert!(z < 4.0, "{z}");
        assert_eq!(square_to_disk(DVec2::splat(0.5)), DVec2::ZERO);
    }

    #[test]
    fn eighths_of_a_turn() {
        for k in -1000..=1000 {
            let x = f64::from(k) / 1000.0;
            let (sin, cos) = sin_cos_eighth(x);
            let (s, c) = (FRAC_PI_4 * x).sin_cos();
            assert!((sin - s).abs() < 5e-16 && (cos - c).abs() < 5e-16, "{x}");
        }
    }

    #[test]
    fn directions_follow_their_densities() {
        check_directions("hemisphere", square_to_hemisphere, square_to_hemisphere_pdf);
        // The edge of the cone lies on the edge of a cell.
        for height in [0.3, 1.0, 1.7] {
            check_directions(
                "cone",
                |u| square_to_cone(u, height),
                |d| square_to_cone_pdf(d, height),
            );
        }
    }

    #[test]
    fn visible_normals_follow_their_density() {
        for (angle, alpha) in [(0.0f64, 0.5), (0.8, 0.3), (1.3, 0.7), (1.5, 1.0), (1.57, 0.4)] {
            let view = DVec3::new(angle.sin(), 0.0, angle.cos());
            check_directions(
                "visible normal",
                |u| square_to_visible_normal(u, view, alpha),
                |m| square_to_visible_normal_pdf(m, view, alpha),
            );
        }
    }

    #[test]
    fn cone_moments() {
        // The mean of 1 - z over a cone is half its height, however thin the cone.
        for height in [1e-12, 1e-3, 1.0] {
            let n = 100_000;
            let sum: f64 = independent_points(n)
                .map(|u| {
                    let d = square_to_cone(u, height);
                    assert!((d.length() - 1.0).abs() < 1e-12);
                    d.truncate().length_squared()
                })
                .sum();
            // E[sin^2] = h - h^2 / 3.
            let expected = height - height * height / 3.0;
            assert!((sum / f64::from(n) / expected - 1.0).abs() < 0.01);
        }
    }

    #[test]
    fn quad_moments() {
        let (corner, edges) = (DVec3::ONE, [DVec3::new(2.0, 0.0, 0.0), DVec3::new(1.0, 3.0, 0.0)]);
        let n = 100_000;
        let sum: DVec3 = independent_points(n).map(|u| square_to_quad(u, corner, edges)).sum();
        let center = corner + 0.5 * (edges[0] + edges[1]);
        assert!((sum / f64::from(n) - center).length() < 0.02);
        assert_eq!(square_to_quad_pdf(edges), 1.0 / 6.0);
    }

    #[test]
    fn triangle_is_uniform() {
        let mut observed = vec![0.0; 400];
        for u in independent_points(200_000) {
            // Barycentric coordinates; folded at the diagonal they are uniform over a square.
            let p = square_to_triangle(u, DVec3::ZERO, [DVec3::X, DVec3::Y]);
            assert!(p.x >= 0.0 && p.y >= 0.0 && p.x + p.y <= 1.0 + 1e-12);
            let cell = |x: f64| ((x * 20.0) as usize).min(19);
            observed[cell(p.x) * 20 + cell(p.y)] += 1.0;
        }
        let cells = (0..400).map(|cell| (cell / 20 + cell % 20, 1000.0));
        let expected: Vec<f64> = cells
            .map(|(diagonal, full)| match diagonal {
                0..19 => full,
                19 => 0.5 * full,
                _ => 0.0,
            })
            .collect();
        let z = chi_square_z(&observed, &expected);
        assert!(z < 4.0, "{z}");
        assert_eq!(square_to_triangle_pdf([DVec3::X, DVec3::Y * 4.0]), 0.5);
    }
}
