//! [`Columns`]: between which heights the surface lies under each voxel's footprint.
//!
//! The columns of `boxes` (see there), kept for the walk: near the surface, where every distance is
//! about 0, a ray is clear of the cells under a voxel if its heights over the footprint lie outside
//! the column's. 8 bytes a column beside `2 nz` of 16-bit codes. They follow from the heights in
//! no time and are not stored with a map.

use rayon::prelude::*;

use crate::map::HeightMap;

/// Height interval of each column, x fastest.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Columns {
    width: usize,
    bounds: Vec<(f32, f32)>,
}

/// The stored cells whose inside meets division `i` of `n` of an axis, first and last.
fn cells_of(i: u32, n: u32, cells: u32) -> (u32, u32) {
    let (i, n, cells) = (u64::from(i), u64::from(n), u64::from(cells));
    ((i * cells / n) as u32, ((i + 1) * cells).div_ceil(n) as u32 - 1)
}

impl Columns {
    /// Those of `heights` under a grid of `nx` by `ny` footprints.
    pub fn new(heights: &HeightMap, [nx, ny]: [u32; 2]) -> Self {
        let cells = [heights.x().cells(), heights.y().cells()];
        let mut bounds = vec![(0.0, 0.0); nx as usize * ny as usize];
        bounds.par_chunks_mut(nx as usize).enumerate().for_each(|(j, row)| {
            let (first_y, last_y) = cells_of(j as u32, ny, cells[1]);
            for (i, column) in row.iter_mut().enumerate() {
                let (first_x, last_x) = cells_of(i as u32, nx, cells[0]);
                let (mut lo, mut hi) = (f32::INFINITY, f32::NEG_INFINITY);
                for cy in first_y..=last_y {
                    for cx in first_x..=last_x {
                        for h in heights.stored_corners(cx, cy) {
                            (lo, hi) = (lo.min(h), hi.max(h));
                        }
                    }
                }
                *column = (lo, hi);
            }
        });
        Self { width: nx as usize, bounds }
    }

    /// All of them, x fastest.
    pub fn bounds(&self) -> &[(f32, f32)] {
        &self.bounds
    }

    /// Lowest and highest raw height of a column; everything where there is none.
    #[inline]
    pub fn at(&self, i: u32, j: u32) -> (f32, f32) {
        let found = self.bounds.get(j as usize * self.width + i as usize);
        found.copied().unwrap_or((f32::NEG_INFINITY, f32::INFINITY))
    }

    /// Bytes held.
    pub fn bytes(&self) -> u64 {
        self.bounds.len() as u64 * 8
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn divisions_own_the_cells_they_overlap_and_no_neighbour() {
        assert_eq!(cells_of(0, 4, 4), (0, 0));
        assert_eq!(cells_of(3, 4, 4), (3, 3));
        assert_eq!(cells_of(1, 2, 5), (2, 4));
        assert_eq!(cells_of(0, 2, 5), (0, 2));
        assert_eq!(cells_of(4, 10, 3), (1, 1));
        assert_eq!(cells_of(3, 10, 3), (0, 1));
    }

    #[test]
    fn a_missing_column_culls_nothing() {
        assert_eq!(Columns::default().at(0, 0), (f32::NEG_INFINITY, f32::INFINITY));
    }
}
