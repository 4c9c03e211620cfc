//! [`replace`]: a file appears whole or not at all.
//!
//! The content goes to a temporary name in the same folder, is flushed to the disk, and then takes
//! the target's name in one step. If anything fails the target, if there was one, is untouched.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

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
    let mut builder = tempfile::Builder::new();
    builder.prefix(".rilievo-").suffix(".part");
    permit(&mut builder);
    let file = builder.tempfile_in(folder).map_err(fail)?;
    let mut buffer = BufWriter::new(file.as_file());
    write(&mut buffer)?;
    buffer.flush().map_err(fail)?;
    drop(buffer);
    file.as_file().sync_all().map_err(fail)?;
    file.persist(path).map_err(|e| fail(e.error))?;
    Ok(())
}

/// Temporary files are private by default; an output is a file like any other.
#[cfg(unix)]
fn permit(builder: &mut tempfile::Builder<'_, '_>) {
    use std::os::unix::fs::PermissionsExt;
    builder.permissions(std::fs::Permissions::from_mode(0o666));
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
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "first");
        put("second", false).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "second");
        assert_eq!(std::fs::read_dir(dir.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_and_a_folder_as_target_are_errors() {
        let dir = tempfile::tempdir().unwrap();
        let missing = dir.path().join("no/such/a.txt");
        assert!(matches!(replace(&missing, |_| Ok(())), Err(Error::Io { .. })));
        assert!(matches!(replace(dir.path(), |_| Ok(())), Err(Error::Io { .. })));
    }
}
