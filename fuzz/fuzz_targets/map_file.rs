//! Any bytes are a baked map, which comes back the same when written, or an error.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use rilievo_io::Limits;
use rilievo_io::map_file::BakedMap;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_bytes: 16 << 20 };
    let Ok(map) = BakedMap::read_bytes(bytes, Path::new("map"), &limits) else { return };
    let path = std::env::temp_dir().join(format!("rilievo-fuzz-{}", std::process::id()));
    map.write(&path).expect("what was read can be written");
    let written = std::fs::read(&path).expect("what was written is there");
    let _ = std::fs::remove_file(&path);
    assert_eq!(written, bytes);
});
