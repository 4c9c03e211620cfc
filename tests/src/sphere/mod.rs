//! Displaced spheres: scenes, rays and a judge of their own.

pub mod oracle;
mod rays;

use std::sync::Arc;

use glam::DVec3;
use rilievo::map::{
    CubeFace, CubeHeights, DistanceOptions, HeightMap, Lattice, Layout, Tiling, Wrap,
};
use rilievo::relief::{CubeRelief, Displacement, Method, ReliefSphere, SphereOptions};
use rilievo::{Ray, SimdLevel};

use crate::maps::Shape;
use crate::random::Random;
use crate::scenes::FAR;
use oracle::SphereOracle;

pub use rays::Family;

/// A way to trace a sphere, and its name.
pub type Contender = (String, ReliefSphere);

/// A displaced sphere, and its name.
#[derive(Clone, Debug)]
pub struct SphereScene {
    /// Map and placement in words.
    pub name: String,
    /// The resampled map.
    pub heights: CubeHeights,
    /// Centre and radius.
    pub center: DVec3,
    /// The radius that is displaced.
    pub radius: f64,
    /// How the map is laid on it.
    pub displacement: Displacement,
}

impl SphereScene {
    /// The judge of this scene.
    pub fn oracle(&self) -> SphereOracle {
        SphereOracle::new(self)
    }

    /// The library's sphere, traced by `method` over bounds in `layout`, at a SIMD level.
    ///
    /// # Panics
    /// If the library refuses it.
    pub fn sphere(&self, method: Method, layout: Layout, simd: SimdLevel) -> ReliefSphere {
        let relief = Arc::new(CubeRelief::with_layout(self.heights.clone(), layout));
        let displacement = self.displacement;
        let options = SphereOptions { displacement, method, simd, ..SphereOptions::default() };
        ReliefSphere::new(self.center, self.radius, relief, options).expect("a valid sphere")
    }

    /// The library's sphere, traced by a `method` that walks distance maps, of a size if there is one.
    ///
    /// # Panics
    /// If the library refuses it, or the method walks none.
    pub fn sphere_over(&self, method: Method, size: Option<[u32; 3]>) -> ReliefSphere {
        let relief = CubeRelief::with_layout(self.heights.clone(), Layout::Default);
        let kind = method.distance_kind().expect("a method by distance");
        let metric = relief.metric(self.radius, self.displacement.scale);
        let face = relief.face(CubeFace::PosX).heights();
        let default = DistanceOptions::by_default(face, kind, metric);
        let options = DistanceOptions { size: size.unwrap_or(default.size), ..default };
        let relief = relief.with_distances(kind, &options).expect("a valid size");
        let displacement = self.displacement;
        let options = SphereOptions { displacement, method, ..SphereOptions::default() };
        ReliefSphere::new(self.center, self.radius, Arc::new(relief), options)
            .expect("a valid sphere")
    }

    /// All ways to trace it; the first shows the leaf every cell.
    ///
    /// # Panics
    /// If the library refuses one.
    pub fn contenders(&self) -> Vec<Contender> {
        let mut all = vec![(
            "dda".to_owned(),
            self.sphere(Method::Dda, Layout::Default, SimdLevel::detect()),
        )];
        for layout in [Layout::Default, Layout::Tiny] {
            for &level in SimdLevel::available() {
                let name = format!("pyramid, {layout}, {level}");
                all.push((name, self.sphere(Method::Pyramid, layout, level)));
            }
        }
        // Voxels of a cell, and of many cells, unlike along x and y.
        for (method, size) in [
            (Method::Distance, None),
            (Method::Distance, Some([5, 3, 4])),
            (Method::DistanceCorrected, Some([21, 6, 3])),
        ] {
            all.push((format!("{method}, {size:?}"), self.sphere_over(method, size)));
        }
        all
    }

    /// Smallest and largest distance of a sample from the centre.
    pub fn radii(&self) -> [f64; 2] {
        let maps = self.heights.clone().into_faces();
        let ends = maps.iter().flat_map(|map| {
            let (low, high) = map.raw_range();
            [low, high].map(|raw| f64::from(raw) * map.unit())
        });
        let Displacement { scale, zero, .. } = self.displacement;
        let radii = ends.map(|height| self.radius + scale * (height - zero));
        radii.fold([f64::INFINITY, 0.0], |[a, b], r| [a.min(r), b.max(r)])
    }

    /// A ray of a family.
    pub fn ray(&self, family: Family, random: &mut Random) -> Ray {
        family.ray(self, random)
    }
}

/// The maps, by turns codes and floats.
fn maps() -> Vec<(&'static str, HeightMap)> {
    let (texel, vertex, repeat) = (Lattice::Texel, Lattice::Vertex, Wrap::Repeat);
    vec![
        ("fbm", Shape::Fbm(1).codes([96, 48], texel, repeat)),
        ("studs", Shape::Studs(6).codes([72, 36], texel, repeat)),
        ("noise", Shape::White(2).floats([60, 30], vertex, Wrap::Clamp)),
        ("flat", Shape::Flat(0.25).codes([64, 32], texel, repeat)),
        ("step", Shape::Step.floats([80, 40], texel, Wrap::Clamp)),
        ("spike", Shape::Spike.codes([50, 40], texel, Wrap::Mirror)),
    ]
}

/// Every map on spheres of all kinds: thin and thick, inward, far from the origin, tiny and large.
pub fn scenes() -> Vec<SphereScene> {
    let laid = |scale: f64, zero: f64| Displacement { scale, zero, ..Displacement::default() };
    let places = [
        ("unit", DVec3::ZERO, 1.0, laid(0.03, 0.0)),
        ("thick", DVec3::new(0.3, -2.0, 1.0), 0.7, laid(0.5, 0.4)),
        ("inward", DVec3::new(1.0, 2.0, 3.0), 2.0, laid(-0.9, 0.1)),
        ("far", FAR, 1.5, laid(0.2, 0.5)),
        ("far and tiny", FAR, 1e-3, laid(2e-4, 0.0)),
        ("large", DVec3::ONE, 1e6, laid(1e4, 0.5)),
    ];
    let mut scenes = Vec::new();
    for (map_name, map) in maps() {
        for (k, &(place_name, center, radius, displacement)) in places.iter().enumerate() {
            // The densest lattice where there are most rays, odd and coarse ones elsewhere.
            let cells = [CubeHeights::least_cells(&map, Tiling::default()), 5, 17, 12, 9, 3][k];
            scenes.push(SphereScene {
                name: format!("{map_name}, {place_name}"),
                heights: CubeHeights::with_cells(&map, Tiling::default(), cells)
                    .expect("few cells"),
                center,
                radius,
                displacement,
            });
        }
    }
    scenes
}
