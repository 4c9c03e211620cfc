//! The command as a user meets it: files in, files and exit codes out.

mod bad_inputs;
mod determinism;
mod diff;
mod live;
mod maps;
mod models;
mod render;
mod stopped;
mod support;
mod texture_sets;
mod usage;
