//! rilievo as a contender: a face on the unit square, the pyramid built from the heights.

use std::sync::Arc;

use rilievo::map::Layout;
use rilievo::relief::{Displacement, FaceOptions, Relief, ReliefFace};
use rilievo::{Coherence, Ray};

use super::{Built, Contender, Facts, Task};
use crate::clock::Watch;
use crate::one_thread;
use crate::rays::{Batch, CORNERS, Row, widened};
use crate::tally::Tally;

/// A face.
pub struct Tracer {
    face: ReliefFace,
}

/// A batch of rays for a face.
pub struct Loaded<'a> {
    face: &'a ReliefFace,
    rays: Vec<Ray>,
    any_hit: bool,
    width: usize,
}

pub fn build((contender, layout): (Contender, Layout), task: &Task<'_>) -> Result<Built, String> {
    let heights = task.heights.clone();
    let watch = Watch::start();
    let relief = one_thread(|| Relief::with_layout(heights, layout));
    let took = watch.took();
    let (_, bytes) = relief.bytes();
    let displacement = Displacement { scale: task.depth, ..Displacement::default() };
    let options = FaceOptions { displacement, simd: task.simd, ..FaceOptions::default() };
    let facts = Facts::from([
        ("version", env!("CARGO_PKG_VERSION").to_owned()),
        ("method", options.method.name().to_owned()),
        ("simd", options.simd.name().to_owned()),
    ]);
    let face = ReliefFace::new(CORNERS, Arc::new(relief), options);
    let tracer = Tracer { face: face.map_err(|e| e.to_string())? };
    let tracer = super::Tracer::Rilievo(Box::new(tracer));
    Ok(Built { contender, took, bytes: (bytes, bytes), facts, tracer })
}

/// The samples of a pixel as a packet, all others one ray a call.
pub fn widths(batch: &Batch) -> Vec<usize> {
    if batch.row == Row::Primary16 { vec![16] } else { vec![1] }
}

impl Tracer {
    /// Calls take `width` rays.
    pub fn load(&self, batch: &Batch, width: usize) -> Loaded<'_> {
        let rays = batch.rays.iter().map(widened).collect();
        Loaded { face: &self.face, rays, any_hit: batch.row.is_any_hit(), width }
    }
}

impl Loaded<'_> {
    pub fn trace(&self) -> Tally {
        let mut tally = Tally::default();
        if self.any_hit {
            for ray in &self.rays {
                if self.face.occludes(ray, &mut ()) {
                    tally.hit(0.0);
                }
            }
        } else if self.width > 1 {
            let mut found = vec![None; self.width];
            for rays in self.rays.chunks(self.width) {
                let found = &mut found[..rays.len()];
                self.face.first_crossings((rays, Coherence::Coherent), found, &mut ());
                for crossing in found.iter().flatten() {
                    tally.hit(crossing.t);
                }
            }
        } else {
            for ray in &self.rays {
                if let Some(crossing) = self.face.first_crossing(ray, &mut ()) {
                    tally.hit(crossing.t);
                }
            }
        }
        tally
    }

    pub fn call(&self) -> &'static str {
        match (self.any_hit, self.width) {
            (true, _) => "ReliefFace::occludes",
            (false, 1) => "ReliefFace::first_crossing",
            (false, _) => "ReliefFace::first_crossings",
        }
    }
}
