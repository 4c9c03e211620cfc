//! Edits: a rectangle of samples changes, the rest of the map stays.

use std::ops::Range;

use super::{HeightMap, HeightMapError, Samples, is_height, range};

/// The part of a row of samples that is being edited.
#[derive(Debug, PartialEq)]
pub enum RowMut<'a> {
    /// Codes.
    U16(&'a mut [u16]),
    /// Heights themselves.
    F32(&'a mut [f32]),
}

impl HeightMap {
    /// Changes the samples of columns `x` and rows `y`: `change` is given the number of each row and
    /// the part of it that lies in `x`. Nothing changes if there is an error or `change` panics.
    ///
    /// The range stays exact. Where the edit may have taken a lowest or highest sample away, the
    /// whole map is searched for the next one.
    ///
    /// # Errors
    /// [`HeightMapError::NotInside`]; [`HeightMapError::NotFinite`] for a sample that is no height
    /// after the change.
    pub fn edit(
        &mut self,
        rect: [Range<u32>; 2],
        change: impl FnMut(u32, RowMut<'_>),
    ) -> Result<(), HeightMapError> {
        if self.edit_samples(rect, change)? {
            self.search_range();
        }
        Ok(())
    }

    /// [`HeightMap::edit`] that only ever widens the range; says whether it may be too wide now.
    pub(crate) fn edit_samples(
        &mut self,
        [x, y]: [Range<u32>; 2],
        mut change: impl FnMut(u32, RowMut<'_>),
    ) -> Result<bool, HeightMapError> {
        let (width, height) = (self.width(), self.height());
        if x.start > x.end || y.start > y.end || x.end > width || y.end > height {
            return Err(HeightMapError::NotInside { x, y, width, height });
        }
        if x.is_empty() || y.is_empty() {
            return Ok(false);
        }
        let part = Part { x, y, width };
        let [old, new] = match &mut self.samples {
            Samples::U16(all) => {
                let new = part.changed(all, |j, row| change(j, RowMut::U16(row)));
                [part.replace(all, &new), new].map(Samples::U16)
            }
            Samples::F32(all) => {
                let new = part.changed(all, |j, row| change(j, RowMut::F32(row)));
                if let Some(at) = new.iter().position(|&h| !is_height(h)) {
                    let [i, j] = part.place(at);
                    return Err(HeightMapError::NotFinite { i, j, value: new[at] });
                }
                [part.replace(all, &new), new].map(Samples::F32)
            }
        };
        let (old, new) = (range(&old), range(&new));
        let gone =
            (old.0 == self.raw_min && new.0 > old.0) || (old.1 == self.raw_max && new.1 < old.1);
        self.raw_min = self.raw_min.min(new.0);
        self.raw_max = self.raw_max.max(new.1);
        Ok(gone)
    }

    /// Makes the range exact by looking at every sample.
    pub(crate) fn search_range(&mut self) {
        (self.raw_min, self.raw_max) = range(&self.samples);
    }

    /// Makes the range exact by what a pyramid of this map knows.
    pub(crate) fn set_range(&mut self, (low, high): (f32, f32)) {
        debug_assert_eq!((low, high), range(&self.samples));
        (self.raw_min, self.raw_max) = (low, high);
    }
}

/// A part of a grid of samples, not empty.
struct Part {
    x: Range<u32>,
    y: Range<u32>,
    /// Samples a row of the grid.
    width: u32,
}

impl Part {
    /// A copy of the part, changed row by row.
    fn changed<T: Copy>(&self, all: &[T], mut change: impl FnMut(u32, &mut [T])) -> Vec<T> {
        let mut part = Vec::with_capacity(self.x.len() * self.y.len());
        for j in self.y.clone() {
            part.extend_from_slice(&all[self.row(j)]);
        }
        for (j, row) in self.y.clone().zip(part.chunks_exact_mut(self.x.len())) {
            change(j, row);
        }
        part
    }

    /// Puts samples in place; returns those that were there.
    fn replace<T: Copy>(&self, all: &mut [T], new: &[T]) -> Vec<T> {
        let mut old = Vec::with_capacity(new.len());
        for (j, row) in self.y.clone().zip(new.chunks_exact(self.x.len())) {
            let place = &mut all[self.row(j)];
            old.extend_from_slice(place);
            place.copy_from_slice(row);
        }
        old
    }

    /// Where row `j` of the part lies in the grid.
    fn row(&self, j: u32) -> Range<usize> {
        let start = j as usize * self.width as usize + self.x.start as usize;
        start..start + self.x.len()
    }

    /// Column and row of a sample of the part.
    fn place(&self, at: usize) -> [u32; 2] {
        let across = self.x.len();
        [self.x.start + (at % across) as u32, self.y.start + (at / across) as u32]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Lattice, Wrap};

    fn ramp() -> HeightMap {
        let samples = Samples::F32((0..12).map(|k| k as f32).collect());
        HeightMap::new(4, 3, samples, Lattice::Texel, Wrap::Repeat).unwrap()
    }

    fn set(map: &mut HeightMap, rect: [Range<u32>; 2], value: f32) -> Result<(), HeightMapError> {
        map.edit(rect, |_, row| match row {
            RowMut::F32(row) => row.fill(value),
            RowMut::U16(row) => row.fill(value as u16),
        })
    }

    #[test]
    fn an_edit_changes_its_rectangle_and_the_range() {
        let mut map = ramp();
        set(&mut map, [1..3, 0..2], 20.0).unwrap();
        let rows = [[0.0, 20.0, 20.0, 3.0], [4.0, 20.0, 20.0, 7.0], [8.0, 9.0, 10.0, 11.0]];
        assert_eq!(map.samples(), &Samples::F32(rows.concat()));
        assert_eq!(map.raw_range(), (0.0, 20.0));
        set(&mut map, [0..3, 0..2], 5.0).unwrap();
        assert_eq!(map.raw_range(), (3.0, 11.0));
        set(&mut map, [2..2, 0..3], 99.0).unwrap();
        assert_eq!(map.raw_range(), (3.0, 11.0));
    }

    #[test]
    fn rows_are_named_by_their_number_in_the_map() {
        let mut rows = Vec::new();
        ramp().edit([1..3, 1..3], |j, row| rows.push((j, format!("{row:?}")))).unwrap();
        assert_eq!(rows[0], (1, "F32([5.0, 6.0])".to_owned()));
        assert_eq!(rows[1], (2, "F32([9.0, 10.0])".to_owned()));
    }

    #[test]
    fn a_bad_edit_changes_nothing() {
        let mut map = ramp();
        let error = set(&mut map, [2..4, 1..3], f32::NAN).unwrap_err();
        assert!(matches!(error, HeightMapError::NotFinite { i: 2, j: 1, .. }), "{error}");
        for rect in [[0..5, 0..1], [0..1, 0..4], [Range { start: 2, end: 1 }, 0..1]] {
            let error = set(&mut map, rect, 1.0).unwrap_err();
            assert!(matches!(error, HeightMapError::NotInside { .. }), "{error}");
        }
        assert_eq!(map, ramp());
    }
}
