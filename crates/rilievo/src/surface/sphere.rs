//! [`Sphere`].
//!
//! The quadratic is solved as in \[Haines2019, chapter 7\]: the discriminant comes from the distance
//! between the centre and the ray, which does not cancel for far or tiny spheres, and the roots
//! from the product and the sum that do not cancel either. A ray that starts on the sphere knows
//! one root, `t = 0`; the other is `-2 (o - c) . d / (d . d)`, no epsilon needed.

use glam::DVec3;
use thiserror::Error;

use crate::accel::Aabb;
use crate::accel::rounding::gamma;
use crate::hit::Hit;
use crate::mesh::COORDINATE_LIMIT;
use crate::ray::{Part, Ray};
use crate::spherical;

/// A sphere with poles on the z axis. u is the longitude over 360 degrees, from +x towards +y, in
/// [0, 1), 0 at the poles; v is 0 at the south pole (-z) and 1 at the north pole, and linear in
/// latitude. The front is outside. At the poles dP/du vanishes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    center: DVec3,
    radius: f64,
}

/// Why a sphere was refused.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SphereError {
    /// The centre is NaN, infinite or beyond [`COORDINATE_LIMIT`].
    #[error("the centre is not finite or larger than 1e100")]
    Center,
    /// The radius is not usable.
    #[error("the radius is {0}, not a number from 1e-100 to 1e100")]
    Radius(f64),
}

impl Sphere {
    /// A sphere; centre and radius in scene units.
    ///
    /// # Errors
    /// See [`SphereError`].
    pub fn new(center: DVec3, radius: f64) -> Result<Self, SphereError> {
        if !center.abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all() {
            return Err(SphereError::Center);
        }
        if !(1.0 / COORDINATE_LIMIT..=COORDINATE_LIMIT).contains(&radius) {
            return Err(SphereError::Radius(radius));
        }
        Ok(Self { center, radius })
    }

    /// The centre.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// The radius.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// The box around the sphere.
    pub fn bounds(&self) -> Aabb {
        Aabb { min: self.center - self.radius, max: self.center + self.radius }
    }

    /// The nearest hit within `0 <= t <= t_max`. `hit.surface` is 0.
    pub fn closest(&self, ray: &Ray) -> Option<Hit> {
        let (t, front) = self.meet(ray)?;
        Some(self.complete(ray, t, front))
    }

    /// The hit at `t`, as [`Sphere::meet`] found it.
    pub(crate) fn complete(&self, ray: &Ray, t: f64, front: bool) -> Hit {
        let normal = self.outwards(ray, t);
        let arm = self.radius * normal;
        let (position, uv) = (self.center + arm, spherical::uv(normal));
        // A unit vector carries 4 roundings a component, its product 1, the sum 1.
        let rounding = gamma(5) * arm.abs() + gamma(1) * position.abs();
        let tangents = spherical::tangents(self.radius, normal);
        Hit {
            t,
            position,
            position_error: rounding.length(),
            geometric_normal: normal,
            shading_normal: normal,
            tangents,
            uv,
            height: 0.0,
            front,
            surface: 0,
            part: Part::Whole,
            time: ray.time,
        }
    }

    /// Whether the sphere is met within `0 <= t <= t_max`.
    pub fn occludes(&self, ray: &Ray) -> bool {
        self.meet(ray).is_some()
    }

    /// Parameter of the nearest meeting within `[0, t_max]`, and whether it is from outside.
    pub(crate) fn meet(&self, ray: &Ray) -> Option<(f64, bool)> {
        let (f, d) = (ray.origin - self.center, ray.direction);
        let a = d.length_squared();
        let b = -f.dot(d);
        let within = |t: f64| (0.0..=ray.t_max).contains(&t) && t.is_finite();
        if let Some(from) = ray.from {
            let t = 2.0 * (b / a);
            return (!from.front && t > 0.0 && within(t)).then_some((t, false));
        }
        let nearest = f + (b / a) * d;
        let half_chord = self.radius * self.radius - nearest.length_squared();
        if half_chord.is_nan() || half_chord < 0.0 {
            return None;
        }
        let distance = f.length();
        let c = (distance - self.radius) * (distance + self.radius);
        let root = a.sqrt() * half_chord.sqrt();
        let (first, second) = if b >= 0.0 {
            (c / (b + root), (b + root) / a)
        } else {
            ((b - root) / a, c / (b - root))
        };
        if within(first) { Some((first, true)) } else { within(second).then_some((second, false)) }
    }

