//! [`SphericalRectangle`]: a rectangle as it is seen from a point, sampled uniformly by solid angle
//! \[Urena2013\].
//!
//! By area, the weight of a sample grows as 1 / r^2 towards the point and its variance has no
//! bound where a light meets a wall; by solid angle every sample weighs the same.
//!
//! What we changed: the paper adds four inner angles, each an arc cosine. Their sines and cosines
//! follow from the rectangle without it, angles add as complex numbers of length 1 multiply, and only
//! the sum, the solid angle, is wanted as a number: one arc tangent.

use std::f64::consts::{FRAC_PI_4, TAU};

use glam::DVec2;

use crate::sampler::warp::sin_cos_eighth;

/// A rectangle seen from a point beside its plane, in the frame of that point: x and y along the
/// edges, z away from the rectangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct SphericalRectangle {
    x: [f64; 2],
    y: [f64; 2],
    /// Below 0.
    z: f64,
    /// z of the normals of the planes through the edges y = y0 and y = y1.
    b: [f64; 2],
    /// Cosine and sine of 2 pi less two of the inner angles.
    k: DVec2,
    solid_angle: f64,
}

impl SphericalRectangle {
    /// The rectangle that spans `x` and `y` at a distance from the point.
    pub(super) fn new(x: [f64; 2], y: [f64; 2], distance: f64) -> Self {
        let z = -distance;
        // The unit normals of the planes through the point and an edge, around the rectangle, are
        // (0, z, -y0), (-z, 0, x1), (0, -z, y1) and (z, 0, -x0), each over its length. Neighbours
        // share z alone, and that is what their angle needs.
        let n = [-y[0], x[1], y[1], -x[0]];
        // Written as loops: vectors take the roots and quotients of all four.
        let (mut b, mut rest) = ([0.0; 4], [0.0; 4]);
        for i in 0..4 {
            let squared = n[i] * n[i] + z * z;
            let squared = if squared > f64::MIN_POSITIVE { squared } else { f64::MIN_POSITIVE };
            b[i] = n[i] / squared.sqrt();
            rest[i] = z * z / squared;
        }
        let inner = |i: usize, j: usize| {
            // 1 - (b b)^2, without its cancellation.
            let sine = (rest[i] + b[i] * b[i] * rest[j]).sqrt();
            DVec2::new(-b[i] * b[j], sine)
        };
        let (low, high) = (inner(0, 1).rotate(inner(1, 2)), inner(2, 3).rotate(inner(3, 0)));
        let sum = low.rotate(high);
        let angle = sum.y.atan2(sum.x);
        let solid_angle = if angle < 0.0 { angle + TAU } else { angle };
        Self { x, y, z, b: [b[0], b[2]], k: DVec2::new(high.x, -high.y), solid_angle }
    }

    /// Solid angle, steradian. Its rounding error is about 1e-15, whatever its size.
    pub(super) fn solid_angle(&self) -> f64 {
        self.solid_angle
    }

    /// A point of the rectangle, in coordinates along its edges from its corner (x0, y0), whose
    /// direction is uniform for `u` uniform in `[0, 1)^2`.
    pub(super) fn sample(&self, u: DVec2) -> DVec2 {
        let ([x0, x1], [y0, y1], [b0, b1]) = (self.x, self.y, self.b);
        let part = u.x * self.solid_angle;
        let (sin, cos) = match part <= FRAC_PI_4 {
            true => sin_cos_eighth(part / FRAC_PI_4),
            false => part.sin_cos(),
        };
        let DVec2 { x: cos, y: sin } = DVec2::new(cos, sin).rotate(self.k);
        let f = (cos * b0 - b1) / sin;
        let c = (f.signum() / (f * f + b0 * b0).sqrt()).clamp(-1.0, 1.0);
        let x = (-c * self.z / (1.0 - c * c).max(f64::MIN_POSITIVE).sqrt()).clamp(x0, x1);
        let d2 = x * x + self.z * self.z;
        let (h0, h1) = (y0 / (d2 + y0 * y0).sqrt(), y1 / (d2 + y1 * y1).sqrt());
        let h = h0 + u.y * (h1 - h0);
        let y = (h * (d2 / (1.0 - h * h).max(f64::MIN_POSITIVE)).sqrt()).clamp(y0, y1);
        DVec2::new(x - x0, y - y0)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::sampler::chi_square::{chi_square_z, independent_points};

    #[test]
    fn known_solid_angles() {
        // A face of a cube seen from its middle is a sixth of the sphere.
        let face = SphericalRectangle::new([-1.0, 1.0], [-1.0, 1.0], 1.0);
        assert!((face.solid_angle() - 4.0 * PI / 6.0).abs() < 1e-14);
        let quarter = SphericalRectangle::new([0.0, 1e9], [0.0, 1e9], 1.0);
        assert!((quarter.solid_angle() - PI / 2.0).abs() < 1e-8);
    }

    #[test]
    fn parts_of_the_rectangle_get_samples_by_their_solid_angles() {
        for (x, y, z) in [
            ([-1.0, 1.0], [-1.0, 1.0], 1.0),
            ([0.1, 2.1], [-3.0, -0.5], 0.02),
            ([-0.5, 4.0], [0.0, 1.0], 1e-3),
        ] {
            let whole = SphericalRectangle::new(x, y, z);
            let n = 100_000;
            let mut observed = vec![0.0; 64];
            for u in independent_points(n) {
                let p = whole.sample(u) * 8.0 / DVec2::new(x[1] - x[0], y[1] - y[0]);
                let [i, j] = p.to_array().map(|x| (x as usize).min(7));
                observed[j * 8 + i] += 1.0;
            }
            let cut = |[a, b]: [f64; 2], i: usize| [i, i + 1].map(|i| a + (b - a) * i as f64 / 8.0);
            let expected: Vec<f64> = (0..64)
                .map(|cell| {
                    SphericalRectangle::new(cut(x, cell % 8), cut(y, cell / 8), z).solid_angle()
                })
                .map(|part| part / whole.solid_angle() * f64::from(n))
                .collect();
            assert!((expected.iter().sum::<f64>() / f64::from(n) - 1.0).abs() < 1e-9);
            let deviations = chi_square_z(&observed, &expected);
            assert!(deviations < 4.0, "{x:?} {y:?} {z}: {deviations}");
        }
    }
}
