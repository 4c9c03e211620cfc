//! Walls inside of triangles, between tiles of a map that do not join.
//!
//! A map on a vertex lattice that repeats shows its last samples and its first ones at the same line. Where these
//! differ the surface jumps at that line, wherever it runs. Base and normal are linear over a triangle, so they
//! are linear along the line too, and the hole between the two sheets is what it is over an edge: a piece of a
//! bilinear patch (`wall`), with two vertices of its own on the triangle's border. Lines along an edge are
//! left to `seams`. In a neighbour that shows the map alike the same line goes on from the same point, to
//! rounding; walls overlap by far more.

use glam::{DVec2, DVec3};

use crate::map::HeightMap;

use super::options::ReliefMeshError;
use super::seams::{SAME, jumps};
use super::vertices::{Vertex, Vertices};
use super::wall::{Side, Wall};

/// Walls inside of triangles at most.
const MOST: u64 = 1 << 22;

/// The walls inside of all triangles, with their vertices added to those of the mesh.
pub(super) fn walls(
    vertices: &mut Vertices,
    lattice: &[[[f64; 2]; 3]],
    heights: &HeightMap,
) -> Result<Vec<Wall>, ReliefMeshError> {
    let axes = [heights.x(), heights.y()];
    let jumping: Vec<usize> = (0..2).filter(|&k| jumps(heights, axes[k], k == 0)).collect();
    let mut walls = Vec::new();
    if jumping.is_empty() {
        return Ok(walls);
    }
    let period = |axis: usize| f64::from(axes[axis].period());
    let counted = |axis: usize| {
        let lines = lattice.iter().map(move |corners| lines(corners, axis, period(axis)));
        lines.map(|[first, end]| (end - first).max(0) as u64).sum::<u64>()
    };
    let found: u64 = jumping.iter().map(|&axis| counted(axis)).sum();
    if found > MOST {
        return Err(ReliefMeshError::TooManyWalls { found });
    }
    for (triangle, corners) in (0..).zip(lattice) {
        for &axis in &jumping {
            let [first, end] = lines(corners, axis, period(axis));
            for line in first..end {
                let line = line as f64 * period(axis);
                if let Some(cut) = cut(corners, axis, line) {
                    walls.push(raised(vertices, (triangle, corners), (axis, line), cut));
                }
            }
        }
    }
    Ok(walls)
}

/// Numbers of the lines between tiles that a triangle may cross, first and one past the last.
fn lines(corners: &[[f64; 2]; 3], axis: usize, period: f64) -> [i64; 2] {
    let [a, b, c] = corners.map(|corner| corner[axis]);
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    [(low / period).ceil() as i64, (high / period).floor() as i64 + 1]
}

/// Barycentric weights of the ends of a line across a triangle, its lower side to the left.
fn cut(corners: &[[f64; 2]; 3], axis: usize, line: f64) -> Option<[DVec3; 2]> {
    let off = corners.map(|corner| corner[axis] - line);
    let side = off.map(|off| if off.abs() <= SAME { 0 } else { off.signum() as i32 });
    let lower = side.iter().position(|&side| side < 0)?;
    if !side.contains(&1) {
        return None;
    }
    let mut ends = Vec::with_capacity(2);
    for k in 0..3 {
        let next = (k + 1) % 3;
        if side[k] == 0 {
            ends.push(DVec3::AXES[k]);
        }
        if side[k] * side[next] < 0 {
            let s = off[k] / (off[k] - off[next]);
            ends.push(DVec3::AXES[k].lerp(DVec3::AXES[next], s));
        }
    }
    let &[a, b] = ends.as_slice() else { return None };
    // Weights of the second and third corner run around a triangle as its corners do in space.
    let flat = |weights: DVec3| DVec2::new(weights.y, weights.z);
    let left = (flat(b) - flat(a)).perp_dot(flat(DVec3::AXES[lower]) - flat(a)) > 0.0;
    Some(if left { [a, b] } else { [b, a] })
}

