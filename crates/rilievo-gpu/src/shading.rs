//! [`GpuScene`]: a scene whose integrators run on the device.
//!
//! Every camera ray has a *slot*: its path, or its tree of rays, as a machine with one ray out (two, of a path: its own and
//! one to a light). A round traces the rays of all slots with the kernel that answers all other rays too, then takes each
//! slot a step on (`shaders/integrator`): it takes in what was met, draws, weighs, and sends the next ray. No ray and no hit
//! leaves the device; the radiance of each camera ray does, when all slots are done. Slots know nothing of each other, so
//! the same scene and seed give the same bytes whatever else is on the way. Shading holds no tracing code and tracing no
//! shading: each is compiled by itself, and only with what a scene asks for.
//!
//! Camera rays are the CPU's, from the same numbers. So are the numbers of a path: keys, permutations and scrambles are
//! whole numbers here as there. Points on surfaces are in doubles; what only weighs light is in floats.
//!
//! What the shaders of light do not know ([`GpuScene::why_not`]) is shaded by the CPU, ray by ray in waves.

use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use rayon::prelude::*;
use rilievo::Ray;
use rilievo::surface::Surface;
use rilievo_render::device::{SceneWords, Uncovered};
use rilievo_render::sampler::Sampler;
use rilievo_render::{
    CameraRay, Integrator, RayCounts, Rgb, Scene, Seen, ShadowRay, Traced, Tracer,
};
use wgpu::BufferUsages;

use crate::device::{Gpu, Kernel};
use crate::error::GpuError;
use crate::forms;
use crate::records::{self, RAY_WORDS};
use crate::shaders::Light;
use crate::upload;
use crate::world::{GpuWorld, MOST_SLOTS};

mod kept;
mod room;

use room::{Room, bind, encode};

pub use kept::{GpuLight, GpuShaders};

/// Camera rays that the CPU shades at a time where somebody may stop it.
pub(crate) const WAVE: usize = 1 << 14;

/// Words of a slot.
pub(crate) const SLOT_WORDS: usize = 12;
/// Words of a path on its way.
pub(crate) const WALK_WORDS: usize = 24;
/// Words of a tree without its points, and of a point.
pub(crate) const TREE_WORDS: usize = 16;
pub(crate) const POINT_WORDS: usize = 44;
/// Words before the first path or tree.
const COUNT_WORDS: usize = 4;

/// Points that wait at once in a tree whose rays do not split again.
const FEWEST_POINTS: u32 = 2;
/// Most of them: bounces of a tree whose rays split at every one.
const MOST_POINTS: u32 = 34;

/// A scene on a GPU.
pub struct GpuScene<'a> {
    scene: &'a Scene,
    world: GpuWorld<'a>,
    light: Result<OnDevice, Uncovered>,
}

/// What the integrators need on the device.
struct OnDevice {
    kernel: Light,
    /// What lies in `words`.
    said: SceneWords,
    words: wgpu::Buffer,
    step: wgpu::Buffer,
    /// Room for slots, kept from one call to the next.
    room: Mutex<Option<Room>>,
}

impl<'a> GpuScene<'a> {
    /// Brings a scene to a GPU: its surfaces, and what lights them if the shaders know all of it.
    ///
    /// # Errors
    /// As [`GpuWorld::new`].
    pub fn new(gpu: &'a Gpu, scene: &'a Scene) -> Result<Self, GpuError> {
        Self::with_world(GpuWorld::new(gpu, scene.world())?, scene)
    }

    /// The same for surfaces that are on the GPU already: those of `scene`.
    ///
    /// # Errors
    /// As the device says.
    pub fn with_world(world: GpuWorld<'a>, scene: &'a Scene) -> Result<Self, GpuError> {
        let light = match OnDevice::words(&world, scene) {
            Ok(words) => OnDevice::new(&world, scene, words, None)?,
            Err(uncovered) => Err(uncovered),
        };
        Ok(Self { scene, world, light })
    }

    /// Why the CPU shades what is traced here; nothing where the integrators run on the device.
    pub fn why_not(&self) -> Option<Uncovered> {
        self.light.as_ref().err().copied()
    }

