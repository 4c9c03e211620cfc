//! [`Udim`]: an image in tiles, one file for each unit square of uv.
//!
//! A path with `<UDIM>` in it stands for all files that have a number there: tile (u, v), which covers
//! `[u, u + 1] x [v, v + 1]`, is number `1001 + u + 10 v` with u below 10 \[Seymour2014\]. The tiles are put
//! together to one image of `columns` x `rows` tiles, all of one size; where a tile is missing the
//! image is 0. It is laid over uv with `1 / columns` and `1 / rows` repetitions.

use std::path::{Path, PathBuf};

use crate::error::{Error, Place, Result};

/// What stands for the number in a path.
pub(crate) const MARK: &str = "<UDIM>";
/// Number of the first tile, and tiles of a row.
const FIRST: u32 = 1001;
const ROW: u32 = 10;
/// Highest number.
const LAST: u32 = 1999;

/// The tiles of an image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Udim {
    /// Tiles along u.
    pub columns: u32,
    /// Tiles along v.
    pub rows: u32,
    /// Column, row and file of every tile there is, by number.
    pub tiles: Vec<(u32, u32, PathBuf)>,
}

impl Udim {
    /// The tiles of `path`; none if it has no `<UDIM>` in its last part.
    ///
    /// # Errors
    /// Of the folder; [`Error::Invalid`] where no tile is there.
    pub fn find(path: &Path) -> Result<Option<Self>> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let Some((before, after)) = name.split_once(MARK) else { return Ok(None) };
        let folder = match path.parent() {
            Some(folder) if folder != Path::new("") => folder,
            _ => Path::new("."),
        };
        let fail = |e| Error::io(folder, e);
        let mut numbers = Vec::new();
        for entry in std::fs::read_dir(folder).map_err(fail)? {
            let entry = entry.map_err(fail)?;
            let file = entry.file_name();
            let digits = file.to_str().and_then(|f| f.strip_prefix(before)?.strip_suffix(after));
            if let Some(number) = digits.and_then(number) {
                numbers.push((number, entry.path()));
            }
        }
        numbers.sort();
        let tiles: Vec<_> = (numbers.into_iter())
            .map(|(number, path)| ((number - FIRST) % ROW, (number - FIRST) / ROW, path))
            .collect();
        let count = |of: fn(&(u32, u32, PathBuf)) -> u32| tiles.iter().map(of).max();
        let Some((columns, rows)) = count(|t| t.0 + 1).zip(count(|t| t.1 + 1)) else {
            let allowed = "files with a number from 1001 to 1999 there";
            return Err(Error::invalid(path, Place::File, MARK, "no such tile", allowed));
        };
        Ok(Some(Self { columns, rows, tiles }))
    }

    /// The first tile.
    pub(crate) fn first(&self) -> &Path {
        // There is one, or `find` has refused.
        self.tiles.first().map_or(Path::new(""), |tile| &tile.2)
    }

    /// A tile is not as large as the first.
    pub(crate) fn uneven(path: &Path, found: [u32; 2], first: [u32; 2]) -> Error {
        let [found, first] = [found, first].map(|[width, height]| format!("{width} x {height}"));
        let allowed = format!("{first}, as the first tile, and samples of the same kind");
        Error::invalid(path, Place::Header, "size of a tile", found, allowed)
    }
}

/// The number of a tile.
pub(crate) fn number(digits: &str) -> Option<u32> {
    let number = digits.parse().ok().filter(|n| (FIRST..=LAST).contains(n))?;
    (digits.len() == 4).then_some(number)
}

/// A grid of tiles that fills up.
pub(crate) struct Mosaic<T> {
    width: usize,
    tile: [usize; 2],
    all: Vec<T>,
}

