//! Interpolation over one triangle of a mesh.

use glam::{DVec2, DVec3};

use super::{Mesh, Triangle};
use crate::accel::rounding::gamma;

/// A point of a triangle with its surroundings.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SurfacePoint {
    pub(crate) position: DVec3,
    pub(crate) position_error: f64,
    pub(crate) geometric_normal: DVec3,
    pub(crate) shading_normal: DVec3,
    pub(crate) uv: DVec2,
    pub(crate) tangents: [DVec3; 2],
}

/// `sum of weights[i] * points[i]` and a bound on its distance from the exact convex combination:
/// division, product and two sums each for weights and terms \[Pharr2023, section 6.8\].
pub(crate) fn interpolate_position(points: &[DVec3; 3], weights: &[f64; 3]) -> (DVec3, f64) {
    let terms = [points[0] * weights[0], points[1] * weights[1], points[2] * weights[2]];
    let reach = terms[0].abs() + terms[1].abs() + terms[2].abs();
    (terms[0] + terms[1] + terms[2], gamma(7) * reach.length())
}

/// Unit normal of a counter-clockwise triangle, or `None` if it has no area to rounding.
pub(crate) fn triangle_normal(&[a, b, c]: &[DVec3; 3]) -> Option<DVec3> {
    let (e, f) = (b - a, c - a);
    let normal = e.cross(f);
    let length = normal.length();
    (length > 4.0 * f64::EPSILON * e.length() * f.length()).then(|| normal / length)
}

impl Mesh {
    /// The point of triangle `index` with barycentric `weights`.
    pub(crate) fn point(&self, index: u32, weights: &[f64; 3]) -> SurfacePoint {
        let triangle = &self.data.triangles[index as usize];
        let corners = self.corners(index);
        let (position, position_error) = interpolate_position(&corners, weights);
        let geometric_normal = triangle_normal(&corners).unwrap_or(DVec3::Z);
        let (uv, tangents) = self.parametrisation(triangle, &corners, weights);
        let shading_normal = self.shading_normal(triangle, geometric_normal, weights);
        SurfacePoint { position, position_error, geometric_normal, shading_normal, uv, tangents }
    }

    /// The interpolated normal, turned to the side of the geometric one; the geometric one where
    /// the file has none or they cancel.
    fn shading_normal(&self, triangle: &Triangle, geometric: DVec3, weights: &[f64; 3]) -> DVec3 {
        let Some(normals) = triangle.normals else {
            return geometric;
        };
        let [a, b, c] = normals.map(|i| self.data.normals[i as usize]);
        let sum = weights[0] * a + weights[1] * b + weights[2] * c;
        let normal = sum.try_normalize().unwrap_or(geometric);
        if normal.dot(geometric) < 0.0 { -normal } else { normal }
    }

    /// uv and (dP/du, dP/dv). Without uv, the weights of the second and third corner are u and v.
    fn parametrisation(
        &self,
        triangle: &Triangle,
        corners: &[DVec3; 3],
        weights: &[f64; 3],
    ) -> (DVec2, [DVec3; 2]) {
        let (e, f) = (corners[1] - corners[0], corners[2] - corners[0]);
        let Some(uvs) = triangle.uvs else {
            return (DVec2::new(weights[1], weights[2]), [e, f]);
        };
        let [a, b, c] = uvs.map(|i| self.data.uvs[i as usize]);
        let uv = weights[0] * a + weights[1] * b + weights[2] * c;
        let (g, h) = (b - a, c - a);
        // e = g.x P_u + g.y P_v, f = h.x P_u + h.y P_v.
        let area = g.perp_dot(h);
        let tangents = [(h.y * e - g.y * f) / area, (g.x * f - h.x * e) / area];
        (uv, if tangents.iter().all(|p| p.is_finite()) { tangents } else { [e, f] })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::MeshData;

    fn mesh(normals: Vec<DVec3>, uvs: Vec<DVec2>) -> Mesh {
        let of = |n: usize| (n > 0).then_some([0, 1, 2]);
        let triangle =
            Triangle { positions: [0, 1, 2], normals: of(normals.len()), uvs: of(uvs.len()) };
        let positions = vec![DVec3::ZERO, 2.0 * DVec3::X, 3.0 * DVec3::Y];
        let data = MeshData { positions, normals, uvs, triangles: vec![triangle] };
        Mesh::new(data).expect("valid")
    }

    #[test]
    fn without_attributes() {
        let p = mesh(vec![], vec![]).point(0, &[0.25, 0.25, 0.5]);
        assert_eq!(p.position, DVec3::new(0.5, 1.5, 0.0));
        assert!(p.position_error > 0.0 && p.position_error < 1e-14);
        assert_eq!((p.geometric_normal, p.shading_normal), (DVec3::Z, DVec3::Z));
        assert_eq!(p.uv, DVec2::new(0.25, 0.5));
        assert_eq!(p.tangents, [2.0 * DVec3::X, 3.0 * DVec3::Y]);
    }

    #[test]
    fn tangents_follow_uv() {
        // u = y / 3, v = 1 - x / 2.
        let uvs = vec![DVec2::new(0.0, 1.0), DVec2::ZERO, DVec2::ONE];
        let p = mesh(vec![], uvs).point(0, &[0.25, 0.25, 0.5]);
        assert_eq!(p.uv, DVec2::new(0.5, 0.75));
        assert_eq!(p.tangents, [3.0 * DVec3::Y, -2.0 * DVec3::X]);
        let flat = mesh(vec![], vec![DVec2::ZERO; 3]).point(0, &[0.25, 0.25, 0.5]);
        assert_eq!(flat.tangents, [2.0 * DVec3::X, 3.0 * DVec3::Y]);
    }

    #[test]
    fn shading_normals_are_unit_and_in_front() {
        let tilted = DVec3::new(1.0, 0.0, 1.0).normalize();
        let weights = [0.5, 0.5, 0.0];
        let p = mesh(vec![DVec3::Z, tilted, DVec3::Z], vec![]).point(0, &weights);
        let expected = (DVec3::Z + tilted).normalize();
        assert!(p.shading_normal.distance(expected) < 1e-15);
        let behind = mesh(vec![-DVec3::Z, -tilted, -DVec3::Z], vec![]).point(0, &weights);
        assert!(behind.shading_normal.distance(expected) < 1e-15);
        let cancelled = mesh(vec![DVec3::X, -DVec3::X, DVec3::Z], vec![]).point(0, &weights);
        assert_eq!(cancelled.shading_normal, DVec3::Z);
    }

    #[test]
    fn collinear_corners_have_no_normal() {
        let [a, b, c] = [DVec3::ZERO, DVec3::new(0.1, 0.2, 0.3), DVec3::new(0.3, 0.6, 0.9)];
        assert_eq!(triangle_normal(&[a, b, c]), None);
        assert_eq!(triangle_normal(&[a, a, b]), None);
        assert_eq!(triangle_normal(&[b, b, b]), None);
    }
}
