//! The watertight ray/triangle test \[Woop2013, sheared edges\], in `f64`.
//!
//! Vertices are sheared so that the ray becomes an axis; three edge functions then say on which
//! side of each edge that axis passes. A vertex is sheared to the same numbers in every triangle
//! that has it, and `fl(a b) - fl(c d)` has the sign of `a b - c d` or is zero, rounding being
//! monotone. Where it is zero the paper goes to a wider type; we add the two products' own
//! rounding errors, which a fused multiply-add gives exactly. So the signs are those of exact
//! arithmetic on the sheared vertices, triangles that share an edge agree on it, and a ray cannot
//! pass between them.
//!
//! What we changed: an edge may be *widened*. A ray that starts on a surface is off it by
//! rounding, and near an edge its whole line may pass outside a closed mesh. Points up to the
//! widening outside an edge then count as inside; barycentric weights are cut at 0, so that
//! position and `t` stay those of a point in the triangle.

use glam::DVec3;

use crate::ray::Ray;

/// By how much edges are widened for rays that start on a surface, as a fraction of the largest
/// coordinate involved. A start is off its own plane by at most `gamma(7) sqrt(3) < 6.1 EPSILON`.
const WIDENING: f64 = 16.0 * f64::EPSILON;

/// A ray made ready for triangles.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedRay {
    origin: DVec3,
    /// The two minor axes and the axis along which the ray is longest; they keep handedness.
    axes: [usize; 3],
    shear: [f64; 2],
    /// Direction along the longest axis.
    along: f64,
    reach: f64,
}

/// A vertex in the frame of a [`ShearedRay`]: the ray is `x = y = 0`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ShearedVertex {
    x: f64,
    y: f64,
    depth: f64,
    reach: f64,
}

/// Which points near an edge count as inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Edges {
    /// Closed edges, exact signs.
    Exact,
    /// Closed edges, moved outwards by [`WIDENING`].
    Widened,
}

/// Where the line of a ray crosses a triangle.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Ray parameter, of either sign.
    pub(crate) t: f64,
    /// Barycentric weights of the corners: at least 0, sum 1 to rounding.
    pub(crate) weights: [f64; 3],
    /// Whether the triangle is met counter-clockwise.
    pub(crate) front: bool,
}

impl ShearedRay {
    pub(crate) fn new(ray: &Ray) -> Self {
        let d = ray.direction;
        let z = d.abs().max_position();
        let (mut x, mut y) = ((z + 1) % 3, (z + 2) % 3);
        if d[z] < 0.0 {
            (x, y) = (y, x);
        }
        Self {
            origin: ray.origin,
            axes: [x, y, z],
            shear: [d[x] / d[z], d[y] / d[z]],
            along: d[z],
            reach: ray.origin.abs().max_element(),
        }
    }

    #[inline]
    pub(crate) fn vertex(&self, p: DVec3) -> ShearedVertex {
        let [x, y, z] = self.axes;
        let r = p - self.origin;
        ShearedVertex {
            x: r[x] - self.shear[0] * r[z],
            y: r[y] - self.shear[1] * r[z],
            depth: r[z],
            reach: p.abs().max_element(),
        }
    }

    /// The crossing with triangle `[a, b, c]`, or `None`. A triangle seen edge-on is not crossed.
    #[inline]
    pub(crate) fn cross(&self, [a, b, c]: [ShearedVertex; 3], edges: Edges) -> Option<Crossing> {
        let mut weights = [edge(c, b), edge(a, c), edge(b, a)];
        match edges {
            Edges::Exact => {
                if weights.iter().any(|&w| w < 0.0) && weights.iter().any(|&w| w > 0.0) {
                    return None;
                }
            }
            Edges::Widened => {
                let reach = self.reach.max(a.reach).max(b.reach).max(c.reach);
                let span =
                    |p: ShearedVertex, q: ShearedVertex| (p.x - q.x).abs() + (p.y - q.y).abs();
                weights = widened(weights, [span(c, b), span(a, c), span(b, a)], reach)?;
            }
        }
        self.crossing(weights, [a.depth, b.depth, c.depth])
    }

