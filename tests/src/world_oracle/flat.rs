//! Triangles and balls, in `f64`.

use glam::DVec3;
use rilievo::Ray;

/// Room for rounding at the edges of triangles, in weights of corners: two that share an edge leave no gap.
const EDGE: f64 = 1e-12;

/// Where a ray meets a triangle, at `0 <= t`: by determinants \[Moeller1997\].
pub fn triangle([a, b, c]: &[DVec3; 3], one_sided: bool, ray: &Ray) -> Option<f64> {
    let (e, f) = (*b - *a, *c - *a);
    let across = ray.direction.cross(f);
    let volume = e.dot(across);
    if volume == 0.0 || one_sided && volume < 0.0 {
        return None;
    }
    let from = ray.origin - *a;
    let v = from.dot(across) / volume;
    let w = ray.direction.dot(from.cross(e)) / volume;
    let t = f.dot(from.cross(e)) / volume;
    (v >= -EDGE && w >= -EDGE && v + w <= 1.0 + EDGE && t >= 0.0).then_some(t)
}

/// Where a ray meets a sphere first, at `0 <= t`.
pub fn sphere(center: DVec3, radius: f64, ray: &Ray) -> Option<f64> {
    // From the point nearest to the centre, so that far origins cost no digits.
    let arm = ray.origin - center;
    let square = ray.direction.length_squared();
    let middle = -arm.dot(ray.direction) / square;
    let nearest = arm + middle * ray.direction;
    let half = ((radius * radius - nearest.length_squared()) / square).sqrt();
    [middle - half, middle + half].into_iter().find(|&t| t >= 0.0)
}
