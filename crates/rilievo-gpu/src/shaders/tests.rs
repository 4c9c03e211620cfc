//! All shaders are valid, whatever is left out, and their structs have the bytes that are written.

use rilievo::glam::DVec3;
use wgpu::naga;

use super::*;
use crate::device::Gpu;
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

/// What draws a facet of a rough surface, alone: three words of a sample in, its normal out.
const FACETS: &str = concat!(
    "const FIRST_SURFACE: u32 = 0u;\nconst SURFACE_RECORD: u32 = 1u;\n",
    "@group(0) @binding(0) var<storage, read> scene: array<u32>;\n",
    "@group(0) @binding(1) var<storage, read_write> facets: array<f32>;\n",
    include_str!("float.wgsl"),
    include_str!("double.wgsl"),
    include_str!("scene/words.wgsl"),
    include_str!("scene/angle.wgsl"),
    include_str!("sampler/warp.wgsl"),
    "@compute @workgroup_size(1)\n",
    "fn facet_of(@builtin(global_invocation_id) id: vec3<u32>) {\n",
    "    let u = vec2<f32>(number(3u * id.x), number(3u * id.x + 1u));\n",
    "    let view = normalize(vec3<f32>(0.6, 0.2, 0.7));\n",
    "    let facet = square_to_visible_normal(u, view, number(3u * id.x + 2u));\n",
    "    for (var k = 0u; k < 3u; k++) { facets[3u * id.x + k] = facet[k]; }\n",
    "}\n",
);

/// The same in `f64`.
fn facet([u, v]: [f64; 2], alpha: f64) -> DVec3 {
    let view = DVec3::new(0.6, 0.2, 0.7).normalize();
    let stretched = (view * DVec3::new(alpha, alpha, 1.0)).normalize();
    let z = (1.0 - u) * (1.0 + stretched.z) - stretched.z;
    let r = ((1.0 - z) * (1.0 + z)).max(0.0).sqrt();
    let (sine, cosine) = (v * std::f64::consts::TAU).sin_cos();
    let half = DVec3::new(r * cosine, r * sine, z) + stretched;
    (half * DVec3::new(alpha, alpha, 1.0)).normalize()
}

#[test]
fn facets_at_the_rim_of_a_narrow_lobe_are_those_of_f64() {
    let Ok(gpu) = Gpu::open() else { return };
    let samples: Vec<[f32; 3]> = (1..18)
        .flat_map(|k| [0.1, 0.45, 0.8].map(|v| [1.0 - 0.5f32.powi(k), v]))
        .flat_map(|[u, v]| [0.0081, 0.1, 0.7].map(|alpha| [u, v, alpha]))
        .collect();
    let words = gpu.upload("samples", bytemuck::cast_slice(&samples)).unwrap();
    let usage = wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC;
    let found = gpu.allocate("facets", 12 * samples.len() as u64, usage).unwrap();
    let module = gpu.device.create_shader_module(wgpu::ShaderModuleDescriptor {
        label: Some("facets"),
        source: wgpu::ShaderSource::Wgsl(FACETS.into()),
    });
    let pipeline = gpu.device.create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
        label: Some("facets"),
        layout: None,
        module: &module,
        entry_point: Some("facet_of"),
        compilation_options: Default::default(),
        cache: None,
    });
    let entries = [(0, &words), (1, &found)].map(|(binding, buffer)| wgpu::BindGroupEntry {
        binding,
        resource: buffer.as_entire_binding(),
    });
    let group = gpu.device.create_bind_group(&wgpu::BindGroupDescriptor {
        label: Some("facets"),
        layout: &pipeline.get_bind_group_layout(0),
        entries: &entries,
    });
    let mut commands = gpu.device.create_command_encoder(&Default::default());
    let mut pass = commands.begin_compute_pass(&Default::default());
    pass.set_pipeline(&pipeline);
    pass.set_bind_group(0, &group, &[]);
    pass.dispatch_workgroups(samples.len() as u32, 1, 1);
    drop(pass);
    gpu.queue.submit([commands.finish()]);
    let bytes = gpu.copy_out(&found).unwrap();
    let facets: Vec<[f32; 3]> = bytemuck::pod_collect_to_vec(&bytes[..12 * samples.len()]);
    for (&[u, v, alpha], found) in samples.iter().zip(facets) {
        let want = facet([u, v].map(f64::from), alpha.into());
        let apart = want.distance(DVec3::from(found.map(f64::from)));
        assert!(apart < 5e-6, "{u} {v} {alpha}: {want} {found:?}, {apart:e} apart");
    }
}