impl<T: Copy> Mosaic<T> {
    /// Of `columns` x `rows` tiles of this size, all `blank`.
    pub fn new(tiles: &Udim, tile: [u32; 2], blank: T) -> Self {
        let tile = tile.map(|n| n as usize);
        let (width, height) = (tiles.columns as usize * tile[0], tiles.rows as usize * tile[1]);
        Self { width, tile, all: vec![blank; width * height] }
    }

    /// Puts the tile of `column` and `row`; both have row 0 at `v = 0`.
    pub fn put(&mut self, [column, row]: [u32; 2], tile: &[T]) {
        let [width, height] = self.tile;
        for (y, line) in tile.chunks_exact(width).enumerate() {
            let start = (row as usize * height + y) * self.width + column as usize * width;
            self.all[start..start + width].copy_from_slice(line);
        }
    }

    /// All of it.
    pub fn finish(self) -> Vec<T> {
        self.all
    }
}

#[cfg(test)]
mod tests {
    use rilievo::glam::DVec2;
    use rilievo::map::Samples;

    use super::*;
    use crate::Limits;
    use crate::image::{
        HeightOptions, read_colour, read_image_info, write_png_grey16, write_png_rgb8,
    };

    #[test]
    fn tiles_are_put_where_their_numbers_say() {
        let dir = tempfile::tempdir().unwrap();
        for (number, code) in [(1001, 1), (1002, 2), (1012, 4)] {
            let path = dir.path().join(format!("a.{number}.png"));
            write_png_grey16(&path, [2, 3], &[code; 6]).unwrap();
            let path = dir.path().join(format!("c_{number}.png"));
            write_png_rgb8(&path, [2, 2], &[[code as u8 * 60; 3]; 4]).unwrap();
        }
        for other in ["a.1000.png", "a.2000.png", "a.01003.png", "a.x.png", "b.1003.png"] {
            write_png_grey16(&dir.path().join(other), [2, 3], &[9; 6]).unwrap();
        }
        let (path, limits) = (dir.path().join("a.<UDIM>.png"), Limits::default());
        let found = Udim::find(&path).unwrap().unwrap();
        assert_eq!((found.columns, found.rows, found.tiles.len()), (2, 2, 3));
        let info = read_image_info(&path, &limits).unwrap();
        assert_eq!((info.width, info.height), (4, 6));
        let map = HeightOptions::default().read(&path, &limits).unwrap();
        let low = [1, 1, 2, 2].repeat(3);
        assert_eq!(*map.samples(), Samples::U16([low, [0, 0, 4, 4].repeat(3)].concat()));
        let image = read_colour(&dir.path().join("c_<UDIM>.png"), &limits).unwrap();
        assert_eq!((image.width(), image.height()), (4, 4));
        assert!(image.lookup(DVec2::new(0.7, 0.7)).x > image.lookup(DVec2::new(0.7, 0.3)).x);
        assert_eq!(image.lookup(DVec2::new(0.2, 0.7)).x, 0.0);
    }

    #[test]
    fn tiles_that_do_not_fit_are_refused() {
        let dir = tempfile::tempdir().unwrap();
        let (path, limits) = (dir.path().join("a<UDIM>.png"), Limits::default());
        assert_eq!(Udim::find(&dir.path().join("a.png")).unwrap(), None);
        let message = Udim::find(&path).unwrap_err().to_string();
        assert!(message.contains("no such tile; allowed: files with a number"), "{message}");
        write_png_grey16(&dir.path().join("a1001.png"), [2, 2], &[1; 4]).unwrap();
        write_png_grey16(&dir.path().join("a1999.png"), [2, 3], &[1; 6]).unwrap();
        let message = HeightOptions::default().read(&path, &limits).unwrap_err().to_string();
        assert!(message.contains("a1999.png: header: size of a tile: 2 x 3"), "{message}");
        let small = Limits { max_bytes: 5000 };
        let refused = HeightOptions::default().read(&path, &small);
        assert!(matches!(refused, Err(Error::Limit { .. })));
    }
}
