//! Any bytes are an image within the limits or an error.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use rilievo_io::Limits;
use rilievo_io::image::{ChannelImage, HeightOptions, read_colour_bytes};

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_bytes: 16 << 20 };
    let name = Path::new("map");
    if let Ok(map) = HeightOptions::default().read_bytes(bytes, name, &limits) {
        assert!(map.bytes() <= limits.max_bytes);
        assert!(map.height_at(0.3, 0.7).is_finite());
    }
    let _ = read_colour_bytes(bytes, name, &limits);
    let _ = ChannelImage::read_bytes(bytes, name, &limits);
});
