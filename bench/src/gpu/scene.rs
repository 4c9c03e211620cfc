//! [`Scene`]: a relief on the unit square, its rays, and the worlds that trace it.

use std::ops::Range;
use std::sync::Arc;

use rayon::prelude::*;
use rilievo::map::{
    DistanceBits, DistanceKind, DistanceMap, DistanceOptions, HeightMap, Metric, RowMut,
};
use rilievo::relief::{Displacement, FaceOptions, Method, Relief, ReliefFace};
use rilievo::surface::{Surface, World};

use crate::rays::{CORNERS, Camera, Ray32, bounced, widened};

/// A kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Family {
    /// One through the middle of each pixel.
    Primary,
    /// From where each of those hits, cosine-distributed about the normal.
    Diffuse,
}

impl Family {
    pub const ALL: [Self; 2] = [Self::Primary, Self::Diffuse];

    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Diffuse => "diffuse",
        }
    }
}

pub struct Scene {
    relief: Arc<Relief>,
    depth: f64,
    image: [u32; 2],
}

impl Scene {
    /// A map with heights from 0 to `depth` scene units, seen in an image of this size.
    ///
    /// # Errors
    /// A depth that is not above 0.
    pub fn new(map: HeightMap, depth: f64, image: [u32; 2]) -> Result<Self, String> {
        if depth.is_nan() || depth <= 0.0 {
            return Err(format!("depth is {depth}; it must be above 0"));
        }
        Ok(Self { relief: Arc::new(Relief::new(map)), depth, image })
    }

    pub fn heights(&self) -> &HeightMap {
        self.relief.heights()
    }

    pub fn relief(&self) -> &Relief {
        &self.relief
    }

    /// The rays of a family: the camera of `kernels`, wider to the sides.
    pub fn rays(&self, family: Family) -> Vec<Ray32> {
        let [width, height] = self.image;
        let camera = Camera::overview(self.depth, height);
        let margin = 0.5 * (f64::from(width) - f64::from(height));
        let pixel = |at: u32| {
            let [x, y] = [at % width, at / width].map(|k| f64::from(k) + 0.5);
            camera.ray(x - margin, y)
        };
        let primary = (0..width * height).into_par_iter().map(pixel);
        match family {
            Family::Primary => primary.collect(),
            Family::Diffuse => {
                let Ok(face) = self.face(Method::Pyramid, Arc::clone(&self.relief)) else {
                    return Vec::new();
                };
                let bounce = |(id, ray): (usize, Ray32)| {
                    let hit = face.closest(&widened(&ray), &mut ())?;
                    Some(bounced(self.heights(), self.depth, &hit, id as u64))
                };
                primary.enumerate().filter_map(bounce).collect()
            }
        }
    }

    fn face(&self, method: Method, relief: Arc<Relief>) -> Result<ReliefFace, String> {
        let displacement = Displacement { scale: self.depth, ..Displacement::default() };
        let options = FaceOptions { displacement, method, ..FaceOptions::default() };
        ReliefFace::new(CORNERS, relief, options).map_err(|e| e.to_string())
    }

    /// Voxels or nodes a side of the distance map that [`Scene::world`] makes.
    pub fn side(&self, kind: DistanceKind, grid: u32) -> u32 {
        let map = self.heights();
        side(map, kind, Metric::of_face(map, [1.0, 1.0], self.depth), grid)
    }

    /// The relief as a method traces it, with a distance map of so many voxels or nodes a side, at most one a
    /// sample, and slices; and the bytes beside the heights.
    ///
    /// # Errors
    /// A distance map that cannot be made.
    pub fn world(
        &self,
        method: Method,
        distances: Option<(DistanceKind, u32, u32)>,
    ) -> Result<(World, u64), String> {
        let mut relief = Arc::clone(&self.relief);
        let mut bytes = relief.pyramid().bytes();
        if let Some((kind, grid, slices)) = distances {
            let map = relief.heights();
            let metric = Metric::of_face(map, [1.0, 1.0], self.depth);
            let side = side(map, kind, metric, grid);
            let options =
                DistanceOptions { size: [side, side, slices], metric, bits: DistanceBits::U16 };
            let made = DistanceMap::from_height(map, kind, &options).map_err(|e| e.to_string())?;
            let with = Relief::clone(&relief).with_distance(made).map_err(|e| e.to_string())?;
            bytes = with.distance(kind).map_or(0, DistanceMap::bytes);
            relief = Arc::new(with);
        }
        Ok((World::new(vec![Surface::from(self.face(method, relief)?)]), bytes))
    }

    /// Turns the heights of a rectangle around.
    ///
    /// # Errors
    /// A rectangle outside of the map, or a world that still holds it.
    pub fn edit(&mut self, rect: [Range<u32>; 2]) -> Result<(), String> {
        let relief = Arc::get_mut(&mut self.relief).ok_or("the map is in use")?;
        let edited = relief.edit(rect, |_row, samples| match samples {
            RowMut::U16(codes) => codes.iter_mut().for_each(|code| *code = !*code),
            RowMut::F32(values) => values.iter_mut().for_each(|value| *value = -*value),
        });
        edited.map_err(|e| e.to_string())
    }
}

/// Voxels or nodes a side: at most `grid`, at most one a sample, and for the published kind at most twice what it gets by
/// default, for it is made by brute force.
fn side(map: &HeightMap, kind: DistanceKind, metric: Metric, grid: u32) -> u32 {
    let most = match kind {
        DistanceKind::Published => 2 * DistanceOptions::by_default(map, kind, metric).size[0],
        DistanceKind::Boxes | DistanceKind::Corrected => grid,
    };
    grid.min(map.width() - 1).min(most)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn bounces_start_where_camera_rays_hit() {
        let mut scene = Scene::new(MapName::Fbm.load(65).unwrap(), 0.1, [32, 18]).unwrap();
        let primary = scene.rays(Family::Primary);
        assert_eq!(primary.len(), 32 * 18);
        let (world, bytes) = scene.world(Method::Pyramid, None).unwrap();
        let hits =
            primary.iter().filter(|ray| world.closest(&widened(ray), &mut ()).is_some()).count();
        let diffuse = scene.rays(Family::Diffuse);
        assert_eq!(diffuse.len(), hits);
        assert!(hits > 100 && bytes > 0);
        assert!(scene.edit([0..64, 0..64]).is_err());
        drop(world);
        scene.edit([0..64, 0..64]).unwrap();
    }
}
