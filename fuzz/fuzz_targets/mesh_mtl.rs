//! Any bytes are materials within the limits or an error.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use rilievo_io::Limits;
use rilievo_io::mesh::read_materials_bytes;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_bytes: 16 << 20 };
    for material in read_materials_bytes(bytes, Path::new("a.mtl"), &limits).unwrap_or_default() {
        assert!((0.0..=1.0).contains(&material.roughness));
        assert!(material.displacement.is_none_or(|d| d.scale != 0.0));
    }
});
