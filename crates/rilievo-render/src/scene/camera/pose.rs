//! [`Pose`]: where a camera is and looks.

use glam::DVec3;

use super::CameraError;

/// Where a camera is and where it looks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// The pinhole, world space, scene units.
    pub position: DVec3,
    /// A point on the view axis.
    pub look_at: DVec3,
    /// A direction whose projection points up in the image; any length but zero.
    pub up: DVec3,
}

impl Pose {
    pub(super) fn is_finite(&self) -> bool {
        self.position.is_finite() && self.look_at.is_finite() && self.up.is_finite()
    }

    /// The pose a share of the way to another: each point on its own straight line, so that what
    /// both look at stays in the middle of the image.
    pub(super) fn towards(self, end: Self, share: f64) -> Self {
        let between = |a: DVec3, b: DVec3| a + share * (b - a);
        Self {
            position: between(self.position, end.position),
            look_at: between(self.look_at, end.look_at),
            up: between(self.up, end.up),
        }
    }
}

/// A pose as rays need it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Frame {
    pub position: DVec3,
    /// Unit view axis.
    pub forward: DVec3,
    /// Image x per pixel on the plane one unit in front of the pinhole.
    pub step_x: DVec3,
    /// Image y (down) per pixel on that plane.
    pub step_y: DVec3,
    /// The length of both.
    pixel: f64,
}

impl Frame {
    /// The frame of a pose, for pixels of so large a side on the plane one unit away.
    pub fn new(pose: Pose, pixel: f64) -> Result<Self, CameraError> {
        let Pose { position, look_at, up } = pose;
        let forward = (look_at - position).try_normalize().ok_or(CameraError::NoDirection)?;
        let up = up.try_normalize().ok_or(CameraError::UpIsParallel)?;
        let side = forward.cross(up);
        // Below this sine the horizon is rounding noise.
        if side.length() < 1e-9 {
            return Err(CameraError::UpIsParallel);
        }
        let right = side.normalize();
        let down = forward.cross(right);
        Ok(Self { position, forward, step_x: pixel * right, step_y: pixel * down, pixel })
    }

    /// Unit vector to the right of the image.
    pub fn right(&self) -> DVec3 {
        self.step_x / self.pixel
    }

    /// Unit vector down the image.
    pub fn down(&self) -> DVec3 {
        self.step_y / self.pixel
    }
}
