//! The first hit of a camera ray, layer by layer.

use glam::DVec3;
use rilievo::{Hit, Ray};

use crate::colour::Rgb;
use crate::film::Aov;
use crate::scene::Scene;

/// The sums over a pixel's samples of one layer.
#[derive(Clone, Copy, Debug)]
pub(super) struct LayerSum {
    sum: DVec3,
    samples: u32,
}

impl LayerSum {
    pub(super) const EMPTY: Self = Self { sum: DVec3::ZERO, samples: 0 };

    /// Adds what a camera ray of the scene met, and the work it took.
    pub(super) fn add(&mut self, aov: Aov, scene: &Scene, hit: Option<&Hit>, work: u64) {
        if let Some(value) = layer_value(aov, scene, hit, work) {
            self.sum += value;
            self.samples += 1;
        }
    }

    /// Writes the mean to the channels of a pixel.
    pub(super) fn store(&self, aov: Aov, channels: &mut [f32]) {
        if self.samples == 0 {
            channels.fill(aov.without_hit());
            return;
        }
        let mean = self.sum / f64::from(self.samples);
        for (channel, value) in channels.iter_mut().zip(mean.to_array()) {
            *channel = value as f32;
        }
    }
}

/// What a layer shows of what a camera ray met, in its first channels, if anything.
pub(super) fn layer_value(aov: Aov, scene: &Scene, hit: Option<&Hit>, work: u64) -> Option<DVec3> {
    match hit {
        Some(hit) => Some(value(aov, scene, hit, work)),
        None if aov == Aov::Steps => Some(DVec3::new(work as f64, 0.0, 0.0)),
        None => None,
    }
}

/// What a layer shows of a hit, in its first channels.
fn value(aov: Aov, scene: &Scene, hit: &Hit, work: u64) -> DVec3 {
    match aov {
        Aov::P => hit.position,
        Aov::N => hit.geometric_normal,
        Aov::Ns => hit.shading_normal,
        Aov::Uv => hit.uv.extend(0.0),
        Aov::Height => DVec3::new(hit.height, 0.0, 0.0),
        Aov::Steps => DVec3::new(work as f64, 0.0, 0.0),
        // Camera rays have length 1 along the view axis, but of a panorama: see `Camera::ray`.
        Aov::Z => DVec3::new(hit.t, 0.0, 0.0),
        Aov::Albedo => albedo(scene, hit),
    }
}

fn albedo(scene: &Scene, hit: &Hit) -> Rgb {
    let material = scene.material(hit.surface);
    material.diffuse.at(hit.uv) + material.reflective
}

/// The colour of the `aov` integrator: the albedo times the cosine between the shading normal and
/// the view direction, or the background.
pub(super) fn headlight(scene: &Scene, ray: &Ray, hit: Option<&Hit>) -> Rgb {
    match hit {
        Some(hit) => albedo(scene, hit) * hit.shading_normal.dot(ray.direction.normalize()).abs(),
        None => scene.sky(ray.direction),
    }
}
