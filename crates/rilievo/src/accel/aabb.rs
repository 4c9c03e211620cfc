//! [`Aabb`]: a box, and the slab test that never misses one by rounding.

use glam::{BVec3, DVec3};

use super::GROWTH;
use super::rounding::gamma;
use crate::ray::Ray;

/// An axis-aligned box, closed, in world space and scene units. It may be infinite; it holds no
/// NaN. A box with `min > max` on any axis is empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Smallest corner.
    pub min: DVec3,
    /// Largest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The empty box, neutral in unions.
    pub const EMPTY: Self = Self { min: DVec3::INFINITY, max: DVec3::NEG_INFINITY };

    /// The smallest box around `points`.
    pub fn around(points: impl IntoIterator<Item = DVec3>) -> Self {
        points.into_iter().fold(Self::EMPTY, |b, p| Self { min: b.min.min(p), max: b.max.max(p) })
    }

    /// Whether the box holds no point.
    pub fn is_empty(&self) -> bool {
        self.min.cmpgt(self.max).any()
    }

    /// The smallest box around both.
    #[inline]
    pub fn union(self, other: Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The box with every face moved outwards by `by`; an empty box stays empty.
    pub fn grown(self, by: f64) -> Self {
        if self.is_empty() {
            return self;
        }
        Self { min: self.min - by, max: self.max + by }
    }

    /// Surface area in square scene units; 0 for an empty box.
    #[inline]
    pub fn surface_area(&self) -> f64 {
        if self.is_empty() {
            return 0.0;
        }
        let d = self.max - self.min;
        2.0 * (d.x * d.y + d.y * d.z + d.z * d.x)
    }

    /// Middle of the box, finite for any box: infinite faces count as the largest number.
    #[inline]
    pub fn centre(&self) -> DVec3 {
        let limit = DVec3::splat(f64::MAX);
        0.5 * self.min.clamp(-limit, limit) + 0.5 * self.max.clamp(-limit, limit)
    }

    /// Largest coordinate of a corner, without sign.
    pub fn largest_coordinate(&self) -> f64 {
        self.min.abs().max(self.max.abs()).max_element()
    }

    /// Whether all of `other` lies in this box.
    pub fn contains(&self, other: &Self) -> bool {
        other.is_empty() || (self.min.cmple(other.min).all() && self.max.cmpge(other.max).all())
    }
}

impl Aabb {
    /// Whether the ray starts beside the box on some axis and does not go back to it, by more than
    /// rounding: then [`SlabRay::entry`] finds nothing, at a higher price.
    #[inline]
    pub fn is_behind(&self, ray: &Ray) -> bool {
        let (origin, direction) = (ray.origin, ray.direction);
        let spread = GROWTH * origin.abs().max_element();
        let above = direction.cmpge(DVec3::ZERO) & self.max.cmplt(origin - spread);
        let below = direction.cmple(DVec3::ZERO) & self.min.cmpgt(origin + spread);
        (above | below).any()
    }
}

/// A ray made ready for many slab tests.
///
/// The test follows \[Ize2013, robust slabs\]: the far distances are multiplied by `1 + 2 gamma(3)`,
/// which covers their rounding. Here the origin is spread as well, by [`GROWTH`] of its largest
/// coordinate, for rays that start on a surface and are off it by rounding.
///
/// A zero direction component (or one whose inverse overflows) leaves its slab's distances
/// infinite, or NaN where the origin lies on a face; `f64::max` and `f64::min` pass over NaN, so
/// such a slab does not cut.
#[derive(Clone, Copy, Debug)]
pub struct SlabRay {
    /// Origin as the smaller and as the larger faces see it.
    origins: [DVec3; 2],
    inverse: DVec3,
    /// Axes along which the larger face is met first.
    backwards: BVec3,
}

/// \[Ize2013, robust slabs\].
const FAR_FACTOR: f64 = 1.0 + 2.0 * gamma(3);

impl SlabRay {
    /// Prepares `ray`.
    pub fn new(ray: &Ray) -> Self {
        let spread = GROWTH * ray.origin.abs().max_element();
        let inverse = ray.direction.recip();
        let backwards = BVec3::from_array(inverse.to_array().map(f64::is_sign_negative));
        Self { origins: [ray.origin + spread, ray.origin - spread], inverse, backwards }
    }

