//! [`Batch`]: the rays of one row of the tables.
//!
//! | family | rays |
//! |---|---|
//! | primary | one through the centre of each pixel of an image that shows the whole map from above |
//! | grazing | the same for a camera a few percent of the map's side above its highest point |
//! | shadow | from each primary hit to a random point of an area light above and aside |
//! | diffuse | from each primary hit in a random direction, cosine-distributed about the normal |
//! | primary16 | 16 jittered rays for each pixel of some rows of the primary image |
//!
//! Single rays come in the order of the pixels, row by row. Packets of shadow rays hold 8 rays of
//! one hit point, for every eighth hit.

use std::sync::Arc;

use clap::ValueEnum;
use glam::DVec3;
use rilievo::map::HeightMap;
use rilievo::relief::{Displacement, FaceOptions, Method, Relief, ReliefFace};
use rilievo::{Hit, Ray};
use serde::{Deserialize, Serialize};

use super::Ray32;
use super::camera::Camera;
use super::clearance::clear;
use crate::random::unit;

/// A kind of ray.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Family {
    Primary,
    Grazing,
    Shadow,
    Diffuse,
    Primary16,
}

impl Family {
    pub const ALL: [Self; 5] =
        [Self::Primary, Self::Grazing, Self::Shadow, Self::Diffuse, Self::Primary16];

    /// The name in records.
    pub fn name(self) -> &'static str {
        match self {
            Self::Primary => "primary",
            Self::Grazing => "grazing",
            Self::Shadow => "shadow",
            Self::Diffuse => "diffuse",
            Self::Primary16 => "primary16",
        }
    }

    /// The name of a row of tables: the family, and whether it comes in packets.
    pub fn row_name(self, packet: bool) -> String {
        format!("{}{}", self.name(), if packet { " packets" } else { "" })
    }
}

/// A family as it is traced: one ray a call or in packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Row {
    Single(Family),
    /// Packets of 16 samples of one pixel.
    Primary16,
    /// Packets of 8 shadow rays of one point.
    Shadow8,
}

impl Row {
    pub const ALL: [Self; 6] = [
        Self::Single(Family::Primary),
        Self::Single(Family::Grazing),
        Self::Single(Family::Shadow),
        Self::Single(Family::Diffuse),
        Self::Primary16,
        Self::Shadow8,
    ];

    pub fn family(self) -> Family {
        match self {
            Self::Single(family) => family,
            Self::Primary16 => Family::Primary16,
            Self::Shadow8 => Family::Shadow,
        }
    }

    /// Rays that belong together; 1 where none do.
    pub fn packet(self) -> usize {
        match self {
            Self::Single(_) => 1,
            Self::Primary16 => 16,
            Self::Shadow8 => 8,
        }
    }

    /// Whether only the existence of a hit is asked for.
    pub fn is_any_hit(self) -> bool {
        self.family() == Family::Shadow
    }
}

/// The rays of one row.
#[derive(Clone, Debug)]
pub struct Batch {
    pub row: Row,
    /// Whole packets, one after the other.
    pub rays: Vec<Ray32>,
}

/// A relief on the unit square with its cameras and its light.
pub struct Scene {
    face: ReliefFace,
    depth: f64,
    /// Pixels a side.
    side: u32,
    /// Where the primary rays hit, in the order of the pixels.
    hits: Vec<Start>,
}

/// A place from which secondary rays start.
#[derive(Clone, Copy, Debug)]
struct Start {
    origin: [f32; 3],
    normal: DVec3,
}

/// The unit square from (0, 0, 0) to (1, 1, 0), its front upwards.
pub const CORNERS: [DVec3; 4] = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];

