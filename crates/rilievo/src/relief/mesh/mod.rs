//! [`ReliefMesh`]: a displaced triangle mesh.
//!
//! **The surface.** Over each base triangle `S(u, v) = P(u, v) + offset(u, v) N(u, v)` with
//! `offset = scale (H(u tile + shift, v tile + shift) - zero)`; `P` and `N` are linear, `N` is *not* made unit
//! again in between, so that neighbours share their sides; `H` is bilinear on the unfolded lattice. Uv
//! may lie anywhere, be mirrored, overlap or be repeated. Nothing is tessellated: memory is that of
//! the map and about 300 bytes a base triangle.
//!
//! **How a ray is traced.** A tree over *prisms*, what a triangle spans between the lowest and the highest
//! height under it (`prism`, `footprint`); in a prism a straight line with a bounded remainder
//! (`frame`), walked through the pyramid of the map (`walk`); at the end the leaf (`leaf`), which encloses
//! every root. This is nonlinear ray tracing \[Ogaki2023\] made linear: where that follows the curve that
//! a ray is in lattice coordinates, we follow its tangent about a centre, whose distance from the
//! curve is known exactly, and take a new centre on the way down. No bound and no step is chosen.
//!
//! **Proven**: no root is left out (`frame`, `walk`), every root is enclosed (`leaf`), all bounds are
//! computed, so it holds for moved and scaled scenes. A mesh that is closed in its positions is closed
//! when displaced with [`Edges::Shared`]: sheets that meet in an edge meet in the same points where
//! they show the same heights, and a wall stands between them where they do not (`wall`), as it does where the map
//! itself jumps under a triangle (`tiles`).
//!
//! **Measured**: docs/METHODS.md.

mod departure;
mod footprint;
mod frame;
mod hit;
mod joined;
mod leaf;
mod line;
mod matching;
mod nearest;
mod options;
mod parts;
mod patch;
mod prism;
mod seams;
mod search;
mod tiles;
mod vertices;
mod walk;
mod wall;

use std::sync::Arc;

use glam::DVec3;

use crate::accel::{Aabb, WideBvh};
use crate::hit::Hit;
use crate::mesh::{Mesh, MeshData};
use crate::probe::Probe;
use crate::ray::Ray;

use super::Relief;
use super::method::Method;
use super::options::Displacement;
use footprint::Footprint;
pub use joined::MeshPart;
use joined::{Neighbour, Whole};
pub use matching::SeamSteps;
use nearest::Candidate;
pub use options::{Edges, MeshOptions, MeshReport, ReliefMeshError};
pub use parts::{MeshBeside, MeshFrame, MeshPrism, MeshWall, PrismFrame};
use prism::{Prism, Shape};
use vertices::{Offsets, Vertex};
use wall::{Side, Wall};

/// Largest magnitude of a lattice coordinate.
const MAX_COORDINATE: f64 = (1u32 << 22) as f64;

/// Largest magnitude of a coordinate of the displaced mesh.
const MAX_REACH: f64 = 1e50;

/// A displaced triangle mesh, ready to be traced.
#[derive(Clone, Debug)]
pub struct ReliefMesh {
    data: Arc<MeshData>,
    relief: Arc<Relief>,
    options: MeshOptions,
    report: MeshReport,
    /// World position of the origin of all that follows.
    centre: DVec3,
    offsets: Offsets,
    vertices: Vec<Vertex>,
    /// One a triangle.
    prisms: Vec<Prism>,
    walls: Vec<Wall>,
    /// What other parts show, by their indices; nothing if no wall asks.
    neighbours: Vec<Option<Neighbour>>,
    /// The parts it is one of, if it was joined.
    whole: Option<Whole>,
    /// Over prisms, and walls after all prisms.
    tree: WideBvh,
    /// The box that rays are cut to: the tree's, or that of all parts.
    cut: Aabb,
    /// Bounds all coordinates of rays in the mesh's box and of the mesh, with a factor to spare.
    reach: f64,
    /// By how much heights of reported roots may lie outside of the bounds of their cell.
    height_slack: f64,
}

/// Where a ray crosses a displaced mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshCrossing {
    /// Ray parameter.
    pub t: f64,
    candidate: Candidate,
}

impl ReliefMesh {
    /// Lays a map on a mesh.
    ///
    /// # Errors
    /// [`ReliefMeshError`] for triangles without uv, numbers of the displacement out of range, or
    /// a method that does not know meshes.
    pub fn new(
        mesh: &Mesh,
        relief: Arc<Relief>,
        options: MeshOptions,
    ) -> Result<Self, ReliefMeshError> {
        Self::laid(Arc::new(mesh.data().clone()), relief, options)
    }

