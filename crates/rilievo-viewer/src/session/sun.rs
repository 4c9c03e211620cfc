//! [`Sun`]: a sun by where it stands in the sky, z up.

use glam::DVec3;

/// A sun. Angles in degrees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Where it stands, from +x towards +y, -180 to 180.
    pub azimuth: f64,
    /// Above the horizon, -90 to 90.
    pub elevation: f64,
    /// Irradiance of a surface that faces it, W/m^2, linear RGB.
    pub irradiance: DVec3,
    /// Across its disc: how soft shadows are.
    pub angle: f64,
}

impl Default for Sun {
    /// Low from the left and the front, warm.
    fn default() -> Self {
        Self { azimuth: -155.0, elevation: 32.0, irradiance: DVec3::new(3.0, 2.8, 2.4), angle: 4.0 }
    }
}

impl Sun {
    /// The sun whose light goes along `direction`.
    pub fn along(direction: DVec3, irradiance: DVec3, angle: f64) -> Self {
        let to = -direction.normalize_or(DVec3::NEG_Z);
        Self {
            azimuth: to.y.atan2(to.x).to_degrees(),
            elevation: to.z.clamp(-1.0, 1.0).asin().to_degrees(),
            irradiance,
            angle,
        }
    }

    /// The way its light goes, unit length.
    pub fn direction(&self) -> DVec3 {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        let flat = elevation.cos();
        -DVec3::new(flat * azimuth.cos(), flat * azimuth.sin(), elevation.sin())
    }

    /// Its brightest channel.
    pub fn strength(&self) -> f64 {
        self.irradiance.max_element()
    }

    /// The same colour at another strength; white if it was dark.
    #[must_use]
    pub fn with_strength(self, strength: f64) -> Self {
        let hue = match self.strength() {
            0.0 => DVec3::ONE,
            most => self.irradiance / most,
        };
        Self { irradiance: hue * strength, ..self }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn angles_and_directions_are_two_ways_to_say_the_same() {
        for azimuth in [-170.0, -90.0, 0.0, 33.0, 179.0] {
            for elevation in [-80.0, 0.0, 12.0, 89.0] {
                let sun = Sun { azimuth, elevation, ..Sun::default() };
                let back = Sun::along(3.0 * sun.direction(), sun.irradiance, sun.angle);
                assert!((back.azimuth - azimuth).abs() < 1e-9, "{back:?}");
                assert!((back.elevation - elevation).abs() < 1e-9, "{back:?}");
            }
        }
        // From above, light goes down.
        let noon = Sun { elevation: 90.0, ..Sun::default() };
        assert!((noon.direction() + DVec3::Z).length() < 1e-12);
    }

    #[test]
    fn strength_keeps_the_colour() {
        let sun = Sun { irradiance: DVec3::new(2.0, 1.0, 0.5), ..Sun::default() };
        assert_eq!(sun.with_strength(4.0).irradiance, DVec3::new(4.0, 2.0, 1.0));
        assert_eq!(sun.with_strength(0.0).with_strength(1.0).irradiance, DVec3::ONE);
    }
}
