//! [`GpuWorld`]: surfaces on a GPU, ready to trace.

use std::collections::HashMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use rilievo::glam::DVec3;
use rilievo::map::{Layout, Pyramid};
use rilievo::relief::ReliefFace;
use rilievo::surface::{Surface, World};
use rilievo::{Hit, Ray};
use wgpu::BufferUsages;

use crate::device::Gpu;
use crate::error::GpuError;
use crate::records::{self, HIT_WORDS, HitRecord, MapPlace, RAY_WORDS};

/// Rays uploaded at once.
const BATCH: usize = 1 << 20;

/// Rays of the first dispatch.
const FIRST_DISPATCH: u32 = 1 << 14;

/// Rays of the largest dispatch: 64 a workgroup, at most 65535 workgroups.
const LARGEST_DISPATCH: u32 = 1 << 20;

/// A dispatch is to take about this long: far from the seconds after which drivers reset a GPU, long enough that
/// its start does not count.
const DISPATCH: Duration = Duration::from_millis(100);

/// The answer to one ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Traced {
    /// The nearest hit.
    pub hit: Option<Hit>,
    /// Nodes and blocks of cells looked at.
    pub steps: u32,
}

/// Surfaces on a GPU.
pub struct GpuWorld<'a> {
    gpu: &'a Gpu,
    surfaces: &'a [Surface],
    anchor: DVec3,
    faces: u32,
    buffers: [wgpu::Buffer; 3],
    params: wgpu::Buffer,
    /// Rays of the next dispatch; follows the time that dispatches take.
    dispatch: AtomicU32,
}

impl<'a> GpuWorld<'a> {
    /// Brings the surfaces of a world to a GPU: heights and pyramids, each map once.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for a surface that is no displaced face or is traced by a method that
    /// is not exact; otherwise as the device says.
    pub fn new(gpu: &'a Gpu, world: &'a World) -> Result<Self, GpuError> {
        let surfaces = world.surfaces();
        let bounds = world.bounds();
        let anchor =
            if surfaces.is_empty() { DVec3::ZERO } else { bounds.min.midpoint(bounds.max) };
        let mut maps = Maps::default();
        let mut faces = Vec::new();
        for (index, surface) in (0..).zip(surfaces) {
            let face = supported(surface)?;
            let place = maps.place(face);
            records::write_face(&mut faces, (face, index), place, anchor);
        }
        let upload =
            |what, words: &Vec<u32>| gpu.upload(what, bytemuck::cast_slice(words.as_slice()));
        let buffers = [
            upload("surfaces", &faces)?,
            upload("height maps", &maps.heights)?,
            upload("bounds", &maps.bounds)?,
        ];
        let params = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        Ok(Self {
            gpu,
            surfaces,
            anchor,
            faces: surfaces.len() as u32,
            buffers,
            params: gpu.allocate("parameters", 16, params)?,
            dispatch: AtomicU32::new(FIRST_DISPATCH),
        })
    }

    /// The nearest hit of every ray within `0 <= t <= ray.t_max`, in order. `ray.from`, if any, names a
    /// surface of this world.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`], [`GpuError::Lost`].
    pub fn closest(&self, rays: &[Ray]) -> Result<Vec<Traced>, GpuError> {
        let mut found = Vec::with_capacity(rays.len());
        for rays in rays.chunks(BATCH) {
            let words = self.trace(rays)?;
            let hits = words.chunks_exact(HIT_WORDS).map(HitRecord);
            found.extend(rays.iter().zip(hits).map(|(ray, record)| self.answer(ray, &record)));
        }
        Ok(found)
    }

    fn answer(&self, ray: &Ray, record: &HitRecord<'_>) -> Traced {
        let hit = record.surface().and_then(|index| match self.surfaces.get(index as usize)? {
            Surface::Face(face) => Some(Hit { surface: index, ..record.on_face(face, ray) }),
            _ => None,
        });
        Traced { hit, steps: record.steps() }
    }

