//! [`Grid`]: cubic voxels around a relief, and the file in which peers get them.

use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::Path;
use std::str::FromStr;

use rilievo::map::{HeightMap, Metric};

/// `side` x `side` columns of `depth` voxels, one cell of the map a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Grid {
    pub side: u32,
    pub depth: u32,
}

impl Grid {
    /// Voxels along x, y and z.
    pub fn voxels(self) -> [u32; 3] {
        [self.side, self.side, self.depth]
    }

    pub fn count(self) -> u64 {
        self.voxels().map(u64::from).iter().product()
    }

    /// The metric in which the voxels between the lowest and the highest height are cubes of side 1.
    pub fn metric(self, heights: &HeightMap) -> Metric {
        let (low, high) = heights.raw_range();
        let range = f64::from(high - low).max(1.0);
        Metric { x: 1.0, y: 1.0, z: f64::from(self.depth) / range }
    }

    /// Which voxels are free of the surface: x fastest, then y, then z; 0 where the surface enters,
    /// else 1. `heights` has `side` cells along both axes.
    pub fn free(self, heights: &HeightMap) -> Vec<u8> {
        let (low, z) = (f64::from(heights.raw_range().0), self.metric(heights).z);
        let [side, depth] = [self.side, self.depth].map(|n| n as usize);
        let mut voxels = vec![1; side * side * depth];
        for j in 0..self.side {
            for i in 0..self.side {
                let corners = heights.stored_corners(i, j).map(|h| (f64::from(h) - low) * z);
                let least = corners.into_iter().fold(f64::INFINITY, f64::min);
                let most = corners.into_iter().fold(0.0, f64::max);
                let top = depth - 1;
                let [first, last] = [least, most].map(|h| (h as usize).min(top));
                for k in first..=last {
                    voxels[(k * side + j as usize) * side + i as usize] = 0;
                }
            }
        }
        voxels
    }

    /// Writes the free voxels as a NumPy array of bytes, shape (depth, side, side), axes z, y, x.
    ///
    /// # Errors
    /// When the file cannot be written.
    pub fn dump(self, heights: &HeightMap, path: &Path) -> Result<(), String> {
        let write = || -> io::Result<()> {
            let mut out = BufWriter::new(File::create(path)?);
            out.write_all(&self.header())?;
            out.write_all(&self.free(heights))?;
            out.flush()
        };
        write().map_err(|e| format!("{}: {e}", path.display()))
    }

    /// The head of a `.npy` file, format 1.0: padded so that the data start at a multiple of 64.
    fn header(self) -> Vec<u8> {
        let shape = format!("({}, {}, {})", self.depth, self.side, self.side);
        let mut text = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': {shape}, }}");
        while !(10 + text.len() + 1).is_multiple_of(64) {
            text.push(' ');
        }
        text.push('\n');
        let mut head = b"\x93NUMPY\x01\x00".to_vec();
        head.extend((text.len() as u16).to_le_bytes());
        head.extend(text.bytes());
        head
    }
}

impl fmt::Display for Grid {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}x{}", self.side, self.depth)
    }
}

impl FromStr for Grid {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let number = |part: &str| part.parse().ok().filter(|n| (1..=8192).contains(n));
        let parts = text.split_once('x').map(|(a, b)| (number(a), number(b)));
        match parts {
            Some((Some(side), Some(depth))) => Ok(Self { side, depth }),
            _ => Err("a grid is SIDExDEPTH in voxels, as 256x64, each from 1 to 8192".to_owned()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn every_column_is_entered_and_joined_to_its_neighbours() {
        let grid = Grid { side: 128, depth: 16 };
        let voxels = grid.free(&MapName::Studded.load(129).unwrap());
        let columns = 128 * 128;
        for column in 0..columns {
            let free: usize = (0..16).map(|k| usize::from(voxels[k * columns + column])).sum();
            assert!((0..16).contains(&free));
        }
        let full = |k: usize| voxels[k * columns..(k + 1) * columns].iter().filter(|v| **v == 0);
        assert!(full(0).count() > 0 && full(15).count() > 0 && full(7).count() > 0);
        assert!(full(7).count() < full(0).count());
    }

    #[test]
    fn the_file_is_numpys() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grid.npy");
        let grid = Grid { side: 20, depth: 5 };
        let heights = MapName::Gaussian.load(21).unwrap();
        grid.dump(&heights, &path).unwrap();
        let bytes = std::fs::read(&path).unwrap();
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert!((10 + length).is_multiple_of(64));
        let head = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(head.contains("'shape': (5, 20, 20)") && head.ends_with('\n'));
        assert_eq!(bytes[10 + length..], grid.free(&heights));
    }

    #[test]
    fn grids_are_read() {
        assert_eq!("256x64".parse(), Ok(Grid { side: 256, depth: 64 }));
        for text in ["256", "0x3", "256x", "99999x1"] {
            assert!(text.parse::<Grid>().is_err(), "{text}");
        }
    }
}
