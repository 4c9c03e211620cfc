//! Exact ray tracing of displacement-mapped surfaces without tessellation.
//!
//! A surface is a coarse base and a height map. A ray goes in, a hit on the displaced surface
//! itself comes out: no triangles are made, and memory depends on the map alone. The library knows
//! no light, material, camera or file; it is meant to sit inside a renderer, anyone's.
//!
//! A stepped face under a grid of upright rays, drawn by the height they meet:
//!
//! ```
//! use std::sync::Arc;
//! use rilievo::{Ray, glam::DVec3};
//! use rilievo::map::{HeightMap, Lattice, Samples, Wrap};
//! use rilievo::relief::{Displacement, FaceOptions, Relief, ReliefFace};
//!
//! // A pyramid of steps: 5 x 5 samples.
//! let steps = [0, 0, 0, 0, 0, 0, 2, 2, 2, 0, 0, 2, 4, 2, 0, 0, 2, 2, 2, 0, 0, 0, 0, 0, 0];
//! let samples = Samples::U16(steps.map(|s| s * 16383).to_vec());
//! let map = HeightMap::new(5, 5, samples, Lattice::Vertex, Wrap::Clamp)?;
//!
//! let displacement = Displacement { scale: 0.5, ..Displacement::default() };
//! let options = FaceOptions { displacement, ..FaceOptions::default() };
//! let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
//! let face = ReliefFace::new(corners, Arc::new(Relief::new(map)), options)?;
//!
//! let mut picture = String::new();
//! for y in (0..8).rev() {
//!     for x in 0..20 {
//!         let over = DVec3::new((f64::from(x) + 0.5) / 20.0, (f64::from(y) + 0.5) / 8.0, 2.0);
//!         let hit = face.closest(&Ray::new(over, DVec3::NEG_Z), &mut ()).expect("rays fall on it");
//!         picture.push(b".-=+*#%@"[(hit.height * 7.99) as usize] as char);
//!     }
//!     picture.push('\n');
//! }
//! assert_eq!(picture, "\
//! ....................
//! ..-==============-..
//! .--=+**********+=--.
//! .--=+**#%%%%#**+=--.
//! .--=+**#%%%%#**+=--.
//! .--=+**********+=--.
//! ..-==============-..
//! ....................
//! ");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Map of the crate
//!
//! - [`Ray`], [`Hit`]: in and out. A hit spawns rays that neither meet their own start nor slip
//!   through it, without an epsilon to choose.
//! - [`map`]: height maps and what is derived from them: normals, distance maps, min-max pyramid.
//! - [`relief`]: displaced faces, spheres and meshes, and the methods that walk rays through them.
//! - [`surface`]: everything that can be hit, and the world that holds it.
//! - [`mesh`], [`accel`]: undisplaced triangle meshes and the BVH, which knows nothing of relief.
//! - [`Probe`]: counters of the work done; `()` counts nothing and costs nothing.
//!
//! # Current state
//!
//! Displacement lies on parallelograms, spheres and triangle meshes, along their normals.
//! docs/LIMITS.md lists what else is missing.

pub mod accel;
mod hit;
pub mod map;
pub mod mesh;
mod probe;
mod ray;
pub mod relief;
mod simd;
mod spherical;
pub mod surface;

pub use glam;
pub use hit::Hit;
pub use probe::{Counters, Probe};
pub use ray::{Coherence, Origin, Part, Ray, Wall};
pub use simd::{SimdLevel, UnknownSimdLevel};
