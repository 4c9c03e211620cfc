//! [`replace`]: a file appears whole or not at all.
//!
//! The content goes to a temporary name in the same folder, is flushed to the disk, and then takes
//! the target's name in one step. If anything fails the target, if there was one, is untouched.
//!
//! A process that is killed while it writes leaves its temporary file. The name begins with a hash of
//! the target's, and whoever writes a file holds a lock on it, which ends with the process; so the next
//! one that writes the same target removes what has such a name and no owner.

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::Path;

use tempfile::NamedTempFile;

use crate::error::{Error, Result};

/// Writes `path` through `write`.
///
/// # Errors
/// [`Error::Io`] of the folder or the disk; the errors of `write`.
pub fn replace(path: &Path, write: impl FnOnce(&mut BufWriter<&File>) -> Result<()>) -> Result<()> {
    let fail = |e| Error::io(path, e);
    let folder = match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder,
        _ => Path::new("."),
    };
    if path.is_dir() {
        return Err(fail(std::io::Error::from(std::io::ErrorKind::IsADirectory)));
    }
    let prefix = prefix(path.file_name().unwrap_or_default());
    remove_left(folder, &prefix);
    let file = create(folder, &prefix).map_err(fail)?;
    let mut buffer = BufWriter::new(file.as_file());
    write(&mut buffer)?;
    buffer.flush().map_err(fail)?;
    drop(buffer);
    file.as_file().sync_all().map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    Ok(())
}

/// End of the name of every temporary file.
const SUFFIX: &str = ".part";

/// Begin of the names of temporary files of a target: FNV-1a of its name.
fn prefix(name: &OsStr) -> String {
    let hash = name.as_encoded_bytes().iter().fold(0xcbf2_9ce4_8422_2325_u64, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    });
    format!(".rilievo-{hash:016x}-")
}

/// A temporary file with a lock on it, where the system has locks.
fn create(folder: &Path, prefix: &str) -> std::io::Result<NamedTempFile> {
    loop {
        let mut builder = tempfile::Builder::new();
        builder.prefix(prefix).suffix(SUFFIX);
        permit(&mut builder);
        let file = builder.tempfile_in(folder)?;
        // Between the two steps another process may have taken it for one that was left.
        let held = !matches!(file.as_file().try_lock(), Err(fs::TryLockError::WouldBlock));
        if held && file.path().exists() {
            return Ok(file);
        }
    }
}

/// Removes temporary files whose owners are gone. What cannot be removed stays.
fn remove_left(folder: &Path, prefix: &str) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let ours = name.to_str().is_some_and(|n| n.starts_with(prefix) && n.ends_with(SUFFIX));
        if ours
            && let Ok(file) = File::options().write(true).open(entry.path())
            && file.try_lock().is_ok()
        {
            // Whoever holds the lock may remove it; if another did so before, all the better.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Temporary files are private by default; an output is a file like any other.
#[cfg(unix)]
fn permit(builder: &mut tempfile::Builder<'_, '_>) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(fs::Permissions::from_mode(0o666));
}

#[cfg(not(unix))]
fn permit(_: &mut tempfile::Builder<'_, '_>) {}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.txt");
        let put = |text: &'static str, fails: bool| {
            replace(&path, |out| {
                out.write_all(text.as_bytes()).map_err(|e| Error::io(&path, e))?;
                if fails { Err(Error::io(&path, std::io::ErrorKind::Other.into())) } else { Ok(()) }
            })
        };
        put("first", false).unwrap();
        put("half", true).unwrap_err();
        assert_eq!(fs::read_to_string(&path).unwrap(), "first");
        put("second", false).unwrap();
        assert_eq!(fs::read_to_string(&path).unwrap(), "second");
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn what_a_killed_process_left_is_removed_and_nothing_else() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.exr");
        let part = |target: &str, end: &str| {
            let path = dir.path().join(prefix(OsStr::new(target)) + end);
            fs::write(&path, "half").unwrap();
            path
        };
        let left = [part("a.exr", "x1.part"), part("a.exr", "x2.part")];
        let others = [part("b.exr", "x1.part"), part("a.exr", "x1.png")];
        // One that is being written.
        let live = create(dir.path(), &prefix(OsStr::new("a.exr"))).unwrap();
        replace(&path, |_| Ok(())).unwrap();
        assert!(path.exists() && live.path().exists());
        assert!(others.iter().all(|path| path.exists()));
        assert!(!left.iter().any(|path| path.exists()));
        live.persist(&path).unwrap();
        replace(&path, |_| Ok(())).unwrap();
        assert_eq!(fs::read_dir(dir.path()).unwrap().count(), 1 + others.len());
    }

    #[test]
    fn a_missing_folder_and_a_folder_as_target_are_errors() {
        let dir = tempfile::tempdir().unwrap();
        let missing = dir.path().join("no/such/a.txt");
        assert!(matches!(replace(&missing, |_| Ok(())), Err(Error::Io { .. })));
        assert!(matches!(replace(dir.path(), |_| Ok(())), Err(Error::Io { .. })));
    }
}
