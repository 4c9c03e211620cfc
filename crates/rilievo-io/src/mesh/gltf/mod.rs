//! glTF 2.0, as JSON or GLB \[Khronos2021\].
//!
//! The document is checked as a whole before any geometry is made of it: what the official
//! validator calls an error is an error here too, named by its JSON pointer. Then the nodes of the
//! default scene (all root nodes without one, all meshes without nodes) are walked, and every
//! primitive becomes triangles in the world of the file: y up, metres.
//!
//! Read are meshes (triangles, strips, fans; sparse and normalised accessors), transforms,
//! materials, perspective cameras, punctual lights, texture transforms, and
//! displacement in `extras` (see [`materials`]). Skins and morph targets are checked and left in their
//! rest pose. Textures may ask for any set of uv; the mesh gets the one of the displacement or the
//! colour.

mod accessor;
mod buffers;
mod container;
mod extensions;
mod images;
mod json;
mod materials;
mod nodes;
mod primitive;
mod uri;

use std::path::Path;

use glam::{DAffine3, DMat3, DVec3};
use rilievo::mesh::{MeshData, Triangle};

use super::Beside;
use super::model::{Model, NO_MATERIAL};
use crate::error::{Place, Result};
use crate::limits::Limits;
use accessor::Accessor;
use buffers::Buffers;
use container::Container;
use images::Images;
use json::Json;
use materials::GltfMaterial;
use nodes::Nodes;
use primitive::{Context, Primitive, Triangles};

pub(super) use container::MAGIC;

/// Reads a model from the bytes of a glTF file or GLB; `name` is what errors call it.
///
/// # Errors
/// Of its JSON, its references, its sizes; files beside it that cannot be opened.
pub(super) fn read(
    bytes: &[u8],
    name: &Path,
    limits: &Limits,
    beside: Beside<'_>,
) -> Result<Model> {
    let container = Container::read(bytes, name, limits)?;
    let root = Json { path: name, value: &container.json, pointer: String::new() }.object()?;
    version(&root)?;
    let used = extensions::check(&root)?;
    let mut model = Model::default();
    let notes = &mut model.notes;
    let mut buffers = Buffers::read(&root, container.glb, (beside, limits), notes)?;
    let accessors = root.objects("accessors")?;
    let accessors: Vec<Accessor<'_>> = accessors
        .into_iter()
        .map(|json| Accessor::read(json, &mut buffers))
        .collect::<Result<_>>()?;
    let images = Images::read(&root, &mut buffers, (beside, limits), notes)?;
    let materials = root.objects("materials")?;
    let materials: Vec<GltfMaterial> = materials
        .iter()
        .map(|json| GltfMaterial::read(json, &images, notes))
        .collect::<Result<_>>()?;
    let mut context = Context {
        accessors: &accessors,
        buffers: &mut buffers,
        materials: materials.len(),
        quantized: used.contains("KHR_mesh_quantization"),
    };
    let meshes = read_meshes(&root, &mut context)?;
    check_uv_sets(&root, &meshes, &materials)?;
    let nodes = Nodes::read(&root, &meshes)?;
    let document = Document { root, limits, buffers, accessors, materials, meshes };
    if nodes.all.is_empty() {
        for mesh in &document.meshes {
            document.add(mesh, DAffine3::IDENTITY, &mut model)?;
        }
    }
    nodes.walk(|node, world_from_node| {
        if let Some(mesh) = node.mesh {
            document.add(&document.meshes[mesh], world_from_node, &mut model)?;
        }
        if let Some(index) = node.camera {
            let cameras = document.root.objects("cameras")?;
            match nodes::camera(&cameras[index], world_from_node)? {
                Some(camera) => model.cameras.push(camera),
                None => model.notes.push(format!("/cameras/{index}: not perspective, not read")),
            }
        }
        if let Some(index) = node.light {
            model.lights.extend(nodes::light(&document.root, index, world_from_node)?);
        }
        Ok(())
    })?;
    model.materials = document.materials.into_iter().map(|m| m.material).collect();
    Ok(model)
}

/// A document whose references hold.
struct Document<'a, 'b> {
    root: Json<'a>,
    limits: &'a Limits,
    buffers: Buffers<'b>,
    accessors: Vec<Accessor<'a>>,
    materials: Vec<GltfMaterial>,
    meshes: Vec<Vec<Primitive>>,
}

