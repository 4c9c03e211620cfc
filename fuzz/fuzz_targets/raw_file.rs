//! Any bytes are the header beside a `.bil` file and its samples, within the limits and without voids, or an error: what stands
//! before the first NUL is the header, the rest are samples.

#![no_main]

use std::path::PathBuf;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use rilievo_io::Limits;
use rilievo_io::image::{HeightOptions, Terrain};

/// A folder of this process's own: the header is read from beside the file.
static FOLDER: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = std::env::temp_dir().join(format!("rilievo-fuzz-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder for headers");
    folder
});

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_bytes: 16 << 20 };
    let mut parts = bytes.splitn(2, |&byte| byte == 0);
    let (header, samples) = (parts.next().unwrap_or_default(), parts.next().unwrap_or_default());
    std::fs::write(FOLDER.join("a.hdr"), header).expect("room for a header");
    let path = FOLDER.join("a.bil");
    std::fs::write(&path, samples).expect("room for samples");
    if let Ok(map) = HeightOptions::default().read(&path, &limits) {
        assert!(map.bytes() <= limits.max_bytes);
        assert!(map.height_at(0.3, 0.7).is_finite());
    }
    if let Ok(Some(ground)) = Terrain::read(&path, &limits) {
        assert!(ground.cell.iter().all(|side| side.is_finite() && *side > 0.0));
    }
});
