//! Embree as a contender: the map tessellated sample by sample, on a device of its own.

use super::{Built, Contender, Facts, Task};
use crate::clock::Watch;
use crate::embree::{Packets, Ray1, Scene, Shape};
use crate::rays::{Batch, Family};
use crate::tally::Tally;

/// A committed scene.
pub struct Tracer {
    scene: Scene,
}

/// A batch of rays for a scene.
pub struct Loaded<'a> {
    scene: &'a Scene,
    rays: Rays,
    any_hit: bool,
    coherent: bool,
}

enum Rays {
    Single(Vec<Ray1>),
    Packets(Packets),
}

fn shape(contender: Contender) -> Option<Shape> {
    match contender {
        Contender::EmbreeTri => Some(Shape::Triangles),
        Contender::EmbreeQuad => Some(Shape::Quads),
        Contender::EmbreeGrid => Some(Shape::Grid),
        Contender::RilievoDefault | Contender::RilievoTiny => None,
    }
}

pub fn peak_bytes(contender: Contender, cells: u64) -> u64 {
    shape(contender).map_or(0, |shape| shape.peak_bytes_per_cell() * cells)
}

pub fn build(contender: Contender, task: &Task<'_>) -> Result<Built, String> {
    let shape = shape(contender).ok_or_else(|| format!("{} is no peer", contender.name()))?;
    let config = task.embree_config;
    let watch = Watch::start();
    let scene = Scene::of_heights(config, shape, task.heights, task.depth)?;
    let took = watch.took();
    let facts = Facts::from([
        ("version", scene.version()),
        ("config", config.to_owned()),
        ("geometry", shape.flags().to_owned()),
    ]);
    let bytes = scene.bytes();
    let tracer = super::Tracer::Embree(Box::new(Tracer { scene }));
    Ok(Built { contender, took, bytes, facts, tracer })
}

/// Single rays one a call; packets in every size up to theirs that Embree traces at once.
pub fn widths(batch: &Batch) -> Vec<usize> {
    match batch.row.packet() {
        16 => vec![16, 8],
        8 => vec![8],
        _ => vec![1],
    }
}

/// Whether neighbouring rays go the same way.
fn is_coherent(family: Family) -> bool {
    matches!(family, Family::Primary | Family::Grazing | Family::Primary16)
}

impl Tracer {
    pub fn load(&self, batch: &Batch, width: usize) -> Loaded<'_> {
        let rays = match Packets::of(&batch.rays, width) {
            Some(packets) => Rays::Packets(packets),
            None => Rays::Single(batch.rays.iter().map(Ray1::from).collect()),
        };
        let (any_hit, coherent) = (batch.row.is_any_hit(), is_coherent(batch.row.family()));
        Loaded { scene: &self.scene, rays, any_hit, coherent }
    }
}

impl Loaded<'_> {
    pub fn trace(&self) -> Tally {
        match (&self.rays, self.any_hit) {
            (Rays::Single(rays), false) => self.scene.closest(rays, self.coherent),
            (Rays::Single(rays), true) => self.scene.occluded(rays, self.coherent),
            (Rays::Packets(rays), false) => self.scene.closest_packets(rays, self.coherent),
            (Rays::Packets(rays), true) => self.scene.occluded_packets(rays, self.coherent),
        }
    }

    pub fn call(&self) -> &'static str {
        match (&self.rays, self.any_hit) {
            (Rays::Single(_), false) => "rtcIntersect1",
            (Rays::Single(_), true) => "rtcOccluded1",
            (Rays::Packets(Packets::Of8(_)), false) => "rtcIntersect8",
            (Rays::Packets(Packets::Of16(_)), false) => "rtcIntersect16",
            (Rays::Packets(Packets::Of8(_)), true) => "rtcOccluded8",
            (Rays::Packets(Packets::Of16(_)), true) => "rtcOccluded16",
        }
    }
}
