//! Any text is a scene or an error that shows a place in it.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use rilievo_io::scene::SceneFile;

fuzz_target!(|text: &str| {
    if let Err(error) = SceneFile::parse(text, Path::new("scene.toml")) {
        assert!(error.to_string().starts_with("scene.toml:"), "{error}");
    }
});