    /// The surfaces.
    pub fn world(&self) -> &GpuWorld<'a> {
        &self.world
    }

    /// The surfaces alone.
    pub fn into_world(self) -> GpuWorld<'a> {
        self.world
    }

    /// Radiance against camera rays whose pixels take `samples` in all; nothing where the CPU shades.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn seen(&self, rays: &[CameraRay], samples: u64) -> Result<Option<Seen>, GpuError> {
        let Ok(light) = &self.light else { return Ok(None) };
        let mut seen = Seen::default();
        let most = light.most_slots(self.world.gpu());
        let mut room = light.room.lock().unwrap_or_else(PoisonError::into_inner);
        let mut left = rays;
        while !left.is_empty() && !self.world.is_stopped() {
            let now = most.min(self.world.paces().slots.get() as usize).min(left.len());
            let (rays, rest) = left.split_at(now);
            left = rest;
            let enough = room.as_ref().is_some_and(|room| room.slots >= rays.len());
            if !enough {
                // The old buffers first, so that both need not fit.
                *room = None;
                let slots = rays.len().next_power_of_two().min(most);
                *room = Some(Room::new(self.world.gpu(), slots, light.kernel)?);
            }
            if let Some(room) = room.as_ref() {
                self.run(light, room, (rays, samples), &mut seen)?;
            }
        }
        Ok(Some(seen))
    }

    /// Takes the slots of some rays to their ends.
    fn run(
        &self,
        light: &OnDevice,
        room: &Room,
        (rays, samples): (&[CameraRay], u64),
        seen: &mut Seen,
    ) -> Result<(), GpuError> {
        let (gpu, count) = (self.world.gpu(), rays.len() as u32);
        self.begin(room, rays);
        let both = light.kernel.parts.path;
        let step = [0, count, count, u32::try_from(samples).unwrap_or(u32::MAX)];
        gpu.queue.write_buffer(&light.step, 0, bytemuck::cast_slice(&step));
        let closest = gpu.pipeline(self.world.maps().closest(), self.world.maps().pages());
        let advance = gpu.pipeline(Kernel::Advance(light.kernel), self.world.maps().pages());
        let traced = self.world.groups(&closest, &room.rays, &room.hits);
        let shaded = self.groups(light, room, &advance);
        let (mut asked, mut longest) = (count, Duration::ZERO);
        while !self.world.is_stopped() {
            let begin = Instant::now();
            let mut commands = gpu.device.create_command_encoder(&Default::default());
            let whole = self.world.trace_slots(&closest, &traced, asked, &mut commands)?;
            encode(&advance, &shaded, count, &mut commands);
            commands.copy_buffer_to_buffer(&room.trees, 0, &room.count, 0, 16);
            gpu.queue.submit([commands.finish()]);
            let done: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&room.count, 16)?);
            if whole {
                self.world.took(asked, begin.elapsed());
            }
            longest = longest.max(begin.elapsed());
            if done.first() == Some(&count) {
                break;
            }
            asked = if both { 2 * count } else { count };
        }
        self.world.paces().slots.took(count, longest, self.world.patience());
        self.end(room, rays.len(), seen)
    }

    /// Writes camera rays and their slots.
    fn begin(&self, room: &Room, rays: &[CameraRay]) {
        let (gpu, anchor) = (self.world.gpu(), self.world.anchor());
        let seed = self.scene.settings().seed;
        let chunks: Vec<(Vec<u32>, Vec<u32>)> = rays
            .par_chunks(4096)
            .map(|rays| {
                let mut words = Vec::with_capacity(rays.len() * RAY_WORDS);
                let mut slots = Vec::with_capacity(rays.len() * SLOT_WORDS);
                for CameraRay { ray, pixel, index, numbers } in rays {
                    records::write_ray(&mut words, ray, anchor);
                    match numbers {
                        Some(numbers) => slots.extend(numbers.words()),
                        None => {
                            let [low, high] = Sampler::new(seed, *pixel).words();
                            slots.extend([low, high, *index as u32, 0]);
                        }
                    }
                    slots.extend([0; SLOT_WORDS - 4]);
                }
                (words, slots)
            })
            .collect();
        let [mut at_ray, mut at_slot] = [0; 2];
        for (words, slots) in &chunks {
            gpu.queue.write_buffer(&room.rays, at_ray, bytemuck::cast_slice(words));
            gpu.queue.write_buffer(&room.of_slots, at_slot, bytemuck::cast_slice(slots));
            at_ray += 4 * words.len() as u64;
            at_slot += 4 * slots.len() as u64;
        }
        gpu.queue.write_buffer(&room.trees, 0, &[0; 4 * COUNT_WORDS]);
    }

    /// Reads what slots have brought.
    fn end(&self, room: &Room, slots: usize, seen: &mut Seen) -> Result<(), GpuError> {
        let gpu = self.world.gpu();
        let bytes = (4 * SLOT_WORDS * slots) as u64;
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(&room.of_slots, 0, &room.read, 0, bytes);
        gpu.queue.submit([commands.finish()]);
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(&gpu.read(&room.read, bytes)?);
        for slot in words.chunks_exact(SLOT_WORDS) {
            let [r, g, b] = [4, 5, 6].map(|k| f64::from(f32::from_bits(slot[k])));
            seen.radiance.push(Rgb::new(r, g, b));
            let [shadow, reflection, diffuse] = [8, 9, 10].map(|k| u64::from(slot[k]));
            seen.rays += RayCounts { camera: 0, shadow, reflection, diffuse };
        }
        Ok(())
    }

    /// What the integrators bind.
    fn groups(
        &self,
        light: &OnDevice,
        room: &Room,
        pipeline: &wgpu::ComputePipeline,
    ) -> Vec<wgpu::BindGroup> {
        let faces = self.world.faces();
        let buffers =
            [&light.step, &room.rays, &room.hits, faces, &light.words, &room.of_slots, &room.trees];
        let gpu = self.world.gpu();
        let own = bind(gpu, pipeline, 0, &buffers);
        vec![own, self.world.maps().heights_group(gpu, pipeline)]
    }
}

