//! [`MeshFrame`], [`MeshPrism`], [`PrismFrame`], [`MeshWall`] and [`MeshBeside`]: what another backend needs to trace a displaced mesh as
//! the CPU does, and how it turns a crossing that it found into a [`Hit`].

use glam::{DMat3, DVec2, DVec3};

use crate::accel::Aabb;
use crate::hit::Hit;
use crate::ray::Ray;

use super::super::Relief;
use super::joined::Neighbour;
use super::nearest::Candidate;
use super::prism::{Prism, Shape};
use super::wall::Side;
use super::{MeshCrossing, ReliefMesh};

/// What holds for all of a [`ReliefMesh`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshFrame {
    /// World position of the origin of vertices, prisms and boxes.
    pub centre: DVec3,
    /// Bounds all coordinates, from the centre, with a factor to spare; scene units.
    pub reach: f64,
    /// Raw heights are counted from here.
    pub level: f32,
    /// No height is farther from the level.
    pub half_range: f64,
    /// Height over the level that lies on the base.
    pub base: f64,
    /// By how much heights of roots may lie outside of the bounds of their cell.
    pub height_slack: f64,
    /// Whether larger raw heights lie farther along the normal.
    pub rises: bool,
    /// The box that rays are cut to, from the centre: that of all parts that were joined.
    pub cut: Aabb,
}

/// A base triangle made ready for rays. Lattice coordinates are unfolded, heights are over the level.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshPrism {
    /// Vertices.
    pub corners: [u32; 3],
    /// Lattice coordinates of the corners.
    pub lattice: [[f64; 2]; 3],
    /// First cell and one past the last along each axis that it shows.
    pub cells: [[i32; 2]; 2],
    /// Change of the second and third barycentric weight along x and y, per cell; 0 where uv span no
    /// area.
    pub weights: [[f64; 2]; 2],
    /// Lowest and highest height that it shows.
    pub heights: [f64; 2],
    /// How much a rounding of a lattice coordinate is magnified in a weight, at least 1.
    pub condition: f64,
    /// Bound on the slope of the surface against its base.
    pub steepness: f64,
    /// Whether its uv span an area.
    pub spread: bool,
    /// Whether uv run against the corners.
    pub mirrored: bool,
    /// Bound on the distance between a reported point and the ray beyond rounding, scene units.
    pub t_slack: f64,
    /// A ray in it as a straight line; nothing where there is no such frame.
    pub frame: Option<PrismFrame>,
}

/// What makes a ray in a prism a straight line with a bounded remainder: at a parameter at which the ray meets
/// the surface, `centre + lattice_from_space (point - at)` is off the lattice coordinates and the height by
/// at most `error`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrismFrame {
    /// The middle of the prism: lattice coordinates and height.
    pub centre: DVec3,
    /// Where it lies, from the centre of the mesh.
    pub at: DVec3,
    /// Its numbers are those of `f32`.
    pub lattice_from_space: DMat3,
    /// How this map of `d`, lattice coordinates and height from the centre, bends: by
    /// `d_h (bend[0] d_x + bend[1] d_y)`.
    pub bend: [DVec3; 2],
    /// Bound on the remainder over the prism.
    pub error: DVec3,
    /// What of it is no bend.
    pub noise: DVec3,
}

/// A wall over an edge between sheets that show different heights, or at an open border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshWall {
    /// Vertices; it runs as the edge does in its triangle.
    pub ends: [u32; 2],
    /// The triangle of the first side.
    pub triangle: u32,
    /// Of the first side: lattice coordinates of both ends, and a vector towards its inside.
    pub first: [[f64; 2]; 3],
    /// The same of the second side; nothing at a border, where the wall goes down to the base.
    pub second: Option<[[f64; 2]; 3]>,
    /// The part whose map the second side shows, if it is not the mesh's own; see [`ReliefMesh::beside`].
    pub beside: Option<u32>,
}

/// What another part of a joined mesh shows: a raw height of its map lies at the mesh's own height
/// `(raw - level) per_height + lift` over the mesh's own level.
#[derive(Clone, Copy, Debug)]
pub struct MeshBeside<'a> {
    /// Its map.
    pub relief: &'a Relief,
    /// Its raw heights are counted from here.
    pub level: f32,
    /// Heights of the mesh that one of its own is.
    pub per_height: f64,
    /// Height of the mesh at which its level lies.
    pub lift: f64,
}

impl ReliefMesh {
    /// What holds for all of the mesh.
    pub fn frame(&self) -> MeshFrame {
        MeshFrame {
            centre: self.centre,
            reach: self.reach,
            level: self.offsets.level,
            half_range: self.offsets.half_range,
            base: self.offsets.base(),
            height_slack: self.height_slack,
            rises: self.offsets.unit > 0.0,
            cut: self.cut,
        }
    }

    /// The vertices: where the level lies, from the centre, and the displacement of one raw unit.
    pub fn vertices(&self) -> impl ExactSizeIterator<Item = [DVec3; 2]> {
        self.vertices.iter().map(|vertex| [vertex.base, vertex.rise])
    }

