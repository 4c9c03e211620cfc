//! Closed solids to begin with: bases for displacement, examples and tests. Without normals and
//! uv; the front is outside.

use std::collections::HashMap;

use glam::DVec3;

use super::{MeshData, Triangle};

fn triangle(positions: [u32; 3]) -> Triangle {
    Triangle { positions, normals: None, uvs: None }
}

/// The cube `[-1, 1]^3`, twelve triangles; corner `i` has a bit for each positive coordinate.
pub fn cube() -> MeshData {
    let sign = |i: u32, bit: u32| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
    let positions = (0..8).map(|i| DVec3::new(sign(i, 0), sign(i, 1), sign(i, 2))).collect();
    let quads =
        [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    let fan = |[a, b, c, d]: [u32; 4]| [triangle([a, b, c]), triangle([a, c, d])];
    let triangles = quads.into_iter().flat_map(fan).collect();
    MeshData { positions, triangles, ..MeshData::default() }
}

/// The unit octahedron with each triangle cut in four `levels` times, `8 4^levels` triangles; vertices
/// are on the unit sphere.
///
/// # Panics
/// If `levels` is above 12: some hundred million triangles.
pub fn subdivided_sphere(levels: u32) -> MeshData {
    assert!(levels <= 12, "at most 12 levels, not {levels}");
    let mut positions: Vec<DVec3> =
        [DVec3::X, DVec3::Y, DVec3::Z].iter().flat_map(|&a| [a, -a]).collect();
    let mut triangles = Vec::new();
    for (x, y, z) in (0..8).map(|i| (i & 1, i >> 1 & 1, i >> 2)) {
        let (a, b, c) = (x, 2 + y, 4 + z);
        triangles.push(if (x + y + z) % 2 == 0 { [a, b, c] } else { [a, c, b] });
    }
    for _ in 0..levels {
        let mut middles = HashMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                positions.push((positions[a as usize] + positions[b as usize]).normalize());
                positions.len() as u32 - 1
            })
        };
        let cut = |[a, b, c]: [u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        triangles = triangles.into_iter().flat_map(cut).collect();
    }
    let triangles = triangles.into_iter().map(triangle).collect();
    MeshData { positions, triangles, ..MeshData::default() }
}
