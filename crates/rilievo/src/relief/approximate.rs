//! Methods `distance-published` and `march`: baselines that are approximate, and say so.
//!
//! Both look at the height map at points along the ray, in `f64`, and never at the cells between:
//! what lies between two points is missed. They are kept as they were published, so that what an
//! exact method mends can be seen and counted.

use crate::map::{DistanceMap, HeightMap};
use crate::probe::Probe;

use super::map_ray::{ExactRay, Window};

/// The paper's cap on recursion, after which a ray counts as a miss. The paper names no number.
pub const PUBLISHED_STEPS: u32 = 256;

/// The paper's epsilon, as a share of the map's height range. The paper names no number.
pub const PUBLISHED_EPSILON: f64 = 1.0 / 1024.0;

/// Fixed steps of `march` through the part of a ray inside the height range.
pub const MARCH_STEPS: u32 = 64;

/// Where an approximate method believes the ray meets the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ApproximateHit {
    /// Walk parameter.
    pub s: f64,
    /// Whether the ray came from above the raw surface.
    pub from_above: bool,
}

/// A ray over a height map, cut to the face's window and the map's height range.
pub(crate) struct Segment<'a> {
    map: &'a HeightMap,
    ray: &'a ExactRay,
    window: &'a Window,
    from: f64,
    to: f64,
    /// The ends of the height range through which the ray comes in and goes out, where it does not do so
    /// through a side or end before.
    entry: Option<f64>,
    exit: Option<f64>,
    /// Whether the ray starts on this very surface.
    spawned: bool,
}

