//! Methods `distance` and `distance-corrected`: safe steps through a distance map, the exact leaf
//! near the surface \[Donnelly2005, made exact\].
//!
//! **Step.** An affine face keeps the ray parameter, so the map is walked in the metric it was made
//! for, whatever the face's size and depth: a safe distance `D` advances the parameter by
//! `D / |G d|`, with `G` the map's metric and `d` the ray's direction in lattice space.
//!
//! **Column.** Near the surface distances are about 0: the distance from a voxel's box is 0 in a
//! ring around every column that the voxel's heights meet. There the ray goes from column to
//! column instead. Within the footprint of a voxel only that column's surface can be met, and it
//! lies between the column's two heights: the cells under the footprint are shown to the leaf
//! between the parameters at which the ray enters and leaves those heights, none if it does not.
//! A step that leads past the footprint is taken first; it needs no column.
//!
//! **No miss.** A step of `D - c` keeps every point of the skipped part farther than `c` from the
//! surface, in the map's metric. [`margin`] chooses `c` so that the leaf would report nothing
//! there: `2^-17 A` raw units of height (16 times the leaf's own rounding, which keeps even the
//! discriminant of a double near-root negative), plus the distance by which the leaf's rounded
//! points may stray from the ray, `2^-21` of the cells in the window. The heights of a column are
//! widened by the same two: `2^-17 A`, and by what the surface can rise over the distance by which
//! the leaf's points stray, its steepest slope being the map's range a cell; that also covers
//! points which stray over the footprint's border, the surface being continuous there. A cell of
//! which only a part was skipped is shown to the leaf whole. So the result is that of every cell,
//! bit for bit.
//!
//! **Progress.** Parameters are `f64`; one that ends at a footprint's border goes [`BEYOND`] it,
//! less than points stray. Where rounding leaves the ray in the column it should have left, the
//! current cell is shown and left, as `dda` does.

use crate::map::{DistanceMap, HeightMap};
use crate::probe::Probe;

use super::leaf::{Crossings, LeafHit, Span};
use super::map_ray::MapRay;
use super::tile::{Tile, TileAxis};

/// The shortest step by a distance that is worth taking, in parameters: so every walk ends soon.
const LEAST: f64 = 1.0 / (1u64 << 20) as f64;

/// How far past the border of a footprint a walk goes on, in parameters.
const BEYOND: f64 = 1.0 / (1u64 << 40) as f64;

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
    let (mut s, end) = (f64::from(from), f64::from(to));
    while s < end {
        probe.step();
        let at = stepper.look(s);
        if at.safe > at.leave.max(s + LEAST) {
            s = at.safe;
            continue;
        }
        let stuck = at.leave <= s;
        let [first, last] = if stuck { [s, s] } else { at.near };
        if first <= last {
            let mut cell = tile.cell_at(ray, (first as f32).next_down().max(from));
            loop {
                probe.cell();
                if let Some(span) = Span::new(ray, cell[0], cell[1])
                    && let Some(hit) = tile.intersect(map, ray, (cell, &span), admit)
                {
                    return Some(hit);
                }
                let far = [ray.t_far(0, cell[0]), ray.t_far(1, cell[1])];
                let leave = far[0].min(far[1]);
                if f64::from(leave) > last {
                    s = s.max(f64::from(leave));
                    break;
                }
                for axis in 0..2 {
                    if far[axis] <= leave {
                        cell[axis] += 1;
                        if cell[axis] >= tile.axes[axis].to {
                            return None;
                        }
                    }
                }
            }
        }
        if !stuck {
            s = s.max(at.leave + BEYOND);
        }
    }
    None
}

/// Largest error, in the map's metric, under which a distance still says that the leaf is silent.
fn margin(map: &HeightMap, distances: &DistanceMap, ray: &MapRay) -> f64 {
    let metric = distances.metric();
    let reach = |axis: usize| 1.0 + f64::from(ray.lo[axis].abs().max(ray.hi[axis].abs()));
    let strays = metric.x * reach(0) + metric.y * reach(1);
    2.0f64.powi(-17) * magnitude(map) * metric.z + 2.0f64.powi(-21) * strays
}

/// By how much the heights of a column are widened, raw units.
fn lift(map: &HeightMap, ray: &MapRay) -> f64 {
    let (low, high) = map.raw_range();
    let steepest = f64::from(high) - f64::from(low);
    let strays = 2.0f64.powi(-21) * (2.0 + f64::from(ray.d[0]) + f64::from(ray.d[1]));
    2.0f64.powi(-17) * magnitude(map) + strays * steepest
}

