//! A picture of positions, by the oracle: one ray through each pixel's centre.

use glam::{DVec2, DVec3};
use rayon::prelude::*;
use rilievo::Ray;

use crate::nudge::nudged;
use crate::oracle::Oracle;

/// A pinhole camera as scene files describe it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The pinhole.
    pub position: DVec3,
    /// A point on the optical axis.
    pub look_at: DVec3,
    /// Upwards; any vector not along the axis.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov: f64,
    /// Pixels, width and height.
    pub resolution: [u32; 2],
}

impl Camera {
    /// The ray through the centre of pixel (i, j), row 0 at the top.
    pub fn ray(&self, i: u32, j: u32) -> Ray {
        let [width, height] = self.resolution.map(f64::from);
        let forward = (self.look_at - self.position).normalize();
        let right = forward.cross(self.up).normalize();
        let up = right.cross(forward);
        let half = (0.5 * self.fov.to_radians()).tan();
        let x = (2.0 * (f64::from(i) + 0.5) - width) / height * half;
        let y = (height - 2.0 * (f64::from(j) + 0.5)) / height * half;
        Ray::new(self.position, (forward + x * right + y * up).normalize())
    }

    fn rays(&self) -> Vec<Ray> {
        let [width, height] = self.resolution;
        (0..height).flat_map(|j| (0..width).map(move |i| self.ray(i, j))).collect()
    }
}

fn nearest(faces: &[Oracle<'_>], ray: &Ray) -> Option<DVec3> {
    faces
        .iter()
        .filter_map(|face| face.closest(ray))
        .min_by(|a, b| a.t.total_cmp(&b.t))
        .map(|hit| hit.position)
}

/// The nearest point of `faces` behind every pixel's centre, row by row from the top.
pub fn oracle_image(camera: &Camera, faces: &[Oracle<'_>]) -> Vec<Option<DVec3>> {
    camera.rays().par_iter().map(|ray| nearest(faces, ray)).collect()
}

/// How a picture of positions differs from the oracle's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageReport {
    /// Pixels of the picture.
    pub pixels: usize,
    /// Pixels with a hit, by the oracle.
    pub hits: usize,
    /// Misses where the oracle hits.
    pub missed: usize,
    /// Hits where the oracle misses.
    pub false_hits: usize,
    /// Hits elsewhere.
    pub misplaced: usize,
    /// Differences that a nudge explains; in none of the counts above.
    pub excused: usize,
    /// Largest distance between two hits that count as equal, scene units.
    pub largest_distance: f64,
    /// The first wrong pixels.
    pub examples: Vec<[u32; 2]>,
}

impl ImageReport {
    /// Whether no pixel is wrong.
    pub fn passed(&self) -> bool {
        self.missed + self.false_hits + self.misplaced == 0
    }
}

/// Compares the positions of `image`, row by row from the top, with the oracle's; `tolerance` is
/// a distance in scene units.
///
/// # Panics
/// If `image` is not of the camera's size.
pub fn compare_image(
    camera: &Camera,
    faces: &[Oracle<'_>],
    image: &[Option<DVec3>],
    tolerance: f64,
) -> ImageReport {
    let rays = camera.rays();
    assert_eq!(image.len(), rays.len(), "an image of the camera's size");
    let judged = oracle_image(camera, faces);
    let mut report = ImageReport { pixels: rays.len(), ..ImageReport::default() };
    let same = |a: &Option<DVec3>, b: &Option<DVec3>| match (a, b) {
        (Some(a), Some(b)) => a.distance(*b) <= tolerance,
        (None, None) => true,
        _ => false,
    };
    for (at, ray) in rays.iter().enumerate() {
        let (found, judge) = (&image[at], &judged[at]);
        report.hits += usize::from(judge.is_some());
        if same(found, judge) {
            if let (Some(a), Some(b)) = (found, judge) {
                report.largest_distance = report.largest_distance.max(a.distance(*b));
            }
            continue;
        }
        let normal = faces.first().map_or(DVec3::Z, Oracle::normal);
        let towards = found.map(|point| point - ray.origin);
        let mut turned = nudged(ray.direction, towards, normal);
        if turned.any(|direction| same(found, &nearest(faces, &Ray { direction, ..*ray }))) {
            report.excused += 1;
            continue;
        }
        match (found, judge) {
            (None, _) => report.missed += 1,
            (_, None) => report.false_hits += 1,
            _ => report.misplaced += 1,
        }
        if report.examples.len() < 16 {
            let width = camera.resolution[0] as usize;
            report.examples.push([(at % width) as u32, (at / width) as u32]);
        }
    }
    report
}

/// Where a world point appears, in pixels from the top left corner; the inverse of
/// [`Camera::ray`] for points in front of the camera.
pub fn project(camera: &Camera, point: DVec3) -> DVec2 {
    let [width, height] = camera.resolution.map(f64::from);
    let forward = (camera.look_at - camera.position).normalize();
    let right = forward.cross(camera.up).normalize();
    let up = right.cross(forward);
    let d = point - camera.position;
    let per_unit = 0.5 * height / (0.5 * camera.fov.to_radians()).tan() / d.dot(forward);
    DVec2::new(0.5 * width + d.dot(right) * per_unit, 0.5 * height - d.dot(up) * per_unit)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scenes;

    fn camera() -> Camera {
        Camera {
            position: DVec3::new(0.5, -1.4, 1.3),
            look_at: DVec3::new(0.5, 0.5, 0.0),
            up: DVec3::Z,
            fov: 40.0,
            resolution: [48, 36],
        }
    }

    #[test]
    fn the_oracle_equals_itself_and_a_moved_picture_does_not() {
        let scene = scenes::named("fbm 64, Vertex Repeat, unit");
        let faces = [scene.oracle()];
        let image = oracle_image(&camera(), &faces);
        let same = compare_image(&camera(), &faces, &image, 1e-5);
        assert!(same.passed() && same.hits > 200 && same.excused == 0, "{same:?}");
        let mut moved = image;
        moved.rotate_right(1);
        let moved = compare_image(&camera(), &faces, &moved, 1e-5);
        assert!(moved.misplaced > 200 && moved.missed > 0 && moved.false_hits > 0, "{moved:?}");
    }

    #[test]
    fn rays_go_through_the_centres_of_their_pixels() {
        let camera = camera();
        for [i, j] in [[0, 0], [47, 0], [13, 35], [24, 18]] {
            let back = project(&camera, camera.ray(i, j).at(3.0));
            let centre = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
            assert!(back.distance(centre) < 1e-9, "{back} against {centre}");
        }
    }
}
