//! [`QuadLight`]: a one-sided parallelogram, sampled uniformly by area.

use glam::{DVec2, DVec3};

use super::{LightSample, clear_share};
use crate::colour::Rgb;
use crate::sampler::warp::{square_to_quad, square_to_quad_pdf};

/// A parallelogram that emits from its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadLight {
    corner: DVec3,
    edges: [DVec3; 2],
    /// Unit normal of the front.
    normal: DVec3,
    pub(super) surface: u32,
    emitted: Rgb,
}

impl QuadLight {
    /// The light of a quad with these corners (u runs c0 to c1, v runs c0 to c3).
    pub(super) fn new(corners: [DVec3; 4], surface: u32, emitted: Rgb) -> Self {
        let edges = [corners[1] - corners[0], corners[3] - corners[0]];
        let normal = edges[0].cross(edges[1]).normalize_or_zero();
        Self { corner: corners[0], edges, normal, surface, emitted }
    }

    /// Area, square scene units.
    pub fn area(&self) -> f64 {
        self.edges[0].cross(self.edges[1]).length()
    }

    pub(super) fn sample(&self, point: DVec3, u: DVec2) -> Option<LightSample> {
        let position = square_to_quad(u, self.corner, self.edges);
        let way = position - point;
        let distance = way.length();
        let cosine = -way.dot(self.normal) / distance;
        // The cosine is NaN where `point` and `position` are the same.
        if cosine.is_nan() || cosine <= 0.0 {
            return None;
        }
        let pdf = square_to_quad_pdf(self.edges) * distance * distance / cosine;
        Some(LightSample {
            position,
            direction: way / distance,
            weight: self.emitted / pdf,
            clear: clear_share(point, position, self.normal),
        })
    }
}
