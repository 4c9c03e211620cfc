//! The paper's ray tracer: Whitted's recursion \[Whitted1980\] with distributed samples \[Cook1984\].
//!
//! The radiance that leaves a hit towards the viewer is
//!
//! `emitted + diffuse * (ambient + sum over lights of E / pi + B) + reflective * R`
//!
//! with `E` the irradiance from a light, estimated by `shadow_samples` stratified points of it with
//! their visibility, `B` the irradiance over pi that does not come straight from lights, estimated
//! by `diffuse_samples` bounce rays of cosine-weighted directions, and `R` the mean radiance around the mirror direction, over the lobe of
//! [`warp::square_to_visible_normal`] (`alpha = roughness^2`). A mirror takes one ray; a glossy
//! first hit takes `glossy_samples` and a diffuse one `diffuse_samples`; later hits take one of
//! each, so that the tree of rays grows with the depth only linearly if surfaces are of one kind.
//! Lights show in glossy surfaces because reflection rays meet them; a bounce ray that meets a light
//! brings nothing from it, `E` has counted it.
//!
//! Left out, as in the paper, while `diffuse_samples` is 0: diffuse interreflection, light from the
//! background, from emitters that are no lights, and from mirrors onto diffuse surfaces.
//!
//! Two normals: the geometric one decides on which side of the surface a direction lies and rays
//! are spawned by it; the shading one weighs light and carries the lobe. A reflected direction that
//! falls below the surface is mirrored back above it.
//!
//! The recursion is unrolled: a [`Branch`] of the tree is a ray that still has to be traced and what its radiance counts in
//! the pixel. [`Distributed::grow`] shades a hit and hands the rays it spawns to a [`Sink`], which keeps them until those of
//! a few camera rays (`trees.rs`) or of very many (`wave.rs`) can be traced together.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use rilievo::{Hit, Ray};

use super::RayCounts;
use crate::bsdf::widened;
use crate::colour::Rgb;
use crate::level_of_detail::Detail;
use crate::light::{Light, QuadLight, SphereLight};
use crate::sampler::{Dimension, PixelTable, Strand, warp};
use crate::scene::{Material, Scene};

/// A place in the tree of rays of a pixel.
#[derive(Clone, Copy)]
pub(super) struct Path {
    /// Which of the pixel's paths it is.
    pub(super) strand: Strand,
    /// Bounces before.
    pub(super) depth: u32,
    /// Whether the last bounce was diffuse: the light of lights is counted then.
    lit: bool,
}

impl Path {
    /// The path of a camera ray.
    pub(super) fn from_camera(strand: Strand) -> Self {
        Self { strand, depth: 0, lit: false }
    }
}

/// A ray of the tree that is to be traced.
#[derive(Clone, Copy)]
pub(super) struct Branch {
    pub(super) ray: Ray,
    path: Path,
    /// What its radiance counts in the camera ray's.
    weight: Rgb,
}

impl Branch {
    /// The root of a tree.
    pub(super) fn root(ray: Ray, strand: Strand) -> Self {
        Self { ray, path: Path::from_camera(strand), weight: Rgb::ONE }
    }
}

/// Takes what becomes of a branch.
pub(super) trait Sink {
    /// Radiance against the camera ray.
    fn bring(&mut self, radiance: Rgb);

    /// Radiance against the camera ray, if the shadow ray meets nothing but `exempt`, the light at its end.
    fn ask(&mut self, shadow: Ray, exempt: Option<u32>, radiance: Rgb);

    /// A branch that grows from this one.
    fn spawn(&mut self, branch: Branch);
}

/// Rays with which a path goes on from a hit.
#[derive(Clone, Copy)]
struct Split {
    reflection: u32,
    diffuse: u32,
}

impl Split {
    /// All of them: each continues a strand of its own.
    fn total(self) -> u32 {
        self.reflection + self.diffuse
    }
}

/// A hit to be shaded: with the normals turned to the side the viewer is on.
struct Facing<'a> {
    hit: &'a Hit,
    /// The path that came there.
    path: Path,
    geometric: DVec3,
    shading: DVec3,
}

impl<'a> Facing<'a> {
    fn of(hit: &'a Hit, path: Path) -> Self {
        let sign = if hit.front { 1.0 } else { -1.0 };
        let [geometric, shading] = [hit.geometric_normal, hit.shading_normal].map(|n| sign * n);
        Self { hit, path, geometric, shading }
    }
}

