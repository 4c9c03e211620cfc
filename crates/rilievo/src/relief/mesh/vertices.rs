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

    /// The offset of a height over the level.
    pub fn offset(&self, height: f64) -> f64 {
        height * self.unit + self.lift
    }

    /// The height over the level of an offset.
    pub fn height(&self, offset: f64) -> f64 {
        (offset - self.lift) / self.unit
    }

    /// Height over the level that lies on the base.
    pub fn base(&self) -> f64 {
        -self.lift / self.unit
    }
}

/// The places of all parts of a mesh, and the normal of each.
pub(super) struct Ground {
    /// For each part and triangle, the places of its corners.
    pub places: Vec<Vec<[u32; 3]>>,
    /// Unit normals by place; zero where those around it cancel.
    normals: Vec<DVec3>,
}

impl Ground {
    pub fn of(parts: &[&MeshData]) -> Self {
        let mut known = HashMap::new();
        let places: Vec<Vec<[u32; 3]>> = (parts.iter())
            .map(|data| {
                let place_of = places(&data.positions, &mut known);
                let corners = data.triangles.iter().map(|t| t.positions);
                corners.map(|corners| corners.map(|p| place_of[p as usize])).collect()
            })
            .collect();
        let mut sums = vec![DVec3::ZERO; known.len()];
        for (data, places) in parts.iter().zip(&places) {
            add_normals(&mut sums, data, places);
        }
        Self { places, normals: sums.into_iter().map(DVec3::normalize_or_zero).collect() }
    }
}

/// The vertices of a mesh.
pub(super) struct Vertices {
    pub all: Vec<Vertex>,
    /// For each triangle, its corners in `all`.
    pub corners: Vec<[u32; 3]>,
}

impl Vertices {
    /// Those of a part of the ground.
    pub fn new(
        data: &MeshData,
        (ground, part): (&Ground, usize),
        centre: DVec3,
        offsets: &Offsets,
        edges: Edges,
    ) -> Self {
        let places = &ground.places[part];
        let vertex = |position: DVec3, normal: DVec3| Vertex {
            base: (position - centre) + offsets.lift * normal,
            rise: offsets.unit * normal,
        };
        let mut all = Vec::new();
        let mut known: HashMap<(u32, Option<u32>), u32> = HashMap::new();
        let mut corners = Vec::with_capacity(places.len());
        for (triangle, places) in data.triangles.iter().zip(places) {
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
                        None => ground.normals[places[k] as usize],
                    };
                    all.push(vertex(data.positions[triangle.positions[k] as usize], normal));
                    all.len() as u32 - 1
                })
            }));
        }
        Self { all, corners }
    }
}

/// For each position the number of its place.
fn places(positions: &[DVec3], known: &mut HashMap<[u64; 3], u32>) -> Vec<u32> {
    known.reserve(positions.len());
    let mut of = Vec::with_capacity(positions.len());
    for position in positions {
        // Adding 0 makes -0 the same as 0.
        let key = position.to_array().map(|x| (x + 0.0).to_bits());
        let next = known.len() as u32;
        of.push(*known.entry(key).or_insert(next));
    }
    of
}

/// Adds the normals of triangles to those of their places, weighted by their angles.
fn add_normals(sums: &mut [DVec3], data: &MeshData, places: &[[u32; 3]]) {
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
}
