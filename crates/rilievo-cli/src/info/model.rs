//! A model as `rilievo info` tells it.

use rilievo::mesh::Mesh;
use rilievo_io::Limits;
use rilievo_io::mesh::{ImageSource, ImageUse, MeshFormat, Model, ModelMaterial};
use serde::Serialize;

use crate::args::InfoArgs;
use crate::outcome::Failure;
use crate::report;

/// The JSON object.
#[derive(Serialize)]
struct Report {
    kind: &'static str,
    format: String,
    positions: usize,
    triangles: usize,
    /// Triangles that have normals, and that have texture coordinates.
    with_normals: usize,
    with_uvs: usize,
    /// Triangles without area; null for a model without triangles.
    degenerate: Option<usize>,
    /// The corners of the box around the triangles; null without any.
    bounds: Option<[[f64; 3]; 2]>,
    /// Memory of the mesh and its tree.
    mesh_bytes: u64,
    materials: Vec<MaterialReport>,
    cameras: usize,
    lights: usize,
    notes: Vec<String>,
}

#[derive(Serialize)]
struct MaterialReport {
    name: String,
    triangles: usize,
    colour: [f64; 3],
    roughness: f64,
    metalness: f64,
    emitted: [f64; 3],
    /// Images by what they are for.
    images: Vec<(&'static str, String)>,
    displacement: Option<DisplacementReport>,
}

#[derive(Serialize)]
struct DisplacementReport {
    image: String,
    scale: f64,
    zero: f64,
}

fn name(image: &ImageUse) -> String {
    match &image.source {
        ImageSource::File(path) => path.display().to_string(),
        ImageSource::Embedded { name, .. } => name.display().to_string(),
    }
}

impl MaterialReport {
    fn new(index: usize, material: &ModelMaterial, model: &Model) -> Self {
        let images = [
            ("colour", material.colour_map.as_ref()),
            ("roughness", material.roughness_map.as_ref()),
            ("metalness", material.metalness_map.as_ref()),
            ("normal", material.normal_map.as_ref().map(|(image, _)| image)),
            ("bump", material.bump_map.as_ref().map(|(image, _)| image)),
        ];
        let displacement = material.displacement.as_ref();
        Self {
            name: material.name.clone(),
            triangles: model.material_of.iter().filter(|m| **m as usize == index).count(),
            colour: material.colour.to_array(),
            roughness: material.roughness,
            metalness: material.metalness,
            emitted: material.emitted.to_array(),
            images: images.iter().filter_map(|(what, i)| Some((*what, name((*i)?)))).collect(),
            displacement: displacement.map(|d| DisplacementReport {
                image: name(&d.image),
                scale: d.scale,
                zero: d.zero,
            }),
        }
    }
}

pub fn run(args: &InfoArgs, format: MeshFormat) -> Result<(), Failure> {
    let model = Model::read(&args.file, &Limits::default())?;
    let all = &model.mesh.triangles;
    let mut report = Report {
        kind: "model",
        format: format.to_string(),
        positions: model.mesh.positions.len(),
        triangles: all.len(),
        with_normals: all.iter().filter(|t| t.normals.is_some()).count(),
        with_uvs: all.iter().filter(|t| t.uvs.is_some()).count(),
        degenerate: None,
        bounds: None,
        mesh_bytes: 0,
        materials: (model.materials.iter().enumerate())
            .map(|(k, material)| MaterialReport::new(k, material, &model))
            .collect(),
        cameras: model.cameras.len(),
        lights: model.lights.len(),
        notes: model.notes.clone(),
    };
    if let Ok(mesh) = Mesh::new(model.mesh) {
        let bounds = mesh.bounds();
        report.degenerate = Some(mesh.degenerate());
        report.bounds = Some([bounds.min, bounds.max].map(|p| p.to_array()));
        report.mesh_bytes = mesh.bytes();
    }
    report.tell(args);
    args.talk.object(&report)
}

impl Report {
    fn tell(&self, args: &InfoArgs) {
        let talk = args.talk;
        talk.line(format_args!(
            "{}: model, {}, {} triangles, {} positions, {} in memory",
            args.file.display(),
            self.format,
            self.triangles,
            self.positions,
            report::bytes(self.mesh_bytes)
        ));
        talk.line(format_args!(
            "triangles   {} with normals, {} with texture coordinates, {} without area",
            self.with_normals,
            self.with_uvs,
            self.degenerate.unwrap_or(0)
        ));
        if let Some([low, high]) = self.bounds {
            talk.line(format_args!("bounds      {low:?} to {high:?}"));
        }
        for m in &self.materials {
            talk.line(format_args!(
                "material    {:?}: {} triangles, colour {:?}, roughness {:.3}, metalness {:.3}",
                m.name, m.triangles, m.colour, m.roughness, m.metalness
            ));
            for (what, file) in &m.images {
                talk.line(format_args!("              {what}: {file}"));
            }
            if let Some(d) = &m.displacement {
                talk.line(format_args!(
                    "              displacement: {}, scale {}, zero {}",
                    d.image, d.scale, d.zero
                ));
            }
        }
        talk.line(format_args!("beside      {} cameras, {} lights", self.cameras, self.lights));
        for note in &self.notes {
            talk.line(format_args!("note        {note}"));
        }
    }
}
