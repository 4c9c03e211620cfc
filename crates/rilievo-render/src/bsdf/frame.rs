//! The two normals of a hit, and local coordinates around the shading one.
//!
//! Both normals are turned to the viewer's side. A shading normal that the viewer would see from
//! behind is tilted to a right angle with the view, so that nothing turns black there.
//!
//! A lobe around a shading normal may send a direction to the wrong side of the surface: a
//! reflection into it, a refraction out of it. Such a direction is mirrored at the plane of the
//! geometric normal ("folded"). The value and the density of a direction on the right side are then
//! sums over the direction and its mirror image, exactly, so the energy of a lobe is kept whatever
//! the angle between the normals.

use glam::DVec3;
use rilievo::Hit;

/// The normals and axes at a hit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    right: DVec3,
    up: DVec3,
    normal: DVec3,
    /// The geometric normal, in local coordinates.
    geometric: DVec3,
    /// Direction to the viewer, in local coordinates; `z >= 0`.
    pub(super) view: DVec3,
}

impl Frame {
    /// Around `shading_normal`, which points to the front as the normals of `hit` do.
    pub(super) fn new(hit: &Hit, shading_normal: DVec3, view: DVec3) -> Self {
        let sign = if hit.front { 1.0 } else { -1.0 };
        let geometric = sign * hit.geometric_normal;
        let mut normal = sign * shading_normal;
        let cosine = normal.dot(view);
        if cosine < 0.0 {
            normal = (normal - cosine * view).try_normalize().unwrap_or(geometric);
        }
        let (right, up) = normal.any_orthonormal_pair();
        let mut frame = Self { right, up, normal, geometric, view: DVec3::ZERO };
        frame.geometric = frame.local(geometric);
        frame.view = frame.local(view);
        frame.view.z = frame.view.z.max(0.0);
        frame
    }

    fn local(&self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.right), world.dot(self.up), world.dot(self.normal))
    }

    fn world(&self, local: DVec3) -> DVec3 {
        local.x * self.right + local.y * self.up + local.z * self.normal
    }

    /// Where `light` lies.
    pub(super) fn side(&self, light: DVec3) -> Side {
        let light = self.local(light);
        let height = light.dot(self.geometric);
        Side { light, image: light - 2.0 * height * self.geometric, height, tilt: self.geometric.z }
    }

    /// The world direction of `light` on the side where it belongs, and whether it was mirrored to
    /// get there.
    pub(super) fn folded(&self, light: DVec3, transmitted: bool) -> (DVec3, bool) {
        let height = light.dot(self.geometric);
        let wrong = if transmitted { height > 0.0 } else { height < 0.0 };
        let there = if wrong { light - 2.0 * height * self.geometric } else { light };
        (self.world(there), wrong)
    }
}

/// The shading normal of `hit`, turned by `normal` of a map in the tangent space of the shading
/// normal: x lies along u, y along v. So a map adds to what is displaced.
pub(super) fn detailed(hit: &Hit, normal: DVec3) -> DVec3 {
    let z = hit.shading_normal;
    let along = |tangent: DVec3| (tangent - tangent.dot(z) * z).try_normalize();
    let [Some(x), Some(y)] = hit.tangents.map(along) else { return z };
    (normal.x * x + normal.y * y + normal.z * z).try_normalize().unwrap_or(z)
}

/// A direction in local coordinates, by both normals.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    pub(super) light: DVec3,
    /// Its mirror image by the plane of the surface.
    image: DVec3,
    /// Cosine with the geometric normal: above 0 on the viewer's side.
    height: f64,
    /// Cosine between the normals.
    tilt: f64,
}

impl Side {
    /// Whether light from here is reflected to the viewer, rather than let through.
    pub(super) fn is_reflection(&self) -> bool {
        self.height > 0.0
    }

    /// The factor that softens the terminator of a diffuse lobe where the normals differ: 1 as far as
    /// the plane of the surface is no nearer than that of the shading normal, then down to 0 at the
    /// plane, smoothly \[Chiang2019\]. Without it light ends at the edges of facets.
    #[inline]
    pub(super) fn softened(&self) -> f64 {
        if self.tilt <= 0.0 {
            return 1.0;
        }
        let ratio = self.height.abs() / (self.light.z.abs() * self.tilt);
        if ratio < 1.0 { ratio * (1.0 + ratio * (1.0 - ratio)) } else { 1.0 }
    }

    /// The directions that a folding lobe sends here.
    #[inline]
    pub(super) fn both(&self) -> [DVec3; 2] {
        [self.light, self.image]
    }

    /// The sum of `density` over all directions that a folding lobe sends here.
    #[inline]
    pub(super) fn folded(&self, density: impl Fn(DVec3) -> f64) -> f64 {
        density(self.light) + density(self.image)
    }
}