/// Grows the trees of rays of one pixel.
pub(super) struct Distributed<'a> {
    pub(super) scene: &'a Scene,
    /// The world that is traced.
    pub(super) detail: Detail<'a>,
    /// At that pixel.
    pub(super) table: &'a mut PixelTable,
    pub(super) rays: &'a mut RayCounts,
}

impl Distributed<'_> {
    /// What becomes of a branch, given what its ray meets.
    pub(super) fn grow(&mut self, branch: &Branch, hit: Option<&Hit>, sink: &mut impl Sink) {
        let Branch { ray, path, weight } = *branch;
        let Some(hit) = hit else {
            return sink.bring(weight * self.escaped(&ray, path));
        };
        let material = self.scene.material(hit.surface);
        let facing = Facing::of(hit, path);
        if hit.front && material.emits() && !(path.lit && self.scene.is_light(hit.surface)) {
            sink.bring(weight * material.emitted_at(hit.uv));
        }
        let diffuse = material.diffuse.at(hit.uv);
        let split = self.split(material, diffuse, path);
        if diffuse != Rgb::ZERO {
            let weight = weight * diffuse;
            sink.bring(weight * self.scene.ambient());
            self.light(&facing, weight * FRAC_1_PI, sink);
            if split.diffuse > 0 {
                self.bounce(&facing, split, weight, sink);
            }
        }
        if split.reflection > 0 {
            let view = -ray.direction.normalize();
            let lost = self.detail.lost_slopes(hit);
            let alpha = widened(material.roughness * material.roughness, lost);
            let weight = weight * material.reflective;
            self.reflect(&facing, (view, alpha), (split, weight), sink);
        }
    }

    /// Radiance that arrives against `ray`, which meets nothing. Suns are lights: to a diffuse bounce
    /// they bring nothing.
    fn escaped(&self, ray: &Ray, path: Path) -> Rgb {
        let mut radiance = self.scene.sky(ray.direction);
        if !path.lit {
            for light in self.scene.lights() {
                if let Light::Sun(sun) = light {
                    radiance += sun.radiance(ray.direction.normalize());
                }
            }
        }
        radiance
    }

    /// How the path goes on from a hit.
    fn split(&self, material: &Material, diffuse: Rgb, path: Path) -> Split {
        let settings = self.scene.settings();
        if path.depth >= settings.max_depth {
            return Split { reflection: 0, diffuse: 0 };
        }
        let first = path.depth == 0;
        let reflection = match (material.reflective != Rgb::ZERO, material.roughness > 0.0) {
            (false, _) => 0,
            (true, true) if first => settings.glossy_samples,
            (true, _) => 1,
        };
        let diffuse = match diffuse != Rgb::ZERO {
            false => 0,
            true if first => settings.diffuse_samples,
            true => settings.diffuse_samples.min(1),
        };
        Split { reflection, diffuse }
    }

    /// Branches over the cosine-weighted hemisphere, for all but what comes straight from lights: the mean of their
    /// radiance counts `weight`.
    fn bounce(&mut self, facing: &Facing<'_>, split: Split, weight: Rgb, sink: &mut impl Sink) {
        let path = facing.path;
        let dimension = Dimension::Bounce { depth: path.depth };
        let (right, up) = facing.shading.any_orthonormal_pair();
        let weight = weight / f64::from(split.diffuse);
        for branch in 0..split.diffuse {
            let u = self.table.point(dimension, path.strand.split(branch, split.diffuse));
            let local = warp::square_to_hemisphere(u);
            let direction = local.x * right + local.y * up + local.z * facing.shading;
            // Like light from there: below the surface there is none.
            if direction.dot(facing.geometric) <= 0.0 {
                continue;
            }
            self.rays.diffuse += 1;
            let strand = path.strand.split(split.reflection + branch, split.total());
            let path = Path { strand, depth: path.depth + 1, lit: true };
            sink.spawn(Branch { ray: facing.hit.spawn(direction), path, weight });
        }
    }

    /// Shadow rays to all lights on the viewer's side of the surface: the irradiance that they find, W/m^2, counts
    /// `weight`.
    fn light(&mut self, facing: &Facing<'_>, weight: Rgb, sink: &mut impl Sink) {
        for (index, light) in self.scene.lights().iter().enumerate() {
            // A flat quad or a sphere cannot light itself.
            if light.surface() != Some(facing.hit.surface) {
                self.light_from((light, index as u32), facing, weight, sink);
            }
        }
    }

    fn light_from(
        &mut self,
        (light, index): (&Light, u32),
        facing: &Facing<'_>,
        weight: Rgb,
        sink: &mut impl Sink,
    ) {
        let Facing { hit, path, .. } = *facing;
        let Some(view) = light.view(hit.position) else { return };
        let count = self.scene.settings().shadow_samples;
        let dimension = Dimension::Light { depth: path.depth, light: index };
        // No other part of a quad or a sphere is in the way of what is seen of it.
        let exempt = match light {
            Light::Quad(QuadLight { surface, .. }) | Light::Sphere(SphereLight { surface, .. }) => {
                Some(*surface)
            }
            Light::Triangle(_) | Light::Point(_) | Light::Sun(_) => None,
        };
        let weight = weight / f64::from(count);
        for k in 0..count {
            let u = self.table.point(dimension, path.strand.split(k, count));
            let Some(sample) = view.sample(u) else {
                continue;
            };
            let cosine = sample.direction.dot(facing.shading);
            if cosine <= 0.0 || sample.direction.dot(facing.geometric) <= 0.0 {
                continue;
            }
            self.rays.shadow += 1;
            let way = hit.spawn(sample.position - hit.position);
            let shadow = Ray { t_max: sample.clear, ..way };
            sink.ask(shadow, exempt, weight * (cosine * sample.weight));
        }
    }

    /// Branches over the lobe around the mirror direction, seen from direction `view`: the mean of their radiance
    /// counts `weight`.
    fn reflect(
        &mut self,
        facing: &Facing<'_>,
        (view, alpha): (DVec3, f64),
        (split, weight): (Split, Rgb),
        sink: &mut impl Sink,
    ) {
        let path = facing.path;
        let (glossy, count) = (alpha > 0.0, split.reflection);
        let dimension = Dimension::Gloss { depth: path.depth };
        let normal = visible_shading_normal([facing.geometric, facing.shading], view);
        let (right, up) = normal.any_orthonormal_pair();
        let local_view = DVec3::new(view.dot(right), view.dot(up), view.dot(normal).max(0.0));
        let weight = weight / f64::from(count);
        for branch in 0..count {
            let facet = if glossy {
                let u = self.table.point(dimension, path.strand.split(branch, count));
                let m = warp::square_to_visible_normal(u, local_view, alpha);
                m.x * right + m.y * up + m.z * normal
            } else {
                normal
            };
            let reflected = 2.0 * view.dot(facet) * facet - view;
            self.rays.reflection += 1;
            let strand = path.strand.split(branch, split.total());
            let path = Path { strand, depth: path.depth + 1, lit: false };
            let ray = facing.hit.spawn(above(reflected, facing.geometric));
            sink.spawn(Branch { ray, path, weight });
        }
    }
}

