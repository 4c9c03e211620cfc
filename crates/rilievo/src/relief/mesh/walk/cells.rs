//! [`Cells`]: cells under one prism on their way to the leaf.

use crate::probe::Probe;

use super::super::ReliefMesh;
use super::super::leaf::{self, Wanted};
use super::super::line::MeshRay;
use super::super::nearest::{Candidate, Nearest};
use super::super::patch::{CellPatch, Heights, Seen, ThreadPatch};
use super::super::prism::{Prism, Shape};

/// Cells under one prism on their way to the leaf.
pub(super) struct Cells<'a, P> {
    pub mesh: &'a ReliefMesh,
    pub index: u32,
    pub prism: &'a Prism,
    pub ray: &'a MeshRay,
    /// The prism as the ray sees it, once a cell asks.
    pub seen: &'a mut Option<Seen>,
    pub nearest: &'a mut Nearest,
    pub probe: &'a mut P,
}

impl<P: Probe> Cells<'_, P> {
    /// Beyond this nothing changes the answer.
    #[inline(always)]
    pub fn limit(&self) -> f64 {
        self.nearest.limit() + self.prism.t_slack / self.ray.speed()
    }

    /// Shows an unfolded cell to the leaf; says whether the search is over.
    #[inline(never)]
    pub fn leaf(&mut self, cell: [i32; 2]) -> bool {
        self.probe.cell();
        let Self { mesh, index, prism, ray, .. } = *self;
        let seen = self
            .seen
            .get_or_insert_with(|| Seen::new(ray, prism, &mesh.vertices, mesh.offsets.half_range));
        let corners = mesh.relief.heights().unfolded_corners(cell[0], cell[1]);
        let heights = Heights::new(corners, mesh.offsets.level);
        let turn = if mesh.options.one_sided { -prism.winding } else { 0.0 };
        let wanted = Wanted { t_max: self.nearest.limit(), turn };
        let root = match prism.shape {
            Shape::Spread => {
                leaf::first_root(&CellPatch::new(seen, prism, cell, heights), ray, wanted)
            }
            Shape::Thread => {
                leaf::first_root(&ThreadPatch::new(seen, prism, cell, heights), ray, wanted)
            }
        };
        root.is_some_and(|root| {
            let front = root.turn * prism.winding < 0.0;
            self.nearest.offer(Candidate { t: root.t, item: index, cell, at: root.at, front })
        })
    }

    /// Shows every cell under the prism to the leaf; says whether the search is over.
    pub fn all(&mut self) -> bool {
        let footprint = self.prism.footprint();
        let [_, y] = footprint.area.cells();
        for j in y[0]..y[1] {
            let [first, end] = footprint.row(j);
            for i in first..end {
                let low = [f64::from(i), f64::from(j)];
                if !footprint.misses(low, low.map(|x| x + 1.0)) && self.leaf([i, j]) {
                    return true;
                }
            }
        }
        false
    }
}
