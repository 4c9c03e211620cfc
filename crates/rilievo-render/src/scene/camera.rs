//! [`Camera`]: a pinhole, right-handed, image x to the right and y down.

use glam::DVec3;
use rilievo::Ray;

/// What a camera is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraParts {
    /// The pinhole, world space, scene units.
    pub position: DVec3,
    /// A point on the view axis.
    pub look_at: DVec3,
    /// A direction whose projection points up in the image; any length but zero.
    pub up: DVec3,
    /// Vertical field of view, degrees, between 0 and 180, both excluded.
    pub fov: f64,
    /// Pixels along image x and y.
    pub resolution: [u32; 2],
}

/// Why a camera was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A coordinate is NaN or infinite.
    #[error("camera position, look_at and up must be finite")]
    NotFinite,
    /// `position` and `look_at` are the same point.
    #[error("camera position and look_at are the same point")]
    NoDirection,
    /// `up` is zero or parallel to the view axis.
    #[error("camera up must not be zero or parallel to the view direction")]
    UpIsParallel,
    /// The field of view is out of range.
    #[error("camera fov is {found} degrees; it must be above 0 and below 180")]
    FieldOfView {
        /// The value found.
        found: f64,
    },
    /// An axis has no pixel, or the image has too many.
    #[error(
        "camera resolution is {} x {}; 1 to {} pixels along an axis are allowed",
        found[0], found[1], Camera::MAX_RESOLUTION
    )]
    Resolution {
        /// The value found.
        found: [u32; 2],
    },
}

/// A perspective camera; valid by construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    parts: CameraParts,
    /// Unit view axis.
    forward: DVec3,
    /// Image x per pixel on the plane one unit in front of the pinhole.
    step_x: DVec3,
    /// Image y (down) per pixel on that plane.
    step_y: DVec3,
}

impl Camera {
    /// Most pixels along an axis.
    pub const MAX_RESOLUTION: u32 = 65_536;

    /// The camera of `parts`.
    ///
    /// # Errors
    /// [`CameraError`] says which part is wrong.
    pub fn new(parts: CameraParts) -> Result<Self, CameraError> {
        let CameraParts { position, look_at, up, fov, resolution } = parts;
        if !(position.is_finite() && look_at.is_finite() && up.is_finite()) {
            return Err(CameraError::NotFinite);
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(CameraError::FieldOfView { found: fov });
        }
        if resolution.iter().any(|n| !(1..=Self::MAX_RESOLUTION).contains(n)) {
            return Err(CameraError::Resolution { found: resolution });
        }
        let forward = (look_at - position).try_normalize().ok_or(CameraError::NoDirection)?;
        let up = up.try_normalize().ok_or(CameraError::UpIsParallel)?;
        let side = forward.cross(up);
        // Below this sine the horizon is rounding noise.
        if side.length() < 1e-9 {
            return Err(CameraError::UpIsParallel);
        }
        let right = side.normalize();
        let down = forward.cross(right);
        let pixel = 2.0 * (0.5 * fov.to_radians()).tan() / f64::from(resolution[1]);
        Ok(Self { parts, forward, step_x: pixel * right, step_y: pixel * down })
    }

    /// What the camera was made of.
    pub fn parts(&self) -> CameraParts {
        self.parts
    }

    /// The same view with other pixels; the vertical field of view stays.
    ///
    /// # Errors
    /// [`CameraError::Resolution`].
    pub fn with_resolution(&self, resolution: [u32; 2]) -> Result<Self, CameraError> {
        Self::new(CameraParts { resolution, ..self.parts })
    }

    /// Pixels along image x and y.
    pub fn resolution(&self) -> [u32; 2] {
        self.parts.resolution
    }

    /// The angle between rays through neighbouring pixels in the middle of the image, radian.
    pub(crate) fn pixel_angle(&self) -> f64 {
        self.step_x.length()
    }

    /// The ray through a point of the image in continuous pixel coordinates: (0, 0) is the top
    /// left corner, the centre of pixel (i, j) is (i + 0.5, j + 0.5).
    ///
    /// The direction's part along the view axis is 1, so a hit's `t` is its camera-space depth.
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let [width, height] = self.parts.resolution.map(f64::from);
        let direction =
            self.forward + (x - 0.5 * width) * self.step_x + (y - 0.5 * height) * self.step_y;
        Ray::new(self.parts.position, direction)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parts() -> CameraParts {
        CameraParts {
            position: DVec3::new(1.0, -2.0, 3.0),
            look_at: DVec3::new(1.0, 8.0, 3.0),
            up: DVec3::Z,
            fov: 90.0,
            resolution: [400, 200],
        }
    }

    fn near(a: DVec3, b: DVec3) -> bool {
        (a - b).length() < 1e-12
    }

    #[test]
    fn corner_rays_span_the_field_of_view() {
        let camera = Camera::new(parts()).unwrap();
        // Looking along +y with +z up, the right hand is +x; half height 1, half width 2.
        assert!(near(camera.ray(200.0, 100.0).direction, DVec3::Y));
        assert!(near(camera.ray(0.0, 0.0).direction, DVec3::new(-2.0, 1.0, 1.0)));
        assert!(near(camera.ray(400.0, 0.0).direction, DVec3::new(2.0, 1.0, 1.0)));
        assert!(near(camera.ray(0.0, 200.0).direction, DVec3::new(-2.0, 1.0, -1.0)));
        assert!(near(camera.ray(400.0, 200.0).direction, DVec3::new(2.0, 1.0, -1.0)));
        assert_eq!(camera.ray(3.0, 4.0).origin, DVec3::new(1.0, -2.0, 3.0));
    }

    #[test]
    fn tilted_up_only_turns_the_horizon() {
        let tilted = CameraParts { up: DVec3::new(0.0, 5.0, 2.0), ..parts() };
        let (a, b) = (Camera::new(parts()).unwrap(), Camera::new(tilted).unwrap());
        assert!(near(a.ray(17.0, 150.0).direction, b.ray(17.0, 150.0).direction));
    }

    #[test]
    fn degenerate_parts_are_refused() {
        let refused = |parts| Camera::new(parts).unwrap_err();
        let up = |up| refused(CameraParts { up, ..parts() });
        assert_eq!(up(DVec3::Y), CameraError::UpIsParallel);
        assert_eq!(up(-DVec3::Y), CameraError::UpIsParallel);
        assert_eq!(up(DVec3::ZERO), CameraError::UpIsParallel);
        assert_eq!(up(DVec3::NAN), CameraError::NotFinite);
        let here = CameraParts { look_at: parts().position, ..parts() };
        assert_eq!(refused(here), CameraError::NoDirection);
        for fov in [0.0, 180.0, -3.0, f64::NAN] {
            let error = refused(CameraParts { fov, ..parts() });
            assert!(matches!(error, CameraError::FieldOfView { .. }));
        }
        for resolution in [[0, 4], [4, 0], [70_000, 4]] {
            let error = refused(CameraParts { resolution, ..parts() });
            assert_eq!(error, CameraError::Resolution { found: resolution });
        }
    }
}
