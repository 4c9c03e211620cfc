//! Bindings to Embree 3.13, as far as the bench needs them: regular height grids as triangles,
//! quads or a GRID, traced by one thread.
//!
//! `ffi` repeats the header, `device` and `scene` own what the library hands out, `trace` calls it.
//! Everything that leaves this module is safe: a [`Scene`] is committed when it is made, never
//! changes and releases itself.

#![expect(unsafe_code, reason = "calls a C library")]

mod device;
mod ffi;
mod scene;
mod trace;

pub use scene::{Scene, Shape};
pub use trace::{Packets, Ray1};