    /// Where the ray enters `bounds`, at least 0 and a lower bound on every meeting inside, or
    /// `None` if it misses the box within `[0, t_max]`.
    #[inline]
    pub fn entry(&self, bounds: &Aabb, t_max: f64) -> Option<f64> {
        let low = (bounds.min - self.origins[0]) * self.inverse;
        let high = (bounds.max - self.origins[1]) * self.inverse;
        let enter = DVec3::select(self.backwards, high, low);
        let leave = DVec3::select(self.backwards, low, high);
        // Written so that NaN, which is only ever new, is passed over in one instruction.
        let later = |a: f64, b: f64| if a > b { a } else { b };
        let sooner = |a: f64, b: f64| if a < b { a } else { b };
        let near = later(enter.x, later(enter.y, later(enter.z, 0.0)));
        let far = sooner(leave.x, sooner(leave.y, sooner(leave.z, f64::INFINITY)));
        (near <= sooner(far, t_max) * FAR_FACTOR).then_some(near)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::accel::random::Random;

    fn unit() -> Aabb {
        Aabb { min: DVec3::ZERO, max: DVec3::ONE }
    }

    fn entry(b: &Aabb, origin: DVec3, direction: DVec3) -> Option<f64> {
        SlabRay::new(&Ray::new(origin, direction)).entry(b, f64::INFINITY)
    }

    #[test]
    fn measures() {
        let b = Aabb::around([DVec3::new(1.0, 2.0, 3.0), DVec3::new(2.0, 0.0, 6.0)]);
        assert_eq!(b.surface_area(), 2.0 * (2.0 + 6.0 + 3.0));
        assert_eq!(b.centre(), DVec3::new(1.5, 1.0, 4.5));
        assert_eq!(b.largest_coordinate(), 6.0);
        assert_eq!(b.grown(1.0).min, DVec3::new(0.0, -1.0, 2.0));
        assert_eq!(b.union(Aabb::EMPTY), b);
        assert!(b.union(unit()).contains(&b) && b.contains(&Aabb::EMPTY) && !b.contains(&unit()));
    }

    #[test]
    fn empty_and_infinite_boxes() {
        assert_eq!(Aabb::EMPTY.surface_area(), 0.0);
        assert_eq!(Aabb::EMPTY.grown(1.0), Aabb::EMPTY);
        assert!(Aabb::EMPTY.centre().is_finite());
        let all = Aabb { min: DVec3::NEG_INFINITY, max: DVec3::INFINITY };
        assert_eq!(all.centre(), DVec3::ZERO);
        for d in [DVec3::X, -DVec3::Y, DVec3::new(1.0, -2.0, 0.0), DVec3::new(-0.0, 0.0, 3.0)] {
            assert_eq!(entry(&all, DVec3::splat(7.0), d), Some(0.0));
            assert_eq!(entry(&Aabb::EMPTY, DVec3::splat(7.0), d), None);
        }
    }

    #[test]
    fn zero_components_on_and_beside_faces() {
        for zero in [0.0, -0.0] {
            let d = DVec3::new(1.0, zero, zero);
            for y in [0.0, 0.5, 1.0] {
                let near = entry(&unit(), DVec3::new(-1.0, y, 1.0), d).expect("face or inside");
                assert!((near - 1.0).abs() < 1e-12);
            }
            assert_eq!(entry(&unit(), DVec3::new(-1.0, 1.1, 0.5), d), None);
            assert_eq!(entry(&unit(), DVec3::new(-1.0, -0.1, 0.5), d), None);
        }
        assert_eq!(entry(&unit(), DVec3::new(2.0, 0.5, 0.5), DVec3::X), None);
    }

    #[test]
    fn what_lies_behind_is_never_entered() {
        let mut random = Random(3);
        let (mut behind, mut missed) = (0, 0);
        for case in 0..100_000 {
            let mut ray = Ray::new(2.0 * random.cube(), random.direction());
            if case % 5 == 0 {
                ray.direction[case % 3] = [0.0, -0.0][case / 3 % 2];
                ray.origin = (2.0 * ray.origin).round() / 2.0;
            }
            let missing = SlabRay::new(&ray).entry(&unit(), f64::INFINITY).is_none();
            assert!(missing || !unit().is_behind(&ray), "{ray:?}");
            behind += u32::from(unit().is_behind(&ray));
            missed += u32::from(missing);
        }
        assert!(behind > 40_000 && missed > behind, "{behind} of {missed}");
    }

    #[test]
    fn t_max_ends_the_ray() {
        let slab = SlabRay::new(&Ray::new(DVec3::new(-1.0, 0.5, 0.5), DVec3::X));
        assert_eq!(slab.entry(&unit(), 0.99), None);
        assert!(slab.entry(&unit(), 1.0).is_some());
    }

    #[test]
    fn flat_boxes_are_never_missed_by_rounding() {
        let mut random = Random(1);
        for case in 0..300_000 {
            let shift =
                if case % 2 == 0 { DVec3::ZERO } else { DVec3::new(148376.0, 1234.0, -2e5) };
            let origin = random.cube() * 10.0 + shift;
            let target = random.cube() + shift;
            let mut half = random.cube().abs();
            half[case % 3] = 0.0;
            let b = Aabb { min: target - half, max: target + half };
            let ray = Ray::new(origin, target - origin);
            assert!(SlabRay::new(&ray).entry(&b, 1.0).is_some(), "{ray:?} {b:?}");
            // A point box, and a corner of the box aimed at.
            let point = Aabb { min: target, max: target };
            assert!(SlabRay::new(&ray).entry(&point, 1.0).is_some(), "{ray:?} {point:?}");
            let ray = Ray::new(origin, b.max - origin);
            assert!(SlabRay::new(&ray).entry(&b, 1.0).is_some(), "{ray:?} {b:?}");
        }
    }
}
