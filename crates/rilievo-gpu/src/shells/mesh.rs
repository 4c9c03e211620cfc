//! Displaced meshes: vertices, prisms and walls.
//!
//! A prism is walked in floats. Its lattice coordinates count from a cell in its middle, its ray from the point
//! nearest to its middle, so all numbers are at most its own size; what a float rounds of that is
//! added to the errors of its frame ([`FLOAT`]).

use std::collections::HashMap;

use rilievo::glam::DVec3;
use rilievo::relief::{MeshBeside, MeshFrame, MeshPrism, MeshWall, ReliefMesh};

use super::ROUNDING;
use crate::records::{NOTHING, Words};

/// Words of a prism.
const PRISM_WORDS: usize = 66;
/// Words of a vertex.
const VERTEX_WORDS: usize = 12;
/// Words of a wall.
const WALL_WORDS: usize = 25;

/// Share of a prism's size that a path in floats is off by: 32 roundings.
const FLOAT: f64 = 1.0 / (1 << 19) as f64;

/// Lifts are this much larger than rounding.
const SPARE: f64 = 4.0;

/// Bits of a prism: its uv span an area; they are mirrored; it has a frame.
const SPREAD: u32 = 1;
const MIRRORED: u32 = 2;
const SEES: u32 = 4;

/// Bits of a mesh.
const RISES: u32 = 1;
const ONE_SIDED: u32 = 4;

/// Where the parts of a mesh lie in `numbers`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshPlaces {
    vertices: u32,
    prisms: u32,
    walls: u32,
}

/// Appends what another part of a joined mesh shows, with its map as that of face `face`; returns its place.
pub(crate) fn write_beside(words: &mut Vec<u32>, beside: &MeshBeside<'_>, face: u32) -> u32 {
    let place = words.len() as u32;
    words.push(face);
    words.float(beside.level);
    words.double(beside.per_height);
    words.double(beside.lift);
    place
}

/// Appends vertices, prisms and walls; other parts that walls show lie at places by their number.
pub(crate) fn write_parts(
    words: &mut Vec<u32>,
    mesh: &ReliefMesh,
    beside: &HashMap<u32, u32>,
) -> MeshPlaces {
    let vertices: Vec<[DVec3; 2]> = mesh.vertices().collect();
    let (prisms, walls) = (mesh.prisms(), mesh.walls());
    words.reserve(
        vertices.len() * VERTEX_WORDS + prisms.len() * PRISM_WORDS + walls.len() * WALL_WORDS,
    );
    let vertices_at = words.len() as u32;
    vertices.iter().flatten().for_each(|&v| words.vector(v));
    let prisms_at = words.len() as u32;
    prisms.for_each(|prism| write_prism(words, &prism, &vertices));
    let walls_at = words.len() as u32;
    walls.for_each(|wall| {
        write_wall(words, &wall);
        let part = wall.beside.and_then(|part| beside.get(&part).copied());
        words.push(part.unwrap_or(NOTHING));
    });
    MeshPlaces { vertices: vertices_at, prisms: prisms_at, walls: walls_at }
}

/// Appends what holds for all of a mesh: its map is that of face `face`, its tree begins at `root`, rays are cut to the
/// box of node `cut`.
pub(crate) fn write_mesh(
    words: &mut Vec<u32>,
    mesh: &ReliefMesh,
    anchor: DVec3,
    (places, face, [root, cut]): (MeshPlaces, u32, [u32; 2]),
) {
    let MeshFrame { centre, reach, level, half_range, base, height_slack, rises, .. } =
        mesh.frame();
    words.vector(centre - anchor);
    words.float(level);
    words.float(half_range as f32);
    words.double(base);
    words.float((height_slack + FLOAT * half_range + 1e-30) as f32);
    // Starts are rounded in the world, and again from the anchor.
    let world = 2.0 * f64::EPSILON * (centre.abs().max_element() + reach);
    let start = world + 0.25 * ROUNDING * ((centre - anchor).length() + reach);
    words.float((SPARE * start) as f32);
    let one_sided = mesh.options().one_sided;
    words.push(u32::from(one_sided) * ONE_SIDED + u32::from(rises) * RISES);
    words.extend([face, places.vertices, places.prisms, places.walls]);
    words.extend([mesh.prisms().len() as u32, root]);
    words.float((SPARE * 64.0 * ROUNDING * reach) as f32);
    words.push(cut);
}

