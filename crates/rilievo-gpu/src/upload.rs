//! [`Upload`]: the surfaces of a world as the shaders read them, before they leave for the device.
//!
//! Triangles of quads and meshes hang below trees of their own, which instances share; the tree over the
//! world's surfaces comes first. Boxes are rounded outward to `f32`, relative to the anchor of their frame.

use std::collections::HashMap;
use std::sync::Arc;

use rilievo::accel::{Aabb, Bvh, BvhNode};
use rilievo::glam::{DAffine3, DMat3, DVec3};
use rilievo::map::CubeFace;
use rilievo::mesh::Mesh;
use rilievo::relief::{Relief, ReliefFace, ReliefMesh, ReliefSphere};
use rilievo::surface::{Instance, MovingInstance, Quad, Sphere, Surface, World};

use crate::error::GpuError;
use crate::maps::MapPlan;
use crate::records::{self, FACE_WORDS, NODE_WORDS, TRIANGLE_WORDS, Words};
use crate::shaders::Walks;
use crate::shells;
use crate::surfaces::{SURFACE_WORDS, SurfaceRecord};

/// Levels of two trees, one below the other, that the stack of `shaders/world.wgsl` holds.
const LARGEST_DEPTH: u32 = 126;

/// Triangles in a leaf of a mesh.
const LEAF_TRIANGLES: u32 = 4;

/// The kind of a displaced face.
pub(crate) const FACE: u32 = 1;
/// The kind of a displaced sphere.
pub(crate) const RELIEF_SPHERE: u32 = 4;
/// The kind of a displaced mesh.
pub(crate) const RELIEF_MESH: u32 = 5;

/// The buffers of a world, in words, and where its maps are to lie.
#[derive(Default)]
pub(crate) struct Upload<'a> {
    pub faces: Vec<u32>,
    pub maps: MapPlan<'a>,
    pub surfaces: Vec<u32>,
    pub nodes: Vec<u32>,
    pub numbers: Vec<u32>,
    /// Levels of the tree over the surfaces and of the deepest one below it.
    levels: [u32; 2],
    /// What instances show, by address.
    prototypes: HashMap<usize, SurfaceRecord>,
}

impl<'a> Upload<'a> {
    /// The surfaces of a world, in coordinates relative to `anchor`.
    ///
    /// # Errors
    /// [`GpuError::Unsupported`] for a surface that no shader knows.
    pub fn new(world: &'a World, anchor: DVec3) -> Result<Self, GpuError> {
        let mut upload = Self::default();
        let surfaces = world.surfaces();
        let boxes: Vec<Aabb> = surfaces.iter().map(Surface::bounds).collect();
        upload.tree(&Bvh::build(&boxes, 1), anchor, |_, items| [items[0], 1]);
        upload.levels = [upload.levels[1], 0];
        upload.surfaces.reserve(surfaces.len() * SURFACE_WORDS);
        for surface in surfaces {
            let record = match surface {
                Surface::Instance(instance) => upload.instance(instance, anchor)?,
                Surface::Moving(moving) => upload.moving(moving, anchor)?,
                other => upload.surface(other, anchor)?,
            };
            record.write(&mut upload.surfaces);
        }
        let levels: u32 = upload.levels.iter().sum();
        if levels > LARGEST_DEPTH {
            return unsupported(&format!("a tree of {levels} levels"));
        }
        Ok(upload)
    }

    /// Of each surface its kind and its first face, if it has any.
    pub fn kinds(&self) -> Vec<[u32; 2]> {
        let records = self.surfaces.chunks_exact(SURFACE_WORDS);
        records.map(|record| kind_and_face(record, &self.numbers)).collect()
    }

    /// Whether nothing of the world can be hit.
    pub fn is_empty(&self) -> bool {
        self.levels[0] == 0
    }

    fn surface(&mut self, surface: &'a Surface, anchor: DVec3) -> Result<SurfaceRecord, GpuError> {
        match surface {
            Surface::Quad(quad) => Ok(self.quad(quad, anchor)),
            Surface::Sphere(sphere) => Ok(self.sphere(sphere, anchor)),
            Surface::Mesh(mesh) => Ok(self.mesh(mesh, anchor)),
            Surface::Face(face) => Ok(self.face(face, anchor)),
            Surface::ReliefSphere(sphere) => Ok(self.relief_sphere(sphere, anchor)),
            Surface::ReliefMesh(mesh) => Ok(self.relief_mesh(mesh, anchor)),
            Surface::Instance(_) | Surface::Moving(_) => unsupported("an instance of an instance"),
        }
    }

