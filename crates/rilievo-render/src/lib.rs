//! rilievo-render: a renderer on top of [`rilievo`].
//!
//! A [`Scene`] is built from surfaces, materials and a [`Camera`]; [`render`] traces it into a
//! [`Film`] of linear radiance and named layers. Nothing here reads a file, prints or keeps a
//! clock. The same scene gives the same bytes for any number of threads.
//!
//! - [`scene`]: what is rendered, checked once, immutable after.
//! - [`texture`], [`colour`]: colour images and the sRGB curve.
//! - [`light`]: the emitters that are sampled.
//! - [`sampler`]: absolute (pixel, sample, dimension) to numbers, and warps with their densities.
//! - [`integrator`]: what is estimated at a pixel.
//! - [`film`]: the image, pixel filters, tone mapping, false colours.
//! - [`mod@render`]: tiles over threads, progress, cancellation.

pub mod colour;
pub mod film;
pub mod integrator;
pub mod light;
pub mod render;
pub mod sampler;
pub mod scene;
pub mod texture;

pub use colour::Rgb;
pub use film::{Aov, Film, Filter};
pub use integrator::Integrator;
pub use render::{RenderError, RenderOptions, RenderStats, render};
pub use scene::{
    Camera, CameraError, CameraParts, Material, MaterialError, Reflectance, RenderSettings, Scene,
    SceneError, SceneParts, SettingsError,
};
pub use texture::{ColourImage, Texels, Texture, TextureError};
