//! [`Fingerprint`]: whether two renders are of the same scene under the same settings.

use std::fmt;
use std::fs::{self, File};
use std::io::Read;
use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::image::Udim;

/// A hash of 128 bits over what a render depends on. It tells a mistake, not a forgery: nothing
/// about it is cryptographic.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint([u64; 2]);

/// Odd factors, from the fractions of the golden ratio and of the square root of 2.
const FACTORS: [u64; 2] = [0x9e37_79b9_7f4a_7c15, 0x6a09_e667_f3bc_c909];

impl Default for Fingerprint {
    /// Of nothing.
    fn default() -> Self {
        Self([0x243f_6a88_85a3_08d3, 0x1319_8a2e_0370_7344])
    }
}

impl Fingerprint {
    /// Takes in some bytes, and where they end.
    pub fn add(&mut self, bytes: &[u8]) {
        self.words(bytes);
        self.word(bytes.len() as u64);
    }

    /// Takes in the content of a file.
    ///
    /// # Errors
    /// [`Error::Io`].
    pub fn add_file(&mut self, path: &Path) -> Result<()> {
        let fail = |e| Error::io(path, e);
        let mut file = File::open(path).map_err(fail)?;
        let mut block = vec![0; 1 << 16];
        let (mut filled, mut length) = (0, 0_u64);
        loop {
            let read = file.read(&mut block[filled..]).map_err(fail)?;
            (filled, length) = (filled + read, length + read as u64);
            if filled == block.len() || read == 0 {
                self.words(&block[..filled]);
                filled = 0;
            }
            if read == 0 {
                self.word(length);
                return Ok(());
            }
        }
    }

    /// Takes in what a path of a scene stands for: a file, all tiles of one with `<UDIM>` in its name, or
    /// the files of a folder.
    ///
    /// # Errors
    /// [`Error::Io`]; [`Error::Invalid`] where there are no tiles.
    pub fn add_reference(&mut self, path: &Path) -> Result<()> {
        if let Some(tiles) = Udim::find(path)? {
            return self.add_named(tiles.tiles.into_iter().map(|(_, _, tile)| tile).collect());
        }
        if !path.is_dir() {
            return self.add_file(path);
        }
        let fail = |e| Error::io(path, e);
        let mut files = Vec::new();
        for entry in fs::read_dir(path).map_err(fail)? {
            files.push(entry.map_err(fail)?.path());
        }
        files.retain(|file| file.is_file());
        files.sort();
        self.add_named(files)
    }

    /// Takes in files with their names.
    fn add_named(&mut self, files: Vec<PathBuf>) -> Result<()> {
        for file in files {
            self.add(file.file_name().unwrap_or_default().as_encoded_bytes());
            self.add_file(&file)?;
        }
        Ok(())
    }

    fn words(&mut self, bytes: &[u8]) {
        let mut words = bytes.chunks_exact(8);
        for word in &mut words {
            self.word(u64::from_le_bytes(word.try_into().unwrap_or_default()));
        }
        let rest = words.remainder();
        if !rest.is_empty() {
            let mut word = [0; 8];
            word[..rest.len()].copy_from_slice(rest);
            self.word(u64::from_le_bytes(word));
        }
    }

    fn word(&mut self, word: u64) {
        for (state, factor) in self.0.iter_mut().zip(FACTORS) {
            let mixed = (*state ^ word).wrapping_mul(factor);
            *state = mixed ^ (mixed >> 29) ^ state.rotate_left(31);
        }
    }
}

impl fmt::Display for Fingerprint {
    /// 32 hexadecimal digits.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:016x}{:016x}", self.0[0], self.0[1])
    }
}

#[cfg(test)]
mod tests {
    use std::collections::HashSet;

    use super::*;

    fn of(parts: &[&[u8]]) -> String {
        let mut fingerprint = Fingerprint::default();
        parts.iter().for_each(|part| fingerprint.add(part));
        fingerprint.to_string()
    }

    #[test]
    fn other_content_has_another_fingerprint() {
        let cases: [&[&[u8]]; 8] =
            [&[], &[b""], &[b"a"], &[b"b"], &[b"ab"], &[b"a", b"b"], &[b"a\0"], &[b"12345678"]];
        let different: HashSet<_> = cases.iter().map(|parts| of(parts)).collect();
        assert_eq!(different.len(), cases.len());
        // One bit anywhere.
        let bytes = [7; 100];
        let mut seen = HashSet::from([of(&[&bytes])]);
        for bit in 0..800 {
            let mut changed = bytes;
            changed[bit / 8] ^= 1 << (bit % 8);
            assert!(seen.insert(of(&[&changed])), "{bit}");
        }
    }

    #[test]
    fn a_file_counts_as_its_bytes() {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a");
        for length in [0, 1, 8, 65535, 65536, 65537, 200_003] {
            let bytes: Vec<u8> = (0..length).map(|k: u64| (k * k / 7) as u8).collect();
            fs::write(&path, &bytes).unwrap();
            let mut fingerprint = Fingerprint::default();
            fingerprint.add_file(&path).unwrap();
            assert_eq!(fingerprint.to_string(), of(&[&bytes]), "{length}");
        }
        let missing = Fingerprint::default().add_file(&dir.path().join("b"));
        assert!(matches!(missing, Err(Error::Io { .. })));
    }

    #[test]
    fn folders_and_tiles_stand_for_their_files() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, bytes: &[u8]| fs::write(dir.path().join(name), bytes).unwrap();
        let of = |path: &Path| {
            let mut fingerprint = Fingerprint::default();
            fingerprint.add_reference(path).unwrap();
            fingerprint
        };
        write("a_1001.png", b"one");
        write("b.png", b"other");
        let (folder, tiles) = (dir.path(), &dir.path().join("a_<UDIM>.png"));
        let before = (of(folder), of(tiles));
        assert_eq!((of(folder), of(tiles)), before);
        write("a_1002.png", b"two");
        assert!(of(folder) != before.0 && of(tiles) != before.1);
        let before = of(tiles);
        write("b.png", b"changed");
        assert_eq!(of(tiles), before);
        let missing = Fingerprint::default().add_reference(&folder.join("c_<UDIM>.png"));
        assert!(missing.is_err());
    }
}
