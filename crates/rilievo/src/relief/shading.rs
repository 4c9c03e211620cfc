//! Normals of a relief: the surface's own, and those to shade with.
//!
//! The map's slopes are turned into world normals with the face's own edges,
//! `n ~ S_u x S_v` with `S_u = edge_u + offset_u N`: size, depth and skew of the face enter here, so
//! no map of normals is needed per face (the paper kept one for each).

use glam::DVec3;

use crate::map::{HeightMap, Metric, NormalKind};

use super::options::ShadingNormals;
use super::placement::Placement;

/// A point of a displaced face that wants a normal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Shading<'a> {
    pub placement: &'a Placement,
    pub heights: &'a HeightMap,
    /// Unfolded cell.
    pub cell: [i32; 2],
    /// Local coordinates in the cell.
    pub local: [f64; 2],
}

impl Shading<'_> {
    /// Scene units per cell along u and v and, with the sign of the scale, per raw unit of height.
    fn metric(&self) -> Metric {
        let (heights, placement) = (self.heights, self.placement);
        let d = &placement.displacement;
        Metric {
            x: placement.edge_u.length() / (d.tile[0] * f64::from(heights.x().period())),
            y: placement.edge_v.length() / (d.tile[1] * f64::from(heights.y().period())),
            z: d.scale * heights.unit(),
        }
    }

    /// Unit normal of the bilinear surface.
    pub fn geometric_normal(&self) -> DVec3 {
        self.normal_of_kind(NormalKind::Exact, self.metric())
    }

    /// Unit normal to shade with, on the side of the geometric one.
    pub fn shading_normal(&self, normals: &ShadingNormals, geometric: DVec3) -> DVec3 {
        let heights = self.heights;
        let normal = match normals {
            ShadingNormals::Exact => geometric,
            ShadingNormals::Smooth => self.normal_of_kind(NormalKind::Smooth, self.metric()),
            ShadingNormals::Published => self.normal_of_kind(NormalKind::Published, self.metric()),
            ShadingNormals::WrongMetric => {
                let unit = Metric {
                    x: 1.0 / f64::from(heights.x().period()),
                    y: 1.0 / f64::from(heights.y().period()),
                    z: heights.unit(),
                };
                self.normal_of_kind(NormalKind::Smooth, unit)
            }
            ShadingNormals::Map(map) => {
                let u = heights.x().parameter(f64::from(self.cell[0]) + self.local[0]);
                let v = heights.y().parameter(f64::from(self.cell[1]) + self.local[1]);
                self.world_normal(map.normal_at(u, v))
            }
        };
        if normal.dot(geometric) > 0.0 { normal } else { geometric }
    }

    fn normal_of_kind(&self, kind: NormalKind, metric: Metric) -> DVec3 {
        self.world_normal(kind.normal_at(self.heights, metric, self.cell, self.local))
    }

    /// World normal from one in map axes: x along u, y along v, z along the displacement.
    fn world_normal(&self, normal: DVec3) -> DVec3 {
        let z = normal.z.max(1e-9);
        let (along_u, along_v) = (-normal.x / z, -normal.y / z);
        let du = self.placement.edge_u
            + along_u * self.placement.edge_u.length() * self.placement.normal;
        let dv = self.placement.edge_v
            + along_v * self.placement.edge_v.length() * self.placement.normal;
        du.cross(dv).normalize()
    }
}