impl Scene {
    /// `relief` with heights from 0 to `depth` scene units, seen by cameras of `side` x `side`
    /// pixels.
    ///
    /// # Errors
    /// A depth that is not finite and above 0.
    pub fn new(relief: Relief, depth: f64, side: u32) -> Result<Self, String> {
        if depth.is_nan() || depth <= 0.0 {
            return Err(format!("depth is {depth}; it must be above 0"));
        }
        let displacement = Displacement { scale: depth, ..Displacement::default() };
        let options = FaceOptions { displacement, method: Method::Dda, ..FaceOptions::default() };
        let face =
            ReliefFace::new(CORNERS, Arc::new(relief), options).map_err(|e| e.to_string())?;
        let mut scene = Self { face, depth, side, hits: Vec::new() };
        let primary = scene.image(scene.overview());
        scene.hits = primary.iter().filter_map(|ray| scene.start(ray)).collect();
        if scene.hits.is_empty() { Err("no primary ray hits".to_owned()) } else { Ok(scene) }
    }

    /// The rays of a row.
    pub fn batch(&self, row: Row) -> Batch {
        let rays = match row {
            Row::Single(Family::Primary | Family::Primary16) => self.image(self.overview()),
            Row::Single(Family::Grazing) => self.image(self.low_camera()),
            Row::Single(Family::Shadow) => {
                self.starts().map(|(k, start)| self.to_light(start, k)).collect()
            }
            Row::Single(Family::Diffuse) => {
                self.starts().map(|(k, start)| bounce(start, k)).collect()
            }
            Row::Primary16 => self.samples(self.overview()),
            Row::Shadow8 => self
                .starts()
                .step_by(8)
                .flat_map(|(k, start)| (0..8).map(move |n| self.to_light(start, k * 8 + n)))
                .collect(),
        };
        Batch { row, rays }
    }

    /// Hits with their numbers.
    fn starts(&self) -> impl Iterator<Item = (u64, &Start)> {
        (0..).zip(&self.hits)
    }

    fn overview(&self) -> Camera {
        Camera::overview(self.depth, self.side)
    }

    fn low_camera(&self) -> Camera {
        let target = DVec3::new(0.55, 0.7, 0.5 * self.depth);
        Camera::new(DVec3::new(0.42, -0.12, self.depth + 0.04), target, 50.0, self.side)
    }

    fn image(&self, camera: Camera) -> Vec<Ray32> {
        let centres = || (0..camera.side).map(|k| f64::from(k) + 0.5);
        centres().flat_map(|y| centres().map(move |x| camera.ray(x, y))).collect()
    }

    /// Every sixteenth row of the image, 16 rays a pixel in a jittered grid of 4 x 4.
    fn samples(&self, camera: Camera) -> Vec<Ray32> {
        let rows = (8..camera.side).step_by(16);
        let pixels = rows.flat_map(|y| (0..camera.side).map(move |x| (x, y)));
        let sample = |x: u32, y: u32, n: u32| {
            let id = (u64::from(y) << 32 | u64::from(x)) * 16 + u64::from(n);
            let jitter = [n % 4, n / 4].map(f64::from);
            let [dx, dy] = [0, 1].map(|a| (jitter[a] + unit(id, a as u32)) / 4.0);
            camera.ray(f64::from(x) + dx, f64::from(y) + dy)
        };
        pixels.flat_map(|(x, y)| (0..16).map(move |n| sample(x, y, n))).collect()
    }

    /// Where a ray hits, made ready for secondary rays.
    fn start(&self, ray: &Ray32) -> Option<Start> {
        let hit = self.face.closest(&widened(ray), &mut ())?;
        let (map, normal) = (self.heights(), hit.geometric_normal);
        Some(Start { origin: clear(map, self.depth, hit.position, normal), normal })
    }

    fn heights(&self) -> &HeightMap {
        self.face.relief().heights()
    }

    /// To a point of a light of 0.5 x 0.6, one unit above the map and aside of it.
    fn to_light(&self, start: &Start, id: u64) -> Ray32 {
        let [a, b] = [0, 1].map(|draw| unit(id, draw));
        let point = DVec3::new(1.9 + 0.5 * a, 0.2 + 0.6 * b, self.depth + 1.0).as_vec3();
        let direction = std::array::from_fn(|k| point[k] - start.origin[k]);
        Ray32 { origin: start.origin, direction, t_max: 1.0 }
    }
}

