//! [`MemoryUse`]: what a render will hold, before it starts.

use std::collections::HashSet;
use std::sync::Arc;

use rilievo::relief::ShadingNormals;
use rilievo::surface::{Surface, World};

use crate::film::Film;
use crate::integrator::Integrator;
use crate::light::Environment;
use crate::render::{RenderOptions, TILE, thread_count};
use crate::scene::Scene;
use crate::texture::TileCache;

/// Bytes held while a scene is rendered, by kind. What surfaces share is counted once. The program
/// itself and what reading files needs come on top.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct MemoryUse {
    /// Samples of the height maps.
    pub heights: u64,
    /// What was derived from them: pyramids, distance maps, normal maps.
    pub bounds: u64,
    /// Surfaces, meshes and the tree over them.
    pub geometry: u64,
    /// Coarser maps for level of detail, with their bounds, what they lost, and the surfaces that show
    /// them.
    pub levels: u64,
    /// Texels; of images in tiles what their cache may hold.
    pub textures: u64,
    /// The image and its layers.
    pub film: u64,
    /// Stacks and tiles of the threads.
    pub threads: u64,
}

/// Touched by the stack of a thread that traces.
const STACK: u64 = 64 << 10;

/// Upper bound on the trees' bytes per surface: two nodes and an index; a part of a node of sixteen
/// and an index.
const TREE: u64 = 128 + 4 + 64 + 4;

/// What a quad that is ready for rays holds beside itself.
const QUAD: u64 = 352;

impl MemoryUse {
    /// What `scene` rendered under `options` will hold.
    pub fn predict(scene: &Scene, options: &RenderOptions<'_>) -> Self {
        let mut all = Self::default();
        let mut seen = HashSet::new();
        let mut first = |address: *const ()| seen.insert(address);
        all.add_world(scene.world(), &mut first);
        if let Some(levels) = scene.level_of_detail() {
            let mut coarser = Self::default();
            for level in levels.levels() {
                coarser.add_world(&level.world, &mut first);
                coarser.levels += level.list_bytes();
                for (address, bytes) in level.lost_bytes() {
                    if first(address) {
                        coarser.levels += bytes;
                    }
                }
            }
            all.levels = coarser.total();
        }
        // Only paths have footprints, and ask for coarser images.
        let paths = scene.settings().integrator == Integrator::Path;
        for material in scene.materials() {
            for texture in material.textures() {
                if let Some(cache) = texture.image.cache() {
                    if first(Arc::as_ptr(cache).cast()) {
                        let threads = thread_count(options.threads) as u64;
                        all.textures += cache.capacity() + threads * TileCache::SLACK;
                    }
                } else if first(Arc::as_ptr(&texture.image).cast()) {
                    all.textures += texture.image.bytes();
                    if paths {
                        all.textures += texture.image.coarser_bytes();
                    }
                }
            }
        }
        all.textures += scene.environment().map_or(0, Environment::bytes);
        if paths {
            all.geometry += scene.lighting().bytes();
        }
        let size = options.crop.map_or(scene.camera().resolution(), |crop| crop.size);
        let sums = scene.settings().integrator.sums();
        all.film = Film::predicted_bytes(size, options.aovs, sums);
        let tile = Film::predicted_bytes([TILE; 2], options.aovs, sums);
        all.threads = thread_count(options.threads) as u64 * (STACK + tile);
        all
    }

    /// Adds what a world holds.
    fn add_world(&mut self, world: &World, first: &mut impl FnMut(*const ()) -> bool) {
        let surfaces = world.surfaces();
        self.geometry += size_of_val(surfaces) as u64 + TREE * surfaces.len() as u64;
        for surface in surfaces {
            self.add(surface, first);
        }
    }

    /// Adds what a surface holds; `first` says whether something shared was not met before.
    fn add(&mut self, surface: &Surface, first: &mut impl FnMut(*const ()) -> bool) {
        match surface {
            Surface::Quad(_) => self.geometry += QUAD,
            Surface::Sphere(_) => {}
            Surface::Mesh(mesh) => self.geometry += mesh.bytes(),
            Surface::Face(face) => {
                self.geometry += size_of_val(face.as_ref()) as u64;
                let relief = face.relief();
                let bytes = (Arc::as_ptr(relief).cast(), relief.bytes());
                self.add_relief(bytes, &face.options().normals, first);
            }
            Surface::ReliefSphere(sphere) => {
                self.geometry += size_of_val(sphere.as_ref()) as u64;
                let relief = sphere.relief();
                let bytes = (Arc::as_ptr(relief).cast(), relief.bytes());
                self.add_relief(bytes, &sphere.options().normals, first);
            }
            Surface::ReliefMesh(mesh) => {
                self.geometry += mesh.bytes();
                let relief = mesh.relief();
                let bytes = (Arc::as_ptr(relief).cast(), relief.bytes());
                self.add_relief(bytes, &mesh.options().normals, first);
            }
            Surface::Instance(instance) => {
                self.geometry += size_of_val(instance.as_ref()) as u64;
                if first(Arc::as_ptr(instance.prototype()).cast()) {
                    self.add(instance.prototype(), first);
                }
            }
            Surface::Moving(moving) => {
                self.geometry += size_of_val(moving.as_ref()) as u64;
                if first(Arc::as_ptr(moving.prototype()).cast()) {
                    self.add(moving.prototype(), first);
                }
            }
        }
    }

    /// Adds what is at an address, heights and bounds, and normals, each once.
    fn add_relief(
        &mut self,
        (address, (heights, bounds)): (*const (), (u64, u64)),
        normals: &ShadingNormals,
        first: &mut impl FnMut(*const ()) -> bool,
    ) {
        if first(address) {
            self.heights += heights;
            self.bounds += bounds;
        }
        if let ShadingNormals::Map(map) = normals
            && first(Arc::as_ptr(map).cast())
        {
            self.bounds += map.bytes();
        }
    }

    /// All bytes.
    pub fn total(&self) -> u64 {
        let held = self.heights + self.bounds + self.geometry + self.levels;
        held + self.textures + self.film + self.threads
    }
}