    /// The records of the nearest hits of at most [`BATCH`] rays.
    fn trace(&self, rays: &[Ray]) -> Result<Vec<u32>, GpuError> {
        let gpu = self.gpu;
        let mut words = Vec::with_capacity(rays.len() * RAY_WORDS);
        rays.iter().for_each(|ray| records::write_ray(&mut words, ray, self.anchor));
        let rays_buffer = gpu.upload("rays", bytemuck::cast_slice(&words))?;
        let bytes = (rays.len() * HIT_WORDS * 4) as u64;
        let hits = gpu.allocate("hits", bytes, BufferUsages::STORAGE | BufferUsages::COPY_SRC)?;
        let read = gpu.allocate("hits", bytes, BufferUsages::MAP_READ | BufferUsages::COPY_DST)?;
        let [faces, heights, bounds] = &self.buffers;
        let bound = [&self.params, &rays_buffer, &hits, faces, heights, bounds];
        let entries: Vec<_> = (0..)
            .zip(bound)
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("closest"),
            layout: &gpu.closest.get_bind_group_layout(0),
            entries: &entries,
        });
        let count = rays.len() as u32;
        let mut first = 0;
        while first < count {
            let end = count.min(first + self.dispatch.load(Ordering::Relaxed));
            self.dispatch(&group, first..end)?;
            first = end;
        }
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        commands.copy_buffer_to_buffer(&hits, 0, &read, 0, bytes.div_ceil(16) * 16);
        gpu.queue.submit([commands.finish()]);
        let bytes = gpu.read(&read, bytes)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Traces some of the rays and waits for them; the next dispatch is as long as the time says.
    fn dispatch(
        &self,
        group: &wgpu::BindGroup,
        rays: std::ops::Range<u32>,
    ) -> Result<(), GpuError> {
        let gpu = self.gpu;
        let params = [0, rays.start, rays.end, self.faces];
        gpu.queue.write_buffer(&self.params, 0, bytemuck::cast_slice(&params));
        let mut commands = gpu.device.create_command_encoder(&Default::default());
        let mut pass = commands.begin_compute_pass(&Default::default());
        pass.set_pipeline(&gpu.closest);
        pass.set_bind_group(0, group, &[]);
        pass.dispatch_workgroups((rays.end - rays.start).div_ceil(64), 1, 1);
        drop(pass);
        let begin = Instant::now();
        gpu.queue.submit([commands.finish()]);
        gpu.wait()?;
        let took = begin.elapsed();
        let done = rays.end - rays.start;
        if took > 2 * DISPATCH {
            self.dispatch.store((done / 2).max(64), Ordering::Relaxed);
        } else if took < DISPATCH / 2 {
            let longer = done.saturating_mul(2).clamp(FIRST_DISPATCH, LARGEST_DISPATCH);
            self.dispatch.fetch_max(longer, Ordering::Relaxed);
        }
        Ok(())
    }
}

/// The face that a surface is, if the shaders know it.
fn supported(surface: &Surface) -> Result<&ReliefFace, GpuError> {
    match surface {
        Surface::Face(face) if face.options().method.is_exact() => Ok(face),
        Surface::Face(face) => {
            Err(GpuError::Unsupported { what: format!("method {}", face.options().method) })
        }
        other => Err(GpuError::Unsupported { what: kind(other).to_owned() }),
    }
}

/// What a surface is called.
fn kind(surface: &Surface) -> &'static str {
    match surface {
        Surface::Quad(_) => "a quad without displacement",
        Surface::Sphere(_) => "a sphere",
        Surface::Mesh(_) => "a mesh",
        Surface::Face(_) => "a displaced quad",
        Surface::ReliefSphere(_) => "a displaced sphere",
        Surface::ReliefMesh(_) => "a displaced mesh",
        Surface::Instance(_) => "an instance",
        Surface::Moving(_) => "a surface that moves",
    }
}

/// The maps of a world, each once.
#[derive(Default)]
struct Maps {
    heights: Vec<u32>,
    bounds: Vec<u32>,
    places: HashMap<usize, MapPlace>,
}

impl Maps {
    fn place(&mut self, face: &ReliefFace) -> MapPlace {
        let relief = face.relief();
        let Self { heights, bounds, places } = self;
        *places.entry(Arc::as_ptr(relief).addr()).or_insert_with(|| {
            let map = relief.heights();
            // Hits do not depend on the layout.
            let written = records::write_bounds(bounds, relief.pyramid()).or_else(|| {
                records::write_bounds(bounds, &Pyramid::build_as(map, Layout::Default))
            });
            MapPlace {
                heights: records::write_heights(heights, map),
                bounds: written.unwrap_or_default(),
            }
        })
    }
}