/// The shading normal, tilted to a right angle with `view` if the viewer sees it from behind.
fn visible_shading_normal([geometric, shading]: [DVec3; 2], view: DVec3) -> DVec3 {
    let cosine = shading.dot(view);
    if cosine >= 0.0 {
        return shading;
    }
    (shading - cosine * view).try_normalize().unwrap_or(geometric)
}

/// `direction`, mirrored at the plane with unit normal `normal` if it points below it.
fn above(direction: DVec3, normal: DVec3) -> DVec3 {
    let height = direction.dot(normal);
    if height >= 0.0 { direction } else { direction - 2.0 * height * normal }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_reflection_points_into_the_surface() {
        let geometric = DVec3::Z;
        for i in 0..1000 {
            let angle = f64::from(i) * 0.37;
            let tilt = f64::from(i) / 1000.0 * 1.5;
            let shading =
                DVec3::new(tilt.sin() * angle.cos(), tilt.sin() * angle.sin(), tilt.cos());
            let view = DVec3::new(0.999, 0.0, 0.01).normalize();
            let normal = visible_shading_normal([geometric, shading], view);
            assert!(normal.dot(view) >= -1e-12);
            let reflected = above(2.0 * view.dot(normal) * normal - view, geometric);
            assert!(reflected.z >= 0.0 && (reflected.length() - 1.0).abs() < 1e-12);
        }
    }
}