/// Largest magnitude of a raw height.
fn magnitude(map: &HeightMap) -> f64 {
    let (low, high) = map.raw_range();
    f64::from(low.abs().max(high.abs()))
}

/// What a walk knows at a point of its ray.
struct Look {
    /// Parameter up to which the distance says that the ray is clear of the surface.
    safe: f64,
    /// Where the ray leaves the footprint of its voxel.
    leave: f64,
    /// The part before that in which the ray is between the heights of the column; empty, first
    /// above last, if there is none.
    near: [f64; 2],
}

/// Steps along one ray in one tile.
struct Stepper<'a> {
    distances: &'a DistanceMap,
    /// Position in voxels: `origin + s * direction`.
    origin: [f64; 3],
    direction: [f64; 3],
    /// Reciprocal of the direction along x and y, never 0; the border that is met next is that of
    /// the voxel's index plus `next`.
    inverse: [f64; 2],
    next: [f64; 2],
    /// Last voxel along each axis.
    last: [f64; 3],
    /// Raw height at `s = 0`, and the reciprocal of its slope.
    height: f64,
    per_height: f64,
    /// What the heights of columns are widened by.
    lift: f64,
    /// `quantum / speed` and `margin / speed`, the speed being the length of the ray's direction in
    /// the map's metric.
    quantum: f64,
    margin: f64,
}

impl<'a> Stepper<'a> {
    fn new(map: &HeightMap, distances: &'a DistanceMap, ray: &MapRay, tile: &Tile) -> Self {
        let along = |axis: usize| stored_line(&tile.axes[axis], ray.o[axis], ray.d[axis]);
        let ([x, dx], [y, dy]) = (along(0), along(1));
        let (oz, dz) = (f64::from(ray.oz), f64::from(ray.dz));
        let metric = distances.metric();
        let per_speed = 1.0 / (metric.x * dx).hypot(metric.y * dy).hypot(metric.z * dz);
        let (density, low) = distances.grid();
        let (origin, slope) = ([x, y, oz], [dx, dy, dz]);
        let direction: [f64; 3] = std::array::from_fn(|a| slope[a] * density[a]);
        let least = distances.kind().least_size();
        Self {
            distances,
            origin: std::array::from_fn(|a| (origin[a] - low[a]) * density[a]),
            direction,
            inverse: [0, 1].map(|a| 1.0 / away(direction[a])),
            next: [0, 1].map(|a| if away(direction[a]) > 0.0 { 1.0 } else { 0.0 }),
            last: distances.size().map(|n| f64::from(n - least)),
            height: oz,
            per_height: 1.0 / away(dz),
            lift: lift(map, ray),
            quantum: per_speed,
            margin: margin(map, distances, ray) * per_speed,
        }
    }

    /// What is known at `s`.
    #[inline]
    fn look(&self, s: f64) -> Look {
        let voxel: [f64; 3] = std::array::from_fn(|a| {
            let at = self.origin[a] + s * self.direction[a];
            f64::from(at.max(0.0).min(self.last[a]) as u32)
        });
        let [i, j, k] = voxel.map(|v| v as u32);
        let leave = [0, 1].map(|a| (voxel[a] + self.next[a] - self.origin[a]) * self.inverse[a]);
        let leave = leave[0].min(leave[1]);
        let safe = s + self.distances.voxel_distance([i, j, k], || self.at(s)) * self.quantum;
        let (low, high) = self.distances.columns().at(i, j);
        let meet = |height: f64| (height - self.height) * self.per_height;
        let ends = [meet(f64::from(low) - self.lift), meet(f64::from(high) + self.lift)];
        let near = [s.max(ends[0].min(ends[1])), leave.min(ends[0].max(ends[1]))];
        Look { safe: safe - self.margin, leave, near }
    }

    /// The point at `s` in stored cells and raw height.
    fn at(&self, s: f64) -> [f64; 3] {
        let (density, low) = self.distances.grid();
        std::array::from_fn(|a| {
            let steps = self.origin[a] + s * self.direction[a];
            if density[a] > 0.0 { low[a] + steps / density[a] } else { low[a] }
        })
    }
}

/// The number, or one of its sign that is not 0.
fn away(x: f64) -> f64 {
    if x.abs() < 1e-200 { 1e-200 } else { x }
}

/// Start and slope, in stored cells, of a forward coordinate that starts at `o` with slope `d`.
fn stored_line(axis: &TileAxis, o: f32, d: f32) -> [f64; 2] {
    let (o, d) = (f64::from(o), f64::from(d));
    let origin = f64::from(axis.stored(0));
    if axis.down { [origin + 1.0 - o, -d] } else { [origin + o, d] }
}
