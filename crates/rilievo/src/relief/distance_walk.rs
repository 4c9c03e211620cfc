//! Methods `distance` and `distance-corrected`: safe steps through a distance map, the exact leaf
//! near the surface \[Donnelly2005, made exact\].
//!
//! **Step.** An affine face keeps the ray parameter, so the map is walked in the metric it was made
//! for, whatever the face's size and depth: a safe distance `D` advances the parameter by
//! `D / |G d|`, with `G` the map's metric and `d` the ray's direction in lattice space. A box map
//! says more: if its voxel is clear of the surface, all of it is, so the ray goes on to the voxel's
//! exit if that is farther. Where no step leads past the current cell, the cell is shown to the
//! leaf.
//!
//! **No miss.** A step of `D - c` keeps every point of the skipped part farther than `c` from the
//! surface, in the map's metric. [`margin`] chooses `c` so that the leaf would report nothing
//! there: `2^-17 A` raw units of height (16 times the leaf's own rounding, which keeps even the
//! discriminant of a double near-root negative), plus the distance by which the leaf's rounded
//! points may stray from the ray, `2^-21` of the cells in the window. A cell of which only a part
//! was skipped is shown to the leaf whole. So the result is that of every cell, bit for bit.

use crate::map::{DistanceKind, DistanceMap, HeightMap};
use crate::probe::Probe;

use super::leaf::{Crossings, LeafHit, Span};
use super::map_ray::MapRay;
use super::tile::{Tile, TileAxis};

/// The first admitted crossing in a tile between two parameters, found with a distance map.
#[inline(never)]
pub(crate) fn walk_distance<P: Probe>(
    (map, distances): (&HeightMap, &DistanceMap),
    ray: &MapRay,
    tile: &Tile,
    [from, to]: [f32; 2],
    (admit, probe): (Crossings, &mut P),
) -> Option<LeafHit> {
    let stepper = Stepper::new(map, distances, ray, tile);
    let mut s = from;
    while s < to {
        probe.step();
        let cell = tile.cell_at(ray, s);
        let leave = ray.t_far(0, cell[0]).min(ray.t_far(1, cell[1]));
        let next = stepper.safe_until(s);
        if next > leave {
            s = next;
            continue;
        }
        probe.cell();
        if let Some(span) = Span::new(ray, cell[0], cell[1])
            && let Some(hit) = tile.intersect(map, ray, (cell, &span), admit)
        {
            return Some(hit);
        }
        s = leave;
    }
    None
}

/// Largest error, in the map's metric, under which a distance still says that the leaf is silent.
fn margin(map: &HeightMap, distances: &DistanceMap, ray: &MapRay) -> f64 {
    let metric = distances.metric();
    let (low, high) = map.raw_range();
    let size = f64::from(low.abs().max(high.abs()));
    let reach = |axis: usize| 1.0 + f64::from(ray.lo[axis].abs().max(ray.hi[axis].abs()));
    let strays = metric.x * reach(0) + metric.y * reach(1);
    2.0f64.powi(-17) * size * metric.z + 2.0f64.powi(-21) * strays
}

/// Steps along one ray in one tile.
struct Stepper<'a> {
    distances: &'a DistanceMap,
    /// Position in stored cells and raw height: `origin + s * direction`.
    origin: [f64; 3],
    direction: [f64; 3],
    /// Length of `direction` in the map's metric.
    speed: f64,
    margin: f64,
}

impl<'a> Stepper<'a> {
    fn new(map: &HeightMap, distances: &'a DistanceMap, ray: &MapRay, tile: &Tile) -> Self {
        let along = |axis: usize| stored_line(&tile.axes[axis], ray.o[axis], ray.d[axis]);
        let ([x, dx], [y, dy]) = (along(0), along(1));
        let dz = f64::from(ray.dz);
        let metric = distances.metric();
        let speed = (metric.x * dx).hypot(metric.y * dy).hypot(metric.z * dz);
        Self {
            distances,
            origin: [x, y, f64::from(ray.oz)],
            direction: [dx, dy, dz],
            speed,
            margin: margin(map, distances, ray),
        }
    }

    /// Largest parameter up to which the ray is surely clear of the surface; `s` itself if none.
    fn safe_until(&self, s: f32) -> f32 {
        let start = f64::from(s);
        let p = [0, 1, 2].map(|k| self.origin[k] + start * self.direction[k]);
        let clear = self.distances.safe_distance(p) - self.margin;
        if clear <= 0.0 {
            return s;
        }
        let mut until = start + clear / self.speed;
        if self.distances.kind() == DistanceKind::Boxes {
            until = until.max(self.voxel_exit(p, start));
        }
        (until as f32).next_down().max(s)
    }

    /// Parameter at which the ray leaves the voxel that holds `p`, its point at `s`.
    fn voxel_exit(&self, p: [f64; 3], s: f64) -> f64 {
        let (low, high) = self.distances.voxel_bounds(self.distances.voxel_of(p));
        let mut exit = f64::INFINITY;
        for k in 0..3 {
            let d = self.direction[k];
            if d != 0.0 {
                let face = if d > 0.0 { high[k] } else { low[k] };
                exit = exit.min(s + (face - p[k]) / d);
            }
        }
        exit.max(s)
    }
}

/// Start and slope, in stored cells, of a forward coordinate that starts at `o` with slope `d`.
fn stored_line(axis: &TileAxis, o: f32, d: f32) -> [f64; 2] {
    let (o, d) = (f64::from(o), f64::from(d));
    let origin = f64::from(axis.stored(0));
    if axis.down { [origin + 1.0 - o, -d] } else { [origin + o, d] }
}
