//! [`CubeMipLevel`]: the faces around a sphere at fewer cells.
//!
//! Inside of a face it is that of [`MipLevel`](crate::map::MipLevel), on the face's own lattice. A sample on an edge
//! of the cube stands for what lies around it on two faces, or three: each gives the mean of its part, and all
//! of them take the mean of these, added up in the same order. So the faces of a level meet as those of
//! the full map do, bit for bit.

use crate::map::height::{HeightMap, Samples};
use crate::map::mip::{LostSlopes, filtered_levels};

use super::resample::CubeHeights;
use super::{CubeFace, Tiling};

/// Heights around a sphere that stand for finer ones, and what they leave out.
#[derive(Clone, Debug)]
pub struct CubeMipLevel {
    /// The heights.
    pub heights: CubeHeights,
    /// What they do not show, in the order of [`CubeFace::ALL`]; u and v are those of the face, from 0 to 1.
    pub lost: [LostSlopes; 6],
}

impl CubeMipLevel {
    /// The levels above the faces of a sphere, finest first.
    pub fn chain(faces: [&HeightMap; 6], tiling: Tiling) -> Vec<Self> {
        let mut of_faces = faces.map(|face| filtered_levels(face).into_iter());
        let mut all = Vec::new();
        while let Some(heights) = next_of_all(&mut of_faces) {
            let heights = CubeHeights::of_faces(stitched(heights), tiling);
            let lost = CubeFace::ALL
                .map(|face| LostSlopes::of_level(faces[face.index()], heights.face(face)));
            all.push(Self { heights, lost });
        }
        all
    }
}

/// The next item of each, while all have one.
fn next_of_all<T>(all: &mut [impl Iterator<Item = T>; 6]) -> Option<[T; 6]> {
    let [a, b, c, d, e, f] = all.each_mut().map(Iterator::next);
    Some([a?, b?, c?, d?, e?, f?])
}

/// Faces whose samples on common edges are the means of what each has there.
fn stitched(faces: [HeightMap; 6]) -> [HeightMap; 6] {
    let cells = faces[0].width() - 1;
    let shared = |face: CubeFace, [i, j]: [u32; 2]| {
        let point = face.lattice_point(cells, [i, j]);
        let (mut sum, mut count) = (0.0, 0.0);
        for other in CubeFace::ALL {
            let on = if other.is_positive() { cells } else { 0 };
            if point[other.axis()] == on {
                let [a, b] = other.across();
                sum += f64::from(faces[other.index()].raw(point[a], point[b]));
                count += 1.0;
            }
        }
        sum / count
    };
    CubeFace::ALL.map(|face| {
        let map = &faces[face.index()];
        let mut samples = map.samples().clone();
        let border = |at: u32| at == 0 || at == cells;
        for j in 0..=cells {
            for i in (0..=cells).filter(|&i| border(i) || border(j)) {
                let (at, raw) = ((j * (cells + 1) + i) as usize, shared(face, [i, j]));
                match &mut samples {
                    Samples::U16(codes) => codes[at] = raw.round() as u16,
                    Samples::F32(heights) => heights[at] = raw as f32,
                }
            }
        }
        HeightMap::new(cells + 1, cells + 1, samples, map.x().lattice(), map.x().wrap())
            .expect("means of heights are heights")
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::{Lattice, Procedural, Wrap};

    #[test]
    fn faces_of_a_level_meet_and_keep_the_mean() {
        for codes in [false, true] {
            let noise = Procedural::Fbm { octaves: 6, seed: 3 };
            let (lattice, wrap) = (Lattice::Texel, Wrap::Repeat);
            let map = match codes {
                true => noise.height_map([128, 64], lattice, wrap).unwrap(),
                false => noise.height_map_f32([128, 64], lattice, wrap).unwrap(),
            };
            let full = CubeHeights::resample(&map, Tiling::default()).unwrap();
            let levels = CubeMipLevel::chain(CubeFace::ALL.map(|f| full.face(f)), full.tiling());
            let cells: Vec<u32> = levels.iter().map(|level| level.heights.cells()).collect();
            assert_eq!((full.cells(), cells), (44, vec![22, 11, 6, 3, 2, 1]));
            for level in &levels {
                let n = level.heights.cells();
                for face in CubeFace::ALL {
                    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
                        let point = face.lattice_point(n, [i, j]);
                        let raw = level.heights.face(face).raw(i, j);
                        for other in CubeFace::ALL {
                            let on = if other.is_positive() { n } else { 0 };
                            let [a, b] = other.across();
                            if point[other.axis()] == on {
                                let there = level.heights.face(other).raw(point[a], point[b]);
                                assert_eq!(raw, there);
                            }
                        }
                    }
                }
            }
        }
    }
}
