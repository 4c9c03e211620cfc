//! Any bytes are a PLY file within the limits, whose parts can be traced, or an error.

#![no_main]

use std::path::Path;

use libfuzzer_sys::fuzz_target;
use rilievo::Ray;
use rilievo::glam::DVec3;
use rilievo::mesh::Mesh;
use rilievo_io::Limits;
use rilievo_io::mesh::Model;

fuzz_target!(|bytes: &[u8]| {
    let limits = Limits { max_bytes: 16 << 20 };
    if let Ok(model) = Model::read_bytes(bytes, Path::new("a.ply"), &limits) {
        assert_eq!(model.material_of.len(), model.mesh.triangles.len());
        let parts = model.by_material();
        let cut: usize = parts.iter().map(|(data, _)| data.triangles.len()).sum();
        assert!(parts.is_empty() || cut == model.mesh.triangles.len());
        let _ = model.presentation(Path::new("a.ply"));
        if let Ok(mesh) = Mesh::new(model.mesh) {
            let _ = mesh.closest(&Ray::new(DVec3::new(0.3, 0.2, 9.0), -DVec3::Z), &mut ());
        }
    }
});
