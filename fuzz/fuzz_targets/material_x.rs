//! Any bytes are a MaterialX document or an error.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use rilievo_io::Limits;
use rilievo_io::texture_set::MaterialX;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_bytes: 16 << 20 };
    if let Ok(material) = MaterialX::read_bytes(bytes, Path::new("a.mtlx"), &limits) {
        if let Some(displacement) = material.displacement {
            assert!(displacement.scale.is_finite() && displacement.zero.is_finite());
        }
    }
});
