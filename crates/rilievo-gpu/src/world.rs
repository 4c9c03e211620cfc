//! [`GpuWorld`]: surfaces on a GPU, ready to trace.

use std::ops::Range;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;
use rilievo::glam::DVec3;
use rilievo::relief::Relief;
use rilievo::surface::{Surface, World};
use rilievo::{Hit, Ray};
use rilievo_render::{ShadowRay, Traced, Tracer};
use wgpu::BufferUsages;

use crate::device::{Gpu, Kernel};
use crate::error::GpuError;
use crate::maps::Maps;
use crate::pages::Pages;
use crate::records::{self, HIT_WORDS, HitRecord, RAY_WORDS};
use crate::upload::Upload;

/// Rays uploaded at once.
pub(crate) const BATCH: usize = 1 << 20;

/// Rays that one thread writes at a time.
const CHUNK: usize = 4096;

/// Rays of the first dispatch.
const FIRST_DISPATCH: u32 = 1 << 14;

/// Rays of the largest dispatch: 64 a workgroup, at most 65535 workgroups.
const LARGEST_DISPATCH: u32 = 1 << 20;

/// A dispatch is to take about this long: far from the seconds after which drivers reset a GPU, long enough that
/// its start does not count.
const DISPATCH: Duration = Duration::from_millis(100);

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
    /// Rays of the next dispatch; follows the time that dispatches take.
    dispatch: AtomicU32,
}

/// What a ray is answered by.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Answer {
    /// The record of its nearest hit.
    Nearest,
    /// One word: whether it meets anything.
    Whether,
}

impl Answer {
    fn words(self) -> usize {
        match self {
            Self::Nearest => HIT_WORDS,
            Self::Whether => 1,
        }
    }
}

/// Heights and bounds on a GPU, of the maps of a world.
pub struct GpuMaps(Maps);

/// All that a [`GpuWorld`] has on its GPU, while nobody looks at the world itself.
pub struct GpuSurfaces {
    anchor: DVec3,
    surfaces: u32,
    maps: Maps,
    kinds: Vec<[u32; 2]>,
    buffers: [wgpu::Buffer; 4],
    params: wgpu::Buffer,
    dispatch: AtomicU32,
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

/// An edit of a map that a [`GpuWorld`] holds.
#[derive(Clone, Debug)]
pub struct MapEdit<'a> {
    /// The relief after the edit.
    pub relief: &'a Relief,
    /// Columns and rows of the samples that may have changed.
    pub samples: [Range<u32>; 2],
}

