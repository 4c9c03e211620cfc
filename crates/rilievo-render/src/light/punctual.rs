//! [`PointLight`] and [`SunLight`]: lights that are no surface.

use glam::{DVec2, DVec3};

use super::LightSample;
use crate::colour::{Rgb, is_radiance};
use crate::sampler::warp::{square_to_cone, square_to_cone_pdf};

/// A light in one point: the same intensity all around, or a spot of light.
///
/// A spot has its full intensity up to the inner angle from its axis, none from the outer angle on,
/// and between them the square of what is linear in the cosine, as glTF has it (KHR_lights_punctual).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    pub(super) position: DVec3,
    pub(super) intensity: Rgb,
    /// Unit axis; zero where there is no cone.
    pub(super) axis: DVec3,
    /// Cosines of the inner and the outer angle.
    pub(super) cosines: [f64; 2],
}

/// Why a light was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum LightError {
    /// A place or a direction is NaN or infinite.
    #[error("position and direction must be finite")]
    NotFinite,
    /// A direction is zero.
    #[error("the direction is zero")]
    NoDirection,
    /// A colour has a channel that is negative, NaN or infinite.
    #[error("channels are [{}, {}, {}]; they must be finite and at least 0", found.x, found.y, found.z)]
    Colour {
        /// The value found.
        found: Rgb,
    },
    /// An angle is out of range.
    #[error("the angle is {found} degrees; it must be {allowed}")]
    Angle {
        /// The value found, degrees.
        found: f64,
        /// The values allowed, in words.
        allowed: &'static str,
    },
}

impl PointLight {
    /// A light at `position` of `intensity` in every direction, W/sr.
    ///
    /// # Errors
    /// [`LightError`] says which number is wrong.
    pub fn new(position: DVec3, intensity: Rgb) -> Result<Self, LightError> {
        check(position, intensity)?;
        Ok(Self { position, intensity, axis: DVec3::ZERO, cosines: [-1.0; 2] })
    }

    /// The same light held to a cone around `axis`; `angles` are the inner and the outer one, from
    /// the axis, degrees, with `0 <= inner < outer <= 90`.
    ///
    /// # Errors
    /// [`LightError`] says which number is wrong.
    pub fn spot(self, axis: DVec3, angles: [f64; 2]) -> Result<Self, LightError> {
        let axis = unit(axis)?;
        let [inner, outer] = angles;
        if !(outer > 0.0 && outer <= 90.0) {
            return Err(LightError::Angle { found: outer, allowed: "above 0, up to 90" });
        }
        if !(inner >= 0.0 && inner < outer) {
            return Err(LightError::Angle { found: inner, allowed: "from 0, below the outer one" });
        }
        Ok(Self { axis, cosines: angles.map(|angle| angle.to_radians().cos()), ..self })
    }

    /// Where it is.
    pub fn position(&self) -> DVec3 {
        self.position
    }

    /// The largest intensity, W/sr.
    pub(super) fn intensity(&self) -> Rgb {
        self.intensity
    }

    /// The axis and the cosine of the outer angle of a spot.
    pub(super) fn cone(&self) -> Option<(DVec3, f64)> {
        (self.axis != DVec3::ZERO).then_some((self.axis, self.cosines[1]))
    }

    /// The light as it comes to `point`; nothing outside of the cone, or in the very place.
    pub(super) fn sample(&self, point: DVec3) -> Option<LightSample> {
        let way = self.position - point;
        let squared = way.length_squared();
        let direction = way / squared.sqrt();
        let share = match self.cone() {
            None => 1.0,
            Some((axis, outer)) => {
                let part = (-direction.dot(axis) - outer) / (self.cosines[0] - outer);
                part.clamp(0.0, 1.0).powi(2)
            }
        };
        // Negated, so that NaN, at no distance, is refused.
        if !(share > 0.0 && squared > 0.0) {
            return None;
        }
        let weight = self.intensity * (share / squared);
        Some(LightSample { position: self.position, direction, weight, pdf: 0.0, clear: 1.0 })
    }
}

/// Light from far away, from one direction or a disc of the sky.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SunLight {
    /// Unit direction towards it.
    pub(super) towards: DVec3,
    /// On a surface that faces it, W/m^2.
    pub(super) irradiance: Rgb,
    /// 1 less the cosine of half the disc's angle; 0 for one direction.
    pub(super) height: f64,
    /// Radiance of the disc.
    pub(super) radiance: Rgb,
}

impl SunLight {
    /// Light that travels along `direction` and gives a surface that faces it `irradiance`, W/m^2,
    /// from a disc of `angle` degrees across, 0 to 180; 0 is one direction, with hard shadows.
    ///
    /// # Errors
    /// [`LightError`] says which number is wrong.
    pub fn new(direction: DVec3, irradiance: Rgb, angle: f64) -> Result<Self, LightError> {
        check(direction, irradiance)?;
        let towards = -unit(direction)?;
        if !(0.0..=180.0).contains(&angle) {
            return Err(LightError::Angle { found: angle, allowed: "from 0 to 180" });
        }
        let sin = (0.5 * angle).to_radians().sin();
        let height = 2.0 * (0.25 * angle).to_radians().sin().powi(2);
        let radiance = match height > 0.0 {
            // The cosine over a disc integrates to pi sin^2.
            true => irradiance / (std::f64::consts::PI * sin * sin),
            false => Rgb::ZERO,
        };
        Ok(Self { towards, irradiance, height, radiance })
    }

