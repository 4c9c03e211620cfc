//! [`Emitter`]: a surface that shines and is drawn by its [`Shape`]; [`Aim`]: a ray towards it.
//!
//! What the ray meets is the sample: its radiance is that of the place that is met, its density that of
//! the meeting, by the same function that weighs what a material's own rays meet. So no shadow ray has to
//! end just before a surface that is not flat, and light neither leaks there nor is stopped by the cell
//! it comes from.
//!
//! **Instances.** A density of directions in the frame of the prototype is one in the world: with the
//! linear map `A` to the prototype, the direction `d` goes to `A d / |A d|`, and a solid angle there is
//! `|det A| / |A d|^3` of that in the world. All instances of a prototype share its shape.

use glam::{DAffine3, DMat3, DVec2, DVec3};
use rilievo::accel::Aabb;
use rilievo::surface::Surface;
use rilievo::{Hit, Ray};

use super::Receiver;
use super::bounds::LightBounds;
use super::lighting::prototype;
use super::shape::{Shape, Target};

/// Two points of an emitter closer than this share of the way to them are one: the point that was drawn,
/// and the same point met. Roundings are far smaller.
const SAME: f64 = 1e-6;

/// A ray towards an emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Aim {
    /// The emitter.
    surface: u32,
    /// The point that was drawn, or one beyond the emitter.
    end: DVec3,
    /// Whether only that point counts.
    exact: bool,
}

impl Aim {
    /// From the receiver to the end, where t = 1.
    pub(crate) fn way(&self, from: DVec3) -> DVec3 {
        self.end - from
    }

    /// The ray from a hit.
    pub(crate) fn ray(&self, from: &Hit) -> Ray {
        Ray { t_max: 1.0 + SAME, ..from.spawn(self.way(from.position)) }
    }

    /// Whether what the ray met first is what it was aimed at.
    pub(crate) fn finds(&self, met: &Hit) -> bool {
        met.surface == self.surface && met.front && (!self.exact || met.t >= 1.0 - SAME)
    }
}

/// A surface that shines.
#[derive(Clone, Debug)]
pub(super) struct Emitter {
    /// The surface.
    pub surface: u32,
    /// Its shape, in the list of them.
    pub shape: u32,
    stands: Stands,
}

/// Where a surface is whose shape is that of its prototype.
#[derive(Clone, Copy, Debug)]
enum Stands {
    /// Where it was made.
    There,
    /// Always in one place.
    At(Place),
    /// At each time elsewhere.
    Moves,
}

/// Where an instance stands.
#[derive(Clone, Copy, Debug)]
struct Place {
    world_from_local: DAffine3,
    local_from_world: DAffine3,
    /// What a volume of 1 is in the prototype's frame.
    volume: f64,
}

impl Emitter {
    /// A surface of a shape.
    pub fn new(surface: u32, shape: u32, stands: &Surface) -> Self {
        let stands = match stands {
            Surface::Instance(instance) => Stands::At(Place::of(*instance.world_from_local())),
            Surface::Moving(_) => Stands::Moves,
            _ => Stands::There,
        };
        Self { surface, shape, stands }
    }

    /// Where it stands at a time, if that is not where it was made.
    #[inline]
    fn place(&self, surface: &Surface, time: f64) -> Option<Place> {
        match (&self.stands, surface) {
            (Stands::At(place), _) => Some(*place),
            (Stands::Moves, Surface::Moving(moving)) => {
                Some(Place::of(moving.world_from_local(time)))
            }
            _ => None,
        }
    }

    /// Bounds in the world at all times, of those in the frame of the shape.
    pub fn bounds(&self, surface: &Surface, local: LightBounds) -> LightBounds {
        let Some(place) = self.place(surface, 0.0) else { return local };
        let bounds = place.bounds(local);
        match surface {
            Surface::Moving(_) => {
                let Aabb { min, max } = surface.bounds();
                LightBounds { min, max, axis: DVec3::Z, cos_normals: -1.0, ..bounds }
            }
            _ => bounds,
        }
    }

