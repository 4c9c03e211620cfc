//! The vertices of a displaced mesh: where they lie and along what they are displaced.
//!
//! Positions that are equal bit for bit are one *place*. With [`Edges::Shared`] a place has one
//! normal, weighted by the angles of all triangles around it \[Thurmer1998\]: both sides of every
//! edge then move along the same segments, and neighbours stay joined wherever they show equal
//! heights. With [`Edges::AsAuthored`] a vertex is a place and a normal of the file.
//!
//! **Frame.** Vertices are kept relative to the centre of the mesh, so that errors scale with the
//! mesh and not with where it lies.

use std::collections::HashMap;

use glam::DVec3;

use crate::map::HeightMap;
use crate::mesh::MeshData;

use super::super::options::Displacement;
use super::options::Edges;

/// A corner of base triangles.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Vertex {
    /// Where the level lies: relative to the centre of the mesh.
    pub base: DVec3,
    /// Displacement of one raw unit of height.
    pub rise: DVec3,
}

/// Raw heights as offsets along a normal: `offset = (raw - level) unit + lift`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Offsets {
    /// Raw heights are counted from here: the middle of the map's range, exact in `f32`.
    pub level: f32,
    /// Scene units of one raw unit.
    pub unit: f64,
    /// Offset of the level, scene units.
    pub lift: f64,
    /// No height is farther from the level.
    pub half_range: f64,
}

impl Offsets {
    pub fn new(heights: &HeightMap, displacement: &Displacement) -> Self {
        let (low, high) = heights.raw_range();
        let level = low + 0.5 * (high - low);
        let unit = displacement.scale * heights.unit();
        let lift = displacement.scale * (f64::from(level) * heights.unit() - displacement.zero);
        let half_range =
            (f64::from(high) - f64::from(level)).max(f64::from(level) - f64::from(low));
        Self { level, unit, lift, half_range }
    }

    /// Height over the level that lies on the base.
    pub fn base(&self) -> f64 {
        -self.lift / self.unit
    }
}

/// The vertices of a mesh.
pub(super) struct Vertices {
    pub all: Vec<Vertex>,
    /// For each triangle, its corners in `all`.
    pub corners: Vec<[u32; 3]>,
    /// For each triangle, the places of its corners.
    pub places: Vec<[u32; 3]>,
}

impl Vertices {
    pub fn new(data: &MeshData, centre: DVec3, offsets: &Offsets, edges: Edges) -> Self {
        let place_of = places(&data.positions);
        let places: Vec<[u32; 3]> = (data.triangles.iter())
            .map(|triangle| triangle.positions.map(|p| place_of[p as usize]))
            .collect();
        let shared = shared_normals(data, &places);
        let vertex = |position: DVec3, normal: DVec3| Vertex {
            base: (position - centre) + offsets.lift * normal,
            rise: offsets.unit * normal,
        };
        let mut all = Vec::new();
        let mut known: HashMap<(u32, Option<u32>), u32> = HashMap::new();
        let mut corners = Vec::with_capacity(places.len());
        for (triangle, places) in data.triangles.iter().zip(&places) {
            corners.push([0, 1, 2].map(|k| {
                let authored = match edges {
                    Edges::Shared => None,
                    Edges::AsAuthored => triangle
                        .normals
                        .map(|normals| normals[k])
                        .filter(|&n| data.normals[n as usize].try_normalize().is_some()),
                };
                *known.entry((places[k], authored)).or_insert_with(|| {
                    let normal = match authored {
                        Some(n) => data.normals[n as usize].normalize_or_zero(),
                        None => shared[places[k] as usize],
                    };
                    all.push(vertex(data.positions[triangle.positions[k] as usize], normal));
                    all.len() as u32 - 1
                })
            }));
        }
        Self { all, corners, places }
    }
}

/// For each position the number of its place.
fn places(positions: &[DVec3]) -> Vec<u32> {
    let mut known = HashMap::with_capacity(positions.len());
    let mut of = Vec::with_capacity(positions.len());
    for position in positions {
        // Adding 0 makes -0 the same as 0.
        let key = position.to_array().map(|x| (x + 0.0).to_bits());
        let next = known.len() as u32;
        of.push(*known.entry(key).or_insert(next));
    }
    of
}

/// Unit normals by place; zero where those around it cancel.
fn shared_normals(data: &MeshData, places: &[[u32; 3]]) -> Vec<DVec3> {
    let count = places.iter().flatten().max().map_or(0, |&p| p as usize + 1);
    let mut sums = vec![DVec3::ZERO; count];
    for (triangle, places) in data.triangles.iter().zip(places) {
        let p = triangle.positions.map(|p| data.positions[p as usize]);
        let normal = (p[1] - p[0]).cross(p[2] - p[0]).normalize_or_zero();
        for k in 0..3 {
            let (e, f) = (p[(k + 1) % 3] - p[k], p[(k + 2) % 3] - p[k]);
            let angle = e.cross(f).length().atan2(e.dot(f));
            if angle.is_finite() {
                sums[places[k] as usize] += angle * normal;
            }
        }
    }
    sums.into_iter().map(DVec3::normalize_or_zero).collect()
}