/// The wall over a cut, and its vertices.
fn raised(
    vertices: &mut Vertices,
    (triangle, corners): (u32, &[[f64; 2]; 3]),
    (axis, line): (usize, f64),
    cut: [DVec3; 2],
) -> Wall {
    let corner_vertices = vertices.corners[triangle as usize].map(|k| vertices.all[k as usize]);
    let first_vertex = vertices.all.len() as u32;
    for weights in cut {
        let mixed = |of: [DVec3; 3]| (0..3).map(|k| weights[k] * of[k]).sum();
        let base = mixed(corner_vertices.map(|v| v.base));
        let rise = mixed(corner_vertices.map(|v| v.rise));
        vertices.all.push(Vertex { base, rise });
    }
    let ends = cut.map(|weights| {
        let mut at = [0, 1].map(|k| (0..3).map(|c| weights[c] * corners[c][k]).sum::<f64>());
        at[axis] = line;
        at
    });
    let side = |towards: f64| {
        let mut inside = [0.0; 2];
        inside[axis] = towards;
        Side { ends, inside }
    };
    Wall {
        ends: [first_vertex, first_vertex + 1],
        triangle,
        first: side(-1.0),
        second: Some(side(1.0)),
        neighbour: None,
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::map::{Lattice, Samples, Wrap};
    use crate::mesh::{Mesh, MeshData, Triangle};
    use crate::ray::{Part, Ray};
    use crate::relief::{Displacement, MeshOptions, Relief, ReliefMesh};

    /// The unit square under saw teeth along x, half a unit high.
    fn saw(teeth: f64) -> Result<ReliefMesh, ReliefMeshError> {
        let samples = Samples::U16(vec![0, 65535, 0, 65535]);
        let map = HeightMap::new(2, 2, samples, Lattice::Vertex, Wrap::Repeat).unwrap();
        let uvs = vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let positions = uvs.iter().map(|uv| uv.extend(0.0)).collect();
        let triangle = |at| Triangle { positions: at, normals: None, uvs: Some(at) };
        let triangles = vec![triangle([0, 1, 2]), triangle([0, 2, 3])];
        let mesh = Mesh::new(MeshData { positions, normals: Vec::new(), uvs, triangles }).unwrap();
        let displacement =
            Displacement { scale: 0.5, tile: [teeth, 1.0], ..Displacement::default() };
        let options = MeshOptions { displacement, ..MeshOptions::default() };
        ReliefMesh::new(&mesh, Arc::new(Relief::new(map)), options)
    }

    #[test]
    fn a_ray_meets_the_back_of_a_saw_tooth() {
        let mesh = saw(2.0).unwrap();
        assert_eq!(mesh.report().tile_walls, 2);
        for y in [0.3, 0.7] {
            for direction in [-DVec3::X, DVec3::X] {
                // From above the next tooth, or from within the tooth itself.
                let from = DVec3::new(if direction.x < 0.0 { 0.51 } else { 0.4 }, y, 0.25 * y);
                let hit = mesh.closest(&Ray::new(from, direction), &mut ()).expect("a wall");
                assert!(matches!(hit.part, Part::SeamWall(_)), "{hit:?}");
                assert!(hit.position.distance(DVec3::new(0.5, y, 0.25 * y)) < 1e-12, "{hit:?}");
                assert!(hit.uv.distance(DVec2::new(0.5, y)) < 1e-12, "{hit:?}");
                assert!(hit.geometric_normal.distance(DVec3::X) < 1e-12, "{hit:?}");
                assert_eq!(hit.front, direction.x < 0.0);
            }
        }
    }

    #[test]
    fn teeth_beyond_counting_are_refused() {
        let found = saw(2.5e6).unwrap_err();
        assert!(matches!(found, ReliefMeshError::TooManyWalls { found } if found > MOST));
    }
}