    /// One prism a base triangle.
    pub fn prisms(&self) -> impl ExactSizeIterator<Item = MeshPrism> {
        self.prisms.iter().map(|prism| {
            let Prism { corners, lattice, cells, weights, t_slack, .. } = *prism;
            MeshPrism {
                corners,
                lattice,
                cells,
                weights,
                heights: prism.range(),
                condition: prism.condition(),
                steepness: prism.steepness(),
                spread: prism.shape == Shape::Spread,
                mirrored: prism.winding() < 0.0,
                t_slack,
                frame: prism.frame.parts(prism.centre()),
            }
        })
    }

    /// The walls.
    pub fn walls(&self) -> impl ExactSizeIterator<Item = MeshWall> {
        let shown = |side: &Side| [side.ends[0], side.ends[1], side.inside];
        self.walls.iter().map(move |wall| MeshWall {
            ends: wall.ends,
            triangle: wall.triangle,
            first: shown(&wall.first),
            second: wall.second.as_ref().map(shown),
            beside: wall.neighbour,
        })
    }

    /// What another part shows that walls of this one go down to; nothing of a part that no wall
    /// shows, or that is not displaced.
    pub fn beside(&self, part: u32) -> Option<MeshBeside<'_>> {
        let Neighbour { relief, offsets } = self.neighbours.get(part as usize)?.as_ref()?;
        Some(MeshBeside {
            relief,
            level: offsets.level,
            per_height: offsets.unit / self.offsets.unit,
            lift: self.offsets.height(offsets.lift),
        })
    }

    /// What a ray may meet, prisms by their number and walls after all prisms, in boxes relative to the
    /// centre, rounding included. Prisms without volume are left out.
    pub fn items(&self) -> Vec<(u32, Aabb)> {
        self.boxes()
    }

    /// The hit of a ray at parameter `t` on a triangle: at a place in `[0, 1]^2` of an unfolded cell, or,
    /// where the triangle's uv span no area, at weights of its second and third corner. Otherwise as
    /// [`ReliefMesh::hit_on_wall`].
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn hit_in_cell(
        &self,
        ray: &Ray,
        t: f64,
        (triangle, cell, at): (u32, [i32; 2], [f64; 2]),
        front: bool,
    ) -> Hit {
        let at = DVec2::from_array(at);
        self.hit_of(ray, Candidate { t, item: triangle, cell, at, front })
    }

    /// The hit of a ray at parameter `t` on a wall: at a place along its edge, and at a height over the
    /// level. `hit.surface` is 0. That `t` and the place belong together is the caller's promise; the
    /// distance between them becomes part of `hit.position_error`.
    ///
    /// # Panics
    /// If there is no such wall.
    pub fn hit_on_wall(&self, ray: &Ray, t: f64, (wall, at): (u32, [f64; 2]), front: bool) -> Hit {
        let item = self.prisms.len() as u32 + wall;
        let at = DVec2::from_array(at);
        self.hit_of(ray, Candidate { t, item, cell: [0; 2], at, front })
    }

    fn hit_of(&self, ray: &Ray, candidate: Candidate) -> Hit {
        let hit = self.complete(ray, &MeshCrossing { t: candidate.t, candidate });
        let apart = hit.position.distance(ray.at(candidate.t));
        Hit { position_error: hit.position_error + apart, ..hit }
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::map::{HeightMap, Lattice, Samples, Wrap};
    use crate::mesh::{Mesh, solids};
    use crate::ray::Part;
    use crate::relief::{Displacement, MeshOptions, Relief};

    #[test]
    fn a_crossing_found_elsewhere_gives_the_same_hit() {
        let samples = Samples::U16((0..64u32).map(|k| (k * 7919 % 65536) as u16).collect());
        let map = HeightMap::new(8, 8, samples, Lattice::Texel, Wrap::Repeat).unwrap();
        let mut data = solids::subdivided_sphere(1);
        data.uvs = (data.positions.iter()).map(|p| DVec2::new(0.3 * p.x + p.z, p.y)).collect();
        data.triangles.iter_mut().for_each(|t| t.uvs = Some(t.positions));
        let mesh = Mesh::new(data).unwrap();
        let displacement = Displacement { scale: 0.1, ..Displacement::default() };
        let options = MeshOptions { displacement, ..MeshOptions::default() };
        let mesh = ReliefMesh::new(&mesh, Arc::new(Relief::new(map)), options).unwrap();
        let from = DVec3::new(2.0, 3.0, 1.0);
        let ray = Ray::new(from, DVec3::new(0.1, 0.2, -0.1) - from);
        let hit = mesh.closest(&ray, &mut ()).expect("aimed at");
        let Part::TriangleCell { triangle, cell } = hit.part else { panic!("{hit:?}") };
        let crossing = mesh.first_crossing(&ray, &mut ()).expect("aimed at");
        let at = crossing.candidate.at.to_array();
        let again = mesh.hit_in_cell(&ray, hit.t, (triangle, cell, at), hit.front);
        assert_eq!(Hit { position_error: hit.position_error, ..again }, hit);
        assert!(again.position_error < 1e-12);
        assert_eq!(mesh.prisms().len(), 32);
        assert!(mesh.items().len() >= 32 && mesh.vertices().len() >= 18);
        let frame = mesh.frame();
        assert!(mesh.prisms().all(|prism| prism.heights[1] <= frame.half_range + 1.0));
    }
}
