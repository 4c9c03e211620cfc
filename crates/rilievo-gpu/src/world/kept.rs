//! [`GpuSurfaces`]: what of a [`GpuWorld`] stays on its GPU from one picture to the next.

use rilievo::glam::DVec3;
use rilievo::surface::World;

use super::GpuWorld;
use super::edits::GpuMaps;
use super::pace::Paces;
use crate::device::{Gpu, Kernel};
use crate::maps::Maps;
use crate::pages::Pages;

/// All that a [`GpuWorld`] has on its GPU, while nobody looks at the world itself.
pub struct GpuSurfaces {
    anchor: DVec3,
    surfaces: u32,
    maps: Maps,
    kinds: Vec<[u32; 2]>,
    buffers: [wgpu::Buffer; 4],
    params: wgpu::Buffer,
    paces: Paces,
}

/// Which shaders trace some surfaces.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpuKernels(Kernel, [Pages; 2]);

impl GpuSurfaces {
    /// Which shaders trace them; a GPU compiles each when it is first used.
    pub fn kernels(&self) -> GpuKernels {
        GpuKernels(self.maps.closest(), self.maps.pages())
    }

    /// The maps alone, see [`GpuWorld::into_maps`].
    pub fn into_maps(self) -> GpuMaps {
        GpuMaps(self.maps)
    }
}

impl<'a> GpuWorld<'a> {
    /// All that lies on the GPU, for the time that the world is elsewhere: [`GpuWorld::again`].
    pub fn into_surfaces(self) -> GpuSurfaces {
        let Self { anchor, surfaces, maps, kinds, buffers, params, paces, .. } = self;
        GpuSurfaces { anchor, surfaces, maps, kinds, buffers, params, paces }
    }

    /// The world that these surfaces are of, which lie on this GPU: nothing is brought over. Of another world
    /// answers would be wrong.
    pub fn again(gpu: &'a Gpu, world: &'a World, kept: GpuSurfaces) -> Self {
        let GpuSurfaces { anchor, surfaces, maps, kinds, buffers, params, paces } = kept;
        let cancel = None;
        Self { gpu, world, anchor, surfaces, maps, kinds, buffers, params, paces, cancel }
    }
}
