//! glTF files: the cases of the official validator, with what its reports say of them.

use std::fs;
use std::path::{Path, PathBuf};

use rilievo::glam::{DVec2, DVec3};
use rilievo::map::Wrap;
use rilievo::mesh::Mesh;
use rilievo_io::mesh::{ImageSource, LightKind, Model};
use rilievo_io::{Error, Limits};

fn data() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data/gltf")
}

/// The cases: file, and triangles or the codes of its errors.
fn cases() -> Vec<(String, Result<usize, String>)> {
    let text = fs::read_to_string(data().join("reports.txt")).unwrap();
    let lines = text.lines().filter(|line| !line.starts_with('#'));
    lines
        .map(|line| {
            let (file, report) = line.split_once(' ').unwrap();
            let report = match report.strip_prefix("valid ") {
                Some(count) => Ok(count.parse().unwrap()),
                None => Err(report.to_owned()),
            };
            (file.to_owned(), report)
        })
        .collect()
}

/// Triangles of the cases whose report counts more than the scene shows: of a primitive without
/// positions, of meshes that no node of the scene holds.
const SHOWN: [(&str, usize); 3] = [
    ("mesh/primitive_no_position.gltf", 0),
    ("json/integer_written_as_float.gltf", 0),
    ("root/unused_objects.gltf", 12),
];

#[test]
fn errors_where_the_report_says_error_geometry_where_it_says_valid() {
    let all = cases();
    assert_eq!(all.len(), 158);
    let mut wrong = Vec::new();
    for (file, report) in &all {
        let found = Model::read(&data().join(file), &Limits::default());
        match (report, found) {
            (Ok(count), Ok(model)) => {
                let count = SHOWN.iter().find(|(f, _)| f == file).map_or(*count, |(_, n)| *n);
                let found = model.mesh.triangles.len();
                if found != count {
                    wrong.push(format!("{file}: {found} triangles, not {count}"));
                }
            }
            (Ok(_), Err(e)) => wrong.push(format!("{file} is valid: {e}")),
            (Err(codes), Ok(_)) => wrong.push(format!("{file} has {codes}")),
            (Err(_), Err(e)) => {
                let name = file.rsplit('/').next().unwrap();
                assert!(e.to_string().contains(name), "{file}: {e}");
            }
        }
    }
    assert!(wrong.is_empty(), "{}\n{}", wrong.len(), wrong.join("\n"));
}

#[test]
fn no_damaged_file_panics() {
    let limits = Limits { max_bytes: 1 << 20 };
    for (file, _) in cases().iter().filter(|(file, _)| !file.starts_with("image/")) {
        let bytes = fs::read(data().join(file)).unwrap();
        for at in (0..bytes.len()).step_by(3) {
            let mut damaged = bytes.clone();
            damaged[at] ^= 1 << (at % 7);
            if let Ok(model) = Model::read_bytes(&damaged, Path::new(file), &limits) {
                let _ = (model.by_material(), Mesh::new(model.mesh));
            }
        }
    }
}

/// A GLB of one JSON chunk.
fn glb(json: &str) -> Vec<u8> {
    let json = format!("{json:width$}", width = json.len().next_multiple_of(4));
    let length = json.len() as u32;
    let parts =
        [b"glTF".to_vec(), 2_u32.to_le_bytes().to_vec(), (length + 20).to_le_bytes().to_vec()];
    let chunk = [length.to_le_bytes().to_vec(), b"JSON".to_vec(), json.into_bytes()];
    parts.into_iter().chain(chunk).flatten().collect()
}

#[test]
fn huge_sizes_end_in_an_error_before_memory_is_asked_for() {
    let limits = Limits { max_bytes: 64 << 20 };
    let read =
        |json: &str, name: &str| Model::read_bytes(json.as_bytes(), Path::new(name), &limits);
    // An accessor of 2^31 zeros, which needs no byte of data.
    let zeros = r#"{"asset":{"version":"2.0"},"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
        "accessors":[{"type":"VEC3","componentType":5126,"count":2147483648,"min":[0,0,0],"max":[0,0,0]}]}"#;
    let error = read(zeros, "a.gltf").unwrap_err();
    assert!(matches!(error, Error::Limit { needed: 51_539_607_552, .. }), "{error}");
    assert!(error.to_string().contains("/accessors/0: the accessor needs"), "{error}");
    let as_glb = Model::read_bytes(&glb(zeros), Path::new("a.glb"), &limits).unwrap_err();
    assert_eq!(as_glb.to_string(), error.to_string().replace("a.gltf", "a.glb"));
    // The same mesh held by so many nodes that their sum is too much.
    let nodes = vec![r#"{"mesh":0}"#; 4000].join(",");
    let many = zeros.replace("2147483648", "30000");
    let many = many.replacen("{\"asset\"", &format!("{{\"nodes\":[{nodes}],\"asset\""), 1);
    assert!(matches!(read(&many, "a.gltf"), Err(Error::Limit { .. })));
    // Counts and offsets at the ends of what numbers hold.
    for (from, to) in [
        ("2147483648", "18446744073709551615"),
        (
            "\"count\":2147483648",
            "\"count\":3,\"bufferView\":0,\"byteOffset\":18446744073709551612",
        ),
        ("\"count\":2147483648", "\"count\":9007199254740993,\"bufferView\":0"),
    ] {
        let views =
            r#""bufferViews":[{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36}],"#;
        let text =
            zeros.replacen("{\"asset\"", &format!("{{{views}\"asset\""), 1).replace(from, to);
        assert!(read(&text, "a.gltf").is_err(), "{text}");
    }
    // JSON that is deep or long.
    assert!(read(&"[".repeat(1_000_000), "a.gltf").is_err());
    assert!(matches!(read(&" ".repeat(4 << 20), "a.gltf"), Err(Error::Limit { .. })));
}

