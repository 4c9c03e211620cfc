//! [`TriangleLight`]: one half of a quad that is no parallelogram, or a triangle of a small mesh,
//! sampled uniformly by area.

use glam::{DVec2, DVec3};

use super::{LightSample, clear_share};
use crate::colour::Rgb;
use crate::sampler::warp::{square_to_triangle, square_to_triangle_pdf};

/// A triangle that emits from the side on which its corners run counter-clockwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TriangleLight {
    corner: DVec3,
    edges: [DVec3; 2],
    /// Unit normal of the front.
    normal: DVec3,
    pub(super) surface: u32,
    emitted: Rgb,
}

impl TriangleLight {
    /// The light of a triangle with these corners.
    pub(super) fn new(corners: [DVec3; 3], surface: u32, emitted: Rgb) -> Self {
        let edges = [corners[1] - corners[0], corners[2] - corners[0]];
        let normal = edges[0].cross(edges[1]).normalize_or_zero();
        Self { corner: corners[0], edges, normal, surface, emitted }
    }

    /// Whether there is a point to sample.
    pub(super) fn has_area(&self) -> bool {
        self.normal != DVec3::ZERO
    }

    /// The corner, the edges from it, the unit normal of the front; zero without area.
    pub(super) fn frame(&self) -> (DVec3, [DVec3; 2], DVec3) {
        (self.corner, self.edges, self.normal)
    }

    /// Radiance sent out.
    pub(super) fn emitted(&self) -> Rgb {
        self.emitted
    }

    /// Density of [`Self::sample`] at a unit direction that meets the front at `distance`, per
    /// steradian.
    pub(super) fn pdf(&self, direction: DVec3, distance: f64) -> f64 {
        let cosine = -direction.dot(self.normal);
        let area = square_to_triangle_pdf(self.edges);
        if cosine > 0.0 { area * distance * distance / cosine } else { 0.0 }
    }

    /// A point of the light; nothing where its front is not seen from `point`.
    pub(super) fn sample(&self, point: DVec3, u: DVec2) -> Option<LightSample> {
        let position = square_to_triangle(u, self.corner, self.edges);
        let way = position - point;
        let distance = way.length();
        let cosine = -way.dot(self.normal) / distance;
        // The cosine is NaN where `point` and `position` are the same.
        if cosine.is_nan() || cosine <= 0.0 {
            return None;
        }
        let pdf = square_to_triangle_pdf(self.edges) * distance * distance / cosine;
        Some(LightSample {
            position,
            direction: way / distance,
            weight: self.emitted / pdf,
            pdf,
            clear: clear_share(point, position, self.normal),
        })
    }
}