    fn instance(
        &mut self,
        instance: &'a Instance,
        anchor: DVec3,
    ) -> Result<SurfaceRecord, GpuError> {
        let (shown, middle) = self.prototype(instance.prototype())?;
        let transform = self.transform(instance.world_from_local(), [anchor, middle]);
        Ok(shown.shown_at(transform))
    }

    /// A prototype in motion: from where it is at time 0, relative to the pivot, and the motion.
    fn moving(
        &mut self,
        moving: &'a MovingInstance,
        anchor: DVec3,
    ) -> Result<SurfaceRecord, GpuError> {
        let (shown, middle) = self.prototype(moving.prototype())?;
        self.maps.add_walks(Walks { moving: true, ..Walks::default() });
        let begin = moving.world_from_local(0.0);
        let transform = self.transform(&begin, [moving.motion().pivot, middle]);
        records::write_motion(&mut self.numbers, moving.motion(), anchor);
        Ok(shown.moving_at(transform))
    }

    /// What instances of a surface show, and what its frame counts from: its own middle, as that of the world does; parts of
    /// one mesh share theirs.
    fn prototype(
        &mut self,
        prototype: &'a Arc<Surface>,
    ) -> Result<(SurfaceRecord, DVec3), GpuError> {
        let bounds = prototype.bounds();
        let middle = match prototype.as_ref() {
            Surface::ReliefMesh(mesh) => mesh.frame().centre,
            _ if bounds.is_empty() => DVec3::ZERO,
            _ => bounds.centre(),
        };
        let address = Arc::as_ptr(prototype).addr();
        if let Some(record) = self.prototypes.get(&address) {
            return Ok((*record, middle));
        }
        let record = self.surface(prototype, middle)?;
        self.prototypes.insert(address, record);
        Ok((record, middle))
    }

    /// The way from a frame that counts from `from` to that of a prototype, which counts from `middle`.
    fn transform(&mut self, world_from_local: &DAffine3, [from, middle]: [DVec3; 2]) -> u32 {
        let DAffine3 { matrix3, translation } = world_from_local.inverse();
        let place = self.numbers.len() as u32;
        let DMat3 { x_axis, y_axis, z_axis } = matrix3.transpose();
        [x_axis, y_axis, z_axis, matrix3 * from + translation - middle]
            .into_iter()
            .for_each(|row| self.numbers.vector(row));
        place
    }

    fn face(&mut self, face: &'a ReliefFace, anchor: DVec3) -> SurfaceRecord {
        let relief = face.relief();
        let place = self.maps.place(relief);
        let walk = self.maps.place_walk(relief, face.options().method);
        let number = (self.faces.len() / FACE_WORDS) as u32;
        records::write_face(&mut self.faces, face, (place, walk), anchor);
        SurfaceRecord::face(number)
    }

    /// A displaced sphere: its numbers, and the maps of its six faces one after the other in `faces`.
    fn relief_sphere(&mut self, sphere: &'a ReliefSphere, anchor: DVec3) -> SurfaceRecord {
        let first = (self.faces.len() / FACE_WORDS) as u32;
        for face in CubeFace::ALL {
            self.map_alone(sphere.relief().face(face));
        }
        self.maps.add_walks(Walks { spheres: true, ..Walks::default() });
        let place = self.numbers.len() as u32;
        shells::write_sphere(&mut self.numbers, sphere, anchor, first);
        SurfaceRecord::relief_sphere(place)
    }

    /// A displaced mesh: its parts and its tree, and its map in `faces`.
    fn relief_mesh(&mut self, mesh: &'a ReliefMesh, anchor: DVec3) -> SurfaceRecord {
        let (items, boxes): (Vec<u32>, Vec<Aabb>) = mesh.items().into_iter().unzip();
        if items.is_empty() {
            return SurfaceRecord::nothing();
        }
        let face = self.map_alone(mesh.relief());
        self.maps.add_walks(Walks { meshes: true, ..Walks::default() });
        let from_centre = anchor - mesh.frame().centre;
        let root =
            self.tree(&Bvh::build(&boxes, 1), from_centre, |_, leaf| [items[leaf[0] as usize], 1]);
        let cut = (self.nodes.len() / NODE_WORDS) as u32;
        let Aabb { min, max } = mesh.frame().cut;
        records::write_node(&mut self.nodes, (min - from_centre, max - from_centre), [0, 0]);
        let beside = self.beside(mesh);
        let places = shells::write_parts(&mut self.numbers, mesh, &beside);
        let place = self.numbers.len() as u32;
        shells::write_mesh(&mut self.numbers, mesh, anchor, (places, face, [root, cut]));
        SurfaceRecord::relief_mesh(place)
    }