#[test]
fn layers_of_materials_arrive() {
    let text = r#"{"asset":{"version":"2.0"},
      "extensionsUsed":["KHR_texture_transform","KHR_materials_ior","KHR_materials_transmission",
        "KHR_materials_clearcoat","KHR_materials_sheen","KHR_materials_specular"],
      "images":[{"uri":"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVQYV2P4z/AfAAQAAf+I0P3MAAAAAElFTkSuQmCC"}],
      "samplers":[{"wrapS":33071,"wrapT":33648}],
      "textures":[{"source":0,"sampler":0}],
      "materials":[{"alphaMode":"BLEND","normalTexture":{"index":0,"scale":0.5},
        "emissiveTexture":{"index":0},"emissiveFactor":[1,0.5,0],
        "pbrMetallicRoughness":{"baseColorFactor":[1,1,1,0.25],"baseColorTexture":{"index":0,
          "extensions":{"KHR_texture_transform":{"rotation":1.5707963267948966,"scale":[2,3]}}}},
        "extensions":{"KHR_materials_ior":{"ior":1.3},
          "KHR_materials_transmission":{"transmissionFactor":0.5,"transmissionTexture":{"index":0}},
          "KHR_materials_clearcoat":{"clearcoatFactor":0.75,"clearcoatRoughnessFactor":0.125},
          "KHR_materials_sheen":{"sheenColorFactor":[0.1,0.2,0.3],"sheenRoughnessFactor":0.4},
          "KHR_materials_specular":{"specularFactor":0.5,"specularColorFactor":[1,0.5,0.5]}}}]}"#;
    let model =
        Model::read_bytes(text.as_bytes(), Path::new("a.gltf"), &Limits::default()).unwrap();
    let m = &model.materials[0];
    assert_eq!((m.ior, m.transmission, m.thin, m.opacity), (1.3, 0.5, true, 0.25));
    assert_eq!((m.coat, m.coat_roughness, m.sheen_roughness), (0.75, 0.125, 0.4));
    assert_eq!((m.sheen, m.specular), (DVec3::new(0.1, 0.2, 0.3), 0.5));
    assert_eq!((m.emitted, m.normal_strength), (DVec3::new(1.0, 0.5, 0.0), 0.5));
    assert!(m.emission_map.is_some() && m.transmission_map.is_some());
    let colour = m.colour_map.as_ref().unwrap();
    assert_eq!(colour.wrap, [Wrap::Clamp, Wrap::Mirror]);
    // A quarter turn: u of the image runs with w = 1 - v, and w against u.
    let place = |uv: DVec2| colour.turn.rotate(uv * colour.tile) + colour.shift;
    for uv in [DVec2::ZERO, DVec2::ONE, DVec2::new(0.25, 0.5)] {
        let want = DVec2::new(3.0 * (1.0 - uv.y), 1.0 + 2.0 * uv.x);
        assert!((place(uv) - want).length() < 1e-12, "{uv}: {}", place(uv));
    }
    let note = "/materials/0: the alpha of its image is not used";
    assert!(model.notes.iter().any(|n| n == note), "{:?}", model.notes);
}

