//! Any bytes are heights of a survey format within the limits, without voids, or an error.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use rilievo_io::Limits;
use rilievo_io::image::HeightOptions;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_bytes: 16 << 20 };
    for name in ["N40W106.hgt", "a.asc"] {
        if let Ok(map) = HeightOptions::default().read_bytes(bytes, Path::new(name), &limits) {
            assert!(map.bytes() <= limits.max_bytes);
            assert!(map.height_at(0.3, 0.7).is_finite());
        }
    }
});
