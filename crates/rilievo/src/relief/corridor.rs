//! [`Corridor`]: a ray over a distance map where it is straight but for a bounded remainder.
//!
//! Rays over faces are straight in lattice coordinates and raw height (`distance_walk`). Over the prism
//! of a mesh and the face of a cube they are straight to within a remainder that is known: `mesh/frame`,
//! `sphere/by_distance`. A *line* `q(t) = start + t speed` comes with an `error`, and the promise that
//!
//! ```text
//! a crossing at t is off from some point of the mapped surface by at most e,  |e_k| <= error_k
//! ```
//!
//! per coordinate, counted from `q(t)`: curvature of the ray, what the surface deviates from the map's
//! bilinear cells, and all rounding are in it. The error is constant where the line is good at all.
//!
//! **Step.** With the map's metric G the surface is at least `D(q(t))` from `q(t)`, so where
//! `D > |G error|` nothing is crossed at t, and, as D changes by at most `|G speed|` per unit of t,
//! neither before `t + (D - |G error|) / |G speed|`. This is the step of faces, shrunk by the error; no
//! sphere is traced, the box of heights decides as before. Outside of the domain the distance of the
//! nearest point in it holds, so a line may leave its tile by the error.
//!
//! **Column.** Where no step leads on, what may be crossed before the line leaves its voxel's
//! footprint lies over the columns that the line touches, widened by the error, and between their
//! heights, widened likewise. The rest is the caller's: he shows the cells there to his leaf.

use crate::map::DistanceMap;

/// Columns under a widened footprint beyond which their heights are not asked for.
const MANY_COLUMNS: u32 = 64;

/// A ray over stored cells and raw height: `start + t speed`, off by at most `error`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    pub start: [f64; 3],
    pub speed: [f64; 3],
    pub error: [f64; 3],
}

/// What is known at a parameter.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    /// Up to here nothing is crossed.
    pub safe: f64,
    /// Where the line leaves the footprint of its voxel.
    pub leave: f64,
    /// The part before `leave` in which something may be crossed; empty, first above last, if none.
    pub near: [f64; 2],
}

/// A line over a distance map.
pub(super) struct Corridor<'a> {
    distances: &'a DistanceMap,
    line: Line,
    /// The line and its error in voxels, counted from the lowest corner of the domain.
    origin: [f64; 3],
    slope: [f64; 3],
    wide: [f64; 3],
    last: [f64; 3],
    /// Parameters for a unit of distance, and the length of the error.
    per_distance: f64,
    reach: f64,
    /// The shortest step, in parameters.
    least: f64,
}

impl<'a> Corridor<'a> {
    /// `span` is the part of the line that is of interest.
    pub fn new(distances: &'a DistanceMap, line: Line, span: [f64; 2]) -> Self {
        let metric = distances.metric();
        let length = |v: [f64; 3]| (metric.x * v[0]).hypot(metric.y * v[1]).hypot(metric.z * v[2]);
        let (density, low) = distances.grid();
        let at_least = distances.kind().least_size();
        let (mut origin, mut slope, mut wide) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        for k in 0..3 {
            origin[k] = (line.start[k] - low[k]) * density[k];
            slope[k] = line.speed[k] * density[k];
            wide[k] = line.error[k] * density[k];
        }
        let spread = (span[1] - span[0]).max(span[0].abs() * 1e-6);
        Self {
            distances,
            line,
            origin,
            slope,
            wide,
            last: distances.size().map(|n| f64::from(n - at_least)),
            per_distance: 1.0 / length(line.speed).max(f64::MIN_POSITIVE),
            reach: length(line.error),
            least: spread / (1u64 << 24) as f64,
        }
    }

    /// The next parameter worth a look after one that led nowhere.
    #[inline]
    pub fn past(&self, look: &Look, t: f64) -> f64 {
        look.leave.max(t + self.least)
    }

    /// Whether the distance alone leads on.
    #[inline]
    pub fn leads_on(&self, look: &Look, t: f64) -> bool {
        look.safe > self.past(look, t)
    }

    /// How many voxels wide the error is, along x and y.
    #[inline]
    pub fn width(&self) -> f64 {
        self.wide[0].max(self.wide[1])
    }

    /// What is known at `t`, up to `end`.
    #[inline]
    pub fn look(&self, t: f64, end: f64) -> Look {
        let mut voxel = [0; 3];
        let mut leave = end;
        for (k, voxel) in voxel.iter_mut().enumerate() {
            let at = self.origin[k] + t * self.slope[k];
            *voxel = at.max(0.0).min(self.last[k]) as u32;
            if k == 2 || self.slope[k] == 0.0 {
                continue;
            }
            // The first voxel goes on below the domain, the last one above.
            let up = self.slope[k] > 0.0;
            let border = if up { (at.floor() + 1.0).max(1.0) } else { at.ceil() - 1.0 };
            let border = if up { border } else { border.min(self.last[k]) };
            if border >= 1.0 && border <= self.last[k] {
                leave = leave.min(t + (border - at) / self.slope[k]);
            }
        }
        let found = self.distances.voxel_distance(voxel, || self.at(t));
        let safe = t + (found - self.reach) * self.per_distance;
        let leave = leave.max(t);
        Look { safe, leave, near: self.near(t, leave.max((t + self.least).min(end))) }
    }

