//! One cell: the graph of `a + b x + c y + d x y` over the unit square, against a ray.
//!
//! The quadratic `gap(t) = w(t) - patch(x(t), y(t))` is written in `s` in `[-1, 1]` over the
//! ray's own stretch of the cell, about its middle: there all coordinates are of the cell's own
//! size and no digits of a far origin are lost. Discriminant by a two-product, roots without
//! cancellation.

use glam::{DVec2, DVec3};

/// Roots up to two, each with whether the gap rises there (the ray comes out of the solid).
pub(super) type Roots = std::iter::Flatten<std::array::IntoIter<Option<(f64, bool)>, 2>>;

/// How far beyond the ends of its stretch a root may lie, in half lengths.
const SLACK: f64 = 1e-12;

/// The bilinear patch of a cell, in cell-local x and y.
#[derive(Clone, Copy, Debug)]
pub(super) struct Patch {
    a: f64,
    b: f64,
    c: f64,
    d: f64,
}

impl Patch {
    /// From the corners `[h00, h10, h01, h11]`.
    pub(super) fn new([h00, h10, h01, h11]: [f64; 4]) -> Self {
        Self { a: h00, b: h10 - h00, c: h01 - h00, d: (h11 - h10) - (h01 - h00) }
    }

    pub(super) fn value(&self, p: DVec2) -> f64 {
        self.a + self.b * p.x + (self.c + self.d * p.x) * p.y
    }

    pub(super) fn gradient(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.b + self.d * p.y, self.c + self.d * p.x)
    }

    /// Coefficients A, B, C of the gap `A s^2 + B s + C` about `p` along `d`.
    fn gap(&self, p: DVec3, d: DVec3) -> [f64; 3] {
        let slope = self.gradient(p.truncate());
        [-self.d * d.x * d.y, d.z - slope.dot(d.truncate()), p.z - self.value(p.truncate())]
    }

    /// All roots on the stretch `[ta, tb]` of the ray `o + t d`.
    pub(super) fn roots(&self, o: DVec3, d: DVec3, [ta, tb]: [f64; 2]) -> Roots {
        let (middle, half) = (0.5 * (ta + tb), 0.5 * (tb - ta));
        let [a, b, c] = self.gap(o + middle * d, half * d);
        quadratic(a, b, c)
            .map(|root| {
                let s = root.filter(|s| s.abs() <= 1.0 + SLACK)?;
                Some((middle + s * half, 2.0 * a * s + b > 0.0))
            })
            .into_iter()
            .flatten()
    }

    /// The root beside `t = 0` of a ray that starts on the patch.
    pub(super) fn other_root(&self, o: DVec3, d: DVec3, [ta, tb]: [f64; 2]) -> Roots {
        let [a, b, _] = self.gap(o, d);
        let t = -b / a;
        // At the other root of a quadratic the slope is that of the first, turned.
        let root = (t > 0.0 && ta <= t && t <= tb).then_some((t, b < 0.0));
        [root, None].into_iter().flatten()
    }
}

/// Real roots of `a s^2 + b s + c`.
fn quadratic(a: f64, b: f64, c: f64) -> [Option<f64>; 2] {
    if a == 0.0 && b == 0.0 {
        return [(c == 0.0).then_some(0.0), None];
    }
    let discriminant = difference_of_products(b, b, 4.0 * a, c);
    if discriminant < 0.0 {
        return [None; 2];
    }
    let q = -0.5 * (b + discriminant.sqrt().copysign(b));
    let finite = |s: f64| s.is_finite().then_some(s);
    if q == 0.0 { [Some(0.0), None] } else { [finite(q / a), finite(c / q)] }
}

/// `a b - c d` to within two roundings.
fn difference_of_products(a: f64, b: f64, c: f64, d: f64) -> f64 {
    let cd = c * d;
    let error = (-c).mul_add(d, cd);
    a.mul_add(b, -cd) + error
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_saddle_has_the_roots_worked_out_by_hand() {
        // w = x y along x = y = t, at height 1/4: t^2 = 1/4.
        let saddle = Patch::new([0.0, 0.0, 0.0, 1.0]);
        let (o, d) = (DVec3::new(0.0, 0.0, 0.25), DVec3::new(1.0, 1.0, 0.0));
        let roots: Vec<_> = saddle.roots(o, d, [0.0, 1.0]).collect();
        assert_eq!(roots.len(), 1);
        assert!((roots[0].0 - 0.5).abs() < 1e-15 && !roots[0].1);
        // Along the other diagonal w = x (1 - x), at 3/16: x = 1/4 and 3/4, in and out.
        let (o, d) = (DVec3::new(0.0, 1.0, 0.1875), DVec3::new(1.0, -1.0, 0.0));
        let mut roots: Vec<_> = saddle.roots(o, d, [0.0, 1.0]).collect();
        roots.sort_by(|a, b| a.0.total_cmp(&b.0));
        assert!((roots[0].0 - 0.25).abs() < 1e-15 && !roots[0].1);
        assert!((roots[1].0 - 0.75).abs() < 1e-15 && roots[1].1);
    }

    #[test]
    fn the_root_at_the_start_is_divided_out() {
        let saddle = Patch::new([0.0, 0.0, 0.0, 1.0]);
        let (o, d) = (DVec3::new(0.25, 0.75, 0.1875), DVec3::new(1.0, -1.0, 0.0));
        let roots: Vec<_> = saddle.other_root(o, d, [0.0, 0.75]).collect();
        assert_eq!(roots.len(), 1);
        assert!((roots[0].0 - 0.5).abs() < 1e-15 && roots[0].1);
        let (o, up) = (DVec3::new(0.5, 0.5, 0.25), DVec3::new(1.0, 1.0, 9.0));
        assert_eq!(saddle.other_root(o, up, [0.0, 0.5]).count(), 0);
    }

    #[test]
    fn roots_far_apart_in_size_keep_their_digits() {
        let [one, two] = quadratic(1.0, -1e8, 1.0);
        let (small, large) = (one.unwrap().min(two.unwrap()), one.unwrap().max(two.unwrap()));
        assert!((small * 1e8 - 1.0).abs() < 1e-15);
        assert!((large / 1e8 - 1.0).abs() < 1e-15);
    }
}
