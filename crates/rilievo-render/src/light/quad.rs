//! [`QuadLight`]: a one-sided parallelogram.
//!
//! Rectangles are sampled by solid angle where they look large, other parallelograms and small
//! rectangles by area: there the two hardly differ, and the solid angle loses its digits.

use glam::{DVec2, DVec3};

use super::rectangle::SphericalRectangle;
use super::{LightSample, clear_share};
use crate::colour::Rgb;
use crate::sampler::warp::{square_to_quad, square_to_quad_pdf};

/// Below this solid angle, steradian, rectangles are sampled by area.
const SMALL: f64 = 1e-4;

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

/// How a quad light is sampled from a point in front of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum QuadView {
    /// By area.
    Area,
    /// By solid angle.
    Solid(SphericalRectangle),
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

    /// How to sample it from `point`; nothing where its front is not seen.
    pub(super) fn view(&self, point: DVec3) -> Option<QuadView> {
        let way = self.corner - point;
        let distance = -way.dot(self.normal);
        if distance <= 0.0 {
            return None;
        }
        let lengths = self.edges.map(DVec3::length);
        if self.edges[0].dot(self.edges[1]).abs() > 1e-12 * lengths[0] * lengths[1] {
            return Some(QuadView::Area);
        }
        let [x, y] = [0, 1].map(|i| {
            let start = way.dot(self.edges[i]) / lengths[i];
            [start, start + lengths[i]]
        });
        let rectangle = SphericalRectangle::new(x, y, distance);
        let large = rectangle.solid_angle() >= SMALL;
        Some(if large { QuadView::Solid(rectangle) } else { QuadView::Area })
    }

    /// A point of the light, sampled as `view` says.
    pub(super) fn sample(&self, point: DVec3, view: &QuadView, u: DVec2) -> Option<LightSample> {
        let position = match view {
            QuadView::Area => square_to_quad(u, self.corner, self.edges),
            QuadView::Solid(rectangle) => {
                let place = rectangle.sample(u);
                let [x, y] = self.edges.map(DVec3::normalize_or_zero);
                self.corner + place.x * x + place.y * y
            }
        };
        let way = position - point;
        let distance = way.length();
        let cosine = -way.dot(self.normal) / distance;
        // Rounding may turn a grazing light away; the cosine is NaN at a distance of 0.
        if cosine.is_nan() || cosine <= 0.0 {
            return None;
        }
        let pdf = match view {
            QuadView::Area => square_to_quad_pdf(self.edges) * distance * distance / cosine,
            QuadView::Solid(rectangle) => 1.0 / rectangle.solid_angle(),
        };
        Some(LightSample {
            position,
            direction: way / distance,
            weight: self.emitted / pdf,
            clear: clear_share(point, position, self.normal),
        })
    }
}