/// A cosine-distributed ray: the normal and a point of the unit sphere, added.
fn bounce(start: &Start, id: u64) -> Ray32 {
    let z = 1.0 - 2.0 * unit(id, 2);
    let (sin, cos) = (std::f64::consts::TAU * unit(id, 3)).sin_cos();
    let r = (1.0 - z * z).max(0.0).sqrt();
    let to = (start.normal + DVec3::new(r * cos, r * sin, z)).try_normalize();
    let direction = to.unwrap_or(start.normal).as_vec3().to_array();
    Ray32 { origin: start.origin, direction, t_max: f32::INFINITY }
}

/// The cosine-distributed ray `id` from a hit on `map`, which lies on the unit square with heights up to `depth`.
pub fn bounced(map: &HeightMap, depth: f64, hit: &Hit, id: u64) -> Ray32 {
    let normal = hit.geometric_normal;
    bounce(&Start { origin: clear(map, depth, hit.position, normal), normal }, id)
}

/// The same ray in `f64`.
pub fn widened(ray: &Ray32) -> Ray {
    let [origin, direction] = [ray.origin, ray.direction].map(|v| DVec3::from(v.map(f64::from)));
    Ray { t_max: f64::from(ray.t_max), ..Ray::new(origin, direction) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    /// Deep, so that even a small smooth map throws shadows.
    const DEPTH: f64 = 0.4;

    fn scene(name: MapName) -> Scene {
        Scene::new(Relief::new(name.load(129).unwrap()), DEPTH, 64).unwrap()
    }

    fn hit_share(scene: &Scene, batch: &Batch) -> f64 {
        let hits = batch.rays.iter().filter(|ray| scene.face.occludes(&widened(ray), &mut ()));
        hits.count() as f64 / batch.rays.len() as f64
    }

    #[test]
    fn the_whole_map_is_in_view() {
        let scene = scene(MapName::Fbm);
        for corner in CORNERS {
            for z in [0.0, DEPTH] {
                let at = scene.overview().project(corner + z * DVec3::Z);
                assert!(at.iter().all(|x| (0.0..=64.0).contains(x)), "{corner}: {at:?}");
            }
        }
    }

    #[test]
    fn every_family_hits_a_plausible_share() {
        for name in MapName::ALL {
            let scene = scene(name);
            for (row, range) in [
                (Row::Single(Family::Primary), 0.3..0.95),
                (Row::Single(Family::Grazing), 0.3..0.95),
                (Row::Single(Family::Shadow), 0.001..0.9),
                (Row::Single(Family::Diffuse), 0.005..0.9),
                (Row::Primary16, 0.3..0.95),
                (Row::Shadow8, 0.001..0.9),
            ] {
                let share = hit_share(&scene, &scene.batch(row));
                assert!(range.contains(&share), "{} {row:?}: {share}", name.name());
            }
        }
    }

    #[test]
    fn rays_come_in_whole_packets_and_finite() {
        let scene = scene(MapName::Studded);
        for row in Row::ALL {
            let batch = scene.batch(row);
            assert!(!batch.rays.is_empty() && batch.rays.len().is_multiple_of(row.packet()));
            for ray in &batch.rays {
                let wide = widened(ray);
                assert!(wide.is_valid());
                assert_eq!(wide.origin.as_vec3().to_array(), ray.origin);
                assert_eq!(wide.direction.as_vec3().to_array(), ray.direction);
            }
        }
    }

    #[test]
    fn bounces_leave_the_side_they_start_on() {
        let scene = scene(MapName::Gaussian);
        let rays = scene.batch(Row::Single(Family::Diffuse)).rays;
        let along = scene
            .hits
            .iter()
            .zip(&rays)
            .map(|(start, ray)| DVec3::from(ray.direction.map(f64::from)).dot(start.normal));
        let (mut least, mut sum) = (f64::INFINITY, 0.0);
        for cosine in along {
            (least, sum) = (least.min(cosine), sum + cosine);
        }
        assert!(least > -1e-6);
        // The mean cosine of a cosine-distributed direction is 2/3.
        assert!((sum / rays.len() as f64 - 2.0 / 3.0).abs() < 0.02);
    }
}
