//! The command as a user meets it: files in, files and exit codes out.

mod backends;
mod bad_inputs;
mod determinism;
mod diff;
#[cfg(unix)]
mod killed;
mod live;
mod lod;
mod maps;
mod models;
mod parts;
mod render;
mod stopped;
mod support;
mod texture_memory;
mod texture_sets;
mod usage;
mod view;