    /// The same mesh under another displacement. Base and relief are shared; prisms are made anew, in
    /// a time that does not depend on the size of the map. What it is joined to stays as it was, walls
    /// included; see [`ReliefMesh::with_displacements`].
    ///
    /// # Errors
    /// As [`ReliefMesh::new`], for numbers of the displacement.
    pub fn with_displacement(&self, displacement: Displacement) -> Result<Self, ReliefMeshError> {
        let options = MeshOptions { displacement, ..self.options.clone() };
        self.with_relief(Arc::clone(&self.relief), options)
    }

    /// The same mesh under another relief, a level of its own for instance. The base is shared. What it is joined to
    /// stays as it was; the walls it makes go down to that.
    ///
    /// # Errors
    /// As [`ReliefMesh::new`].
    pub fn with_relief(
        &self,
        relief: Arc<Relief>,
        options: MeshOptions,
    ) -> Result<Self, ReliefMeshError> {
        if let Some(whole) = &self.whole {
            return Self::among(whole, MeshPart::of(Arc::clone(&self.data), relief, options));
        }
        Self::laid(Arc::clone(&self.data), relief, options)
    }

    fn laid(
        data: Arc<MeshData>,
        relief: Arc<Relief>,
        options: MeshOptions,
    ) -> Result<Self, ReliefMeshError> {
        let alone = [MeshPart::of(data, relief, options)];
        let laid = joined::lay(&alone, |_| true).map_err(|(_, error)| error)?;
        laid.into_iter().flatten().next().ok_or(ReliefMeshError::NotDisplaced)
    }

    /// Lists the triangles that are out of the ordinary.
    fn judge_triangles(&mut self) {
        for (triangle, prism) in (0..).zip(&self.prisms) {
            if prism.has_no_volume() {
                self.report.no_volume.push(triangle);
                continue;
            }
            if prism.shape == Shape::Thread {
                self.report.no_uv_area.push(triangle);
            }
            if prism.folds(&self.vertices, self.offsets.base()) {
                self.report.folded.push(triangle);
            }
        }
    }

    /// Builds the tree.
    fn plant(&mut self) {
        self.tree = WideBvh::build(&self.boxes(), self.reach);
    }

    /// What a ray may meet, in boxes: prisms, and walls after all prisms.
    fn boxes(&self) -> Vec<(u32, Aabb)> {
        let count = self.prisms.len() as u32;
        let mut items = Vec::with_capacity(self.prisms.len() + self.walls.len());
        for (index, prism) in (0..).zip(&self.prisms) {
            if !prism.has_no_volume() {
                let spare = 2.0 * prism.t_slack + prism.rounding(self.reach);
                items.push((index, self.around(&prism.corners, prism.range()).grown(spare)));
            }
        }
        for (index, wall) in (count..).zip(&self.walls) {
            let mut range = [f64::INFINITY, f64::NEG_INFINITY];
            for (side, beside) in std::iter::once((&wall.first, None))
                .chain(wall.second.iter().map(|side| (side, wall.neighbour)))
            {
                let [low, high] = self.range_of(side, beside);
                range = [range[0].min(low), range[1].max(high)];
            }
            if wall.second.is_none() {
                let base = self.offsets.base();
                range = [range[0].min(base), range[1].max(base)];
            }
            let bounds = self.around(&wall.ends, range);
            items.push((index, bounds.grown(4.0 * wall::OVERLAP * self.reach)));
        }
        items
    }

    /// The box of vertices displaced by a range of heights.
    fn around(&self, vertices: &[u32], range: [f64; 2]) -> Aabb {
        let vertices = vertices.iter().map(|&k| self.vertices[k as usize]);
        Aabb::around(vertices.flat_map(|v| range.map(|h| v.base + h * v.rise)))
    }

    /// The box that holds the displaced mesh and its walls, a rounding margin included.
    pub fn bounds(&self) -> Aabb {
        let Aabb { min, max } = self.tree.bounds();
        let bounds = Aabb { min: min + self.centre, max: max + self.centre };
        bounds.grown(crate::accel::GROWTH * bounds.largest_coordinate())
    }