/// Points of a tree of rays that wait at once.
fn points_of(scene: &Scene) -> Result<u32, Uncovered> {
    let settings = scene.settings();
    let splits = settings.integrator == Integrator::Distributed && settings.diffuse_samples > 0;
    if splits && settings.max_depth + FEWEST_POINTS > MOST_POINTS {
        return Err(Uncovered("a tree of so many bounces"));
    }
    Ok(if splits { settings.max_depth + FEWEST_POINTS } else { FEWEST_POINTS })
}

fn stands_elsewhere(surface: &Surface) -> bool {
    matches!(surface, Surface::Instance(_) | Surface::Moving(_))
}

impl OnDevice {
    /// The scene in words, with the forms of its surfaces.
    fn words(world: &GpuWorld<'_>, scene: &Scene) -> Result<SceneWords, Uncovered> {
        let mut words = SceneWords::new(scene, world.anchor())?;
        forms::append(&mut words, (scene.world(), world.anchor()), world.kinds())?;
        Ok(words)
    }

    fn new(
        world: &GpuWorld<'_>,
        scene: &Scene,
        said: SceneWords,
        before: Option<Self>,
    ) -> Result<Result<Self, Uncovered>, GpuError> {
        let gpu = world.gpu();
        let bytes: &[u8] = bytemuck::cast_slice(&said.words);
        if bytes.len() as u64 > gpu.largest_binding() {
            return Ok(Err(Uncovered("images and meshes past what the device binds at once")));
        }
        let points = match points_of(scene) {
            Ok(points) => points,
            Err(uncovered) => return Ok(Err(uncovered)),
        };
        let has = |kind: u32| world.kinds().iter().any(|known| known[0] == kind);
        let kernel = Light {
            parts: said.parts,
            points,
            faces: has(upload::FACE),
            relief_spheres: has(upload::RELIEF_SPHERE),
            relief_meshes: has(upload::RELIEF_MESH),
            instances: scene.world().surfaces().iter().any(stands_elsewhere),
            moving: scene.world().moves(),
        };
        if let Some(before) = before {
            return Ok(Ok(before.followed(gpu, kernel, said)?));
        }
        let uniform = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        gpu.traffic.add_scene(bytes.len());
        Ok(Ok(Self {
            kernel,
            words: gpu.upload("materials and lights", bytes)?,
            said,
            step: gpu.allocate("parameters", 16, uniform)?,
            room: Mutex::new(None),
        }))
    }

    /// Slots that fit the device's bindings.
    fn most_slots(&self, gpu: &Gpu) -> usize {
        let words = self.kernel.state_words().max(2 * RAY_WORDS) as u64;
        let fits = (gpu.largest_binding() / 4).saturating_sub(64) / words;
        fits.clamp(64, MOST_SLOTS.into()) as usize
    }
}

impl Light {
    /// Words of a path or a tree.
    fn state_words(self) -> usize {
        if self.parts.path { WALK_WORDS } else { TREE_WORDS + self.points as usize * POINT_WORDS }
    }
}

/// Integrators on the device where they can be, else in waves.
impl Tracer for GpuScene<'_> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        self.world.closest(rays).map_err(|error| error.to_string())
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        self.world.occluded(rays).map_err(|error| error.to_string())
    }

    fn seen(&self, rays: &[CameraRay], samples: u64) -> Result<Option<Seen>, String> {
        GpuScene::seen(self, rays, samples).map_err(|error| error.to_string())
    }

    fn at_once(&self) -> Option<usize> {
        let most = match self.light {
            Ok(_) => self.world.paces().slots.get() as usize,
            Err(_) => WAVE,
        };
        self.world.is_watched().then_some(most)
    }
}