    /// The part of a stretch in which the line is between the heights of the columns that it touches.
    fn near(&self, from: f64, to: f64) -> [f64; 2] {
        let (mut first, mut last) = ([0; 2], [0; 2]);
        for k in 0..2 {
            let ends = [from, to].map(|t| self.origin[k] + t * self.slope[k]);
            let index = |at: f64| at.max(0.0).min(self.last[k]) as u32;
            first[k] = index(ends[0].min(ends[1]) - self.wide[k]);
            last[k] = index(ends[0].max(ends[1]) + self.wide[k]);
        }
        if (last[0] - first[0] + 1).saturating_mul(last[1] - first[1] + 1) > MANY_COLUMNS {
            return [from, to];
        }
        let (mut low, mut high) = (f32::INFINITY, f32::NEG_INFINITY);
        for j in first[1]..=last[1] {
            for i in first[0]..=last[0] {
                let (a, b) = self.distances.columns().at(i, j);
                (low, high) = (low.min(a), high.max(b));
            }
        }
        self.line.within([from, to], 2, [f64::from(low), f64::from(high)])
    }

    /// The line's point at `t`.
    fn at(&self, t: f64) -> [f64; 3] {
        std::array::from_fn(|k| self.line.start[k] + t * self.line.speed[k])
    }
}

impl Line {
    /// The part of a stretch in which the line is between `low` and `high`, widened, on an axis.
    #[inline]
    pub fn within(&self, [from, to]: [f64; 2], axis: usize, [low, high]: [f64; 2]) -> [f64; 2] {
        let (start, speed, error) = (self.start[axis], self.speed[axis], self.error[axis]);
        let (low, high) = (low - error - start, high + error - start);
        if speed == 0.0 {
            let inside = low <= 0.0 && 0.0 <= high;
            return if inside { [from, to] } else { [to, f64::NEG_INFINITY] };
        }
        let (a, b) = (low / speed, high / speed);
        [from.max(a.min(b)), to.min(a.max(b))]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{DistanceKind, DistanceOptions, HeightMap, Lattice, Metric, Samples, Wrap};

    /// A bar of height 1 over cells 4 and 5 of 16, in x.
    fn bar() -> (HeightMap, DistanceMap) {
        let heights = (0..17 * 17).map(|k| if k % 17 == 5 { 1.0 } else { 0.0 }).collect();
        let map = HeightMap::new(17, 17, Samples::F32(heights), Lattice::Vertex, Wrap::Mirror);
        let map = map.expect("valid");
        let metric = Metric { x: 0.1, y: 0.1, z: 0.5 };
        let options = DistanceOptions::by_default(&map, DistanceKind::Boxes, metric);
        let distances = DistanceMap::from_height(&map, DistanceKind::Boxes, &options);
        let distances = distances.expect("valid").laid_on(&map);
        (map, distances)
    }

    /// All stretches that a walk along a line has to show, in order.
    fn shown(distances: &DistanceMap, line: Line) -> Vec<[f64; 2]> {
        let span = [0.0, 1.0];
        let corridor = Corridor::new(distances, line, span);
        let (mut t, mut all) = (span[0], Vec::new());
        while t < span[1] {
            let look = corridor.look(t, span[1]);
            if corridor.leads_on(&look, t) {
                t = look.safe;
                continue;
            }
            if look.near[0] <= look.near[1] {
                all.push(look.near);
            }
            t = corridor.past(&look, t);
        }
        all
    }

    #[test]
    fn what_a_line_meets_is_shown_whatever_its_error() {
        let (_, distances) = bar();
        for error in [0.0, 1e-9, 0.01, 0.4, 3.0, 40.0] {
            for (from, to) in [([0.2, 8.3], [15.8, 8.3]), ([15.1, 0.4], [0.3, 15.6])] {
                let line = Line {
                    start: [from[0], from[1], 0.5],
                    speed: [to[0] - from[0], to[1] - from[1], 0.0],
                    error: [error, error, 0.01 * error],
                };
                // Where the line is over the bar's flanks, at half of its height.
                let all = shown(&distances, line);
                for x in [4.5, 5.5] {
                    for off in [-0.99, 0.0, 0.99] {
                        let t = (x + off * error - from[0]) / (to[0] - from[0]);
                        if (0.0..=1.0).contains(&t) {
                            let covered = all.iter().any(|[a, b]| *a <= t && t <= *b);
                            assert!(covered, "{error} {x} {off}: {t} not in {all:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_line_far_above_is_left_in_a_few_steps() {
        let (_, distances) = bar();
        let line =
            Line { start: [12.0, 0.1, 0.9], speed: [0.0, 15.0, 0.0], error: [1e-3, 1e-3, 1e-4] };
        assert!(shown(&distances, line).is_empty());
    }
}
