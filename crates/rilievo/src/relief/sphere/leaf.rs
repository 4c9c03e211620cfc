//! The leaf of spheres: a straight ray against one bilinear cell of `q`, in `f64`.
//!
//! It is the leaf of faces (`relief::leaf`) in double precision, with `q` in the place of the height:
//! a ray is straight in `(x, y, q)`, and the gap `Q - q` is positive outside. Over the part of the
//! ray inside a cell the gap is a quadratic, given by its Bernstein coefficients.

/// Linear interpolation, exact at both ends.
#[inline(always)]
fn lerp(a: f64, b: f64, t: f64) -> f64 {
    t * b + (a - t * a)
}

/// Bilinear interpolation of `h = [h00, h10, h01, h11]`.
#[inline(always)]
pub(super) fn bilinear(h: &[f64; 4], [x, y]: [f64; 2]) -> f64 {
    lerp(lerp(h[0], h[2], y), lerp(h[1], h[3], y), x)
}

/// Bernstein coefficients of the gap over the part of a ray inside a cell.
#[derive(Clone, Copy, Debug)]
pub(super) struct Gap {
    pub b0: f64,
    pub b1: f64,
    pub b2: f64,
}

impl Gap {
    /// The first root, as a fraction of the part, and whether it comes from outside. There is one
    /// wherever `b0` and `b2` differ in sign.
    #[inline(always)]
    pub fn first_root(&self) -> Option<(f64, bool)> {
        // A ray that starts on the surface came from the side it does not go to.
        let outside = self.b0 > 0.0
            || (self.b0 == 0.0 && (self.b1 < 0.0 || (self.b1 == 0.0 && self.b2 < 0.0)));
        let sign = if outside { 1.0 } else { -1.0 };
        let (b0, b1, b2) = (sign * self.b0, sign * self.b1, sign * self.b2);
        if b0 == 0.0 {
            return Some((0.0, outside));
        }
        let discriminant = b1 * b1 - b0 * b2;
        if b2 > 0.0 && (b1 >= 0.0 || discriminant < 0.0) {
            return None;
        }
        let root = discriminant.max(0.0).sqrt();
        let at = if b1 <= 0.0 { b0 / (b0 - b1 + root) } else { (b1 + root) / (b1 + root - b2) };
        Some((at.min(1.0), outside))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_of_all_sign_patterns_are_first_roots() {
        let steps = [-7.0, -1.0, -0.25, 0.5, 1.0, 6.0];
        for b0 in steps {
            for b1 in steps {
                for b2 in steps {
                    let value =
                        |q: f64| b0 * (1.0 - q) * (1.0 - q) + 2.0 * b1 * q * (1.0 - q) + b2 * q * q;
                    let mut scan = (0..=20_000).map(|k| f64::from(k) / 20_000.0);
                    let first = scan.find(|&q| value(q) * b0 <= 0.0);
                    match (Gap { b0, b1, b2 }.first_root(), first) {
                        (Some((q, outside)), Some(want)) => {
                            assert!((q - want).abs() <= 2e-4, "{b0} {b1} {b2}: {q} {want}");
                            assert_eq!(outside, b0 > 0.0);
                        }
                        (None, None) => {}
                        // A double root may fall between two points of the scan.
                        (Some((q, _)), None) => assert!(value(q).abs() < 1e-12),
                        (None, Some(q)) => panic!("{b0} {b1} {b2}: root near {q} not found"),
                    }
                }
            }
        }
    }

    #[test]
    fn lerp_is_exact_at_both_ends() {
        for (a, b) in [(0.1, 65535.0), (65535.0, 0.3), (-1437.2, 2205.7)] {
            assert_eq!((lerp(a, b, 0.0), lerp(a, b, 1.0)), (a, b));
        }
    }
}
