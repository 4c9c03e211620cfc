//! rilievo-render: a renderer on top of [`rilievo`].
//!
//! A [`Scene`] is built from surfaces, materials and a [`Camera`]; [`render()`] traces it into a
//! [`Film`] of linear radiance and named layers. Nothing here reads a file, prints or keeps a
//! clock. The same scene gives the same bytes for any number of threads.
//!
//! ```
//! use rilievo::{glam::DVec3, surface::{Quad, Surface, World}};
//! use rilievo_render::{
//!     Camera, CameraParts, Material, RenderOptions, RenderSettings, Rgb, Scene, SceneParts, render,
//! };
//!
//! // A grey floor under a lamp of 1 x 1 whose front looks down.
//! let [x, y, z] = DVec3::AXES;
//! let floor = Quad::new([-x - y, x - y, x + y, y - x].map(|c| 9.0 * c), false)?;
//! let lamp = Quad::new([z, y + z, x + y + z, x + z].map(|c| c - 0.5 * (x + y) + z), false)?;
//! let scene = Scene::new(SceneParts {
//!     world: World::new(vec![Surface::Quad(floor), Surface::Quad(lamp)]),
//!     materials: vec![Material::default(), Material { emitted: Rgb::ONE, ..Material::default() }],
//!     material_of: vec![0, 1],
//!     camera: Camera::new(CameraParts {
//!         position: DVec3::new(0.0, -4.0, 1.0),
//!         look_at: DVec3::ZERO,
//!         up: DVec3::Z,
//!         fov: 1.0,
//!         resolution: [8, 8],
//!     })?,
//!     background: Rgb::ZERO,
//!     ambient: Rgb::ZERO,
//!     settings: RenderSettings { samples: 64, ..RenderSettings::default() },
//! })?;
//! let (film, stats) = render(&scene, &RenderOptions::default())?;
//! assert!(stats.complete);
//!
//! // Two units below its middle the lamp's irradiance is 0.2308; half of it is reflected, over pi.
//! let middle = film.radiance()[8 * 4 + 4][0];
//! assert!((middle - 0.5 * 0.2308 / std::f32::consts::PI).abs() < 1e-4, "{middle}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! - [`scene`]: what is rendered, checked once, immutable after.
//! - [`texture`], [`colour`]: colour images and the sRGB curve.
//! - [`bsdf`]: a material at one hit, evaluated and sampled.
//! - [`light`]: the emitters that are sampled.
//! - [`sampler`]: absolute (pixel, sample, dimension) to numbers, and warps with their densities.
//! - [`integrator`]: what is estimated at a pixel.
//! - [`mod@denoise`]: noise averaged away, edges kept.
//! - [`film`]: the image, pixel filters, tone mapping, false colours.
//! - [`mod@render`]: tiles over threads, progress, cancellation.
//! - [`memory`]: what a render will hold.
//! - [`device`]: a scene in words, for integrators that shade where rays are traced.
//! - [`tracer`]: what traces rays in place of the CPU's threads, a GPU for instance.

#![forbid(unsafe_code)]

pub mod bsdf;
pub mod colour;
pub mod denoise;
pub mod device;
pub mod film;
pub mod integrator;
mod level_of_detail;
pub mod light;
pub mod memory;
mod pass;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod texture;
pub mod tracer;

pub use bsdf::{Bsdf, Scattered};
pub use colour::Rgb;
pub use film::{Aov, Film, Filter, FilterKind};
pub use integrator::{Integrator, RayCounts};
pub use memory::MemoryUse;
pub use render::{RenderError, RenderOptions, RenderStats, begin, check, render, resume};
pub use sampler::{PathSampler, SamplerKind};
pub use scene::{
    Camera, CameraError, CameraParts, Lens, Material, MaterialError, Pose, Projection, Reflectance,
    RenderSettings, Scene, SceneError, SceneParts, SettingsError,
};
pub use texture::{ColourImage, Texels, Texture, TextureError};
pub use tracer::{CameraRay, Seen, ShadowRay, Traced, Tracer};
