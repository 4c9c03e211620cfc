//! [`MovingInstance`]: a surface that is somewhere else at every time.
//!
//! A ray has a time, and meets the surface where it then is: it is brought into the frame of the
//! prototype by the place of that time, and hits are brought back by the same. So a hit is that of an
//! [`Instance`](super::Instance) in that place, bit for bit, and all that holds of those holds at each time: origins of
//! rays, bounds of errors.
//!
//! The world's tree knows one box, around the surface at all times. Proof that [`MovingInstance::bounds`]
//! is such a box. At any time the surface lies in the hull of the eight corners of its prototype's box,
//! moved. A coordinate of a corner at time s is `a + b s + c cos(w s) + d sin(w s)`, w the angle and
//! `c^2 + d^2 <= r^2`, r the corner's distance from the axis. Over a span of length h it departs from
//! the straight line between the ends of the span by at most `h^2 / 8` times its largest second
//! derivative, `w^2 r`, and never by more than `2 r`, the extent of its circle. That line lies in the box of both ends. So the box of all
//! corners at the ends of all spans, grown by the smaller of the two, holds the corners at all times.
//! What is rounded is bounded by [`GROWTH`] of all that is added up; an angle is rounded by its last
//! bit, which moves a corner by that times r.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use crate::accel::{Aabb, GROWTH};
use crate::hit::Hit;
use crate::mesh::departure::Shell;

use crate::ray::Ray;

use super::place::{Place, corners};
use super::{InstanceError, Motion, Surface};

/// Spans for each radian: the box is too large by up to 1/2048 of the largest circle.
const SPANS: f64 = 16.0;

/// Most spans.
const MOST_SPANS: f64 = 4096.0;

/// A prototype, where it stands at time 0 and how it goes on from there.
#[derive(Clone, Debug)]
pub struct MovingInstance {
    prototype: Arc<Surface>,
    begin: DAffine3,
    motion: Motion,
}

impl MovingInstance {
    /// Moves a surface from `world_from_local`, where it stands at time 0, by a motion of the world. That of an instance moves the same
    /// prototype.
    ///
    /// # Errors
    /// [`InstanceError`] for a transform that cannot be undone, a motion out of range, and a prototype that moves
    /// already.
    pub fn new(
        prototype: Arc<Surface>,
        world_from_local: DAffine3,
        motion: Motion,
    ) -> Result<Self, InstanceError> {
        match prototype.as_ref() {
            Surface::Instance(inner) => {
                let begin = world_from_local * *inner.world_from_local();
                Self::new(Arc::clone(inner.prototype()), begin, motion)
            }
            Surface::Moving(_) => Err(InstanceError::Moving),
            _ => {
                let motion = motion.checked()?;
                let begin = Place::new(world_from_local)?.world_from_local;
                let moving = Self { prototype, begin, motion };
                // At the end, too, numbers are within the limit.
                Place::new(moving.world_from_local(1.0))?;
                Ok(moving)
            }
        }
    }

    /// The surface shown.
    pub fn prototype(&self) -> &Arc<Surface> {
        &self.prototype
    }

    /// How it moves; its axis has length 1.
    pub fn motion(&self) -> &Motion {
        &self.motion
    }

    /// Where it stands at a time from 0 to 1.
    pub fn world_from_local(&self, time: f64) -> DAffine3 {
        self.motion.now_from_begin(time) * self.begin
    }

    #[inline]
    pub(super) fn place(&self, time: f64) -> Place {
        Place::unchecked(self.world_from_local(time))
    }

    /// A ray in the frame of the prototype, which is where the ray's time says; the parameter stays.
    pub fn local_ray(&self, ray: &Ray) -> Ray {
        self.place(ray.time).local_ray(ray)
    }

    /// A hit of the prototype, in the world at a time.
    pub fn world_hit(&self, hit: Hit, time: f64) -> Hit {
        Hit { time, ..self.place(time).world_hit(hit) }
    }

    /// A box around the surface at all times.
    pub fn bounds(&self) -> Aabb {
        let local = self.prototype.bounds();
        if local.is_empty() {
            return local;
        }
        let Motion { translation, pivot, angle, .. } = self.motion;
        let spans = (SPANS * angle.abs()).ceil().clamp(1.0, MOST_SPANS);
        let places = (0..=spans as u32).map(|k| self.place(f64::from(k) / spans));
        let ends = Aabb::around(places.flat_map(|place| place.corners(&local)));
        let begin = corners(&local).map(|p| self.begin.transform_point3(p));
        let arm = begin.into_iter().map(|p| self.motion.arm(p)).fold(0.0, f64::max);
        let bend = (angle / spans).powi(2) / 8.0;
        let added = ends.largest_coordinate()
            + Place::unchecked(self.begin).reach(&local)
            + pivot.abs().max_element()
            + translation.abs().max_element();
        ends.grown(arm * (bend.min(2.0) + 4.0 * f64::EPSILON * angle.abs()) + GROWTH * added)
    }
}

impl Shell for MovingInstance {
    /// The corners of its prototype's box at that time.
    fn hull(&self, time: f64) -> [DVec3; 8] {
        self.place(time).corners(&self.prototype.bounds())
    }
}

#[cfg(test)]
mod tests;