#[test]
fn transforms_materials_cameras_lights_and_displacement_arrive() {
    let text = r#"{"asset":{"version":"2.0"},
      "extensionsUsed":["KHR_lights_punctual","KHR_texture_transform"],
      "scene":0,"scenes":[{"nodes":[0]}],
      "nodes":[{"translation":[0,0,1],"scale":[2,2,-2],"children":[1,2,3]},
        {"mesh":0},{"camera":0,"rotation":[0,1,0,0]},
        {"extensions":{"KHR_lights_punctual":{"light":0}},"translation":[1,0,0]}],
      "cameras":[{"type":"perspective","perspective":{"yfov":1.0,"aspectRatio":2.0,"znear":0.1}}],
      "extensions":{"KHR_lights_punctual":{"lights":[{"type":"point","intensity":5,"color":[1,0.5,0]}]}},
      "images":[{"uri":"data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABCAIAAACQd1PeAAAADElEQVQYV2P4z/AfAAQAAf+I0P3MAAAAAElFTkSuQmCC"}],
      "textures":[{"source":0}],
      "materials":[{"name":"stone","pbrMetallicRoughness":{"metallicFactor":0,"roughnessFactor":0.4,
          "baseColorFactor":[0.1,0.2,0.3,1],
          "baseColorTexture":{"index":0,"extensions":{"KHR_texture_transform":{"scale":[2,3],"offset":[0.5,0.25]}}}},
        "extras":{"displacement":{"texture":{"index":0},"scale":0.02,"zero":0.5}}}],
      "meshes":[{"primitives":[{"attributes":{"POSITION":0,"NORMAL":1,"TEXCOORD_0":2},"material":0}]}],
      "accessors":[
        {"type":"VEC3","componentType":5126,"count":3,"bufferView":0,"min":[0,0,0],"max":[1,1,0]},
        {"type":"VEC3","componentType":5126,"count":3,"sparse":{"count":3,
          "indices":{"bufferView":1,"componentType":5121},"values":{"bufferView":2}}},
        {"type":"VEC2","componentType":5121,"normalized":true,"count":3,"bufferView":3}],
      "bufferViews":[{"buffer":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":3},
        {"buffer":0,"byteOffset":40,"byteLength":36},{"buffer":0,"byteOffset":76,"byteLength":12,"byteStride":4}],
      "buffers":[{"byteLength":88,"uri":"data:application/octet-stream;base64,@"}]}"#;
    let floats = |all: &[f32]| all.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>();
    let mut bytes = floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
    bytes.extend([0, 1, 2, 0]);
    bytes.extend(floats(&[0.0, 0.0, 1.0, 0.0, 0.0, 1.0, 0.0, 0.0, 1.0]));
    bytes.extend([0, 0, 9, 9, 255, 0, 9, 9, 0, 255, 9, 9]);
    let text = text.replace('@', &base64(&bytes));
    let model =
        Model::read_bytes(text.as_bytes(), Path::new("a.gltf"), &Limits::default()).unwrap();
    let mesh = &model.mesh;
    assert_eq!(mesh.positions, [DVec3::Z, DVec3::new(2.0, 0.0, 1.0), DVec3::new(0.0, 2.0, 1.0)]);
    // The mirror turns the triangle round, and its normal with it.
    assert_eq!(mesh.triangles[0].positions, [0, 2, 1]);
    assert!(mesh.normals.iter().all(|n| (*n + DVec3::Z).length() < 1e-12), "{:?}", mesh.normals);
    assert_eq!(mesh.uvs, [DVec2::Y, DVec2::ONE, DVec2::ZERO]);
    let stone = &model.materials[0];
    assert_eq!((stone.name.as_str(), stone.roughness, stone.metalness), ("stone", 0.4, 0.0));
    let colour = stone.colour_map.as_ref().unwrap();
    assert_eq!((colour.tile, colour.shift), (DVec2::new(2.0, 3.0), DVec2::new(0.5, -2.25)));
    let displacement = stone.displacement.as_ref().unwrap();
    assert_eq!((displacement.scale, displacement.zero), (0.02, 0.5));
    assert!(
        matches!(&displacement.image.source, ImageSource::Embedded { bytes, .. } if bytes.len() == 69)
    );
    let camera = &model.cameras[0];
    assert!((camera.fov - 1_f64.to_degrees()).abs() < 1e-9 && camera.aspect == Some(2.0));
    assert!((camera.forward + DVec3::Z).length() < 1e-9 && camera.position == DVec3::Z);
    let light = &model.lights[0];
    assert_eq!(light.intensity, DVec3::new(5.0, 2.5, 0.0));
    assert_eq!(light.kind, LightKind::Point { position: DVec3::new(2.0, 0.0, 1.0) });
}

fn base64(bytes: &[u8]) -> String {
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let group = |three: &[u8]| {
        let bits = (0..3).fold(0, |bits, k| bits << 8 | u32::from(*three.get(k).unwrap_or(&0)));
        let digit = |k: usize| char::from(digits[(bits >> (18 - 6 * k)) as usize % 64]);
        (0..=three.len()).map(digit).collect::<String>()
    };
    bytes.chunks(3).map(group).collect()
}
