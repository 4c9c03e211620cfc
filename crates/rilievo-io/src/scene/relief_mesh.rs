//! Displaced meshes of a scene, and displaced quads that are not parallelograms: those are two
//! base triangles.

use std::sync::Arc;

use rilievo::glam::DVec2;
use rilievo::mesh::{Mesh, MeshData, Triangle};
use rilievo::relief::{
    Displacement, Edges, MeshOptions, MeshPart, MeshReport, Method, Relief, ReliefMesh,
    ReliefMeshError,
};
use rilievo::surface::Surface;
use rilievo_render::Material;

use super::file::{DisplacementEntry, MeshEntry, QuadEntry};
use super::load_map::{self, Face};
use super::resolve::Loader;
use crate::error::Result;

/// How many texels from seams `edges = "matched"` changes heights.
const MATCHED_TEXELS: u32 = 8;

/// Lengths of one repetition of the map along u and v.
pub(super) fn sides(mesh: &Mesh, displacement: &Displacement) -> [f64; 2] {
    let [u, v] = mesh.data().lengths_of_uv().unwrap_or([1.0; 2]);
    [u / displacement.tile[0], v / displacement.tile[1]]
}

impl Loader<'_> {
    /// The mesh of an entry under one displacement: whole, or, if the materials of its file are `wanted`, joined of
    /// one part for each of them.
    pub(super) fn relief_mesh(
        &mut self,
        entry: &MeshEntry,
        displacement: &DisplacementEntry,
        wanted: bool,
    ) -> Result<Vec<(Surface, Option<Material>)>> {
        let model = self.model(entry)?;
        let place = entry.world_from_object.as_ref();
        let cut = if wanted { model.by_material() } else { Vec::new() };
        let mesh = self.placed(model.mesh, &entry.file, place)?;
        let options =
            MeshOptions { displacement: displacement.displacement, ..self.mesh_options(entry) };
        let mut laid = self.laid_on(&mesh, displacement, options)?;
        if entry.matched {
            let index = self.file.find(&displacement.map, &self.file.maps, "map")?;
            let (name, map) = &self.file.maps[index];
            let method = self.method(entry.method);
            let face = Face {
                sides: sides(&mesh, &displacement.displacement),
                scale: displacement.displacement.scale,
            };
            let (file, options) = (self.file, self.options);
            laid = self.matched(entry, &mesh, laid, |relief| match method.distance_kind() {
                Some(kind) => {
                    load_map::add_distance(file, (&name.value, map), relief, (kind, face), options)
                }
                None => Ok(relief),
            })?;
        }
        self.tell(&entry.file.value, laid.report());
        let (mut parts, mut materials) = (Vec::new(), Vec::new());
        let several = cut.len() > 1;
        for (data, material) in cut {
            if several {
                let mesh = self.placed(data, &entry.file, place)?;
                let (relief, options) = (Arc::clone(laid.relief()), laid.options().clone());
                parts.push(MeshPart::displaced(&mesh, relief, options));
            }
            let material = material.and_then(|index| model.materials.get(index));
            materials.push(material.map(|from| self.model_material(from)).transpose()?);
        }
        if !several {
            return Ok(vec![(laid.into(), materials.pop().flatten())]);
        }
        let joined = ReliefMesh::joined(&parts).map_err(|(_, e)| {
            self.file.invalid(&displacement.at, "displacement", e.to_string(), String::new())
        })?;
        let parts = joined.into_iter().zip(materials);
        Ok(parts.filter_map(|(mesh, material)| Some((mesh?.into(), material))).collect())
    }

    /// The same displaced mesh over a map that is baked towards equal heights at its seams; `complete`
    /// adds what the method needs.
    pub(super) fn matched(
        &mut self,
        entry: &MeshEntry,
        mesh: &Mesh,
        laid: ReliefMesh,
        complete: impl FnOnce(Relief) -> Result<Relief>,
    ) -> Result<ReliefMesh> {
        let before = laid.seam_steps();
        if before.largest == 0.0 {
            return Ok(laid);
        }
        let layout = laid.relief().pyramid().layout();
        let relief = Relief::with_layout(laid.matched_heights(MATCHED_TEXELS), layout);
        let (relief, options) = (Arc::new(complete(relief)?), laid.options().clone());
        let matched = ReliefMesh::new(mesh, relief, options).map_err(|e| {
            self.file.invalid(&entry.file.at, "edges", e.to_string(), String::new())
        })?;
        let after = matched.seam_steps();
        self.notes.push(format!(
            "{}: heights at seams matched, from steps of {:.2e} (at most {:.2e}) to {:.2e} ({:.2e})",
            entry.file.value, before.mean, before.largest, after.mean, after.largest
        ));
        Ok(matched)
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
        &mut self,
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
        &mut self,
        mesh: &Mesh,
        entry: &DisplacementEntry,
        options: MeshOptions,
    ) -> Result<ReliefMesh> {
        let relief = self.relief_for(mesh, entry, options.method)?;
        let axis = relief.heights().x();
        let normals = self.normals(&entry.normals, (axis.lattice(), axis.wrap()))?;
        let options = MeshOptions { normals, ..options };
        ReliefMesh::new(mesh, relief, options).map_err(|e| {
            let allowed = match e {
                ReliefMeshError::NoUv(_) => "texture coordinates on every face, or `projection`",
                ReliefMeshError::Method(_) => "pyramid, dda, distance, distance-corrected",
                _ => "",
            };
            self.file.invalid(&entry.at, "displacement", e.to_string(), allowed.to_owned())
        })
    }

    /// The map of an entry with the distance map that a method walks, made for a mesh unless it is
    /// there.
    fn relief_for(
        &mut self,
        mesh: &Mesh,
        entry: &DisplacementEntry,
        method: Method,
    ) -> Result<Arc<Relief>> {
        let index = self.file.find(&entry.map, &self.file.maps, "map")?;
        let (name, map) = &self.file.maps[index];
        let relief = &self.maps[name.value.as_str()];
        let Some(kind) = method.distance_kind().filter(|&kind| relief.distance(kind).is_none())
        else {
            return Ok(Arc::clone(relief));
        };
        // Copied only where another shape holds it already.
        let own = match self.maps.remove(name.value.as_str()) {
            Some(relief) => Arc::unwrap_or_clone(relief),
            None => {
                return Err(self.file.invalid(&entry.at, "map", name.value.clone(), String::new()));
            }
        };
        let sides = sides(mesh, &entry.displacement);
        let need = (kind, Face { sides, scale: entry.displacement.scale });
        let map = (name.value.as_str(), map);
        let relief = Arc::new(load_map::add_distance(self.file, map, own, need, self.options)?);
        load_map::keep(self.file, map.1, &relief, self.options);
        self.maps.insert(&name.value, Arc::clone(&relief));
        Ok(relief)
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
