//! Scene files: TOML text to a [`Scene`](rilievo_render::Scene) ready to be rendered.
//!
//! Text -> [`SceneFile`] (what was written, values checked one by one, places kept) ->
//! [`LoadedScene`] (names looked up, files read, everything checked against everything). docs/SCENE.md
//! names every key.
//!
//! Every error names file, line, column, the value found and the values allowed, and shows the
//! line:
//!
//! ```
//! use std::path::Path;
//! use rilievo_io::scene::SceneFile;
//!
//! let text = "[camera]\nposition = [0, 0, 1]\nlook_at = [0, 0, 0]\nfvo = 40\n";
//! let error = SceneFile::parse(text, Path::new("scene.toml")).unwrap_err();
//! assert_eq!(error.to_string(), "\
//! scene.toml:4:1: camera: unknown key `fvo`; did you mean `fov`?; allowed: position, look_at, up, fov, resolution, projection, height, aperture, f_stop, focus_distance, blades, blade_rotation, motion, shutter
//!   |
//! 4 | fvo = 40
//!   | ^^^");
//! ```

#[cfg(test)]
mod asked;
mod cache;
mod file;
mod instances;
mod keys;
mod load_map;
mod materials;
mod model_material;
mod models;
mod options;
mod present;
mod relief_mesh;
mod relief_sphere;
mod resolve;
mod set_materials;
mod sets;
mod syntax;
mod terrain;
mod texture_memory;

pub use cache::{Cache, KeptMap, Stamp};
pub use file::SceneFile;
pub use keys::reference;
pub use options::{BuildDistances, DistanceBuild, LoadOptions};
pub use relief_sphere::LoadedSphereMap;
pub use resolve::{LoadedMap, LoadedScene};

pub(crate) use syntax::quoted;
