//! The places of shapes that stand elsewhere, or in many places, and of those that move.

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::sync::Arc;

use rilievo::glam::DAffine3;
use rilievo::relief::Displacement;
use rilievo::surface::{Instance, InstanceError, Motion, MovingInstance, Surface};

use super::file::InstanceEntry;
use super::resolve::Loader;
use super::syntax::Located;
use crate::error::Result;

/// A shape's surfaces under one displacement.
type Prototypes = Vec<(Arc<Surface>, u32)>;

impl Loader<'_> {
    /// The surfaces of a shape, with their materials, in all its places. Places with the same
    /// displacement share everything. The shape's own motion happens in each of them.
    pub(super) fn stand(
        &self,
        surfaces: Vec<(Surface, u32)>,
        entries: &[InstanceEntry],
        motion: Option<&Located<Motion>>,
    ) -> Result<Vec<(Surface, u32)>> {
        let own: Prototypes = surfaces.into_iter().map(|(s, m)| (Arc::new(s), m)).collect();
        let mut changed: HashMap<Vec<u64>, Prototypes> = HashMap::new();
        let mut all = Vec::with_capacity(entries.len() * own.len());
        for entry in entries {
            let prototypes = match &entry.displacement {
                None => &own,
                Some(changes) => {
                    let displaced = own.iter().filter_map(|(surface, _)| displacement(surface));
                    let key = displaced.flat_map(|d| bits(&changes.value.of(d))).collect();
                    match changed.entry(key) {
                        Entry::Occupied(there) => &*there.into_mut(),
                        Entry::Vacant(free) => &*free.insert(self.changed(&own, entry)?),
                    }
                }
            };
            let place = entry.world_from_shape;
            let own = motion.map(|m| Located { value: m.value.placed(&place), at: m.at.clone() });
            let motion = entry.motion.as_deref().or(own.as_ref());
            for (prototype, material) in prototypes {
                let prototype = Arc::clone(prototype);
                let surface = match motion {
                    Some(motion) => self.moving(prototype, place, motion)?,
                    None => {
                        let refuse = |e: InstanceError| {
                            let allowed = "a scale that is not 0, numbers up to 1e100".to_owned();
                            self.file.invalid(&entry.at, "instance", e.to_string(), allowed)
                        };
                        Instance::new(prototype, place).map_err(refuse)?.into()
                    }
                };
                all.push((surface, *material));
            }
        }
        Ok(all)
    }

    /// The surfaces of a shape that moves where it is.
    pub(super) fn set_off(
        &self,
        surfaces: Vec<(Surface, u32)>,
        motion: &Located<Motion>,
    ) -> Result<Vec<(Surface, u32)>> {
        let all = surfaces.into_iter().map(|(surface, material)| {
            Ok((self.moving(Arc::new(surface), DAffine3::IDENTITY, motion)?, material))
        });
        all.collect()
    }

    fn moving(
        &self,
        prototype: Arc<Surface>,
        place: DAffine3,
        motion: &Located<Motion>,
    ) -> Result<Surface> {
        let moving = MovingInstance::new(prototype, place, motion.value);
        let moving = moving.map_err(|e| {
            let allowed = "a place and a way with numbers up to 1e100".to_owned();
            self.file.invalid(&motion.at, "motion", e.to_string(), allowed)
        })?;
        Ok(moving.into())
    }

    /// Prototypes under the displacement of an instance.
    fn changed(&self, own: &Prototypes, entry: &InstanceEntry) -> Result<Prototypes> {
        let Some(changes) = &entry.displacement else { return Ok(own.clone()) };
        let refuse = |found: String, allowed: &str| {
            self.file.invalid(&changes.at, "displacement", found, allowed.to_owned())
        };
        if own.iter().all(|(surface, _)| displacement(surface).is_none()) {
            let found = "the shape has no displacement to change".to_owned();
            return Err(refuse(found, "nothing, or a shape with `displacement`"));
        }
        let mut all = Vec::new();
        for (surface, material) in own {
            let Some(displacement) = displacement(surface) else {
                all.push((Arc::clone(surface), *material));
                continue;
            };
            let displacement = changes.value.of(displacement);
            let surface = match surface.as_ref() {
                Surface::Face(face) => face
                    .with_displacement(displacement)
                    .map(Surface::from)
                    .map_err(|e| refuse(e.to_string(), ""))?,
                Surface::ReliefSphere(sphere) => sphere
                    .with_displacement(displacement)
                    .map(Surface::from)
                    .map_err(|e| refuse(e.to_string(), ""))?,
                Surface::ReliefMesh(mesh) => mesh
                    .with_displacements(|own| changes.value.of(own))
                    .map(Surface::from)
                    .map_err(|e| refuse(e.to_string(), ""))?,
                other => other.clone(),
            };
            all.push((Arc::new(surface), *material));
        }
        Ok(all)
    }
}

/// How a surface is displaced, if it is.
fn displacement(surface: &Surface) -> Option<Displacement> {
    match surface {
        Surface::Face(face) => Some(face.options().displacement),
        Surface::ReliefSphere(sphere) => Some(sphere.options().displacement),
        Surface::ReliefMesh(mesh) => Some(mesh.options().displacement),
        _ => None,
    }
}

/// What tells two displacements apart.
fn bits(d: &Displacement) -> [u64; 6] {
    [d.scale, d.zero, d.tile[0], d.tile[1], d.shift[0], d.shift[1]].map(f64::to_bits)
}
