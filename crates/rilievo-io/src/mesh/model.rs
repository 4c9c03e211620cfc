//! [`Model`]: what a file of any mesh format holds: triangles, which material each has, and beside
//! them cameras and lights.
//!
//! Materials are kept as the file means them, whether or not the renderer uses all of it.

use std::path::PathBuf;
use std::sync::Arc;

use rilievo::glam::{DVec2, DVec3};
use rilievo::map::{NormalConvention, Wrap};
use rilievo::mesh::MeshData;

/// Triangle without a material.
pub const NO_MATERIAL: u32 = u32::MAX;

/// A model.
#[derive(Clone, Debug, Default)]
pub struct Model {
    /// All triangles, in the frame of the file.
    pub mesh: MeshData,
    /// For each triangle an index into `materials`, or [`NO_MATERIAL`].
    pub material_of: Vec<u32>,
    /// The materials.
    pub materials: Vec<ModelMaterial>,
    /// The cameras.
    pub cameras: Vec<ModelCamera>,
    /// The lights.
    pub lights: Vec<ModelLight>,
    /// Files beside it that were read: libraries of materials and buffers; not images.
    pub files: Vec<PathBuf>,
    /// What the file holds that was not read, a line each.
    pub notes: Vec<String>,
}

/// A material as a file means it.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelMaterial {
    /// Its name.
    pub name: String,
    /// Base colour, linear; it multiplies `colour_map`.
    pub colour: DVec3,
    /// Base colour, an image.
    pub colour_map: Option<ImageUse>,
    /// Mirror reflectance that comes on top, linear.
    pub reflective: DVec3,
    /// Roughness, 0 to 1; it multiplies `roughness_map`.
    pub roughness: f64,
    /// Roughness, an image: its green channel in glTF.
    pub roughness_map: Option<ImageUse>,
    /// Metalness, 0 to 1; it multiplies `metalness_map`.
    pub metalness: f64,
    /// Metalness, an image: its blue channel in glTF.
    pub metalness_map: Option<ImageUse>,
    /// Radiance of the front; it multiplies `emission_map`.
    pub emitted: DVec3,
    /// What the front sends out, an image.
    pub emission_map: Option<ImageUse>,
    /// Share of the surface that is there, 0 to 1; it multiplies `opacity_map`.
    pub opacity: f64,
    /// Opacity, an image: its red channel.
    pub opacity_map: Option<ImageUse>,
    /// Index of refraction.
    pub ior: f64,
    /// Factor on the gloss of what is no metal.
    pub specular: f64,
    /// Tint of that gloss.
    pub specular_colour: DVec3,
    /// Share of what is no metal that is glass, 0 to 1; it multiplies `transmission_map`.
    pub transmission: f64,
    /// Transmission, an image: its red channel.
    pub transmission_map: Option<ImageUse>,
    /// Whether glass is a sheet without thickness.
    pub thin: bool,
    /// Weight of a clear coat, 0 to 1; it multiplies `coat_map`.
    pub coat: f64,
    /// Weight of the coat, an image: its red channel.
    pub coat_map: Option<ImageUse>,
    /// Roughness of the coat; it multiplies `coat_roughness_map`.
    pub coat_roughness: f64,
    /// Roughness of the coat, an image: its green channel.
    pub coat_roughness_map: Option<ImageUse>,
    /// Colour of a sheen.
    pub sheen: DVec3,
    /// Roughness of the sheen.
    pub sheen_roughness: f64,
    /// Normals and where their green points.
    pub normal_map: Option<(ImageUse, NormalConvention)>,
    /// Factor on the slope of those normals.
    pub normal_strength: f64,
    /// Heights that only bend normals, and their strength.
    pub bump_map: Option<(ImageUse, f64)>,
    /// Heights that move the surface.
    pub displacement: Option<ModelDisplacement>,
}

impl Default for ModelMaterial {
    /// White, rough, no metal.
    fn default() -> Self {
        Self {
            name: String::new(),
            colour: DVec3::ONE,
            colour_map: None,
            reflective: DVec3::ZERO,
            roughness: 1.0,
            roughness_map: None,
            metalness: 0.0,
            metalness_map: None,
            emitted: DVec3::ZERO,
            emission_map: None,
            opacity: 1.0,
            opacity_map: None,
            ior: 1.5,
            specular: 1.0,
            specular_colour: DVec3::ONE,
            transmission: 0.0,
            transmission_map: None,
            thin: false,
            coat: 0.0,
            coat_map: None,
            coat_roughness: 0.0,
            coat_roughness_map: None,
            sheen: DVec3::ZERO,
            sheen_roughness: 0.0,
            normal_map: None,
            normal_strength: 1.0,
            bump_map: None,
            displacement: None,
        }
    }
}

