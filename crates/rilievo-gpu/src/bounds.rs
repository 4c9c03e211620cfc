//! Pyramids in words, as `shaders/pyramid.wgsl` makes them and walks read them: a table of levels, then of each level the
//! maxima and the minima of its nodes, two codes a word.

use rilievo::map::{HeightMap, LevelBounds, Pyramid};

/// Words of a level in the table: nodes along x, first word of maxima and of minima.
pub(crate) const LEVEL_WORDS: usize = 3;

/// Levels of the pyramid of a map.
pub(crate) fn levels(map: &HeightMap) -> u32 {
    let cells = map.x().cells().max(map.y().cells());
    (0..).find(|level| cells.div_ceil(16 << (2 * level)) == 1).unwrap_or(0) + 1
}

/// Appends the table and the bounds of a pyramid in the default layout, as they lie from word `first` on. False,
/// and nothing of use, for another layout.
pub(crate) fn write_bounds(words: &mut Vec<u32>, first: u32, pyramid: &Pyramid) -> bool {
    let at = words.len();
    let levels = pyramid.levels() as usize;
    words.resize(at + levels * LEVEL_WORDS, 0);
    for level in 0..levels {
        let stored = pyramid.level(level as u32);
        let LevelBounds::Wide { max, min } = &stored.bounds else { return false };
        let table = at + level * LEVEL_WORDS;
        words[table] = stored.nodes[0];
        for (side, bounds) in [max, min].into_iter().enumerate() {
            words[table + 1 + side] = first + (words.len() - at) as u32;
            words.extend(bounds.as_flattened().chunks(2).map(pair));
        }
    }
    true
}

/// One or two codes in a word, the first in the low half.
fn pair(codes: &[u16]) -> u32 {
    codes.iter().rev().fold(0, |word, &code| (word << 16) | u32::from(code))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rilievo::map::{Lattice, Layout, Samples, Wrap};

    #[test]
    fn bounds_are_written_in_words() {
        let samples = Samples::U16((0..35).collect());
        let map = HeightMap::new(7, 5, samples, Lattice::Vertex, Wrap::Clamp).unwrap();
        let mut words = vec![9];
        assert!(write_bounds(&mut words, 7, &Pyramid::build(&map)));
        assert_eq!((words[..4].to_vec(), words.len()), (vec![9, 1, 10, 18], 20));
        assert_eq!(levels(&map), 1);
        assert!(!write_bounds(&mut words, 0, &Pyramid::build_as(&map, Layout::Tiny)));
    }
}