    /// What walls of a mesh show of other parts: where each is told of, by its number.
    fn beside(&mut self, mesh: &'a ReliefMesh) -> HashMap<u32, u32> {
        let mut places = HashMap::new();
        for part in mesh.walls().filter_map(|wall| wall.beside) {
            if places.contains_key(&part) {
                continue;
            }
            let Some(beside) = mesh.beside(part) else { continue };
            let face = self.map_alone(beside.relief);
            places.insert(part, shells::write_beside(&mut self.numbers, &beside, face));
        }
        places
    }

    /// The number in `faces` of a map that is no face's.
    fn map_alone(&mut self, relief: &'a Relief) -> u32 {
        let place = self.maps.place(relief);
        records::write_map_alone(&mut self.faces, relief, place);
        (self.faces.len() / FACE_WORDS) as u32 - 1
    }

    fn sphere(&mut self, sphere: &Sphere, anchor: DVec3) -> SurfaceRecord {
        let place = self.numbers.len() as u32;
        self.numbers.vector(sphere.center() - anchor);
        self.numbers.double(sphere.radius());
        SurfaceRecord::sphere(place)
    }

    /// A quad is two triangles; a parallelogram is one part to rays that leave it.
    fn quad(&mut self, quad: &Quad, anchor: DVec3) -> SurfaceRecord {
        let [c0, c1, c2, c3] = quad.corners();
        let second = u32::from(!quad.is_parallelogram());
        let triangles = [([c0, c1, c2], 0), ([c0, c2, c3], second)];
        let place = self.numbers.len() as u32;
        for (corners, index) in triangles {
            self.triangle(corners.map(|p| p - anchor), index);
        }
        let tree = Bvh::build(&[quad.bounds()], 1);
        let root = self.tree(&tree, anchor, |_, _| [place, 2]);
        SurfaceRecord::triangles(root, quad.one_sided())
    }

    fn mesh(&mut self, mesh: &Mesh, anchor: DVec3) -> SurfaceRecord {
        let count = mesh.data().triangles.len() as u32;
        let boxes: Vec<Aabb> = (0..count).map(|index| Aabb::around(mesh.corners(index))).collect();
        let tree = Bvh::build(&boxes, LEAF_TRIANGLES);
        let root = self.tree(&tree, anchor, |upload, items| {
            let place = upload.numbers.len() as u32;
            for &index in items {
                upload.triangle(mesh.corners(index).map(|p| p - anchor), index);
            }
            [place, items.len() as u32]
        });
        SurfaceRecord::triangles(root, false)
    }

    fn triangle(&mut self, corners: [DVec3; 3], index: u32) {
        let before = self.numbers.len();
        corners.into_iter().for_each(|corner| self.numbers.vector(corner));
        self.numbers.extend([index, 0]);
        debug_assert_eq!(self.numbers.len() - before, TRIANGLE_WORDS);
    }

    /// Appends a tree; returns its root. `leaf` writes the items of a leaf and says where and how many they are.
    fn tree(
        &mut self,
        tree: &Bvh,
        anchor: DVec3,
        mut leaf: impl FnMut(&mut Self, &[u32]) -> [u32; 2],
    ) -> u32 {
        let root = (self.nodes.len() / NODE_WORDS) as u32;
        self.levels[1] = self.levels[1].max(levels(tree));
        for node in tree.nodes() {
            let (bounds, content) = match node {
                BvhNode::Inner { bounds, second } => (bounds, [root + second, 0]),
                BvhNode::Leaf { bounds, items } => (bounds, leaf(self, items)),
            };
            let corners = (bounds.min - anchor, bounds.max - anchor);
            records::write_node(&mut self.nodes, corners, content);
        }
        root
    }
}

/// The kind of a surface and the number of its first face, if it has any, from its record.
fn kind_and_face(record: &[u32], numbers: &[u32]) -> [u32; 2] {
    let face = match record[0] {
        FACE => record[1],
        // The last of a displaced sphere's numbers; see `shells::write_sphere`.
        RELIEF_SPHERE => numbers[record[1] as usize + 21],
        // See `shells::write_mesh`.
        RELIEF_MESH => numbers[record[1] as usize + 13],
        _ => u32::MAX,
    };
    [record[0], face]
}

/// Levels of a tree; 0 if it is empty.
fn levels(tree: &Bvh) -> u32 {
    let mut of = vec![1; tree.nodes().len()];
    for (at, node) in tree.nodes().enumerate() {
        if let BvhNode::Inner { second, .. } = node {
            for child in [at + 1, second as usize] {
                of[child] = of[at] + 1;
            }
        }
    }
    of.into_iter().max().unwrap_or(0)
}

fn unsupported<T>(what: &str) -> Result<T, GpuError> {
    Err(GpuError::Unsupported { what: what.to_owned() })
}
