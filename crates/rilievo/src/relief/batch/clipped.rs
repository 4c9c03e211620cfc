//! [`ClippedRays`]: the rays of a batch inside of the face's box, in `f64`.

use glam::DVec3;

use super::super::map_ray::ExactRay;
use super::super::shell::ClippedRay;
use super::BATCH;

/// Numbers of all rays, none yet.
const NONE: [f64; BATCH] = [0.0; BATCH];

/// See [`ClippedRay`].
pub(super) struct ClippedRays {
    pub start: [[f64; BATCH]; 3],
    pub direction: [[f64; BATCH]; 3],
    pub t_start: [f64; BATCH],
    pub t_length: [f64; BATCH],
    pub cull: [[f64; BATCH]; 2],
    pub end: [f64; BATCH],
    /// Added to the height at the start.
    pub lift: [f64; BATCH],
}

impl ClippedRays {
    /// No rays yet.
    #[inline(always)]
    pub fn new() -> Self {
        Self {
            start: [NONE; 3],
            direction: [NONE; 3],
            t_start: NONE,
            t_length: NONE,
            cull: [NONE; 2],
            end: NONE,
            lift: NONE,
        }
    }

    #[inline(always)]
    pub fn set(&mut self, k: usize, ray: &ClippedRay) {
        for axis in 0..3 {
            self.start[axis][k] = ray.start[axis];
            self.direction[axis][k] = ray.direction[axis];
        }
        (self.t_start[k], self.t_length[k]) = (ray.t_start, ray.t_length);
        (self.cull[0][k], self.cull[1][k]) = (ray.cull[0], ray.cull[1]);
        self.end[k] = ray.end;
    }

    /// A ray, unrounded.
    #[inline(always)]
    pub fn exact(&self, k: usize) -> ExactRay {
        ExactRay {
            origin: [self.start[0][k], self.start[1][k], self.start[2][k]],
            direction: [self.direction[0][k], self.direction[1][k], self.direction[2][k]],
            t_start: self.t_start[k],
            t_length: self.t_length[k],
        }
    }
}

/// The vector of a ray.
#[inline(always)]
pub(super) fn at(of: &[[f64; BATCH]; 3], k: usize) -> DVec3 {
    DVec3::new(of[0][k], of[1][k], of[2][k])
}
