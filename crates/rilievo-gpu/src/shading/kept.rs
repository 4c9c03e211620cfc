//! [`GpuLight`]: what a [`GpuScene`] says of materials and lights stays on its GPU from one picture to the next, as its
//! surfaces do. Of a scene that has changed only the words that differ are brought over.

use std::ops::Range;
use std::sync::Mutex;

use rilievo_render::Scene;
use rilievo_render::device::{HEAD, SceneWords, Uncovered};
use wgpu::BufferUsages;

use super::room::{Room, bind, encode};
use super::{GpuScene, OnDevice, points_of};
use crate::device::{Gpu, Kernel};
use crate::error::GpuError;
use crate::pages::Pages;
use crate::shaders::Light;
use crate::world::{GpuSurfaces, GpuWorld};

/// Words that are compared at once.
const BLOCK: usize = 256;

/// What the integrators of a scene have on a GPU, while nobody looks at the scene itself.
pub struct GpuLight(OnDevice);

/// Which shaders shade a scene.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct GpuShaders(Light, [Pages; 2]);

impl<'a> GpuScene<'a> {
    /// What lies on the GPU, for the time that the scene is elsewhere: surfaces, and what lights them if that is shaded there.
    pub fn into_parts(self) -> (GpuSurfaces, Option<GpuLight>) {
        (self.world.into_surfaces(), self.light.ok().map(GpuLight))
    }

    /// Surfaces and what lights them, each for itself.
    pub fn apart(self) -> (GpuWorld<'a>, Option<GpuLight>) {
        (self.world, self.light.ok().map(GpuLight))
    }

    /// The scene that `world` and `light` are of, or one that differs from it in camera and settings alone.
    ///
    /// # Errors
    /// As the device says.
    pub fn again(world: GpuWorld<'a>, scene: &'a Scene, light: GpuLight) -> Result<Self, GpuError> {
        let GpuLight(mut light) = light;
        match light.said.follow(scene) {
            Ok(false) => Self::following(world, scene, GpuLight(light)),
            Ok(true) => {
                let light = light.settled(world.gpu(), scene);
                Ok(Self { scene, world, light })
            }
            Err(uncovered) => Ok(Self { scene, world, light: Err(uncovered) }),
        }
    }

    /// Any scene, whose surfaces are those of `world`: of what was said of another only what differs is brought over.
    ///
    /// # Errors
    /// As the device says.
    pub fn following(
        world: GpuWorld<'a>,
        scene: &'a Scene,
        GpuLight(before): GpuLight,
    ) -> Result<Self, GpuError> {
        let light = match OnDevice::words(&world, scene) {
            Ok(words) => OnDevice::new(&world, scene, words, Some(before))?,
            Err(uncovered) => Err(uncovered),
        };
        Ok(Self { scene, world, light })
    }

    /// Which shaders it takes, if the integrators run on the device.
    pub fn shaders(&self) -> Option<GpuShaders> {
        let light = self.light.as_ref().ok()?;
        Some(GpuShaders(light.kernel, self.world.maps().pages()))
    }
}

impl OnDevice {
    /// The same after its scene's settings have changed.
    fn settled(self, gpu: &Gpu, scene: &Scene) -> Result<Self, Uncovered> {
        let points = points_of(scene)?;
        self.write(gpu, 0..HEAD.len());
        let kernel = Light { points, ..self.kernel };
        Ok(self.with_kernel(kernel))
    }

    /// The same with other words.
    ///
    /// # Errors
    /// As the device says.
    pub(super) fn followed(
        self,
        gpu: &Gpu,
        kernel: Light,
        said: SceneWords,
    ) -> Result<Self, GpuError> {
        let before = self.said;
        let bytes: &[u8] = bytemuck::cast_slice(&said.words);
        if bytes.len() as u64 > self.words.size() {
            gpu.traffic.add_scene(bytes.len());
            let words = gpu.upload("materials and lights", bytes)?;
            return Ok(Self { words, said, ..self }.with_kernel(kernel));
        }
        let now = Self { said, ..self }.with_kernel(kernel);
        for range in differences(&before.words, &now.said.words) {
            now.write(gpu, range);
        }
        Ok(now)
    }

    /// With other shaders; slots of another kind need another room.
    fn with_kernel(mut self, kernel: Light) -> Self {
        let kind = |kernel: Light| (kernel.parts.path, kernel.state_words());
        if kind(kernel) != kind(self.kernel) {
            self.room = Mutex::new(None);
        }
        Self { kernel, ..self }
    }

    fn write(&self, gpu: &Gpu, range: Range<usize>) {
        let bytes: &[u8] = bytemuck::cast_slice(&self.said.words[range.clone()]);
        gpu.traffic.add_scene(bytes.len());
        gpu.queue.write_buffer(&self.words, 4 * range.start as u64, bytes);
    }
}

/// Where words are others than before, in runs of whole blocks.
fn differences(before: &[u32], now: &[u32]) -> Vec<Range<usize>> {
    let mut found: Vec<Range<usize>> = Vec::new();
    for (first, block) in (0..).step_by(BLOCK).zip(now.chunks(BLOCK)) {
        let end = first + block.len();
        if before.get(first..end) == Some(block) {
            continue;
        }
        match found.last_mut().filter(|last| last.end == first) {
            Some(last) => last.end = end,
            None => found.push(first..end),
        }
    }
    found
}

impl Gpu {
    /// Has shaders compiled that shade a scene, and run once over nothing: only then do some drivers compile them.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn compile(&self, GpuShaders(kernel, pages): &GpuShaders) -> Result<(), GpuError> {
        let pipeline = self.pipeline(Kernel::Advance(*kernel), *pages);
        let room = Room::new(self, 1, *kernel)?;
        let storage = BufferUsages::STORAGE;
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let step = self.allocate("parameters", 16, uniform)?;
        let nothing = self.allocate("nothing", 0, storage)?;
        let own = [&step, &room.rays, &room.hits, &nothing, &nothing, &room.of_slots, &room.trees];
        let heights = vec![&nothing; pages[0].count as usize];
        let groups = [bind(self, &pipeline, 0, &own), bind(self, &pipeline, 1, &heights)];
        let mut commands = self.device.create_command_encoder(&Default::default());
        encode(&pipeline, &groups, 1, &mut commands);
        self.queue.submit([commands.finish()]);
        self.wait()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_that_differ_are_found_in_runs() {
        let before: Vec<u32> = (0..1000).collect();
        assert!(differences(&before, &before).is_empty());
        assert!(differences(&before, &before[..500]).is_empty());
        let mut now = before.clone();
        (now[300], now[520], now[999]) = (0, 0, 0);
        assert_eq!(differences(&before, &now), vec![256..1000]);
        (now[520], now[999]) = (520, 999);
        assert_eq!(differences(&before, &now), vec![256..512]);
        now[999] = 0;
        now.push(7);
        assert_eq!(differences(&before, &now), vec![256..512, 768..1001]);
        assert_eq!(differences(&[], &now), vec![0..1001]);
    }
}