    /// The crossings of the triangles 0 1 2 and 0 2 3 of four points with widened edges, as
    /// [`ShearedRay::cross`] finds them. The points are given by axis, with the largest coordinate of
    /// each triangle.
    #[inline(always)]
    pub(crate) fn cross_quad(
        &self,
        columns: &[[f64; 4]; 3],
        reaches: [f64; 2],
    ) -> [Option<Crossing>; 2] {
        let [px, py, pz] = self.axes.map(|axis| columns[axis]);
        let [ox, oy, oz] = self.axes.map(|axis| self.origin[axis]);
        let [mut x, mut y, mut depths] = [[0.0; 4]; 3];
        for k in 0..4 {
            depths[k] = pz[k] - oz;
            x[k] = (px[k] - ox) - self.shear[0] * depths[k];
            y[k] = (py[k] - oy) - self.shear[1] * depths[k];
        }
        // Of each side, from a point to the next, and of the diagonal.
        let (to_x, to_y) = ([x[1], x[2], x[3], x[0]], [y[1], y[2], y[3], y[0]]);
        let [mut sides, mut spans] = [[0.0; 4]; 2];
        for k in 0..4 {
            sides[k] = x[k] * to_y[k] - y[k] * to_x[k];
            spans[k] = (x[k] - to_x[k]).abs() + (y[k] - to_y[k]).abs();
        }
        let mut diagonal = x[0] * y[2] - y[0] * x[2];
        if diagonal == 0.0 || sides.contains(&0.0) {
            let at = |k: usize| ShearedVertex { x: x[k], y: y[k], depth: 0.0, reach: 0.0 };
            sides =
                [edge(at(0), at(1)), edge(at(1), at(2)), edge(at(2), at(3)), edge(at(3), at(0))];
            diagonal = edge(at(0), at(2));
        }
        let across = (x[0] - x[2]).abs() + (y[0] - y[2]).abs();
        // The other way round an edge is its negative; a zero stays above 0.
        let halves = [
            ([0.0 - sides[1], diagonal, 0.0 - sides[0]], [spans[1], across, spans[0]], [0, 1, 2]),
            (
                [0.0 - sides[2], 0.0 - sides[3], 0.0 - diagonal],
                [spans[2], spans[3], across],
                [0, 2, 3],
            ),
        ];
        let mut found = [None; 2];
        for half in 0..2 {
            let (weights, spans, [a, b, c]) = halves[half];
            if let Some(weights) = widened(weights, spans, self.reach.max(reaches[half])) {
                found[half] = self.crossing(weights, [depths[a], depths[b], depths[c]]);
            }
        }
        found
    }

    /// The crossing of a triangle with these edge functions and depths.
    #[inline(always)]
    fn crossing(&self, weights: [f64; 3], depths: [f64; 3]) -> Option<Crossing> {
        let sum = weights[0] + weights[1] + weights[2];
        if sum == 0.0 {
            return None;
        }
        let weights = [weights[0] / sum, weights[1] / sum, weights[2] / sum];
        let depth = weights[0] * depths[0] + weights[1] * depths[1] + weights[2] * depths[2];
        let t = depth / self.along;
        t.is_finite().then_some(Crossing { t, weights, front: sum > 0.0 })
    }
}

/// Edge functions of a triangle whose edges, of these spans, are widened: cut at 0 where they are of the
/// other sign; nothing where one lies further outside.
#[inline(always)]
fn widened(mut weights: [f64; 3], spans: [f64; 3], reach: f64) -> Option<[f64; 3]> {
    let width = 2.0 * WIDENING * reach;
    let sign = (weights[0] + weights[1] + weights[2]).signum();
    for (w, span) in weights.iter_mut().zip(spans) {
        if *w * sign < -width * span {
            return None;
        }
        *w = (*w * sign).max(0.0) * sign;
    }
    Some(weights)
}

