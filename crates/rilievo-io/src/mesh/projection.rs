//! [`Projection`]: texture coordinates for meshes that have none, or none that serve.
//!
//! | projection | u, v |
//! |---|---|
//! | along x, y or z | the other two coordinates |
//! | box | for each triangle that along the axis it faces most |
//! | sphere | longitude and latitude around the middle of the mesh, poles on +-z |
//!
//! One unit of uv is the largest side of the box around the mesh; on a sphere it is the whole turn.
//! Neighbours agree where they face alike; a box has seams where the axis changes, a sphere where
//! longitudes meet, which a triangle crosses with u beyond 1. At a pole a corner takes the middle
//! longitude of the other two.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3, Vec3Swizzles};
use rilievo::mesh::MeshData;

/// How texture coordinates follow from positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Along the x axis: (y, z).
    X,
    /// Along the y axis: (x, z).
    Y,
    /// Along the z axis: (x, y).
    Z,
    /// Along the axis that a triangle faces most.
    Box,
    /// Longitude and latitude.
    Sphere,
}

impl Projection {
    /// Names and projections.
    pub const ALL: [(&'static str, Self); 5] = [
        ("x", Self::X),
        ("y", Self::Y),
        ("z", Self::Z),
        ("box", Self::Box),
        ("sphere", Self::Sphere),
    ];

    /// Replaces the texture coordinates of a mesh, whose indices hold.
    pub fn lay(self, mesh: &mut MeshData) {
        let used = mesh.triangles.iter().flat_map(|t| t.positions);
        let used = used.map(|i| mesh.positions[i as usize]);
        let ends = |(low, high): (DVec3, DVec3), p: DVec3| (low.min(p), high.max(p));
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = used.fold(none, ends);
        let side = (high - low).max_element();
        // A mesh that is a point has no size to measure by.
        let side = if side > 0.0 && side.is_finite() { side } else { 1.0 };
        mesh.uvs.clear();
        for triangle in &mut mesh.triangles {
            let corners = triangle.positions.map(|i| mesh.positions[i as usize]);
            let uvs = match self {
                Self::Sphere => around(corners.map(|p| p - 0.5 * (low + high))),
                _ => corners.map(|p| self.flat(corners, (p - low) / side)),
            };
            let first = mesh.uvs.len() as u32;
            mesh.uvs.extend(uvs);
            triangle.uvs = Some([first, first + 1, first + 2]);
        }
    }

    /// The place of `p` on the plane that a triangle is projected on.
    fn flat(self, [a, b, c]: [DVec3; 3], p: DVec3) -> DVec2 {
        let facing = (b - a).cross(c - a).abs();
        match self {
            Self::X => p.yz(),
            Self::Y => p.xz(),
            Self::Z | Self::Sphere => p.xy(),
            Self::Box if facing.z >= facing.x && facing.z >= facing.y => p.xy(),
            Self::Box if facing.x >= facing.y => p.yz(),
            Self::Box => p.xz(),
        }
    }
}

/// Longitude over a turn and latitude over half of one, so that no side of the triangle goes the
/// long way round.
fn around(corners: [DVec3; 3]) -> [DVec2; 3] {
    let mut uvs = corners.map(|p| {
        let latitude = p.z.atan2(p.truncate().length());
        DVec2::new(p.y.atan2(p.x) / TAU + 0.5, latitude / (0.5 * TAU) + 0.5)
    });
    let is_pole = corners.map(|p| p.x == 0.0 && p.y == 0.0);
    let reference = (0..3).find(|&k| !is_pole[k]).map_or(0.5, |k| uvs[k].x);
    for uv in &mut uvs {
        uv.x -= (uv.x - reference).round();
    }
    for k in (0..3).filter(|&k| is_pole[k]) {
        uvs[k].x = 0.5 * (uvs[(k + 1) % 3].x + uvs[(k + 2) % 3].x);
    }
    uvs
}

#[cfg(test)]
mod tests {
    use rilievo::mesh::Triangle;

    use super::*;

    fn mesh(corners: &[[f64; 3]]) -> MeshData {
        let positions = corners.iter().map(|p| DVec3::from_array(*p)).collect();
        let triangles = (0..corners.len() as u32 / 3)
            .map(|k| Triangle {
                positions: [3 * k, 3 * k + 1, 3 * k + 2],
                normals: None,
                uvs: None,
            })
            .collect();
        MeshData { positions, triangles, ..MeshData::default() }
    }

    fn uvs(projection: Projection, corners: &[[f64; 3]]) -> Vec<[f64; 2]> {
        let mut mesh = mesh(corners);
        projection.lay(&mut mesh);
        assert!(mesh.triangles.iter().all(|t| t.uvs == Some(t.positions)));
        mesh.uvs.iter().map(|uv| uv.to_array()).collect()
    }

    #[test]
    fn planes_keep_shapes_and_the_largest_side_is_one() {
        let corners = [[1.0, 1.0, 0.0], [5.0, 1.0, 0.0], [1.0, 3.0, 1.0]];
        assert_eq!(uvs(Projection::Z, &corners), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]);
        assert_eq!(uvs(Projection::Y, &corners), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.25]]);
        assert_eq!(uvs(Projection::X, &corners), [[0.0, 0.0], [0.0, 0.0], [0.5, 0.25]]);
        assert_eq!(uvs(Projection::Box, &corners), uvs(Projection::Z, &corners));
        let wall = [[0.0, 0.0, 0.0], [0.0, 2.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(uvs(Projection::Box, &wall), [[0.0, 0.0], [1.0, 0.0], [0.0, 0.5]]);
        assert_eq!(uvs(Projection::Z, &[[7.0; 3]; 3]), [[0.0; 2]; 3]);
    }

    #[test]
    fn no_triangle_of_a_sphere_goes_the_long_way_round() {
        // Across the date line, and to the pole.
        let corners = [
            [-1.0, 0.2, 0.0],
            [-1.0, -0.2, 0.0],
            [-1.0, 0.0, 0.4],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.0],
            [0.0, 0.0, 1.0],
            [0.0, 0.0, -1.0],
            [1.0, -1.0, 0.0],
            [0.5, 1.0, 0.0],
        ];
        let found = uvs(Projection::Sphere, &corners);
        for triangle in found.chunks(3) {
            let across = triangle.iter().map(|uv| uv[0]);
            let (low, high) =
                across.fold((9.0, -9.0), |(l, h): (f64, f64), u| (l.min(u), h.max(u)));
            assert!(high - low < 0.5, "{triangle:?}");
            assert!(triangle.iter().all(|uv| (0.0..=1.0).contains(&uv[1])));
        }
        assert!((found[5][0] - 0.5 * (found[3][0] + found[4][0])).abs() < 1e-12);
        assert_eq!(found[5][1], 1.0);
    }
}
