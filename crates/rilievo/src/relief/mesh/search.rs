//! One ray against a mesh: the tree, and what is done at its items.

use crate::accel::Visit;
use crate::hit::Hit;
use crate::map::DistanceMap;
use crate::probe::{Counters, Probe};
use crate::ray::Ray;
use crate::simd::{self, Kernel, Lanes};

use super::line::MeshRay;
use super::nearest::Nearest;
use super::walk::PrismWalk;
use super::{MeshCrossing, Method, ReliefMesh};

impl ReliefMesh {
    /// The nearest hit on some cells, each an unfolded one under a triangle, and on all walls: no tree and no
    /// bound is asked. `cells` lists them, triangle by triangle, for the ray as it is traced, its start lifted.
    ///
    /// It is for suites: what [`Method::Dda`] finds, if all cells are listed that the ray meets.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn closest_among(
        &self,
        ray: &Ray,
        cells: impl FnOnce(&Ray) -> Vec<(u32, [i32; 2])>,
    ) -> Option<Hit> {
        let lifted = self.lifted(ray);
        let line = MeshRay::new(&lifted, self.centre, &self.cut)?;
        let mut nearest = Nearest::new(line.t_max, false);
        for listed in cells(&lifted).chunk_by(|a, b| a.0 == b.0) {
            let index = listed[0].0;
            if !self.prisms[index as usize].has_no_volume() {
                let (ray, nearest) = (&line, &mut nearest);
                PrismWalk { mesh: self, index, ray, nearest, probe: &mut () }.listed(listed);
            }
        }
        for (index, wall) in (self.prisms.len() as u32..).zip(&self.walls) {
            wall.meet(index, self, &line, &mut nearest);
        }
        let candidate = nearest.found?;
        let t = (line.t_start + candidate.t).min(ray.t_max);
        Some(self.complete(ray, &MeshCrossing { t, candidate }))
    }

    /// The nearest crossing, or any.
    pub(super) fn search(
        &self,
        ray: &Ray,
        any: bool,
        counters: Option<&mut Counters>,
    ) -> Option<MeshCrossing> {
        let mesh = self;
        match counters {
            None => simd::run(self.options.simd, Search { mesh, ray, any, probe: &mut () }),
            Some(probe) => simd::run_portable(Search { mesh, ray, any, probe }),
        }
    }
}

/// One ray against all items.
struct Search<'a, P> {
    mesh: &'a ReliefMesh,
    ray: &'a Ray,
    any: bool,
    probe: &'a mut P,
}

impl<P: Probe> Kernel for Search<'_, P> {
    type Output = Option<MeshCrossing>;

    #[inline(always)]
    fn run<L: Lanes>(self) -> Option<MeshCrossing> {
        let Self { mesh, ray, any, probe } = self;
        let line = MeshRay::new(&mesh.lifted(ray), mesh.centre, &mesh.cut)?;
        let mut nearest = Nearest::new(line.t_max, any);
        let distances = mesh.relief.walked_by(mesh.options.method);
        let mut items = Items { mesh, distances, line: &line, nearest: &mut nearest };
        mesh.tree.walk::<L, P>(&line.as_ray(), &mut items, probe);
        let candidate = nearest.found?;
        let t = (line.t_start + candidate.t).min(ray.t_max);
        Some(MeshCrossing { t, candidate })
    }
}

/// What is done at an item of the tree.
struct Items<'a> {
    mesh: &'a ReliefMesh,
    /// What the mesh's method walks, if not the pyramid.
    distances: Option<&'a DistanceMap>,
    line: &'a MeshRay,
    nearest: &'a mut Nearest,
}

impl<P: Probe> Visit<P> for Items<'_> {
    #[inline(always)]
    fn approach<L: Lanes>(&self, item: u32) {
        if let Some(prism) = self.mesh.prisms.get(item as usize) {
            L::fetch(prism);
        }
    }

    #[inline(always)]
    fn visit<L: Lanes>(&mut self, index: u32, probe: &mut P) -> Option<f64> {
        let Self { mesh, distances, line, nearest } = self;
        let count = mesh.prisms.len() as u32;
        let over = if index >= count {
            mesh.walls[(index - count) as usize].meet(index, mesh, line, nearest)
        } else {
            let walk = PrismWalk { mesh, index, ray: line, nearest, probe };
            match (mesh.options.method, distances) {
                (Method::Dda, _) => walk.every_cell(),
                (_, Some(distances)) => walk.by_distance(distances),
                (_, None) => walk.through_pyramid::<L>(),
            }
        };
        (!over).then(|| nearest.limit())
    }
}
