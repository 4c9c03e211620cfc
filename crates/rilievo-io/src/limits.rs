//! [`Limits`]: how much memory a file may ask for.
//!
//! A header of forty bytes can declare an image of petabytes. Every reader takes a [`Limits`] and
//! compares the declared size with it *before* it allocates.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use crate::error::{Error, Place, Result};

/// What a reader may allocate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest size in bytes of the decoded samples of one file, and of the file where it is read
    /// as a whole.
    pub max_bytes: u64,
}

impl Default for Limits {
    /// 4 GiB: a 32768 x 32768 map of 32-bit samples just fits.
    fn default() -> Self {
        Self { max_bytes: 4 << 30 }
    }
}

impl Limits {
    /// Checks that `what`, declared at `place` of `path`, fits: the product of `factors` is its
    /// size in bytes.
    ///
    /// # Errors
    /// [`Error::Limit`] if it does not.
    pub fn check(&self, path: &Path, place: Place, what: &str, factors: &[u64]) -> Result<()> {
        let needed = factors.iter().fold(1_u64, |product, &f| product.saturating_mul(f));
        let most = self.max_bytes.min(isize::MAX as u64);
        if needed <= most {
            return Ok(());
        }
        let (path, what) = (path.to_owned(), what.to_owned());
        Err(Error::Limit { path, place, what, needed, allowed: most })
    }

    /// Reads a whole file.
    ///
    /// # Errors
    /// [`Error::Io`], or [`Error::Limit`] for a file above the limit, which is not read.
    pub fn read(&self, path: &Path) -> Result<Vec<u8>> {
        let fail = |e| Error::io(path, e);
        let file = File::open(path).map_err(fail)?;
        let length = file.metadata().map_err(fail)?.len();
        self.check(path, Place::File, "reading the file", &[length])?;
        let mut bytes = Vec::with_capacity(length as usize);
        // A pipe or a growing file may hold more than its length says.
        file.take(self.max_bytes.saturating_add(1)).read_to_end(&mut bytes).map_err(fail)?;
        self.check(path, Place::File, "reading the file", &[bytes.len() as u64])?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_that_overflow_are_refused() {
        let limits = Limits::default();
        let path = Path::new("a.png");
        assert!(limits.check(path, Place::Header, "x", &[32768, 32768, 4]).is_ok());
        let e = limits.check(path, Place::Header, "x", &[u64::MAX, u64::MAX, 8]);
        assert!(matches!(e, Err(Error::Limit { needed: u64::MAX, .. })));
    }

    #[test]
    fn large_files_are_not_read() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        std::fs::write(&path, [0; 100]).unwrap();
        assert_eq!(Limits { max_bytes: 100 }.read(&path).unwrap().len(), 100);
        assert!(matches!(Limits { max_bytes: 99 }.read(&path), Err(Error::Limit { .. })));
        assert!(matches!(Limits::default().read(dir.path()), Err(Error::Io { .. })));
    }
}
