//! The scenes of the conformance suite: maps crossed with placements of the face.

use glam::{DMat3, DVec3};
use rilievo::map::{HeightMap, Lattice, Wrap};

use crate::maps::Shape;
use crate::oracle::{Oracle, Placement};

/// A face with a relief, and its name.
#[derive(Clone, Debug)]
pub struct Scene {
    /// Map and placement in words.
    pub name: String,
    /// The map.
    pub map: HeightMap,
    /// The face.
    pub place: Placement,
}

impl Scene {
    /// A scene of its own.
    pub fn new(name: impl Into<String>, map: HeightMap, place: Placement) -> Self {
        Self { name: name.into(), map, place }
    }

    /// The judge of this scene.
    pub fn oracle(&self) -> Oracle<'_> {
        Oracle::new(&self.map, self.place.clone())
    }
}

/// The place far from the origin at which scenes must keep their digits.
pub const FAR: DVec3 = DVec3::new(148_376.0, 1234.0, -223_423.0);

/// The face z = 0 over the unit square, raised by `scale`.
pub fn unit_face(scale: f64) -> Placement {
    Placement::new(DVec3::ZERO, DVec3::X, DVec3::Y, scale)
}

fn turned(size: f64, at: DVec3, scale: f64) -> Placement {
    let turn = DMat3::from_euler(glam::EulerRot::XYZ, 0.7, -0.4, 1.9);
    Placement::new(at, turn * DVec3::X * size, turn * DVec3::Y * (0.75 * size), scale * size)
}

/// The placements every kind of map meets in turn.
fn placements() -> Vec<(&'static str, Placement)> {
    let skewed = |scale| {
        let (e1, e2) = (DVec3::new(1.3, 0.2, 0.1), DVec3::new(0.5, 0.9, -0.2));
        Placement::new(DVec3::new(-0.4, 0.3, 0.2), e1, e2, scale)
    };
    vec![
        ("unit", unit_face(0.1)),
        ("skewed", Placement { zero: 0.5, ..skewed(0.2) }),
        ("turned", turned(1.0, DVec3::new(0.3, -2.0, 1.0), 0.15)),
        ("sunken", Placement { zero: 0.25, ..unit_face(-0.2) }),
        ("closed", Placement { closed: true, ..unit_face(0.3) }),
        ("closed across the plane", Placement { closed: true, zero: 0.5, ..skewed(-0.4) }),
        ("one-sided", Placement { one_sided: true, ..unit_face(0.2) }),
        ("one-sided closed", Placement { one_sided: true, closed: true, ..skewed(0.3) }),
        ("tiled", Placement { tile: [3.0, 2.0], ..unit_face(0.1) }),
        (
            "tiled and shifted",
            Placement { tile: [2.37, 1.61], shift: [0.3, -0.45], ..skewed(0.15) },
        ),
        (
            "part of a tile, closed",
            Placement { tile: [0.43, 0.57], shift: [0.31, 0.22], closed: true, ..unit_face(0.2) },
        ),
        ("deep", Placement { zero: 0.3, ..unit_face(4.0) }),
        ("thin", unit_face(1e-3)),
        ("far away", turned(1.0, FAR, 0.2)),
        ("far away and small", Placement { closed: true, ..turned(1e-3, FAR, 0.2) }),
        ("far away and vast", turned(1e6, FAR, 0.1)),
        ("tiny", Placement { tile: [2.0, 2.0], ..turned(1e-3, DVec3::ZERO, 0.2) }),
        ("vast", Placement { closed: true, ..turned(1e6, DVec3::ZERO, 0.05) }),
    ]
}

/// A kind of map: its name, shape, size and whether it is stored as codes.
type Kind = (&'static str, Shape, [u32; 2], bool);

const KINDS: [Kind; 17] = [
    ("fbm 64", Shape::Fbm(1), [64, 64], true),
    ("fbm 129 x 65 floats", Shape::Fbm(2), [129, 65], false),
    ("fbm 256", Shape::Fbm(3), [256, 256], true),
    ("studs 64", Shape::Studs(4), [64, 64], true),
    ("studs 128 floats", Shape::Studs(8), [128, 128], false),
    ("gaussian 100 floats", Shape::Gaussian, [100, 100], false),
    ("gaussian 64 x 17", Shape::Gaussian, [64, 17], true),
    ("tent 33", Shape::Tent, [33, 33], true),
    ("step 50 x 30", Shape::Step, [50, 30], true),
    ("white noise 64", Shape::White(4), [64, 64], true),
    ("white noise 31 floats", Shape::White(5), [31, 31], false),
    ("flat 16", Shape::Flat(0.625), [16, 16], true),
    ("ramp 9 x 12 floats", Shape::Ramp(0.75, -0.5), [9, 12], false),
    ("spike 80", Shape::Spike, [80, 80], true),
    ("ripple 96 floats", Shape::Ripple, [96, 96], false),
    ("noise 2 x 2", Shape::White(6), [2, 2], true),
    ("noise 3 x 5 floats", Shape::White(7), [3, 5], false),
];

/// Every lattice with every wrap.
pub const UNFOLDINGS: [(Lattice, Wrap); 6] = [
    (Lattice::Vertex, Wrap::Repeat),
    (Lattice::Texel, Wrap::Repeat),
    (Lattice::Vertex, Wrap::Clamp),
    (Lattice::Texel, Wrap::Clamp),
    (Lattice::Vertex, Wrap::Mirror),
    (Lattice::Texel, Wrap::Mirror),
];

/// Every kind of map with some of the placements, so that each placement and each lattice and
/// wrap occurs with several kinds.
pub fn all() -> Vec<Scene> {
    let placements = placements();
    let mut scenes = Vec::new();
    for (k, (kind, shape, size, codes)) in KINDS.into_iter().enumerate() {
        // Five placements a kind, stepping through the list; 18 placements and 6 unfoldings
        // share a factor, so the unfolding also moves with the kind.
        for n in 0..5 {
            let (label, place) = &placements[(5 * k + n) % placements.len()];
            let (lattice, wrap) = UNFOLDINGS[(k + n) % UNFOLDINGS.len()];
            let map = if codes {
                shape.codes(size, lattice, wrap)
            } else {
                shape.floats(size, lattice, wrap)
            };
            let name = format!("{kind}, {lattice:?} {wrap:?}, {label}");
            scenes.push(Scene::new(name, map, place.clone()));
        }
    }
    scenes
}

/// The scene far away and vast keeps its neighbourhood: named so that tests can ask for one.
///
/// # Panics
/// If no scene's name contains `words`.
pub fn named(words: &str) -> Scene {
    all().into_iter().find(|scene| scene.name.contains(words)).expect("a scene of that name")
}
