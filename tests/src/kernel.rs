//! The library's own methods as entries of the suites.

use std::sync::Arc;

use rilievo::map::{DistanceBits, DistanceKind, DistanceMap, DistanceOptions, Layout, Metric};
use rilievo::relief::{Displacement, FaceOptions, Method, Relief, ReliefFace, ShadingNormals};
use rilievo::{Hit, Ray};

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
    face_as(scene, method, Layout::Default)
}

/// The face of a scene, traced by `method` over bounds in `layout`.
///
/// # Panics
/// If the library refuses it.
pub fn face_as(scene: &Scene, method: Method, layout: Layout) -> ReliefFace {
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
    };
    ReliefFace::new(place.corners, relief(scene, method, layout), options).expect("a face")
}

/// Method `dda`.
pub const DDA: Entry = Entry { name: "dda", build: |scene| Box::new(face(scene, Method::Dda)) };

/// Method `pyramid`.
pub const PYRAMID: Entry =
    Entry { name: "pyramid", build: |scene| Box::new(face(scene, Method::Pyramid)) };

/// Method `pyramid` over bounds of 8 bits.
pub const TINY: Entry = Entry {
    name: "pyramid tiny",
    build: |scene| Box::new(face_as(scene, Method::Pyramid, Layout::Tiny)),
};

/// Method `distance`.
pub const DISTANCE: Entry =
    Entry { name: "distance", build: |scene| Box::new(face(scene, Method::Distance)) };

/// Method `distance-corrected`.
pub const DISTANCE_CORRECTED: Entry = Entry {
    name: "distance-corrected",
    build: |scene| Box::new(face(scene, Method::DistanceCorrected)),
};
