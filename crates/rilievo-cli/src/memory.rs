//! Memory: what a render will need, and what this process has needed so far.

use rilievo_render::MemoryUse;

/// Resident before any file is read: code, allocator, terminal and threads' own pages.
const PROCESS_BYTES: u64 = 8 << 20;

/// Bytes that a render will need at its peak. There are two peaks: reading the files, where
/// decoders hold copies, and writing the picture. The first is over when this is asked, so it is
/// taken from the system; the second is what `render` says, `writing` the picture, and the process.
pub fn predicted_bytes(render: &MemoryUse, writing: u64) -> u64 {
    let writing = render.total() + writing + PROCESS_BYTES;
    writing.max(peak_rss_bytes().unwrap_or(0))
}

/// Largest resident size of this process so far. None where the system does not tell.
pub fn peak_rss_bytes() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024)
}