    /// The light as it comes to `point`.
    pub(super) fn sample(&self, point: DVec3, u: DVec2) -> LightSample {
        let (direction, weight, pdf) = if self.height > 0.0 {
            let local = square_to_cone(u, self.height);
            let (right, up) = self.towards.any_orthonormal_pair();
            let direction = local.x * right + local.y * up + local.z * self.towards;
            let pdf = square_to_cone_pdf(DVec3::Z, self.height);
            (direction.normalize(), self.radiance / pdf, pdf)
        } else {
            (self.towards, self.irradiance, 0.0)
        };
        LightSample { position: point + direction, direction, weight, pdf, clear: f64::INFINITY }
    }

    /// Radiance that comes against a unit `direction`.
    pub(crate) fn radiance(&self, direction: DVec3) -> Rgb {
        self.seen(direction).map_or(Rgb::ZERO, |(radiance, _)| radiance)
    }

    /// Radiance seen along a unit `direction` and the density of [`Self::sample`] there, per
    /// steradian.
    pub(super) fn seen(&self, direction: DVec3) -> Option<(Rgb, f64)> {
        // 1 less the cosine, without its cancellation.
        let below = 0.5 * (direction - self.towards).length_squared();
        (below < self.height).then(|| (self.radiance, square_to_cone_pdf(DVec3::Z, self.height)))
    }
}

fn check(vector: DVec3, colour: Rgb) -> Result<(), LightError> {
    if !vector.is_finite() {
        return Err(LightError::NotFinite);
    }
    if is_radiance(colour) { Ok(()) } else { Err(LightError::Colour { found: colour }) }
}

fn unit(direction: DVec3) -> Result<DVec3, LightError> {
    if !direction.is_finite() {
        return Err(LightError::NotFinite);
    }
    direction.try_normalize().ok_or(LightError::NoDirection)
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;
    use crate::sampler::chi_square::{check_directions, independent_points};

    #[test]
    fn point_and_spot_follow_the_inverse_square() {
        let light = PointLight::new(DVec3::Z * 2.0, Rgb::new(8.0, 4.0, 0.0)).unwrap();
        let sample = light.sample(DVec3::ZERO).unwrap();
        assert_eq!((sample.weight, sample.direction), (Rgb::new(2.0, 1.0, 0.0), DVec3::Z));
        assert!(light.sample(DVec3::Z * 2.0).is_none());

        let spot = light.spot(-DVec3::Z, [20.0, 40.0]).unwrap();
        let at = |angle: f64| {
            let point = DVec3::new(angle.to_radians().tan() * 2.0, 0.0, 0.0);
            spot.sample(point).map(|s| s.weight.x * (s.position - point).length_squared() / 8.0)
        };
        assert!((at(0.0).unwrap() - 1.0).abs() < 1e-12 && (at(19.9).unwrap() - 1.0).abs() < 1e-12);
        assert!(at(40.1).is_none() && spot.sample(DVec3::Z * 5.0).is_none());
        let [inner, outer] = [20.0_f64, 40.0].map(|a| a.to_radians().cos());
        let middle = ((30.0_f64.to_radians().cos() - outer) / (inner - outer)).powi(2);
        assert!((at(30.0).unwrap() - middle).abs() < 1e-12);
    }

    #[test]
    fn a_sun_gives_its_irradiance() {
        for angle in [0.0, 0.53, 60.0, 180.0] {
            let sun = SunLight::new(DVec3::new(0.0, 0.0, -3.0), Rgb::splat(5.0), angle).unwrap();
            let mut sum = 0.0;
            for u in independent_points(20_000) {
                let sample = sun.sample(DVec3::ONE, u);
                sum += sample.direction.z * sample.weight.x / 20_000.0;
                match sun.seen(sample.direction) {
                    Some((radiance, pdf)) => {
                        assert_eq!((radiance / pdf, pdf), (sample.weight, sample.pdf));
                    }
                    None => assert!(angle == 0.0 || sample.direction.z < sun.height.cos()),
                }
            }
            assert!((sum - 5.0).abs() < 0.05, "{angle}: {sum}");
        }
        let sun = SunLight::new(DVec3::new(0.0, 0.0, -1.0), Rgb::ONE, 180.0).unwrap();
        assert!((sun.radiance.x - 1.0 / PI).abs() < 1e-12);
        // The edge of the disc lies on the edge of a cell.
        let edge = 2.0 * 0.8_f64.acos().to_degrees();
        let sun = SunLight::new(DVec3::new(0.0, 0.0, -1.0), Rgb::ONE, edge).unwrap();
        check_directions(
            "sun",
            |u| sun.sample(DVec3::ZERO, u).direction,
            |d| sun.seen(d).map_or(0.0, |(_, pdf)| pdf),
        );
    }

    #[test]
    fn what_makes_no_light_is_refused() {
        let new = |p, i| PointLight::new(p, i).unwrap_err();
        assert_eq!(new(DVec3::NAN, Rgb::ONE), LightError::NotFinite);
        let found = Rgb::new(1.0, -1.0, 0.0);
        assert_eq!(new(DVec3::ZERO, found), LightError::Colour { found });
        let light = PointLight::new(DVec3::ZERO, Rgb::ONE).unwrap();
        assert_eq!(light.spot(DVec3::ZERO, [0.0, 9.0]).unwrap_err(), LightError::NoDirection);
        for angles in [[9.0, 9.0], [-1.0, 9.0], [0.0, 0.0], [0.0, 91.0], [0.0, f64::NAN]] {
            assert!(matches!(light.spot(DVec3::X, angles), Err(LightError::Angle { .. })));
        }
        let sun = |angle| SunLight::new(DVec3::X, Rgb::ONE, angle).unwrap_err();
        assert!(matches!(sun(181.0), LightError::Angle { .. }));
        assert!(matches!(sun(f64::NAN), LightError::Angle { .. }));
    }
}
