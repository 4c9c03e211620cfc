//! All shaders are valid, whatever is left out, and their structs have the bytes that are written.

use wgpu::naga;

use super::*;
use crate::{records, shading};

/// The shader as every device without optional features must take it.
fn validated(text: &str) -> naga::Module {
    let module = naga::front::wgsl::parse_str(text)
        .unwrap_or_else(|error| panic!("{}", error.emit_to_string(text)));
    let mut validator = naga::valid::Validator::new(
        naga::valid::ValidationFlags::all(),
        naga::valid::Capabilities::empty(),
    );
    if let Err(error) = validator.validate(&module) {
        panic!("{}", error.emit_to_string(text));
    }
    module
}

const ONE: Pages = Pages { count: 1, shift: 31 };
const THREE: Pages = Pages { count: 3, shift: 25 };

#[test]
fn shaders_are_valid_without_optional_features() {
    for (pages, step) in [([ONE, ONE], 1), ([THREE, ONE], 5), ([ONE, THREE], 11)] {
        for walks in (0..64).step_by(step) {
            let [bounds, distances, published, marched, spheres, meshes] =
                [1, 2, 4, 8, 16, 32].map(|bit| walks & bit != 0);
            // As good as any other half.
            let moving = bounds != meshes;
            let walks = Walks { bounds, distances, published, marched, spheres, meshes, moving };
            assert_eq!(validated(&closest(walks, pages)).entry_points.len(), 1);
        }
        assert_eq!(validated(&pyramid(pages)).entry_points.len(), 2);
        assert_eq!(validated(&boxes(pages)).entry_points.len(), 4);
        assert_eq!(validated(&nearest(pages)).entry_points.len(), 1);
    }
}

#[test]
fn light_is_valid_without_optional_features() {
    // All, none, and one part at a time.
    for pages in [ONE, THREE] {
        let one = (0..14).map(|bit| 1 << bit).filter(|_| pages == ONE);
        for parts in [0x3fff, 0].into_iter().chain(one) {
            for path in [false, true] {
                let has: [bool; 14] = std::array::from_fn(|bit| parts >> bit & 1 != 0);
                let [images, normals, sky, metals, glass, principled, mixes, jittered, ..] = has;
                let [.., emitters, relief_meshes, faces, relief_spheres, instances] = has;
                // As good as any other half.
                let moving = faces != metals;
                let parts = Parts {
                    path,
                    images,
                    normals,
                    sky,
                    metals,
                    glass,
                    principled,
                    mixes,
                    emitters,
                    jittered,
                };
                let displaced = Light { faces, relief_spheres, relief_meshes, ..Light::default() };
                let light = Light { parts, points: 4, instances, moving, ..displaced };
                assert_eq!(validated(&advance(light, pages)).entry_points.len(), 1);
            }
        }
    }
}

#[test]
fn structs_take_the_bytes_that_are_written() {
    let module = validated(&closest(Walks::default(), [ONE, ONE]));
    let span = |module: &naga::Module, name: &str| {
        module.types.iter().find_map(|(_, ty)| match &ty.inner {
            naga::TypeInner::Struct { span, .. } if ty.name.as_deref() == Some(name) => {
                Some(*span as usize)
            }
            _ => None,
        })
    };
    for (name, words) in [
        ("Ray", records::RAY_WORDS),
        ("Hit", records::HIT_WORDS),
        ("Face", records::FACE_WORDS),
        ("Surface", crate::surfaces::SURFACE_WORDS),
        ("Node", records::NODE_WORDS),
    ] {
        assert_eq!(span(&module, name), Some(4 * words), "{name}");
    }
    for (path, points, words) in
        [(true, 2, shading::WALK_WORDS), (false, 3, shading::TREE_WORDS + 3 * shading::POINT_WORDS)]
    {
        let parts = Parts { path, ..Parts::default() };
        let module = validated(&advance(Light { parts, points, ..Light::default() }, ONE));
        let name = if path { "Walk" } else { "Tree" };
        assert_eq!(span(&module, name), Some(4 * words), "{name}");
        assert_eq!(span(&module, "Slot"), Some(4 * shading::SLOT_WORDS));
    }
    let tasks = validated(&pyramid([ONE, ONE]));
    assert_eq!(span(&tasks, "Task"), Some(4 * records::TASK_WORDS));
    let tasks = validated(&boxes([ONE, ONE]));
    assert_eq!(span(&tasks, "Task"), Some(4 * records::BOX_TASK_WORDS));
    let tasks = validated(&nearest([ONE, ONE]));
    assert_eq!(span(&tasks, "Task"), Some(4 * records::NEAREST_TASK_WORDS));
}
