//! [`GpuWorld`]: surfaces on a GPU, ready to trace.

mod answers;
mod edits;
mod kept;
mod pace;
mod tracing;

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use rilievo::glam::DVec3;
use rilievo::surface::World;
use wgpu::BufferUsages;

use crate::device::Gpu;
use crate::error::GpuError;
use crate::maps::Maps;
use crate::upload::Upload;
use pace::Paces;

pub use edits::{GpuMaps, MapEdit};
pub use kept::{GpuKernels, GpuSurfaces};
pub(crate) use pace::MOST_SLOTS;
pub(crate) use tracing::{Answer, BATCH};

/// Surfaces on a GPU.
pub struct GpuWorld<'a> {
    gpu: &'a Gpu,
    world: &'a World,
    anchor: DVec3,
    /// How many can be hit at all; none where the tree is empty.
    surfaces: u32,
    maps: Maps,
    /// Of each surface its kind, and its first face if it has any.
    kinds: Vec<[u32; 2]>,
    buffers: [wgpu::Buffer; 4],
    params: wgpu::Buffer,
    paces: Paces,
    /// Set to stop: then answers mean nothing.
    cancel: Option<&'a AtomicBool>,
}

impl<'a> GpuWorld<'a> {
    /// Brings the surfaces of a world to a GPU: heights and pyramids, each map once.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for trees too deep for the shaders; otherwise as the device says.
    pub fn new(gpu: &'a Gpu, world: &'a World) -> Result<Self, GpuError> {
        let anchor = anchor_of(world);
        let words = Upload::new(world, anchor)?;
        let maps = Maps::new(gpu, &words.maps)?;
        Self::assemble(gpu, (world, anchor), &words, maps)
    }

    fn assemble(
        gpu: &'a Gpu,
        (world, anchor): (&'a World, DVec3),
        words: &Upload<'_>,
        maps: Maps,
    ) -> Result<Self, GpuError> {
        let params = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        Ok(Self {
            gpu,
            world,
            anchor,
            surfaces: if words.is_empty() { 0 } else { world.surfaces().len() as u32 },
            maps,
            kinds: words.kinds(),
            buffers: records(gpu, words)?,
            params: gpu.allocate("parameters", 16, params)?,
            paces: Paces::default(),
            cancel: None,
        })
    }

    /// Looks at `cancel` before every dispatch, and makes those shorter. Once it is set, answers come at once and mean
    /// nothing.
    #[must_use]
    pub fn stopped_by(self, cancel: &'a AtomicBool) -> Self {
        Self { cancel: Some(cancel), ..self }
    }

    /// Whether somebody may stop it.
    pub(crate) fn is_watched(&self) -> bool {
        self.cancel.is_some()
    }

    pub(crate) fn is_stopped(&self) -> bool {
        self.cancel.is_some_and(|cancel| cancel.load(Ordering::Relaxed))
    }

    /// How much work goes into a dispatch and into a round of shading.
    pub(crate) fn paces(&self) -> &Paces {
        &self.paces
    }

    /// How long a dispatch is to take.
    pub(crate) fn patience(&self) -> Duration {
        if self.is_watched() { pace::WATCHED } else { pace::ALONE }
    }

    /// The surfaces themselves.
    pub fn world(&self) -> &'a World {
        self.world
    }

    pub(crate) fn gpu(&self) -> &Gpu {
        self.gpu
    }

    pub(crate) fn anchor(&self) -> DVec3 {
        self.anchor
    }

    pub(crate) fn maps(&self) -> &Maps {
        &self.maps
    }

    pub(crate) fn kinds(&self) -> &[[u32; 2]] {
        &self.kinds
    }

    /// Displaced faces.
    pub(crate) fn faces(&self) -> &wgpu::Buffer {
        &self.buffers[0]
    }
}

/// The point that coordinates on the device count from.
fn anchor_of(world: &World) -> DVec3 {
    let bounds = world.bounds();
    if bounds.is_empty() { DVec3::ZERO } else { bounds.centre() }
}

/// Buffers of all that is not a map.
fn records(gpu: &Gpu, words: &Upload<'_>) -> Result<[wgpu::Buffer; 4], GpuError> {
    let upload = |what, words: &Vec<u32>| gpu.upload(what, bytemuck::cast_slice(words.as_slice()));
    for words in [&words.faces, &words.surfaces, &words.nodes, &words.numbers] {
        gpu.traffic.add_scene(4 * words.len());
    }
    Ok([
        upload("displaced faces", &words.faces)?,
        upload("surfaces", &words.surfaces)?,
        upload("trees", &words.nodes)?,
        upload("triangles", &words.numbers)?,
    ])
}