fn version(root: &Json<'_>) -> Result<()> {
    let asset = root.require("asset")?.object()?;
    let version = asset.require("version")?;
    let text = version.text()?;
    match text.split('.').next() {
        Some("2") => Ok(()),
        _ => Err(version.fault("version", format!("{text:?}"), "2.0")),
    }
}

fn read_meshes(root: &Json<'_>, context: &mut Context<'_, '_, '_>) -> Result<Vec<Vec<Primitive>>> {
    let mut meshes = Vec::new();
    for json in root.objects("meshes")? {
        json.require("primitives")?;
        let primitives: Vec<_> = (json.objects("primitives")?.iter())
            .map(|json| Primitive::read(json, context))
            .collect::<Result<_>>()?;
        let targets = primitives.first().map_or(0, |p| p.targets);
        if let Some(other) = primitives.iter().find(|p| p.targets != targets) {
            let found = format!("{} morph targets beside {targets}", other.targets);
            return Err(json.fault("primitives", found, "as many in each primitive"));
        }
        let weights = json.list("weights")?.len();
        if weights > 0 && weights != targets {
            let found = format!("{weights} numbers");
            return Err(json.fault("weights", found, format!("{targets}, one a morph target")));
        }
        meshes.push(primitives);
    }
    Ok(meshes)
}

/// Checks that primitives have the sets of uv that their materials ask for.
fn check_uv_sets(
    root: &Json<'_>,
    meshes: &[Vec<Primitive>],
    materials: &[GltfMaterial],
) -> Result<()> {
    for primitive in meshes.iter().flatten() {
        let Some(material) = primitive.material else { continue };
        if let Some((pointer, set)) = materials[material].lacking(primitive.uvs.len()) {
            let json = Json { pointer: primitive.json_pointer.clone(), ..root.clone() };
            let allowed = format!("TEXCOORD_{set}, which {pointer} asks for");
            let found = format!("{} sets of texture coordinates", primitive.uvs.len());
            return Err(json.fault("attributes", found, allowed));
        }
    }
    Ok(())
}

impl Document<'_, '_> {
    /// Adds the triangles of a mesh, placed, to the model.
    fn add(&self, mesh: &[Primitive], world_from_node: DAffine3, model: &mut Model) -> Result<()> {
        for primitive in mesh {
            let material = primitive.material;
            let set = material.map_or(0, |material| self.materials[material].uv_set());
            let triangles =
                primitive.triangles((&self.accessors, &self.buffers), set, self.limits)?;
            let Some(triangles) = triangles else {
                model.notes.push(format!("{}: no triangles", primitive.json_pointer));
                continue;
            };
            let count = triangles.corners.len();
            append(&mut model.mesh, &triangles, world_from_node);
            model
                .material_of
                .extend((0..count).map(|_| material.map_or(NO_MATERIAL, |m| m as u32)));
            let data = &model.mesh;
            let bytes = size_of_val(data.positions.as_slice())
                + size_of_val(data.normals.as_slice())
                + size_of_val(data.uvs.as_slice())
                + size_of_val(data.triangles.as_slice());
            let place = Place::Pointer(primitive.json_pointer.clone());
            self.limits.check(self.root.path, place, "the mesh", &[bytes as u64])?;
        }
        Ok(())
    }
}

/// Appends triangles in the frame of a node.
fn append(mesh: &mut MeshData, triangles: &Triangles, world_from_node: DAffine3) {
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = world_from_node.matrix3;
    let mirrors = world_from_node.matrix3.determinant() < 0.0;
    // Normals go by the cofactors, which a mirror turns round.
    let sign = if mirrors { -1.0 } else { 1.0 };
    let normals_by = DMat3::from_cols(y.cross(z), z.cross(x), x.cross(y)) * sign;
    let first = [mesh.positions.len(), mesh.normals.len(), mesh.uvs.len()].map(|n| n as u32);
    let place = |p: &DVec3| world_from_node.transform_point3(*p);
    mesh.positions.extend(triangles.positions.iter().map(place));
    mesh.normals.extend(triangles.normals.iter().map(|n| (normals_by * *n).normalize_or_zero()));
    mesh.uvs.extend(&triangles.uvs);
    for &corners in &triangles.corners {
        let [a, b, c] = corners;
        let corners = if mirrors { [a, c, b] } else { [a, b, c] };
        let from = |start: u32| corners.map(|corner| start + corner);
        mesh.triangles.push(Triangle {
            positions: from(first[0]),
            normals: (!triangles.normals.is_empty()).then(|| from(first[1])),
            uvs: (!triangles.uvs.is_empty()).then(|| from(first[2])),
        });
    }
}
