//! The library's own methods as entries of the suites.

use std::io::Write;
use std::sync::Arc;

use rilievo::map::{DistanceBits, DistanceKind, DistanceMap, DistanceOptions, Layout, Metric};
use rilievo::relief::{Displacement, FaceOptions, Method, Relief, ReliefFace, ShadingNormals};
use rilievo::{Hit, Ray, SimdLevel};

use crate::conformance::{Contender, Entry};
use crate::scenes::Scene;

impl Contender for ReliefFace {
    fn closest(&self, ray: &Ray) -> Option<Hit> {
        Self::closest(self, ray, &mut ())
    }

    fn occludes(&self, ray: &Ray) -> bool {
        Self::occludes(self, ray, &mut ())
    }
}

/// The relief of a scene's map in a layout, with the distance map that `method` needs.
///
/// # Panics
/// If the library refuses it.
pub fn relief(scene: &Scene, method: Method, layout: Layout) -> Arc<Relief> {
    let relief = Relief::with_layout(scene.map.clone(), layout);
    let kind = match method {
        Method::Dda | Method::Pyramid | Method::March => return Arc::new(relief),
        Method::Distance => DistanceKind::Boxes,
        Method::DistanceCorrected => DistanceKind::Corrected,
        Method::DistancePublished => DistanceKind::Published,
    };
    let (x, y) = (scene.map.x(), scene.map.y());
    let (low, high) = scene.map.raw_range();
    let metric = Metric {
        x: 1.0 / f64::from(x.period()),
        y: 1.0 / f64::from(y.period()),
        z: 0.2 / f64::from(high - low).max(1e-3),
    };
    let side = |cells: u32| cells.clamp(2, 48);
    let options = DistanceOptions {
        size: [side(x.cells()), side(y.cells()), 12],
        metric,
        bits: DistanceBits::U16,
    };
    let map = DistanceMap::from_height(&scene.map, kind, &options).expect("a distance map");
    Arc::new(relief.with_distance(map).expect("a distance map of its own heights"))
}

/// The face of a scene, traced by `method`.
///
/// # Panics
/// If the library refuses it.
pub fn face(scene: &Scene, method: Method) -> ReliefFace {
    face_as(scene, method, Layout::Default, SimdLevel::detect())
}

/// The face of a scene, traced by `method` over bounds in `layout`, at a SIMD level.
///
/// # Panics
/// If the library refuses it.
pub fn face_as(scene: &Scene, method: Method, layout: Layout, simd: SimdLevel) -> ReliefFace {
    let place = &scene.place;
    let options = FaceOptions {
        displacement: Displacement {
            scale: place.scale,
            zero: place.zero,
            tile: place.tile,
            shift: place.shift,
        },
        method,
        normals: ShadingNormals::Exact,
        closed: place.closed,
        one_sided: place.one_sided,
        simd,
    };
    ReliefFace::new(place.corners, relief(scene, method, layout), options).expect("a face")
}

/// Method `dda`.
pub const DDA: Entry = Entry { name: "dda", build: |scene| Box::new(face(scene, Method::Dda)) };

/// Method `pyramid`.
pub const PYRAMID: Entry =
    Entry { name: "pyramid", build: |scene| Box::new(face(scene, Method::Pyramid)) };

/// Method `distance`.
pub const DISTANCE: Entry =
    Entry { name: "distance", build: |scene| Box::new(face(scene, Method::Distance)) };

/// Method `distance-corrected`.
pub const DISTANCE_CORRECTED: Entry = Entry {
    name: "distance-corrected",
    build: |scene| Box::new(face(scene, Method::DistanceCorrected)),
};

/// Method `pyramid` once for every layout of the bounds and SIMD level of this processor. The levels
/// it lacks are named on stderr.
pub fn pyramid_everywhere() -> Vec<Entry> {
    fn build(scene: &Scene, layout: Layout, level: &str) -> Box<dyn Contender> {
        let level = level.parse().expect("an available level");
        Box::new(face_as(scene, Method::Pyramid, layout, level))
    }
    /// Name of the level, of the entry, and how to build it.
    type Candidate = (&'static str, &'static str, fn(&Scene) -> Box<dyn Contender + '_>);
    let candidates: [Candidate; 6] = [
        ("portable", "pyramid portable", |s| build(s, Layout::Default, "portable")),
        ("avx2", "pyramid avx2", |s| build(s, Layout::Default, "avx2")),
        ("avx512", "pyramid avx512", |s| build(s, Layout::Default, "avx512")),
        ("portable", "pyramid tiny portable", |s| build(s, Layout::Tiny, "portable")),
        ("avx2", "pyramid tiny avx2", |s| build(s, Layout::Tiny, "avx2")),
        ("avx512", "pyramid tiny avx512", |s| build(s, Layout::Tiny, "avx512")),
    ];
    let mut found = Vec::new();
    for (level, name, build) in candidates {
        if level.parse::<SimdLevel>().is_ok() {
            found.push(Entry { name, build });
        } else {
            let _ = writeln!(std::io::stderr(), "{name} left out: no such instructions");
        }
    }
    found
}
