//! Normals of a relief: the surface's own, and those to shade with.
//!
//! The map's slopes are turned into world normals with the face's own edges,
//! `n ~ S_u x S_v` with `S_u = edge_u + offset_u N`: size, depth and skew of the face enter here, so
//! no map of normals is needed per face (the paper kept one for each).
//!
//! With `(x, y, z)` the normal in map axes, `offset_u = -x/z |edge_u|` and `offset_v = -y/z |edge_v|`;
//! since `N x N = 0` the product times `z` is linear in the normal, a matrix made once a face.

use glam::{DMat3, DVec3};

use crate::map::{HeightMap, Metric, NormalKind};

use super::options::ShadingNormals;
use super::placement::Placement;

/// How the map's axes lie on a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MapAxes {
    /// A world normal, of any length, from one in map axes.
    world_from_map: DMat3,
    /// Scene units per cell along u and v and, with the sign of the scale, per raw unit of height.
    metric: Metric,
}

impl MapAxes {
    /// Those of a map laid by `placement`.
    pub fn new(placement: &Placement, heights: &HeightMap) -> Self {
        let Placement { edge_u, edge_v, normal, displacement, .. } = placement;
        let (length_u, length_v) = (edge_u.length(), edge_v.length());
        let world_from_map = DMat3::from_cols(
            -length_u * normal.cross(*edge_v),
            -length_v * edge_u.cross(*normal),
            edge_u.cross(*edge_v),
        );
        let sides = [length_u / displacement.tile[0], length_v / displacement.tile[1]];
        Self { world_from_map, metric: Metric::of_face(heights, sides, displacement.scale) }
    }

    /// Unit world normal from one in map axes: x along u, y along v, z along the displacement.
    #[inline]
    fn world_normal(&self, normal: DVec3) -> DVec3 {
        (self.world_from_map * normal.with_z(normal.z.max(1e-9))).normalize()
    }
}

/// A point of a displaced face that wants a normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shading<'a> {
    pub axes: &'a MapAxes,
    pub heights: &'a HeightMap,
    /// Unfolded cell.
    pub cell: [i32; 2],
    /// Local coordinates in the cell.
    pub local: [f64; 2],
}

impl Shading<'_> {
    /// Unit normal of the bilinear surface.
    pub fn geometric_normal(&self) -> DVec3 {
        self.normal_of_kind(NormalKind::Exact, self.axes.metric)
    }

    /// Unit normal to shade with, on the side of the geometric one.
    pub fn shading_normal(&self, normals: &ShadingNormals, geometric: DVec3) -> DVec3 {
        let (heights, metric) = (self.heights, self.axes.metric);
        let normal = match normals {
            ShadingNormals::Exact => geometric,
            ShadingNormals::Smooth => self.normal_of_kind(NormalKind::Smooth, metric),
            ShadingNormals::Published => self.normal_of_kind(NormalKind::Published, metric),
            ShadingNormals::WrongMetric => {
                self.normal_of_kind(NormalKind::Smooth, Metric::of_face(heights, [1.0; 2], 1.0))
            }
            ShadingNormals::Map(map) => {
                let u = heights.x().parameter(f64::from(self.cell[0]) + self.local[0]);
                let v = heights.y().parameter(f64::from(self.cell[1]) + self.local[1]);
                self.axes.world_normal(map.normal_at(u, v))
            }
        };
        if normal.dot(geometric) > 0.0 { normal } else { geometric }
    }

    #[inline]
    fn normal_of_kind(&self, kind: NormalKind, metric: Metric) -> DVec3 {
        self.axes.world_normal(kind.direction_at(self.heights, metric, self.cell, self.local))
    }
}