impl<'a> Segment<'a> {
    /// The segment, if the ray crosses the box before `s = 1`.
    pub fn new(
        map: &'a HeightMap,
        ray: &'a ExactRay,
        window: &'a Window,
        end: f64,
    ) -> Option<Self> {
        let (low, high) = map.raw_range();
        let lows = [window.lo[0], window.lo[1], f64::from(low)];
        let highs = [window.hi[0], window.hi[1], f64::from(high)];
        let (mut from, mut to) = (0.0f64, end);
        let (mut entry, mut exit) = (None, None);
        for k in 0..3 {
            let (o, d) = (ray.origin[k], ray.direction[k]);
            if d == 0.0 {
                if o < lows[k] || o > highs[k] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((lows[k] - o) / d, (highs[k] - o) / d);
            if k == 2 {
                let ends = if d < 0.0 { [highs[2], lows[2]] } else { [lows[2], highs[2]] };
                entry = (a.min(b) > from).then_some(ends[0]);
                exit = (a.max(b) < to).then_some(ends[1]);
            }
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from <= to).then_some(Self { map, ray, window, from, to, entry, exit, spawned: false })
    }

    /// The same for a ray that starts on the surface: the start itself is not to be found.
    #[must_use]
    pub fn spawned(self, spawned: bool) -> Self {
        Self { spawned, ..self }
    }

    fn point(&self, s: f64) -> [f64; 3] {
        [0, 1, 2].map(|k| self.ray.origin[k] + s * self.ray.direction[k])
    }

    fn gap(&self, s: f64) -> f64 {
        self.point(s)[2] - self.under(s)
    }

    /// Raw height of the surface under or above a point.
    fn under(&self, s: f64) -> f64 {
        let [x, y, _] = self.point(s);
        let ([i, j], local) = cell_in(self.window, [x, y]);
        self.map.raw_in_cell([i, j], local)
    }

    /// The gap where the ray passes an end of the height range: its sign is that of no rounding.
    fn gap_at_end(&self, s: f64, end: f64) -> f64 {
        let (low, high) = self.map.raw_range();
        end - self.under(s).clamp(low.into(), high.into())
    }

    /// Parameter length of half a cell, or of the whole segment for an upright ray.
    fn half_cell(&self) -> f64 {
        let speed = self.ray.direction[0].abs().max(self.ray.direction[1].abs());
        if speed > 0.0 { 0.5 / speed } else { self.to - self.from }
    }

    /// The seed paper's intersection \[Book2007, section 3.4\]: advance by the interpolated
    /// distance until the point is within epsilon of the surface or has just crossed it; too many
    /// steps or a point outside the maps is a miss.
    ///
    /// A spawned ray first moves half a cell, since at its own start it is within epsilon.
    pub fn published<P: Probe>(&self, map: &DistanceMap, probe: &mut P) -> Option<ApproximateHit> {
        let metric = map.metric();
        let d = self.ray.direction;
        let speed = (metric.x * d[0]).hypot(metric.y * d[1]).hypot(metric.z * d[2]);
        let (low, high) = self.map.raw_range();
        let epsilon = PUBLISHED_EPSILON * f64::from(high - low);
        let mut s = if self.spawned { self.from + self.half_cell() } else { self.from };
        let mut above = None;
        for _ in 0..PUBLISHED_STEPS {
            if s > self.to {
                return None;
            }
            probe.step();
            let gap = self.gap(s);
            let was_above = above.unwrap_or(gap >= 0.0);
            if gap.abs() <= epsilon || was_above != (gap >= 0.0) {
                return Some(ApproximateHit { s, from_above: was_above });
            }
            above = Some(was_above);
            let [x, y, z] = self.point(s);
            let stored =
                [stored_coordinate(self.map.x(), x), stored_coordinate(self.map.y(), y), z];
            s += map.safe_distance(stored) / speed;
        }
        None
    }

    /// Fixed steps to the first sign change, then one secant, as parallax occlusion mapping does
    /// \[Policarpo2005\]. Misses whatever fits between two steps.
    pub fn march<P: Probe>(&self, probe: &mut P) -> Option<ApproximateHit> {
        let from = if self.spawned { self.from + self.half_cell() } else { self.from };
        let step = (self.to - from) / f64::from(MARCH_STEPS);
        if step < 0.0 {
            return None;
        }
        let mut last = (from, self.gap(from));
        let mut from_above = last.1 > 0.0;
        // The highest and lowest places touch the ends of the range, where the ray comes in and goes out.
        if let Some(end) = self.entry.filter(|_| !self.spawned) {
            from_above = self.ray.direction[2] < 0.0;
            if self.gap_at_end(from, end) == 0.0 {
                return Some(ApproximateHit { s: from, from_above });
            }
        }
        for k in 1..=MARCH_STEPS {
            probe.step();
            let s = from + f64::from(k) * step;
            let exit = self.exit.filter(|_| k == MARCH_STEPS);
            let gap = exit.map_or_else(|| self.gap(s), |end| self.gap_at_end(s, end));
            if exit.is_some() && gap == 0.0 {
                return Some(ApproximateHit { s, from_above });
            }
            if (gap > 0.0) != from_above {
                let s = last.0 + (s - last.0) * last.1 / (last.1 - gap);
                return Some(ApproximateHit { s, from_above });
            }
            last = (s, gap);
        }
        None
    }
}

/// The unfolded cell of a window that holds a point, and where in it: on the window's border the cell inside, where
/// rounding would choose between two tiles that may not meet.
pub(super) fn cell_in(window: &Window, point: [f64; 2]) -> ([i32; 2], [f64; 2]) {
    let cell = [0, 1].map(|k| {
        let last = (window.hi[k].ceil() - 1.0).max(window.lo[k].floor());
        point[k].floor().clamp(window.lo[k].floor(), last)
    });
    (cell.map(|c| c as i32), [point[0] - cell[0], point[1] - cell[1]])
}

/// Stored-cell coordinate of an unfolded lattice coordinate.
fn stored_coordinate(axis: &crate::map::Axis, x: f64) -> f64 {
    let run = axis.run(x.floor() as i32);
    let along = x - f64::from(run.start);
    if run.flipped { f64::from(run.first) + 1.0 - along } else { f64::from(run.first) + along }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use crate::Ray;
    use crate::map::{Lattice, Procedural, Wrap};
    use crate::relief::{FaceOptions, Method, Relief, ReliefFace};

    #[test]
    fn flat_tops_are_met_where_rays_come_in() {
        for map in [Procedural::Flat { value: 1.0 }, Procedural::Studded { studs: [1, 1] }] {
            let map = map.height_map([9, 9], Lattice::Vertex, Wrap::Clamp).unwrap();
            let corners =
                [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y].map(|c| c * 0.7);
            let options = FaceOptions { method: Method::March, ..FaceOptions::default() };
            let face = ReliefFace::new(corners, Arc::new(Relief::new(map)), options).unwrap();
            for i in 0..100 {
                let target = DVec3::new(0.3 + 0.001 * f64::from(i), 0.35, 1.0);
                let origin = target + DVec3::new(0.01 * f64::from(i), 0.3, 1.0);
                let hit = face.closest(&Ray::new(origin, target - origin), &mut ());
                let hit = hit.expect("a flat top");
                assert!(hit.front && (hit.position - target).length() < 1e-9, "{hit:?}");
            }
        }
    }

    #[test]
    fn flat_floors_and_tops_are_met_where_rays_go_out() {
        let map = Procedural::Studded { studs: [1, 1] };
        let map = map.height_map_f32([33, 33], Lattice::Vertex, Wrap::Clamp).unwrap();
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y].map(|c| c * 0.7);
        let options = FaceOptions { method: Method::March, ..FaceOptions::default() };
        let face = ReliefFace::new(corners, Arc::new(Relief::new(map)), options).unwrap();
        for i in 0..1000 {
            let along = 0.0001 * f64::from(i);
            let floor = DVec3::new(0.02 + along, 0.65 - 0.3 * along, 0.0);
            let top = DVec3::new(0.3 + along, 0.35 - 0.3 * along, 1.0);
            for (target, up) in [(floor, 1.0), (top, -1.0)] {
                // No stud is in the way of the one, nor a floor of the other.
                let origin = target + up * DVec3::new(0.013 * along, 0.011, 1.7 + along);
                let hit = face.closest(&Ray::new(origin, target - origin), &mut ());
                let hit = hit.unwrap_or_else(|| panic!("{target} from {origin}"));
                assert!(hit.front == (up > 0.0), "{hit:?}");
                assert!((hit.position - target).length() < 1e-9, "{hit:?}");
            }
        }
    }
}
