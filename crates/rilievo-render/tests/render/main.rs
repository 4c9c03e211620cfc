//! Whole renders, through the public interface.

mod closed_forms;
mod determinism;
mod layers;
mod scene;
mod scenes;
