//! [`Cells`]: cells under one prism on their way to the leaf.

use crate::probe::Probe;
use crate::simd::{PortableQuad, Quad};

use super::super::ReliefMesh;
use super::super::leaf::{self, Root, Wanted};
use super::super::line::MeshRay;
use super::super::nearest::{Candidate, Nearest};
use super::super::patch::{CellPatch, Heights, Seen, ThreadPatch};
use super::super::prism::{Prism, Shape};

/// Cells under one prism on their way to the leaf.
pub(super) struct Cells<'a, P, Q> {
    pub mesh: &'a ReliefMesh,
    pub index: u32,
    pub prism: &'a Prism,
    pub ray: &'a MeshRay,
    /// By how much later than the nearest a meeting may begin and yet be first.
    pub spare: f64,
    /// The prism as the ray sees it, once a cell asks.
    pub seen: &'a mut Option<Seen<Q>>,
    pub nearest: &'a mut Nearest,
    pub probe: &'a mut P,
}

impl<P: Probe, Q: Quad> Cells<'_, P, Q> {
    /// Beyond this nothing changes the answer.
    #[inline(always)]
    pub fn limit(&self) -> f64 {
        self.nearest.limit() + self.spare
    }

    /// Shows an unfolded cell with its corner heights, under a prism of [`Shape::Spread`], to the leaf;
    /// says whether the search is over.
    #[inline(always)]
    pub fn leaf(&mut self, cell: [i32; 2], corners: [f32; 4]) -> bool {
        let (seen, heights) = self.approach(corners);
        let patch = CellPatch::new(&seen, self.prism, cell, heights);
        let root = leaf::first_root(&patch, self.ray, self.wanted());
        root.is_some_and(|root| self.offer(&root, cell))
    }

    /// The prism as the ray sees it, and the heights of a cell.
    #[inline(always)]
    fn approach(&mut self, corners: [f32; 4]) -> (Seen<Q>, Heights) {
        self.probe.cell();
        let Self { mesh, prism, ray, .. } = *self;
        let seen = match self.seen {
            Some(seen) => *seen,
            None => {
                let seen = Seen::new(ray, prism, &mesh.vertices, mesh.offsets.half_range);
                *self.seen.insert(seen)
            }
        };
        (seen, Heights::new(corners, mesh.offsets.level))
    }

    #[inline(always)]
    fn wanted(&self) -> Wanted {
        let turn = if self.mesh.options.one_sided { -self.prism.winding() } else { 0.0 };
        Wanted { t_max: self.nearest.limit(), turn }
    }

    #[inline(always)]
    fn offer(&mut self, root: &Root, cell: [i32; 2]) -> bool {
        let front = root.turn * self.prism.winding() < 0.0;
        self.nearest.offer(Candidate { t: root.t, item: self.index, cell, at: root.at, front })
    }
}

impl<P: Probe> Cells<'_, P, PortableQuad> {
    /// Shows an unfolded cell to the leaf; says whether the search is over.
    #[inline(never)]
    pub fn leaf_of_any(&mut self, cell: [i32; 2]) -> bool {
        let corners = self.mesh.relief.heights().unfolded_corners(cell[0], cell[1]);
        if self.prism.shape == Shape::Spread {
            return self.leaf(cell, corners);
        }
        let (seen, heights) = self.approach(corners);
        let patch = ThreadPatch::new(&seen, self.prism, cell, heights);
        let root = leaf::first_root(&patch, self.ray, self.wanted());
        root.is_some_and(|root| self.offer(&root, cell))
    }

    /// Shows every cell under the prism to the leaf; says whether the search is over.
    pub fn all(&mut self) -> bool {
        let footprint = self.prism.footprint();
        let [_, y] = footprint.area.cells();
        for j in y[0]..y[1] {
            let [first, end] = footprint.row(j);
            for i in first..end {
                let low = [f64::from(i), f64::from(j)];
                if !footprint.misses(low, low.map(|x| x + 1.0)) && self.leaf_of_any([i, j]) {
                    return true;
                }
            }
        }
        false
    }
}
