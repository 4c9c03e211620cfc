//! Meshes of which each part shows a map of its own, or none: what a model with several materials is.
//!
//! **One ground.** All parts are displaced along the normals of the whole, a position's triangles counted in every part, so
//! the sides of an edge between two parts move along the same segments, and all that was said of seams holds: where
//! the sides show different heights the hole is a piece of a bilinear patch, and a wall fills it. It belongs
//! to the part that is higher in the middle of the edge. Beside a part that is not displaced it goes down to offset 0.
//!
//! **One frame.** Parts are traced one by one, yet a ray has the same origin and shear in all of them: they share centre,
//! reach and the box that it is cut to. Between two parts with one map and one displacement, which need no wall, the
//! leaf therefore computes the same numbers on both sides, as within a mesh.
//!
//! A ray that leaves one part is lifted off that part only; within rounding of the edge it may start behind the other.

use std::sync::Arc;

use glam::DVec3;
use rayon::prelude::*;

use crate::accel::{Aabb, WideBvh};
use crate::mesh::{Mesh, MeshData};

use super::footprint::{Footprint, MARGIN};
use super::options::{Edges, MeshOptions, MeshReport, ReliefMeshError};
use super::prism::Prism;
use super::seams::{SeamSide, Seams, Shown};
use super::tiles;
use super::vertices::{Ground, Offsets, Vertices};
use super::{Displacement, MAX_REACH, Relief, ReliefMesh, lattice};

/// By how much the box of all parts is larger than what they may reach, as a share of [`ReliefMesh::reach`].
const ROOM: f64 = 1e-4;

/// A part of a mesh: a mesh itself, and how it is displaced, if it is.
#[derive(Clone, Debug)]
pub struct MeshPart {
    data: Arc<MeshData>,
    displaced: Option<(Arc<Relief>, MeshOptions)>,
}

impl MeshPart {
    /// A part that is displaced.
    pub fn displaced(mesh: &Mesh, relief: Arc<Relief>, options: MeshOptions) -> Self {
        Self::of(Arc::new(mesh.data().clone()), relief, options)
    }

    /// A part that stays as it is.
    pub fn plain(mesh: &Mesh) -> Self {
        Self { data: Arc::new(mesh.data().clone()), displaced: None }
    }

    pub(super) fn of(data: Arc<MeshData>, relief: Arc<Relief>, options: MeshOptions) -> Self {
        Self { data, displaced: Some((relief, options)) }
    }

    fn change(&mut self, change: impl FnOnce(Displacement) -> Displacement) {
        if let Some((_, options)) = &mut self.displaced {
            options.displacement = change(options.displacement);
        }
    }
}

/// All parts of a mesh, and which of them one is.
#[derive(Clone, Debug)]
pub(super) struct Whole {
    parts: Arc<[MeshPart]>,
    own: usize,
}

/// What another part shows beside a wall.
#[derive(Clone, Debug)]
pub(super) struct Neighbour {
    pub relief: Arc<Relief>,
    pub offsets: Offsets,
}

impl ReliefMesh {
    /// Displaces the parts of a mesh, one surface each; none for those that stay as they are. Positions
    /// that are equal bit for bit are one place in all parts. With [`Edges::Shared`] a mesh that is closed as a whole
    /// stays closed, but for parts with other `edges`.
    ///
    /// # Errors
    /// As [`ReliefMesh::new`], with the index of the part.
    pub fn joined(parts: &[MeshPart]) -> Result<Vec<Option<Self>>, (usize, ReliefMeshError)> {
        let parts: Arc<[MeshPart]> = parts.into();
        let all = lay(&parts, |_| true)?.into_iter().enumerate();
        let known = |(own, mesh): (usize, Option<Self>)| {
            mesh.map(|mesh| Self { whole: Some(Whole { parts: Arc::clone(&parts), own }), ..mesh })
        };
        Ok(all.map(known).collect())
    }

    /// The same mesh with its displacement changed; if it is a part of a whole, with those of all parts changed
    /// alike.
    ///
    /// # Errors
    /// As [`ReliefMesh::new`], for numbers of a displacement.
    pub fn with_displacements(
        &self,
        change: impl Fn(Displacement) -> Displacement,
    ) -> Result<Self, ReliefMeshError> {
        let Some(Whole { parts, own }) = &self.whole else {
            return self.with_displacement(change(self.options.displacement));
        };
        let mut parts = parts.to_vec();
        parts.iter_mut().for_each(|part| part.change(&change));
        Self::again(parts, *own)
    }

    /// A part laid anew among its neighbours.
    pub(super) fn among(whole: &Whole, part: MeshPart) -> Result<Self, ReliefMeshError> {
        let mut parts = whole.parts.to_vec();
        parts[whole.own] = part;
        Self::again(parts, whole.own)
    }

    fn again(parts: Vec<MeshPart>, own: usize) -> Result<Self, ReliefMeshError> {
        let mut laid = lay(&parts, |part| part == own).map_err(|(_, error)| error)?;
        let mesh = laid.swap_remove(own).ok_or(ReliefMeshError::NotDisplaced)?;
        Ok(Self { whole: Some(Whole { parts: parts.into(), own }), ..mesh })
    }

    /// Whether it is a part of a mesh whose parts are displaced in different ways.
    pub fn is_joined(&self) -> bool {
        self.whole.as_ref().is_some_and(|whole| whole.parts.len() > 1)
    }
}

/// A displaced part before it is planted.
struct Draft<'a> {
    relief: &'a Arc<Relief>,
    options: &'a MeshOptions,
    lattice: Vec<[[f64; 2]; 3]>,
    offsets: Offsets,
    vertices: Vertices,
}

