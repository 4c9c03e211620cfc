//! A scene as `rilievo info` tells it.

use rilievo::relief::Relief;
use rilievo::surface::Surface;
use rilievo_io::image::Blocks;
use rilievo_io::scene::{LoadOptions, LoadedMap, LoadedScene, LoadedSphereMap};
use rilievo_render::{MemoryUse, RenderOptions, Scene};
use serde::Serialize;

use crate::args::InfoArgs;
use crate::job;
use crate::memory::predicted_bytes;
use crate::outcome::Failure;
use crate::picture::PictureKind;
use crate::report;

/// The JSON object.
#[derive(Serialize)]
struct Report {
    kind: &'static str,
    integrator: String,
    samples: u32,
    resolution: [u32; 2],
    reliefs: usize,
    quads: usize,
    spheres: usize,
    meshes: usize,
    instances: usize,
    triangles: usize,
    lights: usize,
    maps: Vec<MapReport>,
    sphere_maps: Vec<SphereMapReport>,
    map_bytes: u64,
    bounds_bytes: u64,
    level_bytes: u64,
    film_bytes: u64,
    predicted_bytes: u64,
}

#[derive(Serialize)]
struct MapReport {
    name: String,
    width: u32,
    height: u32,
    range: [f64; 2],
    layout: String,
    map_bytes: u64,
    bounds_bytes: u64,
}

impl From<&LoadedMap> for MapReport {
    fn from(map: &LoadedMap) -> Self {
        let heights = Relief::heights(&map.relief);
        let (map_bytes, bounds_bytes) = map.relief.bytes();
        let (low, high) = heights.raw_range();
        Self {
            name: map.name.clone(),
            width: heights.width(),
            height: heights.height(),
            range: [low, high].map(|raw| f64::from(raw) * heights.unit()),
            layout: map.relief.pyramid().layout().to_string(),
            map_bytes,
            bounds_bytes,
        }
    }
}

/// A map resampled to the six faces around a sphere.
#[derive(Serialize)]
struct SphereMapReport {
    name: String,
    width: u32,
    height: u32,
    /// Cells along a side of a face.
    cells: u32,
    range: [f64; 2],
    /// Largest and root mean square difference from the map, in heights.
    error_max: f64,
    error_rms: f64,
    map_bytes: u64,
    bounds_bytes: u64,
}

impl From<&LoadedSphereMap> for SphereMapReport {
    fn from(map: &LoadedSphereMap) -> Self {
        let (map_bytes, bounds_bytes) = map.relief.bytes();
        let (low, high) = map.relief.raw_range();
        let error = map.error.unwrap_or_default();
        Self {
            name: map.name.clone(),
            width: map.size[0],
            height: map.size[1],
            cells: map.relief.cells(),
            range: [low, high].map(|raw| f64::from(raw) * map.relief.unit()),
            error_max: error.max,
            error_rms: error.rms,
            map_bytes,
            bounds_bytes,
        }
    }
}

pub fn run(args: &InfoArgs) -> Result<(), Failure> {
    let options =
        LoadOptions { layout: args.layout, resampling_error: true, ..LoadOptions::default() };
    let LoadedScene { mut scene, maps, sphere_maps, .. } =
        job::load(&args.file, &options, args.talk)?;
    if let Some(resolution) = args.resolution {
        let camera = scene.camera().with_resolution(resolution).map_err(Failure::refused)?;
        scene = scene.with_camera(camera);
    }
    let report = Report::new(&scene, &maps, &sphere_maps);
    report.tell(args);
    args.talk.object(&report)
}

impl Report {
    fn new(scene: &Scene, maps: &[LoadedMap], sphere_maps: &[LoadedSphereMap]) -> Self {
        let memory = MemoryUse::predict(scene, &RenderOptions::default());
        let resolution = scene.camera().resolution();
        let mut report = Self {
            kind: "scene",
            integrator: scene.settings().integrator.to_string(),
            samples: scene.settings().samples,
            resolution,
            reliefs: 0,
            quads: 0,
            spheres: 0,
            meshes: 0,
            instances: 0,
            triangles: 0,
            lights: scene.lights().len(),
            maps: maps.iter().map(MapReport::from).collect(),
            sphere_maps: sphere_maps.iter().map(SphereMapReport::from).collect(),
            map_bytes: memory.heights + memory.textures,
            bounds_bytes: memory.bounds,
            level_bytes: memory.levels,
            film_bytes: memory.film,
            predicted_bytes: predicted_bytes(
                &memory,
                PictureKind::Colour.writing_bytes(resolution, Blocks::Lines, 0),
            ),
        };
        for surface in scene.world().surfaces() {
            let surface = match surface {
                Surface::Instance(instance) => {
                    report.instances += 1;
                    instance.prototype().as_ref()
                }
                Surface::Moving(moving) => {
                    report.instances += 1;
                    moving.prototype().as_ref()
                }
                surface => surface,
            };
            match surface {
                // Instances show no instances.
                Surface::Instance(_) | Surface::Moving(_) => {}
                Surface::Face(_) | Surface::ReliefSphere(_) => report.reliefs += 1,
                Surface::ReliefMesh(mesh) => {
                    report.reliefs += 1;
                    report.triangles += mesh.data().triangles.len();
                }
                Surface::Quad(_) => report.quads += 1,
                Surface::Sphere(_) => report.spheres += 1,
                Surface::Mesh(mesh) => {
                    report.meshes += 1;
                    report.triangles += mesh.data().triangles.len();
                }
            }
        }
        report
    }

    fn tell(&self, args: &InfoArgs) {
        let talk = args.talk;
        let [width, height] = self.resolution;
        talk.line(format_args!(
            "{}: scene, {width} x {height} pixels, {} samples, integrator {}",
            args.file.display(),
            self.samples,
            self.integrator
        ));
        talk.line(format_args!(
            "surfaces    {} reliefs, {} quads, {} spheres, {} meshes with {} triangles, {} of them \
             instances; {} lights",
            self.reliefs,
            self.quads,
            self.spheres,
            self.meshes,
            self.triangles,
            self.instances,
            self.lights
        ));
        for map in &self.maps {
            talk.line(format_args!(
                "map         {:?}: {} x {} samples, heights {:.6} to {:.6}, {}, bounds {} ({})",
                map.name,
                map.width,
                map.height,
                map.range[0],
                map.range[1],
                report::bytes(map.map_bytes),
                report::bytes(map.bounds_bytes),
                map.layout
            ));
        }
        for map in &self.sphere_maps {
            talk.line(format_args!(
                "sphere map  {:?}: {} x {} samples on 6 faces of {} x {} cells, heights {:.6} to {:.6}, {}, \
                 bounds {}; off by {:.2e} rms, {:.2e} at most",
                map.name,
                map.width,
                map.height,
                map.cells,
                map.cells,
                map.range[0],
                map.range[1],
                report::bytes(map.map_bytes),
                report::bytes(map.bounds_bytes),
                map.error_rms,
                map.error_max
            ));
        }
        talk.line(format_args!(
            "memory      maps {}, bounds {}, {}image {}; a render needs about {}",
            report::bytes(self.map_bytes),
            report::bytes(self.bounds_bytes),
            report::levels(self.level_bytes),
            report::bytes(self.film_bytes),
            report::bytes(self.predicted_bytes)
        ));
    }
}