/// An image and how it is laid over uv: looked up at `uv * tile`, turned, plus `shift`, v upwards.
#[derive(Clone, Debug, PartialEq)]
pub struct ImageUse {
    /// Where its bytes are.
    pub source: ImageSource,
    /// Repetitions along u and v.
    pub tile: DVec2,
    /// Cosine and sine of the angle by which `uv * tile` is turned, from u to v.
    pub turn: DVec2,
    /// Added after tiling and turning.
    pub shift: DVec2,
    /// What lies beyond the borders along u and v.
    pub wrap: [Wrap; 2],
}

impl ImageUse {
    /// The image over `[0, 1]^2`, repeated.
    pub fn new(source: ImageSource) -> Self {
        let (tile, turn, shift) = (DVec2::ONE, DVec2::X, DVec2::ZERO);
        Self { source, tile, turn, shift, wrap: [Wrap::Repeat; 2] }
    }
}

/// Where the bytes of an image are.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageSource {
    /// A file.
    File(PathBuf),
    /// Inside the model's file; the name is what errors call it.
    Embedded {
        /// What errors call it.
        name: PathBuf,
        /// The bytes of the image file.
        bytes: Arc<[u8]>,
    },
}

/// Heights that move the surface by `scale * (H - zero)` along its normal.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelDisplacement {
    /// The heights.
    pub image: ImageUse,
    /// Units of the file per unit of height.
    pub scale: f64,
    /// The height that stays in place.
    pub zero: f64,
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelCamera {
    /// Its name.
    pub name: String,
    /// The pinhole.
    pub position: DVec3,
    /// Where it looks, a unit vector.
    pub forward: DVec3,
    /// Up in the picture, a unit vector.
    pub up: DVec3,
    /// Vertical field of view, degrees.
    pub fov: f64,
    /// Width over height, if the file says.
    pub aspect: Option<f64>,
}

/// A light without size.
#[derive(Clone, Debug, PartialEq)]
pub struct ModelLight {
    /// Its name.
    pub name: String,
    /// Linear colour times intensity: candela of a point, lux of a sun.
    pub intensity: DVec3,
    /// What kind of light.
    pub kind: LightKind,
}

/// Kinds of lights without size.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LightKind {
    /// Shines from a point in all directions.
    Point {
        /// The point.
        position: DVec3,
    },
    /// Shines from a point into a cone.
    Spot {
        /// The point.
        position: DVec3,
        /// Its axis, a unit vector.
        direction: DVec3,
        /// From the axis to where the full intensity ends, radians.
        inner: f64,
        /// From the axis to where all light ends, radians.
        outer: f64,
    },
    /// Shines from infinitely far.
    Sun {
        /// Where its light goes, a unit vector.
        direction: DVec3,
    },
}

impl Model {
    /// The triangles of each material, with the index of the material, if they have one. Positions
    /// and the like that a part does not use are left out of it.
    pub fn by_material(&self) -> Vec<(MeshData, Option<usize>)> {
        let mut used: Vec<u32> = self.material_of.clone();
        used.sort_unstable();
        used.dedup();
        if let [one] = *used.as_slice() {
            return vec![(self.mesh.clone(), (one != NO_MATERIAL).then_some(one as usize))];
        }
        let part = |&material: &u32| {
            let mine = self.mesh.triangles.iter().zip(&self.material_of);
            let mine = mine.filter(|(_, m)| **m == material).map(|(t, _)| *t).collect();
            let data = MeshData { triangles: mine, ..self.mesh.clone() };
            (compact(data), (material != NO_MATERIAL).then_some(material as usize))
        };
        used.iter().map(part).collect()
    }
}

/// Leaves out what no triangle names.
fn compact(mut data: MeshData) -> MeshData {
    /// Keeps the items that are named, in their order, and gives their new places.
    fn keep<T: Copy>(items: &mut Vec<T>, named: impl Iterator<Item = u32>) -> Vec<u32> {
        let mut place = vec![u32::MAX; items.len()];
        named.for_each(|i| place[i as usize] = 0);
        let mut kept = Vec::new();
        for (slot, item) in place.iter_mut().zip(items.iter()) {
            if *slot == 0 {
                *slot = kept.len() as u32;
                kept.push(*item);
            }
        }
        *items = kept;
        place
    }

    let all = data.triangles.clone();
    let positions = keep(&mut data.positions, all.iter().flat_map(|t| t.positions));
    let normals = keep(&mut data.normals, all.iter().filter_map(|t| t.normals).flatten());
    let uvs = keep(&mut data.uvs, all.iter().filter_map(|t| t.uvs).flatten());
    for t in &mut data.triangles {
        t.positions = t.positions.map(|i| positions[i as usize]);
        t.normals = t.normals.map(|n| n.map(|i| normals[i as usize]));
        t.uvs = t.uvs.map(|n| n.map(|i| uvs[i as usize]));
    }
    data
}
