//! Hits on displaced spheres and meshes beside those of the CPU, on the scenes and rays of their suites.
//!
//! Where both differ, the rule of the nudge decides: the CPU must give the GPU's answer to some ray turned
//! by at most 2e-6 radian. Without an adapter nothing is tried, and stderr says so. `RILIEVO_RAYS` sets the
//! rays a scene, `RILIEVO_STEP` = n takes every n-th scene only.

mod joined;
mod meshes;
mod pair;
mod spheres;