/// Twice the signed area of the origin, `q` and `p`, with its exact sign.
#[inline]
fn edge(p: ShearedVertex, q: ShearedVertex) -> f64 {
    let (ab, cd) = (p.x * q.y, p.y * q.x);
    let difference = ab - cd;
    if difference == 0.0 { p.x.mul_add(q.y, -ab) - p.y.mul_add(q.x, -cd) } else { difference }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::random::Random;

    fn cross(ray: &Ray, corners: [DVec3; 3], edges: Edges) -> Option<Crossing> {
        let sheared = ShearedRay::new(ray);
        sheared.cross(corners.map(|p| sheared.vertex(p)), edges)
    }

    const RIGHT: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn closed_form() {
        let ray = Ray::new(DVec3::new(0.25, 0.5, 2.0), -4.0 * DVec3::Z);
        let c = cross(&ray, RIGHT, Edges::Exact).expect("inside");
        assert_eq!((c.t, c.weights, c.front), (0.5, [0.25, 0.25, 0.5], true));
        let up = Ray::new(DVec3::new(0.25, 0.5, -1.0), DVec3::Z);
        let c = cross(&up, RIGHT, Edges::Exact).expect("inside");
        assert_eq!((c.t, c.front), (1.0, false));
        // Behind the origin: a negative parameter.
        let c = cross(&Ray::new(DVec3::new(0.1, 0.1, 1.0), DVec3::Z), RIGHT, Edges::Exact);
        assert_eq!(c.expect("the line crosses").t, -1.0);
        // Outside, edge-on.
        assert!(
            cross(&Ray::new(DVec3::new(0.6, 0.6, 1.0), DVec3::Z), RIGHT, Edges::Exact).is_none()
        );
        for edges in [Edges::Exact, Edges::Widened] {
            assert!(cross(&Ray::new(-DVec3::X, DVec3::X), RIGHT, edges).is_none());
        }
    }

    #[test]
    fn signs_are_exact_where_products_round_alike() {
        // 1 + e and 1 - e: the products differ from 1 by e^2 only.
        let e = 2f64.powi(-40);
        let at = |x, y| ShearedVertex { x, y, depth: 0.0, reach: 0.0 };
        assert!(edge(at(1.0 + e, 1.0), at(1.0, 1.0 - e)) < 0.0);
        assert!(edge(at(1.0, 1.0 - e), at(1.0 + e, 1.0)) > 0.0);
        assert_eq!(edge(at(3.0, 1.0), at(6.0, 2.0)), 0.0);
    }

    #[test]
    fn two_triangles_with_a_common_edge_leave_no_gap() {
        let mut random = Random(23);
        for _ in 0..200_000 {
            let shift = if random.unit() < 0.5 { 0.0 } else { 1e5 };
            let [p, q, r, s] = [0; 4].map(|_| random.cube() + shift);
            // A point on the edge p q, from a start from which both triangles lie on either side.
            let on_edge = p.lerp(q, random.unit());
            let origin = on_edge + random.direction();
            let ray = Ray::new(origin, on_edge - origin);
            let side = |x: DVec3| (q - p).cross(x - p).dot(ray.direction.cross(q - p));
            let normal = (q - p).cross(ray.direction);
            if side(r).is_nan() || normal.dot(r - p) * normal.dot(s - p) >= 0.0 {
                continue;
            }
            let one = cross(&ray, [p, q, r], Edges::Exact);
            let other = cross(&ray, [q, p, s], Edges::Exact);
            let near_corner = on_edge.distance(p).min(on_edge.distance(q)) < 1e-6;
            assert!(one.is_some() || other.is_some() || near_corner, "{ray:?}");
        }
    }

    #[test]
    fn widened_edges_reach_a_few_roundings_and_no_further() {
        for (beyond, expected) in [(1e-15, true), (1e-13, false)] {
            let ray = Ray::new(DVec3::new(0.5, -beyond, 1.0), -DVec3::Z);
            assert!(cross(&ray, RIGHT, Edges::Exact).is_none());
            let c = cross(&ray, RIGHT, Edges::Widened);
            assert_eq!(c.is_some(), expected);
            assert!(c.is_none_or(|c| c.weights[2] == 0.0 && (c.weights[0] - 0.5).abs() < 1e-14));
        }
    }
}
