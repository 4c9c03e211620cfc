//! [`QuadLight`]: a one-sided parallelogram.
//!
//! Rectangles are sampled by solid angle where they lie near enough to look crooked, other
//! parallelograms and far rectangles by area: there the two hardly differ, and the area takes a few
//! operations where the solid angle takes an arc tangent and a dozen roots. Slivers go by area too:
//! the solid angle of one loses its digits.

use glam::{DVec2, DVec3};

use super::rectangle::SphericalRectangle;
use super::{LightSample, clear_share};
use crate::colour::Rgb;
use crate::sampler::warp::square_to_quad;

/// Up to this ratio between the squared distances of its farthest and its nearest point a rectangle
/// is sampled by area: weights, which go as the distance to the power -3, then spread over less
/// than a factor of 2.9, smoothly, and strata take most of that out. Measured on the benchmark scene
/// (16 samples, 512 x 512 map): error 3 % larger than by solid angle everywhere; at a ratio of 2.5 it
/// is 19 % larger, more than the time saved is worth.
const FAR: f64 = 2.0;

/// Below this solid angle, steradian, rectangles are sampled by area.
const SMALL: f64 = 1e-4;

/// A parallelogram that emits from its front.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct QuadLight {
    corner: DVec3,
    edges: [DVec3; 2],
    /// Lengths of the edges.
    lengths: [f64; 2],
    /// Unit vectors along the edges.
    along: [DVec3; 2],
    pub(super) rectangular: bool,
    area: f64,
    /// Unit normal of the front.
    normal: DVec3,
    pub(crate) surface: u32,
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
        let across = edges[0].cross(edges[1]);
        let lengths = edges.map(DVec3::length);
        Self {
            corner: corners[0],
            edges,
            lengths,
            along: edges.map(DVec3::normalize_or_zero),
            rectangular: edges[0].dot(edges[1]).abs() <= 1e-12 * lengths[0] * lengths[1],
            area: across.length(),
            normal: across.normalize_or_zero(),
            surface,
            emitted,
        }
    }

    /// Area, square scene units.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// How to sample it from `point`; nothing where its front is not seen.
    #[inline]
    pub(super) fn view(&self, point: DVec3) -> Option<QuadView> {
        let way = self.corner - point;
        let distance = -way.dot(self.normal);
        if distance <= 0.0 {
            return None;
        }
        if !self.rectangular {
            return Some(QuadView::Area);
        }
        let (start_x, start_y) = (way.dot(self.along[0]), way.dot(self.along[1]));
        let x = [start_x, start_x + self.lengths[0]];
        let y = [start_y, start_y + self.lengths[1]];
        let nearest = |[low, high]: [f64; 2]| low.max(-high).max(0.0);
        let farthest = |[low, high]: [f64; 2]| high.max(-low);
        let squared = |x: f64, y: f64| x * x + y * y + distance * distance;
        if squared(farthest(x), farthest(y)) <= FAR * squared(nearest(x), nearest(y)) {
            return Some(QuadView::Area);
        }
        let rectangle = SphericalRectangle::new(x, y, distance);
        let large = rectangle.solid_angle() >= SMALL;
        Some(if large { QuadView::Solid(rectangle) } else { QuadView::Area })
    }

    /// Density of [`Self::sample`] at a unit direction that meets the front at `distance`, per
    /// steradian.
    pub(super) fn pdf(&self, view: &QuadView, direction: DVec3, distance: f64) -> f64 {
        match view {
            QuadView::Area => {
                let cosine = -direction.dot(self.normal);
                if cosine > 0.0 { distance * distance / (self.area * cosine) } else { 0.0 }
            }
            QuadView::Solid(rectangle) => rectangle.solid_angle().recip(),
        }
    }

    /// The point at a place of the unit square.
    pub(super) fn at(&self, uv: DVec2) -> DVec3 {
        square_to_quad(uv, self.corner, self.edges)
    }

    /// The place in the unit square that [`Self::sample`] takes.
    pub(super) fn place(&self, view: &QuadView, u: DVec2) -> DVec2 {
        match view {
            QuadView::Area => u,
            QuadView::Solid(rectangle) => rectangle.sample(u) / DVec2::from(self.lengths),
        }
    }

    /// The corner, the edges from it, the unit normal of the front.
    pub(super) fn frame(&self) -> (DVec3, [DVec3; 2], DVec3) {
        (self.corner, self.edges, self.normal)
    }

    /// Radiance sent out.
    pub(super) fn emitted(&self) -> Rgb {
        self.emitted
    }

    /// A point of the light, sampled as `view` says.
    #[inline]
    pub(super) fn sample(&self, point: DVec3, view: &QuadView, u: DVec2) -> Option<LightSample> {
        let position = match view {
            QuadView::Area => square_to_quad(u, self.corner, self.edges),
            QuadView::Solid(rectangle) => {
                let [x, y] = self.along;
                let place = rectangle.sample(u);
                self.corner + place.x * x + place.y * y
            }
        };
        let way = position - point;
        let inverse = way.length().recip();
        let cosine = -way.dot(self.normal) * inverse;
        // Rounding may turn a grazing light away; the cosine is NaN at a distance of 0.
        if cosine.is_nan() || cosine <= 0.0 {
            return None;
        }
        let solid_angle = match view {
            QuadView::Area => self.area * cosine * inverse * inverse,
            QuadView::Solid(rectangle) => rectangle.solid_angle(),
        };
        Some(LightSample {
            position,
            direction: way * inverse,
            weight: self.emitted * solid_angle,
            pdf: solid_angle.recip(),
            clear: clear_share(point, position, self.normal),
        })
    }
}