    /// Unit vector from the centre to the point at `t`.
    fn outwards(&self, ray: &Ray, t: f64) -> DVec3 {
        let arm = (ray.origin - self.center) + t * ray.direction;
        arm.try_normalize().unwrap_or(DVec3::Z)
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::{PI, TAU};

    use glam::DVec2;

    use super::*;
    use crate::accel::random::Random;

    fn unit() -> Sphere {
        Sphere::new(DVec3::ZERO, 1.0).expect("valid")
    }

    #[test]
    fn closed_form() {
        let sphere = Sphere::new(DVec3::new(1.0, 2.0, 3.0), 2.0).expect("valid");
        let ray = Ray::new(DVec3::new(-9.0, 2.0, 3.0), 2.0 * DVec3::X);
        let hit = sphere.closest(&ray).expect("hit");
        assert_eq!((hit.t, hit.position, hit.front), (4.0, DVec3::new(-1.0, 2.0, 3.0), true));
        assert_eq!((hit.geometric_normal, hit.uv), (-DVec3::X, DVec2::splat(0.5)));
        assert!(!sphere.occludes(&Ray { t_max: 3.9, ..ray }));
        let inside = Ray::new(DVec3::new(1.0, 2.0, 3.0), DVec3::Z);
        let hit = sphere.closest(&inside).expect("hit");
        assert_eq!((hit.t, hit.front, hit.uv), (2.0, false, DVec2::Y));
        assert!(!sphere.occludes(&Ray::new(DVec3::new(4.0, 2.0, 3.0), DVec3::X)), "behind");
        assert!(!sphere.occludes(&Ray::new(DVec3::new(-9.0, 4.1, 3.0), DVec3::X)), "beside");
    }

    #[test]
    fn uv_at_the_poles_and_the_date_line() {
        let at = |n: DVec3| unit().closest(&Ray::new(3.0 * n, -n)).expect("hit").uv;
        assert_eq!(at(DVec3::Z), DVec2::new(0.0, 1.0));
        assert_eq!(at(-DVec3::Z), DVec2::new(0.0, 0.0));
        assert_eq!(at(DVec3::X), DVec2::new(0.0, 0.5));
        assert_eq!(at(DVec3::Y), DVec2::new(0.25, 0.5));
        assert_eq!(at(-DVec3::X), DVec2::new(0.5, 0.5));
        assert_eq!(at(-DVec3::Y), DVec2::new(0.75, 0.5));
        for pole in [DVec3::new(-0.0, 0.0, 1.0), DVec3::new(-0.0, -0.0, -1.0)] {
            assert_eq!(spherical::uv(pole).x, 0.0);
        }
        // Either side of the date line, down to the smallest step.
        for step in [1e-3, 1e-16, 1e-300, f64::MIN_POSITIVE] {
            let (east, west) = (
                spherical::uv(DVec3::new(1.0, step, 0.0)),
                spherical::uv(DVec3::new(1.0, -step, 0.0)),
            );
            assert!(east.x < 1e-3 && (west.x > 0.999 || west.x == 0.0) && west.x < 1.0);
        }
    }

    #[test]
    fn tangents_are_the_derivatives() {
        let mut random = Random(71);
        let radius = 2.0;
        let sphere = Sphere::new(DVec3::ONE, radius).expect("valid");
        let point = |uv: DVec2| {
            let (longitude, latitude) = (TAU * uv.x, PI * (uv.y - 0.5));
            let (s, c) = longitude.sin_cos();
            DVec3::ONE + radius * DVec3::new(latitude.cos() * c, latitude.cos() * s, latitude.sin())
        };
        for _ in 0..1000 {
            let n = random.direction();
            let hit = sphere.closest(&Ray::new(DVec3::ONE + 5.0 * n, -n)).expect("hit");
            assert!(point(hit.uv).distance(hit.position) < 1e-14);
            for (axis, tangent) in [DVec2::X, DVec2::Y].into_iter().zip(hit.tangents) {
                let step = 1e-5 * axis;
                let slope = (point(hit.uv + step) - point(hit.uv - step)) / 2e-5;
                assert!(slope.distance(tangent) < 1e-6, "{slope} {tangent}");
            }
            assert!(hit.tangents[0].cross(hit.tangents[1]).dot(n) >= 0.0);
        }
    }

    #[test]
    fn far_and_tiny_spheres() {
        let mut random = Random(73);
        for (radius, distance) in [(1e-3, 1e6), (1e-6, 1.0), (1.0, 1e8), (1e6, 1e6 + 1.0)] {
            for _ in 0..10_000 {
                let center = random.cube() * 100.0;
                let sphere = Sphere::new(center, radius).expect("valid");
                let from = random.direction();
                let origin = center + distance * from;
                let aim = center + 0.9 * radius * random.cube() / 3f64.sqrt();
                let hit = sphere.closest(&Ray::new(origin, aim - origin)).expect("aimed at");
                // Off the sphere by its bound at most; off the ray by roundings of the distance.
                let off = (hit.position - center).length() - radius;
                assert!(off.abs() <= hit.position_error + f64::EPSILON * radius);
                let reach = distance + 100.0;
                assert!(hit.position_error < 1e-14 * (radius + 100.0));
                let away = (hit.position - origin).cross((aim - origin).normalize()).length();
                assert!(away <= 1e-14 * reach, "{away} {radius} {distance}");
                assert!(hit.front && hit.t > 0.0);
            }
        }
    }

    #[test]
    fn a_thousand_rays_from_a_thousand_hits() {
        let mut random = Random(79);
        for (center, radius) in
            [(DVec3::ZERO, 1.0), (DVec3::new(148376.0, 1234.0, -223423.0), 1e-3), (DVec3::ONE, 1e6)]
        {
            let sphere = Sphere::new(center, radius).expect("valid");
            for _ in 0..1000 {
                let n = random.direction();
                let origin = center + 3.0 * radius * n;
                let hit = sphere.closest(&Ray::new(origin, -n)).expect("hit");
                for _ in 0..1000 {
                    let direction = random.direction();
                    let next = sphere.closest(&hit.spawn(direction));
                    // Outwards nothing, inwards the other end of the chord 2 r |cos|.
                    let cos = direction.dot(hit.geometric_normal);
                    assert_eq!(next.is_some(), cos < 0.0);
                    if let Some(next) = next {
                        let slack = 4.0 * (hit.position_error + f64::EPSILON * radius);
                        assert!((next.t + 2.0 * radius * cos).abs() <= slack);
                        assert!(!next.front && next.t > 0.0);
                    }
                }
            }
        }
    }

    #[test]
    fn bad_spheres_are_refused() {
        for radius in [0.0, -1.0, f64::NAN, f64::INFINITY, 1e-200] {
            assert!(matches!(Sphere::new(DVec3::ZERO, radius), Err(SphereError::Radius(_))));
        }
        let center = DVec3::new(0.0, f64::NAN, 0.0);
        assert_eq!(Sphere::new(center, 1.0), Err(SphereError::Center));
    }
}
