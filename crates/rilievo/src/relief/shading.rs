//! Normals of a relief: the surface's own, and those to shade with.
//!
//! The map's slopes are turned into world normals with the face's own edges,
//! `n ~ S_u x S_v` with `S_u = edge_u + offset_u N`: size, depth and skew of the face enter here, so
//! no map of normals is needed per face (the paper kept one for each).

use std::sync::Arc;

use glam::DVec3;

use crate::map::{Metric, NormalKind, NormalMap};

use super::face::ReliefFace;

/// Which normals a relief is shaded with.
#[derive(Clone, Debug, Default)]
pub enum ShadingNormals {
    /// The surface's own: breaks between cells are visible.
    Exact,
    /// Central differences, interpolated: smooth over cells. The default.
    #[default]
    Smooth,
    /// The paper's one-sided cross product, interpolated \[Book2007, section 3.3\].
    Published,
    /// The paper's figure 1: normals of the map on a unit square of depth 1, whatever the face's
    /// size and depth. Wrong on purpose.
    WrongMetric,
    /// A normal map laid on the face like the height map.
    Map(Arc<NormalMap>),
}

impl ReliefFace {
    /// Scene units per cell along u and v and, with the sign of the scale, per raw unit of height.
    pub(super) fn metric(&self) -> Metric {
        let heights = self.relief.heights();
        let d = &self.options.displacement;
        Metric {
            x: self.placement.edge_u.length() / (d.tile[0] * f64::from(heights.x().period())),
            y: self.placement.edge_v.length() / (d.tile[1] * f64::from(heights.y().period())),
            z: d.scale * heights.unit(),
        }
    }

    /// Unit normal of the bilinear surface in an unfolded cell.
    pub(super) fn geometric_normal(&self, cell: [i32; 2], local: [f64; 2]) -> DVec3 {
        self.normal_of_kind(NormalKind::Exact, self.metric(), (cell, local))
    }

    /// Unit normal to shade with, on the side of the geometric one.
    pub(super) fn shading_normal(
        &self,
        cell: [i32; 2],
        local: [f64; 2],
        geometric: DVec3,
    ) -> DVec3 {
        let at = (cell, local);
        let heights = self.relief.heights();
        let normal = match &self.options.normals {
            ShadingNormals::Exact => geometric,
            ShadingNormals::Smooth => self.normal_of_kind(NormalKind::Smooth, self.metric(), at),
            ShadingNormals::Published => {
                self.normal_of_kind(NormalKind::Published, self.metric(), at)
            }
            ShadingNormals::WrongMetric => {
                let unit = Metric {
                    x: 1.0 / f64::from(heights.x().period()),
                    y: 1.0 / f64::from(heights.y().period()),
                    z: heights.unit(),
                };
                self.normal_of_kind(NormalKind::Smooth, unit, at)
            }
            ShadingNormals::Map(map) => {
                let u = heights.x().parameter(f64::from(cell[0]) + local[0]);
                let v = heights.y().parameter(f64::from(cell[1]) + local[1]);
                self.world_normal(map.normal_at(u, v))
            }
        };
        if normal.dot(geometric) > 0.0 { normal } else { geometric }
    }

    fn normal_of_kind(
        &self,
        kind: NormalKind,
        metric: Metric,
        (cell, local): ([i32; 2], [f64; 2]),
    ) -> DVec3 {
        self.world_normal(kind.normal_at(self.relief.heights(), metric, cell, local))
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