    /// A ray from `at`, for `choice` and `u` uniform in `[0, 1)`.
    pub fn aim(
        &self,
        (shape, surface): (&Shape, &Surface),
        at: &Receiver,
        choice: f64,
        u: DVec2,
    ) -> Option<Aim> {
        let made = prototype(surface);
        let Target { end, exact } = match self.place(surface, at.time) {
            None => shape.sample(made, at, choice, u)?,
            Some(place) => {
                let target = shape.sample(made, &place.receiver(at), choice, u)?;
                let end = place.world_from_local.transform_point3(target.end);
                Target { end, ..target }
            }
        };
        Some(Aim { surface: self.surface, end, exact })
    }

    /// Density of the directions of [`Self::aim`] at what a ray from `at` met, per steradian.
    pub fn pdf(&self, (shape, surface): (&Shape, &Surface), at: &Receiver, met: &Hit) -> f64 {
        let made = prototype(surface);
        let Some(place) = self.place(surface, at.time) else { return shape.pdf(made, at, met) };
        let direction = (met.position - at.position).normalize_or_zero();
        let local = place.local_from_world.transform_vector3(direction).length();
        let pdf = shape.pdf(made, &place.receiver(at), &place.hit(met));
        let pdf = pdf * place.volume / (local * local * local);
        if pdf.is_finite() { pdf } else { 0.0 }
    }
}

impl Place {
    fn of(world_from_local: DAffine3) -> Self {
        let local_from_world = world_from_local.inverse();
        let volume = local_from_world.matrix3.determinant().abs();
        Self { world_from_local, local_from_world, volume }
    }

    /// A unit normal in the frame of the prototype, where the inverse turns normals by its transpose.
    fn normal(&self, normal: DVec3) -> DVec3 {
        (self.world_from_local.matrix3.transpose() * normal).normalize_or(DVec3::Z)
    }

    fn receiver(&self, at: &Receiver) -> Receiver {
        let position = self.local_from_world.transform_point3(at.position);
        Receiver { position, normal: at.normal.map(|normal| self.normal(normal)), ..*at }
    }

    /// What a shape asks of a hit, in the frame of the prototype.
    fn hit(&self, met: &Hit) -> Hit {
        Hit {
            position: self.local_from_world.transform_point3(met.position),
            geometric_normal: self.normal(met.geometric_normal),
            ..*met
        }
    }

    fn bounds(&self, local: LightBounds) -> LightBounds {
        let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for k in 0..8 {
            let pick = |axis: usize| {
                if k >> axis & 1 == 0 { local.min[axis] } else { local.max[axis] }
            };
            let corner = DVec3::new(pick(0), pick(1), pick(2));
            let corner = self.world_from_local.transform_point3(corner);
            (min, max) = (min.min(corner), max.max(corner));
        }
        let turned = self.local_from_world.matrix3.transpose() * local.axis;
        // A cone of normals stays one where lengths keep their ratios.
        let keeps = local.cos_normals == 1.0 || is_similar(&self.world_from_local.matrix3);
        let (axis, cos_normals) = match keeps {
            true => (turned.normalize_or(DVec3::Z), local.cos_normals),
            false => (DVec3::Z, -1.0),
        };
        // As where the stretch is even.
        let area = self.volume.powf(-2.0 / 3.0);
        let [intensity, held] = [local.intensity, local.held].map(|part| part * area);
        LightBounds { min, max, intensity, held, axis, cos_normals, ..local }
    }
}

/// Whether a map stretches all directions alike.
fn is_similar(map: &DMat3) -> bool {
    let product = map.transpose() * *map;
    let stretch = product.x_axis.x;
    (product - DMat3::from_diagonal(DVec3::splat(stretch)))
        .to_cols_array()
        .iter()
        .all(|x| x.abs() <= 1e-9 * stretch)
}