    /// The box that holds what is displaced of a base triangle, to rounding, without walls.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn triangle_bounds(&self, triangle: u32) -> Aabb {
        let prism = &self.prisms[triangle as usize];
        let Aabb { min, max } = self.around(&prism.corners, prism.range());
        Aabb { min: min + self.centre, max: max + self.centre }
    }

    /// The shared relief.
    pub fn relief(&self) -> &Arc<Relief> {
        &self.relief
    }

    /// The options the mesh was displaced with.
    pub fn options(&self) -> &MeshOptions {
        &self.options
    }

    /// What is out of the ordinary.
    pub fn report(&self) -> &MeshReport {
        &self.report
    }

    /// The base mesh.
    pub fn data(&self) -> &MeshData {
        &self.data
    }

    /// The point of the displaced surface over a base triangle at barycentric weights of its corners.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn point(&self, triangle: u32, weights: [f64; 3]) -> DVec3 {
        let prism = &self.prisms[triangle as usize];
        let corners = prism.corners.map(|k| self.vertices[k as usize]);
        let mixed = |values: [f64; 3]| (0..3).map(|k| weights[k] * values[k]).sum::<f64>();
        let at = [0, 1].map(|k| mixed(prism.lattice.map(|p| p[k])));
        let raw = self.relief.heights().raw_at_lattice(at[0], at[1]);
        let height = raw - f64::from(self.offsets.level);
        let points = corners.map(|v| v.base + height * v.rise);
        self.centre + weights[0] * points[0] + weights[1] * points[1] + weights[2] * points[2]
    }

    /// Area of a base triangle's uv, in cells of the map.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn cells_under(&self, triangle: u32) -> f64 {
        let [a, b, c] = self.prisms[triangle as usize].lattice.map(glam::DVec2::from_array);
        0.5 * (b - a).perp_dot(c - a).abs()
    }

    /// Bytes held beyond the relief, the base mesh included.
    pub fn bytes(&self) -> u64 {
        let parts = size_of_val(self.vertices.as_slice())
            + size_of_val(self.prisms.as_slice())
            + size_of_val(self.walls.as_slice());
        parts as u64 + self.data.bytes() + self.tree.bytes()
    }

    /// The nearest hit with `0 <= t <= ray.t_max`. `hit.surface` is 0.
    pub fn closest<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<Hit> {
        let crossing = self.first_crossing(ray, probe)?;
        Some(self.complete(ray, &crossing))
    }

    /// Whether the ray meets the mesh at some `0 <= t <= ray.t_max`.
    pub fn occludes<P: Probe>(&self, ray: &Ray, probe: &mut P) -> bool {
        self.search(ray, true, probe.counters()).is_some()
    }

    /// The nearest crossing with `0 <= t <= ray.t_max`: what [`ReliefMesh::closest`] finds, without
    /// normals and position.
    pub fn first_crossing<P: Probe>(&self, ray: &Ray, probe: &mut P) -> Option<MeshCrossing> {
        self.search(ray, false, probe.counters())
    }

    /// Lowest and highest height over the level that a side of an edge shows, here or on another part.
    fn range_of(&self, side: &Side, beside: Option<u32>) -> [f64; 2] {
        let [a, b] = side.ends;
        let shown = |relief: &Relief| Footprint::new([a, b, b]).raw_range(relief).map(f64::from);
        match beside.and_then(|part| self.neighbours[part as usize].as_ref()) {
            None => shown(&self.relief).map(|raw| raw - f64::from(self.offsets.level)),
            Some(Neighbour { relief, offsets }) => {
                let [a, b] = shown(relief)
                    .map(|raw| self.offsets.height(offsets.offset(raw - f64::from(offsets.level))));
                [a.min(b), a.max(b)]
            }
        }
    }

    /// Height over the level that a side of an edge of another part shows.
    fn height_beside(&self, part: u32, side: &Side, s: f64) -> f64 {
        let Some(Neighbour { relief, offsets }) = &self.neighbours[part as usize] else {
            return self.offsets.base();
        };
        self.offsets.height(offsets.offset(side.height(relief.heights(), offsets.level, s)))
    }

    /// Height over the level that a side of an edge shows.
    fn height_over(&self, side: &Side, s: f64) -> f64 {
        side.height(self.relief.heights(), self.offsets.level, s)
    }
}

/// Unfolded lattice coordinates of the corners of all triangles.
fn lattice(
    data: &MeshData,
    relief: &Relief,
    displacement: &Displacement,
) -> Result<Vec<[[f64; 2]; 3]>, ReliefMeshError> {
    let Displacement { tile, shift, .. } = displacement;
    let axes = [relief.heights().x(), relief.heights().y()];
    let mut all = Vec::with_capacity(data.triangles.len());
    for (number, triangle) in (0..).zip(&data.triangles) {
        let uvs = triangle.uvs.ok_or(ReliefMeshError::NoUv(number))?;
        let corners = uvs.map(|uv| {
            let uv = data.uvs[uv as usize].to_array();
            [0, 1].map(|k| axes[k].coordinate(uv[k] * tile[k] + shift[k]))
        });
        let farthest = corners.iter().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
        if farthest.is_nan() || farthest > MAX_COORDINATE {
            return Err(ReliefMeshError::TooManyCells { found: farthest });
        }
        all.push(corners);
    }
    Ok(all)
}
