//! What a user says about a displaced mesh, and what is said in return.

use crate::map::DistanceKind;
use crate::simd::SimdLevel;

use super::super::method::Method;
use super::super::options::{Displacement, ShadingNormals};

/// Along which normals a mesh is displaced, and what closes it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Edges {
    /// One normal for each position, weighted by the angles of all triangles around it; walls stand
    /// where the two sides of an edge show different heights. A closed mesh stays closed.
    #[default]
    Shared,
    /// The normals of the file, no walls: holes at hard edges and uv seams are the author's. Where
    /// the file has no normals, those of [`Edges::Shared`].
    AsAuthored,
}

/// Everything about a displaced mesh but the mesh and its map.
#[derive(Clone, Debug, Default)]
pub struct MeshOptions {
    /// How the map is laid on the uv of the mesh.
    pub displacement: Displacement,
    /// How rays are walked: an exact method; those by distance need the relief's distance map.
    pub method: Method,
    /// Which normals to shade with.
    pub normals: ShadingNormals,
    /// Along which normals the mesh is displaced.
    pub edges: Edges,
    /// Whether walls go down from open borders to offset 0; needs [`Edges::Shared`].
    pub closed: bool,
    /// Whether rays from behind pass through.
    pub one_sided: bool,
    /// Vector instructions of the walk; no answer depends on it.
    pub simd: SimdLevel,
}

/// What a displaced mesh has to say about its triangles, by their numbers.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MeshReport {
    /// Never hit: neither their base nor their shell has an extent.
    pub no_volume: Vec<u32>,
    /// Displaced and hit, but slowly: their uv span no area, so each shows a line of the map.
    pub no_uv_area: Vec<u32>,
    /// The offset goes beyond the radius of curvature: the surface folds over itself there. It is
    /// traced as it is.
    pub folded: Vec<u32>,
    /// Walls that close seams: pairs of triangles that show different heights on a common edge.
    pub seam_walls: usize,
    /// Walls inside of triangles, between tiles of a map whose ends differ.
    pub tile_walls: usize,
    /// Walls that close open borders.
    pub border_walls: usize,
    /// Edges with one triangle only.
    pub open_edges: usize,
}

/// Why a displaced mesh was refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ReliefMeshError {
    /// There is no displacement to change.
    #[error("the mesh is not displaced")]
    NotDisplaced,
    /// A triangle cannot show a map.
    #[error("triangle {0} has no texture coordinates")]
    NoUv(u32),
    /// A number of the displacement is out of its range.
    #[error("displacement {key} is {value}; {allowed}")]
    Displacement {
        /// The key at fault.
        key: &'static str,
        /// The value found.
        value: f64,
        /// What is allowed.
        allowed: &'static str,
    },
    /// Tiling unfolds the map to more cells than indices can count exactly.
    #[error(
        "uv, tile and shift unfold the map to lattice coordinates up to {found}; at most 4194304"
    )]
    TooManyCells {
        /// Largest lattice coordinate.
        found: f64,
    },
    /// The displaced mesh reaches farther than numbers can be multiplied.
    #[error("the displaced mesh reaches as far as {found}; at most 1e50")]
    TooLarge {
        /// Largest coordinate.
        found: f64,
    },
    /// A map whose ends differ is repeated too often.
    #[error(
        "the two ends of the map differ, and tiles of it meet inside of triangles at {found} places, each of which takes a wall; at most 4194304"
    )]
    TooManyWalls {
        /// How many it would take.
        found: u64,
    },
    /// The method is approximate, for faces only.
    #[error("method {0} is for faces only; meshes are walked by the exact methods")]
    Method(Method),
    /// The method needs a distance map that the relief does not have.
    #[error("method {method} needs a {kind:?} distance map")]
    NoDistanceMap {
        /// The method.
        method: Method,
        /// The kind that is missing.
        kind: DistanceKind,
    },
}