impl<'a> GpuWorld<'a> {
    /// Brings the surfaces of a world to a GPU: heights and pyramids, each map once.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for a surface that moves; otherwise as the device says.
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
            dispatch: AtomicU32::new(FIRST_DISPATCH),
        })
    }

    /// All that lies on the GPU, for the time that the world is elsewhere: [`GpuWorld::again`].
    pub fn into_surfaces(self) -> GpuSurfaces {
        let Self { anchor, surfaces, maps, kinds, buffers, params, dispatch, .. } = self;
        GpuSurfaces { anchor, surfaces, maps, kinds, buffers, params, dispatch }
    }

    /// The world that these surfaces are of, which lie on this GPU: nothing is brought over. Of another world
    /// answers would be wrong.
    pub fn again(gpu: &'a Gpu, world: &'a World, kept: GpuSurfaces) -> Self {
        let GpuSurfaces { anchor, surfaces, maps, kinds, buffers, params, dispatch } = kept;
        Self { gpu, world, anchor, surfaces, maps, kinds, buffers, params, dispatch }
    }

    /// The surfaces themselves.
    pub fn world(&self) -> &'a World {
        self.world
    }

    /// The maps alone, for a world after edits of them: they hold nothing of this one.
    pub fn into_maps(self) -> GpuMaps {
        GpuMaps(self.maps)
    }

    /// The surfaces of a world whose maps differ from `maps`, which lie on this GPU, in what `edits` name alone: only
    /// that is brought over and made anew. All other surfaces may differ. If there are other maps, or maps of another
    /// size, everything is brought over.
    ///
    /// # Errors
    /// As [`GpuWorld::new`].
    pub fn edited(
        gpu: &'a Gpu,
        world: &'a World,
        GpuMaps(mut maps): GpuMaps,
        edits: &[MapEdit<'_>],
    ) -> Result<Self, GpuError> {
        let anchor = anchor_of(world);
        let words = Upload::new(world, anchor)?;
        if !maps.fits(&words.maps) {
            return Self::new(gpu, world);
        }
        let number = |edit: &MapEdit<'_>| {
            words.maps.number(edit.relief).map(|number| (number, edit.samples.clone()))
        };
        let edits: Vec<_> = edits.iter().filter_map(number).collect();
        maps.edit(gpu, &words.maps, &edits)?;
        Self::assemble(gpu, (world, anchor), &words, maps)
    }

    /// The nearest hit of every ray within `0 <= t <= ray.t_max`, in order. `ray.from`, if any, names a
    /// surface of this world.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, GpuError> {
        let mut found = Vec::with_capacity(rays.len());
        for rays in rays.chunks(BATCH) {
            let write = |words: &mut _, ray: &_| records::write_ray(words, ray, self.anchor);
            let words = self.trace(rays, write, Answer::Nearest)?;
            let hits = words.par_chunks_exact(HIT_WORDS).map(HitRecord);
            let answer = |(ray, record)| self.answer(ray, &record);
            found.par_extend(rays.par_iter().zip(hits).map(answer));
        }
        Ok(found)
    }

    /// Whether each ray meets anything within `0 <= t <= ray.t_max`, in order. `ray.from` and the surface that does not
    /// count, if any, name surfaces of this world.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, GpuError> {
        let mut found = Vec::with_capacity(rays.len());
        for rays in rays.chunks(BATCH) {
            let write = |words: &mut _, ray: &_| records::write_shadow_ray(words, ray, self.anchor);
            let words = self.trace(rays, write, Answer::Whether)?;
            found.extend(words.into_iter().map(|met| met != 0));
        }
        Ok(found)
    }

    /// Works a hit out in `f64`; where the CPU cannot find the surface that the GPU names, at a border that is a
    /// rounding away, its own answer counts.
    fn answer(&self, ray: &Ray, record: &HitRecord<'_>) -> Traced {
        let hit = record.surface().and_then(|index| {
            let surface = self.world.surfaces().get(index as usize)?;
            let from = ray.from.filter(|from| from.surface == index);
            match completed(surface, &Ray { from, ..*ray }, record.t(ray), record) {
                Some(hit) => Some(Hit { surface: index, ..hit }),
                None => self.world.closest(ray, &mut ()),
            }
        });
        Traced { hit, work: u64::from(record.steps()) }
    }

    /// The answers to at most [`BATCH`] rays, given how one is written.
    fn trace<R: Sync>(
        &self,
        rays: &[R],
        write: impl Fn(&mut Vec<u32>, &R) + Sync,
        answer: Answer,
    ) -> Result<Vec<u32>, GpuError> {
        let gpu = self.gpu;
        let written = rays.par_chunks(CHUNK).map(|rays| {
            let mut words = Vec::with_capacity(rays.len() * RAY_WORDS);
            rays.iter().for_each(|ray| write(&mut words, ray));
            words
        });
        let words = written.collect::<Vec<_>>().concat();
        let rays_buffer = gpu.upload("rays", bytemuck::cast_slice(&words))?;
        let bytes = (rays.len() * answer.words() * 4) as u64;
        let hits = gpu.allocate("hits", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?;
        let read = gpu.allocate("hits", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let pipeline = gpu.pipeline(self.maps.closest(), self.maps.pages());
        let groups = self.groups(&pipeline, &rays_buffer, &hits);
        let count = rays.len() as u32;
        let mut first = 0;
        while first < count {
            let end = count.min(first + self.dispatch.load(Ordering::Relaxed));
            self.dispatch(&pipeline, &groups, first..end, answer)?;
            first = end;
        }
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(&hits, 0, &read, 0, bytes.div_ceil(16) * 16);
        gpu.queue.submit([commands.finish()]);
        let bytes = gpu.read(&read, bytes)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// What the kernel binds, for rays and hits in these buffers.
    pub(crate) fn groups(
        &self,
        pipeline: &wgpu::ComputePipeline,
        rays: &wgpu::Buffer,
        hits: &wgpu::Buffer,
    ) -> Vec<wgpu::BindGroup> {
        let own = [&self.params, rays, hits];
        let entries: Vec<_> = (0..)
            .zip(own.into_iter().chain(&self.buffers))
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let mut groups = vec![self.gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("closest"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &entries,
        })];
        groups.extend(self.maps.groups(self.gpu, pipeline));
        groups
    }

    /// Tells the next dispatch its rays and what is asked of them.
    pub(crate) fn set_params(&self, rays: Range<u32>, answer: Answer) {
        let whether = u32::from(answer == Answer::Whether);
        let params = [whether, rays.start, rays.end, self.surfaces];
        self.gpu.queue.write_buffer(&self.params, 0, bytemuck::cast_slice(&params));
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

    /// Traces the first `count` rays of a buffer that stay on the device: with the next commands, and then the answer is
    /// true, or before them, where they are too many for one dispatch.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub(crate) fn trace_slots(
        &self,
        pipeline: &wgpu::ComputePipeline,
        groups: &[wgpu::BindGroup],
        count: u32,
        commands: &mut wgpu::CommandEncoder,
    ) -> Result<bool, GpuError> {
        if count <= self.dispatch.load(Ordering::Relaxed) {
            self.set_params(0..count, Answer::Nearest);
            Self::pass(pipeline, groups, count, commands);
            return Ok(true);
        }
        let mut first = 0;
        while first < count {
            let end = count.min(first + self.dispatch.load(Ordering::Relaxed));
            self.dispatch(pipeline, groups, first..end, Answer::Nearest)?;
            first = end;
        }
        Ok(false)
    }

    /// Adds the tracing of so many rays.
    fn pass(
        pipeline: &wgpu::ComputePipeline,
        groups: &[wgpu::BindGroup],
        rays: u32,
        commands: &mut wgpu::CommandEncoder,
    ) {
        let mut pass = commands.begin_compute_pass(&Default::default());
        pass.set_pipeline(pipeline);
        for (index, group) in (0..).zip(groups) {
            pass.set_bind_group(index, group, &[]);
        }
        pass.dispatch_workgroups(rays.div_ceil(64), 1, 1);
    }

    /// Makes the next dispatches as long as the time that one of so many rays took says.
    pub(crate) fn took(&self, rays: u32, took: Duration) {
        if took > 2 * DISPATCH {
            self.dispatch.store((rays / 2).max(64), Ordering::Relaxed);
        } else if took < DISPATCH / 2 {
            let longer = rays.saturating_mul(2).clamp(FIRST_DISPATCH, LARGEST_DISPATCH);
            self.dispatch.fetch_max(longer, Ordering::Relaxed);
        }
    }

    /// Traces some of the rays and waits for them; the next dispatch is as long as the time says.
    fn dispatch(
        &self,
        pipeline: &wgpu::ComputePipeline,
        groups: &[wgpu::BindGroup],
        rays: Range<u32>,
        answer: Answer,
    ) -> Result<(), GpuError> {
        let gpu = self.gpu;
        self.set_params(rays.clone(), answer);
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        let count = rays.end - rays.start;
        Self::pass(pipeline, groups, count, &mut commands);
        let begin = Instant::now();
        gpu.queue.submit([commands.finish()]);
        gpu.wait()?;
        self.took(count, begin.elapsed());
        Ok(())
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
    Ok([
        upload("displaced faces", &words.faces)?,
        upload("surfaces", &words.surfaces)?,
        upload("trees", &words.nodes)?,
        upload("triangles", &words.numbers)?,
    ])
}

/// For the integrators of `rilievo-render`, which shade what is traced here.
impl Tracer for GpuWorld<'_> {
    fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, String> {
        GpuWorld::closest(self, rays).map_err(|error| error.to_string())
    }

    fn occluded(&self, rays: &[ShadowRay]) -> Result<Vec<bool>, String> {
        GpuWorld::occluded(self, rays).map_err(|error| error.to_string())
    }
}

/// The hit on the surface that a record names.
fn completed(surface: &Surface, ray: &Ray, t: f64, record: &HitRecord<'_>) -> Option<Hit> {
    match surface {
        Surface::Quad(quad) => quad.closest(ray),
        Surface::Sphere(sphere) => sphere.closest(ray),
        Surface::Mesh(mesh) => mesh.hit_on(record.triangle(), ray),
        Surface::Face(face) => Some(record.on_face(face, ray, t)),
        Surface::Instance(instance) => {
            let hit = completed(instance.prototype(), &instance.local_ray(ray), t, record)?;
            Some(instance.world_hit(hit))
        }
        Surface::ReliefSphere(sphere) => Some(record.on_relief_sphere(sphere, ray, t)),
        Surface::ReliefMesh(mesh) => Some(record.on_relief_mesh(mesh, ray, t)),
        Surface::Moving(_) => None,
    }
}
