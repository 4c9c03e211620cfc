//! Forms of displaced meshes: base and displacement of each triangle's corners and of each wall's ends. The twin of the
//! CPU's `relief/mesh/hit.rs`, `shaders/hit/mesh.wgsl`, reads them.

use rilievo::glam::{DVec2, DVec3};
use rilievo::map::Metric;
use rilievo::mesh::MeshData;
use rilievo::relief::{MeshPrism, MeshWall, ReliefMesh, ShadingNormals};
use rilievo_render::device::Uncovered;

use super::{MOST_TRIANGLES, pair, triple};
use crate::records::Words;

/// Words of a displaced triangle.
pub(crate) const SHELL_FORM: usize = 81;
/// Words of a wall.
pub(crate) const SHELL_WALL_FORM: usize = 29;
/// Words of what holds for all of a mesh.
const MESH_FORM: usize = 15;

/// Bits of a triangle: its uv span an area; they are mirrored; it has normals of its own.
const SPREAD: u32 = 1;
const MIRRORED: u32 = 2;
const AUTHORED: u32 = 4;

/// Writes a displaced mesh; its form is what begins at the words of the mesh.
///
/// # Errors
/// [`Uncovered`] for a map of normals, and for too many triangles.
pub(super) fn write_relief_mesh(
    words: &mut Vec<u32>,
    mesh: &ReliefMesh,
    anchor: DVec3,
) -> Result<(), Uncovered> {
    let (prisms, walls) = (mesh.prisms(), mesh.walls());
    if prisms.len() + walls.len() > MOST_TRIANGLES {
        return Err(Uncovered("a mesh of more than four million triangles"));
    }
    let (heights, options) = (mesh.relief().heights(), mesh.options());
    let (kind, made_in) = match options.normals {
        ShadingNormals::Exact => (0, None),
        ShadingNormals::Smooth => (1, None),
        ShadingNormals::Published => (2, None),
        ShadingNormals::WrongMetric => (1, Some(Metric::of_face(heights, [1.0; 2], 1.0))),
        ShadingNormals::Map(_) => return Err(Uncovered("a map of normals under a relief")),
    };
    let (frame, before) = (mesh.frame(), words.len());
    words.vector(frame.centre - anchor);
    words.float(frame.level);
    words.extend([kind, u32::from(made_in.is_some())]);
    let steepness = made_in.map_or([0.0; 2], |Metric { x, y, z }| [z / x, z / y]);
    steepness.into_iter().for_each(|x| words.float(x as f32));
    words.float((options.displacement.scale * heights.unit()) as f32);
    let first = before + MESH_FORM;
    words.extend([first as u32, (first + prisms.len() * SHELL_FORM) as u32, 0]);
    debug_assert_eq!(words.len(), first);
    let vertices: Vec<[DVec3; 2]> = mesh.vertices().collect();
    let prisms: Vec<MeshPrism> = prisms.collect();
    for (prism, number) in prisms.iter().zip(0..) {
        write_shell(words, (prism, number), mesh.data(), &vertices);
    }
    for wall in walls {
        let ends = wall_uvs(mesh, &wall, &prisms);
        let before = words.len();
        write_vertices(words, wall.ends.map(|k| vertices[k as usize]));
        ends.into_iter().for_each(|uv| pair(words, uv));
        words.push(wall.triangle);
        debug_assert_eq!(words.len() - before, SHELL_WALL_FORM);
    }
    Ok(())
}

/// Where vertices lie, then along what they are displaced.
fn write_vertices<const N: usize>(words: &mut Vec<u32>, vertices: [[DVec3; 2]; N]) {
    vertices.iter().for_each(|[base, _]| words.vector(*base));
    vertices.iter().for_each(|[_, rise]| words.vector(*rise));
}

fn write_shell(
    words: &mut Vec<u32>,
    (prism, number): (&MeshPrism, usize),
    data: &MeshData,
    vertices: &[[DVec3; 2]],
) {
    let before = words.len();
    write_vertices(words, prism.corners.map(|k| vertices[k as usize]));
    let [p, q, r] = prism.lattice.map(DVec2::from_array);
    for place in [p, q - p, r - p] {
        place.to_array().into_iter().for_each(|x| words.double(x));
    }
    prism.weights.as_flattened().iter().for_each(|&weight| words.double(weight));
    let triangle = &data.triangles[number];
    let flags = [
        (prism.spread, SPREAD),
        (prism.mirrored, MIRRORED),
        (triangle.normals.is_some(), AUTHORED),
    ];
    words.push(flags.into_iter().map(|(flag, bit)| u32::from(flag) * bit).sum());
    let [a, b, c] = triangle.positions.map(|at| data.positions[at as usize]);
    let (e, f) = (b - a, c - a);
    let uvs = triangle.uvs.map(|at| at.map(|uv| data.uvs[uv as usize]));
    let [uv, g, h] = uvs.map_or([DVec2::ZERO; 3], |[a, b, c]| [a, b - a, c - a]);
    [uv, g, h].into_iter().for_each(|uv| pair(words, uv));
    let area = g.perp_dot(h);
    let along = [(h.y * e - g.y * f) / area, (g.x * f - h.x * e) / area];
    let along = if along.iter().all(|v| v.is_finite()) { along } else { [e, f] };
    along.into_iter().for_each(|v| triple(words, v));
    triple(words, e.cross(f).normalize_or(DVec3::Z));
    let normals = triangle.normals.map(|at| at.map(|n| data.normals[n as usize]));
    let normals = normals.map(|at| at.map(|n| n.normalize_or_zero()));
    normals.unwrap_or_default().into_iter().for_each(|n| triple(words, n));
    debug_assert_eq!(words.len() - before, SHELL_FORM);
}

/// Uv at both ends of a wall: those of its triangle's corners; inside of the triangle, those that show the map there.
fn wall_uvs(mesh: &ReliefMesh, wall: &MeshWall, prisms: &[MeshPrism]) -> [DVec2; 2] {
    let (data, triangle) = (mesh.data(), wall.triangle as usize);
    let (heights, shown) = (mesh.relief().heights(), mesh.options().displacement);
    [0, 1].map(|end| {
        let corner = prisms[triangle].corners.iter().position(|&k| k == wall.ends[end]);
        match (data.triangles[triangle].uvs, corner) {
            (Some(uvs), Some(k)) => data.uvs[uvs[k] as usize],
            _ => {
                let [x, y] = wall.first[end];
                let tiled = DVec2::new(heights.x().parameter(x), heights.y().parameter(y));
                (tiled - DVec2::from_array(shown.shift)) / DVec2::from_array(shown.tile)
            }
        }
    })
}