/// Lays all parts on one ground; makes surfaces of those that are wanted.
pub(super) fn lay(
    parts: &[MeshPart],
    wanted: impl Fn(usize) -> bool,
) -> Result<Vec<Option<ReliefMesh>>, (usize, ReliefMeshError)> {
    let all: Vec<&MeshData> = parts.iter().map(|part| part.data.as_ref()).collect();
    let corners = all.iter().flat_map(|data| {
        data.triangles.iter().flat_map(|t| t.positions.map(|p| data.positions[p as usize]))
    });
    let centre = Aabb::around(corners).centre();
    let ground = Ground::of(&all);
    let mut drafts = Vec::with_capacity(parts.len());
    let mut size = 0.0f64;
    for (own, MeshPart { data, displaced }) in parts.iter().enumerate() {
        let draft = displaced.as_ref().map(|(relief, options)| {
            check(relief, options)?;
            let lattice = lattice(data, relief, &options.displacement)?;
            let offsets = Offsets::new(relief.heights(), &options.displacement);
            let vertices = Vertices::new(data, (&ground, own), centre, &offsets, options.edges);
            let reaches =
                |v: DVec3, rise: DVec3| (v.abs() + offsets.half_range * rise.abs()).max_element();
            let finite = vertices.all.iter().all(|v| v.base.is_finite() && v.rise.is_finite());
            let found = vertices.all.iter().map(|v| reaches(v.base, v.rise)).fold(0.0, f64::max);
            if found > MAX_REACH || !finite {
                return Err(ReliefMeshError::TooLarge { found });
            }
            size = size.max(found);
            Ok(Draft { relief, options, lattice, offsets, vertices })
        });
        drafts.push(draft.transpose().map_err(|error| (own, error))?);
    }
    let reach = 4.0 * size;
    let box_of_all = (parts.len() > 1).then(|| {
        let points = drafts.iter().flatten().flat_map(|draft| {
            let range = [-draft.offsets.half_range, draft.offsets.half_range];
            draft.vertices.all.iter().flat_map(move |v| range.map(|h| v.base + h * v.rise))
        });
        Aabb::around(points).grown(ROOM * reach)
    });
    let sides: Vec<Option<SeamSide<'_>>> = (drafts.iter().enumerate())
        .map(|(own, draft)| match draft {
            Some(draft) if draft.options.edges == Edges::AsAuthored => None,
            Some(draft) => Some(SeamSide {
                places: &ground.places[own],
                shown: Some(Shown {
                    relief: draft.relief,
                    offsets: &draft.offsets,
                    lattice: &draft.lattice,
                }),
                corners: &draft.vertices.corners,
                displacement: draft.options.displacement,
                closed: draft.options.closed,
            }),
            None => Some(SeamSide {
                places: &ground.places[own],
                shown: None,
                corners: &[],
                displacement: Displacement::default(),
                closed: false,
            }),
        })
        .collect();
    let mut seams = Seams::find(&sides);
    let neighbours: Vec<Option<Neighbour>> = (drafts.iter())
        .map(|draft| {
            let Draft { relief, offsets, .. } = draft.as_ref()?;
            Some(Neighbour { relief: Arc::clone(relief), offsets: *offsets })
        })
        .collect();
    let mut laid = Vec::with_capacity(parts.len());
    for (own, draft) in drafts.into_iter().enumerate() {
        let Some(draft) = draft.filter(|_| wanted(own)) else {
            laid.push(None);
            continue;
        };
        let Draft { relief, options, lattice, offsets, mut vertices } = draft;
        let inner = match options.edges {
            Edges::AsAuthored => Vec::new(),
            Edges::Shared => tiles::walls(&mut vertices, &lattice, relief.heights())
                .map_err(|error| (own, error))?,
        };
        let level = f64::from(offsets.level);
        let prisms: Vec<Prism> = (vertices.corners.par_iter().zip(&lattice))
            .map(|(&corners, &lattice)| {
                let range = Footprint::new(lattice).raw_range(relief);
                let range = range.map(|raw| f64::from(raw) - level);
                Prism::new(corners, &vertices.all, lattice, range, reach)
            })
            .collect();
        let Seams { mut walls, between, borders, open, beside } = std::mem::take(&mut seams[own]);
        let tile_walls = inner.len();
        walls.extend(inner);
        let mut mesh = ReliefMesh {
            height_slack: 8.0 * MARGIN * offsets.half_range,
            data: Arc::clone(&parts[own].data),
            relief: Arc::clone(relief),
            options: options.clone(),
            report: MeshReport::default(),
            centre,
            offsets,
            vertices: vertices.all,
            prisms,
            walls,
            neighbours: if beside { neighbours.clone() } else { Vec::new() },
            whole: None,
            tree: WideBvh::default(),
            cut: Aabb::around([]),
            reach,
        };
        mesh.report.seam_walls = between;
        mesh.report.tile_walls = tile_walls;
        mesh.report.border_walls = borders;
        mesh.report.open_edges = open;
        mesh.judge_triangles();
        mesh.plant();
        mesh.cut = box_of_all.unwrap_or(mesh.tree.bounds());
        laid.push(Some(mesh));
    }
    Ok(laid)
}

/// What is wrong with a displacement, apart from the mesh it is laid on.
fn check(relief: &Relief, options: &MeshOptions) -> Result<(), ReliefMeshError> {
    let method = options.method;
    if !method.is_exact() {
        return Err(ReliefMeshError::Method(method));
    }
    if let Some(kind) = method.distance_kind()
        && relief.distance(kind).is_none()
    {
        return Err(ReliefMeshError::NoDistanceMap { method, kind });
    }
    match options.displacement.fault() {
        Some((key, value, allowed)) => Err(ReliefMeshError::Displacement { key, value, allowed }),
        None => Ok(()),
    }
}
