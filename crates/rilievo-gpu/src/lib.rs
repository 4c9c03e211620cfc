//! Exact ray tracing of displacement-mapped surfaces on the GPU, through wgpu: Vulkan, Metal or
//! Direct3D 12, shaders in WGSL alone.
//!
//! [`Gpu::open`] takes the system's fastest adapter, [`GpuWorld`] brings the surfaces of a
//! [`World`](rilievo::surface::World) to it: heights as they are (two codes a word). Rays go in, hits come
//! out: nearest hits, or for shadow rays whether there is any. The shaders are the twins of the CPU's
//! modules, by path and name: the same walk in
//! the same order down to the same leaf.
//!
//! **Precision.** The CPU prepares a ray and refines a root in `f64`, which WGSL lacks. Here both are done
//! in *doubles*: unevaluated sums of two floats, about 48 bits \[Dekker1971\] (`shaders/double.wgsl`). World
//! coordinates are first taken relative to the middle of the world, in `f64` on the CPU, so that what is
//! rounded to 48 bits is as small as the world, not as large as its distance from the origin: a
//! point is off by 2^-48 of the world's size. The walk between is the CPU's `f32`, whose numbers are small
//! by construction, and the bits of its leaf and bounds are the same, for two reasons: its
//! input is rounded to `f32` from something much finer, so it differs from the CPU's in one of about 2^20 numbers, by
//! one unit in the last place; and no operation is fused or reordered, since every product and sum that could be is
//! shown to `rounded` (`shaders/float.wgsl`). Quotients and roots, which a GPU need not round to nearest,
//! decide nothing but where the refinement starts. So what the CPU's proofs say of bounds and leaf holds
//! here, and where answers differ it is by less than the rule of the nudge allows (docs/LIMITS.md).
//!
//! **Order of work.** Hits are completed on the CPU in `f64`, from cell, place and parameter: normals, position and its
//! error bound come from the code that all CPU methods share. A GPU gives back 48 bytes a ray, 4 of one that is only asked whether it
//! meets anything.
//!
//! **Flat surfaces** are met in doubles too: triangles by sheared edges, spheres by their quadratic, below trees of
//! boxes in floats, rounded outward. The CPU then meets the surface that the GPU names once more, in `f64`.
//!
//! **Maps.** Pyramids are built on the device, bit for bit the CPU's: samples are compared as whole numbers, and codes of
//! floats are proven by comparisons, so a device may divide as it likes. After an edit ([`GpuWorld::edited`]) the samples of its
//! rectangle are brought over and the nodes above them made anew. All maps of a world share one range of places; where a shader
//! binds less than that at once (128 MiB on the least of devices), it lies in several buffers. Maps past what all of them
//! hold are refused with the sizes.
//!
//! **Distances.** Methods `distance` and `distance-corrected` step through a 3-D texture in `f32`, with wider margins than
//! the CPU's `f64`, and end in the same leaf: the same hits, bit for bit (`shaders/distance.wgsl`). `distance-published` is the
//! paper's, in floats (`shaders/published.wgsl`); `march` takes the CPU's fixed steps, in doubles (`shaders/approximate.wgsl`).
//! [`Gpu::distance_map`] makes maps of all kinds on the device, code for code the CPU's (`shaders/boxes.wgsl`, `shaders/nearest.wgsl`).
//!
//! **Displaced spheres** are cut to segments over the faces of the cube, and their cells solved, in doubles; blocks are swept in floats,
//! whose slacks cover what a driver may fuse.
//!
//! **Displaced meshes** are walked prism by prism in floats, which count from the prism's own corner and from where the ray passes its
//! middle; what they round is part of the frame's error, so nothing is left out (`shells/mesh.rs`). The leaf encloses roots as the CPU's
//! does, values in doubles, derivatives in floats: what these round is part of the enclosure. Parts of one mesh count from one middle and
//! are cut to one box, so that what is computed beside an edge is the same in both; walls show the neighbour's map.
//!
//! **Light.** [`GpuScene`] runs the integrators of `rilievo-render` on the device, for scenes whose materials, lights and surfaces its shaders
//! know; see `shading.rs`. Numbers of samplers are the CPU's bit for bit, points are in doubles, weights in floats.
//!
//! **Motion.** A ray brings its time. Where a surface then is, is worked out for each ray that reaches its box, in doubles: the turn's sine and
//! cosine by their series (`shaders/motion.wgsl`). The CPU completes the hit by its own place of that time.
//!
//! **Limits.** Rays whose start is farther than 1e30
//! from the middle of the world meet nothing.
//!
//! **Watchdog.** Dispatches are cut so that each takes about a tenth of a second.
//!
//! **Measured** (2026-11, Mesa's llvmpipe 22.3, all 85 scenes of the conformance suite): 32 996 rays, none missed, none
//! false, none needed the nudge; points at most 2.9e-8 of the size from the CPU's. Displaced spheres, all 36 scenes of their suite: 11 896
//! rays, 4 in 10 of them spawned, none missed, none false, 19 excused by the nudge, points at most 1.1e-6 of the size apart. Displaced meshes, 18
//! of all kinds, moved, scaled, and in mirrored places: 3 598 rays, none missed, none false, none excused, at most 3.5e-6 apart (5 mm at a
//! distance of 270 km; 5.7e-8 where the mesh is near). Mesa compiles the shader of spheres in 9 s of one core, that of meshes in 33.

#![forbid(unsafe_code)]

mod backend;
mod bounds;
mod device;
mod distance_build;
mod distances;
mod error;
mod forms;
mod maps;
mod measure;
mod pages;
mod pyramid_build;
mod records;
mod shaders;
mod shading;
mod shells;
mod surfaces;
mod traffic;
mod upload;
mod world;

pub use backend::{Backend, GpuTracer, UnknownBackend, check};
pub use device::Gpu;
pub use error::GpuError;
pub use measure::GpuRays;
pub use shading::{GpuLight, GpuScene, GpuShaders};
pub use traffic::GpuBytes;
pub use world::{GpuKernels, GpuMaps, GpuSurfaces, GpuWorld, MapEdit};
// Its types stand in what `Gpu` gives away.
pub use wgpu;
