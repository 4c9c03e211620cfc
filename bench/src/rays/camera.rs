//! [`Camera`]: a pinhole.

use glam::DVec3;

use super::Ray32;

/// A pinhole camera with square pixels.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    position: DVec3,
    /// To the middle of the image, one unit away.
    forward: DVec3,
    /// From one pixel to the next.
    right: DVec3,
    down: DVec3,
    /// Pixels a side.
    pub side: u32,
}

impl Camera {
    /// At `position`, looking at `target`, z up, with the vertical field of view `fov` in degrees
    /// and `side` x `side` pixels.
    pub fn new(position: DVec3, target: DVec3, fov: f64, side: u32) -> Self {
        let forward = (target - position).normalize();
        let right = forward.cross(DVec3::Z).normalize();
        let down = forward.cross(right);
        let pixel = 2.0 * (0.5 * fov.to_radians()).tan() / f64::from(side);
        Self { position, forward, right: right * pixel, down: down * pixel, side }
    }

    /// Sees the whole unit square from above, with heights up to `depth`.
    pub fn overview(depth: f64, side: u32) -> Self {
        let target = DVec3::new(0.5, 0.31, 0.5 * depth);
        Self::new(DVec3::new(0.5, -0.5, 1.2 + depth), target, 43.5, side)
    }

    /// The ray through (x, y) in pixels, (0, 0) the upper left corner of the image.
    pub fn ray(&self, x: f64, y: f64) -> Ray32 {
        let middle = 0.5 * f64::from(self.side);
        let through = self.forward + (x - middle) * self.right + (y - middle) * self.down;
        Ray32 {
            origin: self.position.as_vec3().to_array(),
            direction: through.normalize().as_vec3().to_array(),
            t_max: f32::INFINITY,
        }
    }

    /// Where `point` lies in the image, in pixels.
    #[cfg(test)]
    pub fn project(&self, point: DVec3) -> [f64; 2] {
        let to = point - self.position;
        let ahead = to.dot(self.forward);
        [self.right, self.down]
            .map(|axis| 0.5 * f64::from(self.side) + to.dot(axis) / axis.length_squared() / ahead)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rays_go_through_what_is_projected() {
        let camera = Camera::new(DVec3::new(0.5, -1.0, 1.0), DVec3::new(0.5, 0.5, 0.0), 50.0, 64);
        let point = DVec3::new(0.2, 0.7, 0.1);
        let [x, y] = camera.project(point);
        let ray = camera.ray(x, y);
        let direction = DVec3::from(ray.direction.map(f64::from));
        let to = (point - DVec3::new(0.5, -1.0, 1.0)).normalize();
        assert!((direction - to).length() < 1e-6);
        let [_, high] = camera.project(point + DVec3::Z * 0.1);
        assert!(high < y, "the image's y grows downwards");
    }
}
