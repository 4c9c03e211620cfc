//! [`Motion`]: a rigid motion over the time from 0 to 1.

use glam::{DAffine3, DMat3, DVec3};

use crate::mesh::COORDINATE_LIMIT;

use super::InstanceError;

/// A turn about an axis through a pivot that moves along a straight line, both at an even speed. Sizes
/// stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// How far the pivot has gone at time 1, scene units.
    pub translation: DVec3,
    /// A point on the axis at time 0, scene units.
    pub pivot: DVec3,
    /// Direction of the axis: any length but zero where there is an angle.
    pub axis: DVec3,
    /// Turned at time 1, radian, counter-clockwise seen against the axis; more than a whole turn goes
    /// round more than once. Up to [`Motion::MOST`].
    pub angle: f64,
}

impl Motion {
    /// Largest angle, radian: some 1600 turns.
    pub const MOST: f64 = 1e4;

    /// The straight way along `translation`.
    pub fn along(translation: DVec3) -> Self {
        Self { translation, pivot: DVec3::ZERO, axis: DVec3::Z, angle: 0.0 }
    }

    /// The motion with an axis of length 1.
    ///
    /// # Errors
    /// [`InstanceError`] for numbers out of range.
    pub(super) fn checked(self) -> Result<Self, InstanceError> {
        let Self { translation, pivot, axis, angle } = self;
        // Negated, so that NaN is refused.
        let wild = |p: DVec3| !p.abs().cmple(DVec3::splat(COORDINATE_LIMIT)).all();
        if [translation, pivot, axis].into_iter().any(wild) || !angle.is_finite() {
            return Err(InstanceError::NotFinite);
        }
        if angle.abs() > Self::MOST {
            return Err(InstanceError::TooFar);
        }
        match axis.try_normalize() {
            Some(axis) => Ok(Self { axis, ..self }),
            None if angle == 0.0 => Ok(Self { axis: DVec3::Z, ..self }),
            None => Err(InstanceError::NoAxis),
        }
    }

    /// The same motion of a world that stands elsewhere by a transform that keeps shapes: turns, one
    /// scale for all axes, mirrors.
    #[must_use]
    pub fn placed(&self, world_from_local: &DAffine3) -> Self {
        let linear = world_from_local.matrix3;
        Self {
            translation: linear * self.translation,
            pivot: world_from_local.transform_point3(self.pivot),
            axis: linear * self.axis,
            // A mirror turns the other way about the image of the axis.
            angle: self.angle * linear.determinant().signum(),
        }
    }

    /// From where things are at time 0 to where they are at a time, of a motion whose axis has length 1.
    /// Times before 0 and after 1 are those.
    pub(super) fn now_from_begin(&self, time: f64) -> DAffine3 {
        // NaN is 0.
        let time = if time > 0.0 { time.min(1.0) } else { 0.0 };
        let turn = DMat3::from_axis_angle(self.axis, time * self.angle);
        let shift = self.pivot + time * self.translation - turn * self.pivot;
        DAffine3 { matrix3: turn, translation: shift }
    }

    /// How far a point is from the axis at time 0, scene units.
    pub(super) fn arm(&self, point: DVec3) -> f64 {
        self.axis.cross(point - self.pivot).length()
    }
}
