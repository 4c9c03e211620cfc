//! Whole renders, through the public interface.

mod cameras;
mod closed_forms;
mod determinism;
mod emitters;
mod interreflection;
mod layers;
mod level_of_detail;
mod motion;
mod parts;
mod paths;
mod recorded;
mod relief;
mod scene;
mod scenes;
mod tiles;
mod waves;
