//! Displaced meshes of a scene, and displaced quads that are not parallelograms: those are two
//! base triangles.

use std::sync::Arc;

use rilievo::glam::DVec2;
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{Edges, MeshOptions, MeshReport, ReliefMesh, ReliefMeshError};
use rilievo_render::Material;

use super::file::{DisplacementEntry, MeshEntry, QuadEntry};
use super::resolve::Loader;
use crate::error::Result;

impl Loader<'_> {
    /// The mesh of an entry, displaced, and the material of its file where that has one for all.
    pub(super) fn relief_mesh(
        &mut self,
        entry: &MeshEntry,
        displacement: &DisplacementEntry,
    ) -> Result<(ReliefMesh, Option<Material>)> {
        let model = self.model(entry)?;
        let material = match model.materials.as_slice() {
            [one] => Some(self.model_material(one)),
            [] => None,
            many => {
                let note = format!(
                    "{}: displaced as one surface; the {} materials of the file are not used",
                    entry.file.value,
                    many.len()
                );
                self.notes.push(note);
                None
            }
        };
        let mesh = self.placed(model.mesh, &entry.file, entry.world_from_object.as_ref())?;
        let options =
            MeshOptions { displacement: displacement.displacement, ..self.mesh_options(entry) };
        let mesh = self.laid_on(&mesh, displacement, options)?;
        self.tell(&entry.file.value, mesh.report());
        Ok((mesh, material))
    }

    /// How the mesh of an entry is displaced, but for the displacement.
    pub(super) fn mesh_options(&self, entry: &MeshEntry) -> MeshOptions {
        MeshOptions {
            method: self.method(entry.method),
            edges: entry.edges,
            closed: entry.closed,
            one_sided: entry.one_sided,
            simd: self.options.simd,
            ..MeshOptions::default()
        }
    }

    /// A displaced quad that is not a parallelogram.
    pub(super) fn relief_quad(
        &self,
        quad: &QuadEntry,
        displacement: &DisplacementEntry,
    ) -> Result<ReliefMesh> {
        let half = |corners| Triangle { positions: corners, normals: None, uvs: Some(corners) };
        let data = MeshData {
            positions: quad.corners.value.to_vec(),
            normals: Vec::new(),
            uvs: vec![DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y],
            triangles: vec![half([0, 1, 2]), half([0, 2, 3])],
        };
        let mesh = Mesh::new(data).map_err(|e| {
            let allowed = "four corners that span an area".to_owned();
            self.file.invalid(&quad.corners.at, "corners", e.to_string(), allowed)
        })?;
        let options = MeshOptions {
            displacement: displacement.displacement,
            method: self.method(quad.method),
            edges: Edges::Shared,
            closed: quad.closed,
            one_sided: quad.one_sided,
            simd: self.options.simd,
            ..MeshOptions::default()
        };
        self.laid_on(&mesh, displacement, options)
    }

    /// The map of an entry laid on a mesh.
    fn laid_on(
        &self,
        mesh: &Mesh,
        entry: &DisplacementEntry,
        options: MeshOptions,
    ) -> Result<ReliefMesh> {
        let relief = Arc::clone(&self.maps[entry.map.value.as_str()]);
        let axis = relief.heights().x();
        let normals = self.normals(&entry.normals, (axis.lattice(), axis.wrap()))?;
        let options = MeshOptions { normals, ..options };
        ReliefMesh::new(mesh, relief, options).map_err(|e| {
            let allowed = match e {
                ReliefMeshError::NoUv(_) => "texture coordinates on every face, or `projection`",
                ReliefMeshError::Method(_) => "pyramid, dda",
                _ => "",
            };
            self.file.invalid(&entry.at, "displacement", e.to_string(), allowed.to_owned())
        })
    }

    /// Notes what is out of the ordinary.
    pub(super) fn tell(&mut self, name: &str, report: &MeshReport) {
        for (triangles, what) in [
            (&report.no_volume, "have no area and are left out"),
            (&report.no_uv_area, "have texture coordinates without area; they are slow"),
            (&report.folded, "are displaced beyond their radius of curvature and fold over"),
        ] {
            if let Some(first) = triangles.first() {
                let count = triangles.len();
                self.notes.push(format!("{name}: {count} triangles {what}, the first is {first}"));
            }
        }
    }
}