fn write_prism(words: &mut Vec<u32>, prism: &MeshPrism, vertices: &[[DVec3; 2]]) {
    let before = words.len();
    let corners = prism.corners.map(|k| vertices[k as usize]);
    let ends = prism.heights.into_iter();
    let hull = ends.flat_map(|h| corners.map(|[base, rise]| base + h * rise));
    let [low, high] = prism.heights;
    let third = 1.0 / 3.0;
    let middle = [0, 1].map(|k| third * prism.lattice.iter().map(|p| p[k]).sum::<f64>());
    let base = middle.map(f64::floor);
    let at = match &prism.frame {
        Some(frame) => frame.at,
        None => hull.clone().sum::<DVec3>() / 6.0,
    };
    let radius = hull.map(|p| p.distance(at)).fold(0.0, f64::max) * 1.0001 + 4.0 * prism.t_slack;
    words.extend(prism.corners);
    let sees = prism.frame.is_some();
    let flags = [(prism.spread, SPREAD), (prism.mirrored, MIRRORED), (sees, SEES)];
    words.push(flags.into_iter().map(|(flag, bit)| u32::from(flag) * bit).sum());
    let lattice = prism.lattice.map(|p| [p[0] - base[0], p[1] - base[1]]);
    lattice.as_flattened().iter().for_each(|&x| words.double(x));
    words.extend(base.map(|x| x as i32 as u32));
    words.extend(prism.cells.as_flattened().iter().map(|&cell| cell as u32));
    prism.weights.as_flattened().iter().for_each(|&w| words.double(w));
    for x in [low, high, prism.condition, prism.steepness, prism.t_slack] {
        words.float(x as f32);
    }
    let centre = match &prism.frame {
        Some(frame) => frame.centre - DVec3::new(base[0], base[1], 0.0),
        None => DVec3::ZERO,
    };
    centre.to_array().into_iter().for_each(|x| words.float(x as f32));
    words.vector(at);
    match &prism.frame {
        None => words.resize(before + PRISM_WORDS - 1, 0),
        Some(frame) => {
            let matrix = frame.lattice_from_space;
            let size = |k: usize| {
                let corners = lattice.iter().map(|p| p[k].abs());
                1.0 + corners.fold(0.0, f64::max)
            };
            let extent = DVec3::new(size(0), size(1), low.abs().max(high.abs()));
            let spread = matrix.x_axis.abs() + matrix.y_axis.abs() + matrix.z_axis.abs();
            // A quarter for speeds that count as larger than they are.
            let noise = 1.25 * (frame.noise + FLOAT * (radius * spread + extent));
            let error = frame.error + (noise - frame.noise);
            let [a, b] = frame.bend;
            for v in [matrix.x_axis, matrix.y_axis, matrix.z_axis, a, b, error, noise] {
                v.to_array().into_iter().for_each(|x| words.float(x as f32));
            }
        }
    }
    words.float(radius as f32);
    debug_assert_eq!(words.len() - before, PRISM_WORDS);
}

fn write_wall(words: &mut Vec<u32>, wall: &MeshWall) {
    words.extend(wall.ends);
    words.extend([wall.triangle, u32::from(wall.second.is_some())]);
    for [a, b, inside] in [wall.first, wall.second.unwrap_or_default()] {
        [a, b].as_flattened().iter().for_each(|&x| words.double(x));
        inside.into_iter().for_each(|x| words.float(x as f32));
    }
}
