//! [`SceneMemory`]: the bytes a scene holds while it is rendered.

use std::ops::AddAssign;
use std::sync::Arc;

use rilievo::relief::ShadingNormals;
use rilievo::surface::Surface;

use super::{Reflectance, Scene};

/// Bytes held by the parts of a scene. What several surfaces share counts once.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SceneMemory {
    /// Height maps, normal maps and colour images.
    pub maps: u64,
    /// What was derived from height maps to trace them: pyramids and distance maps.
    pub bounds: u64,
    /// Triangle meshes with their trees.
    pub meshes: u64,
}

impl SceneMemory {
    /// All bytes.
    pub fn total(&self) -> u64 {
        self.maps + self.bounds + self.meshes
    }
}

impl AddAssign for SceneMemory {
    fn add_assign(&mut self, other: Self) {
        self.maps += other.maps;
        self.bounds += other.bounds;
        self.meshes += other.meshes;
    }
}

impl Scene {
    /// The bytes this scene holds.
    pub fn memory(&self) -> SceneMemory {
        let mut memory = SceneMemory::default();
        let mut seen = Vec::new();
        for surface in self.world().surfaces() {
            match surface {
                Surface::Face(face) => {
                    if is_new(&mut seen, Arc::as_ptr(face.relief())) {
                        let (maps, bounds) = face.relief().bytes();
                        memory += SceneMemory { maps, bounds, meshes: 0 };
                    }
                    if let ShadingNormals::Map(map) = &face.options().normals
                        && is_new(&mut seen, Arc::as_ptr(map))
                    {
                        memory.maps += map.bytes();
                    }
                }
                Surface::Mesh(mesh) => memory.meshes += mesh.bytes(),
                Surface::Quad(_) | Surface::Sphere(_) => {}
            }
        }
        for material in self.materials() {
            if let Reflectance::Textured(texture) = &material.diffuse
                && is_new(&mut seen, Arc::as_ptr(&texture.image))
            {
                memory.maps += texture.image.bytes();
            }
        }
        memory
    }
}

/// Whether an address was not seen before; it is from now on.
fn is_new<T>(seen: &mut Vec<*const ()>, address: *const T) -> bool {
    let address = address.cast();
    let new = !seen.contains(&address);
    if new {
        seen.push(address);
    }
    new
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Camera, CameraParts, Material, RenderSettings, SceneParts};
    use crate::{ColourImage, Rgb, Texels, Texture};
    use glam::{DVec3, dvec3};
    use rilievo::map::{Lattice, Procedural, Wrap};
    use rilievo::relief::{FaceOptions, Relief, ReliefFace};
    use rilievo::surface::World;

    #[test]
    fn shared_maps_count_once() {
        let heights = Procedural::Tent.height_map([64, 32], Lattice::Texel, Wrap::Repeat).unwrap();
        let relief = Arc::new(Relief::new(heights));
        let (maps, bounds) = relief.bytes();
        assert_eq!(maps, 64 * 32 * 2);
        let face = |z: f64| {
            let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
            let corners = corners.map(|(x, y)| dvec3(x, y, z));
            let face = ReliefFace::new(corners, Arc::clone(&relief), FaceOptions::default());
            Surface::Face(Box::new(face.unwrap()))
        };
        let image = ColourImage::new(2, 1, Texels::Srgb8(vec![[1, 2, 3]; 2])).unwrap();
        let diffuse = Reflectance::Textured(Texture::new(Arc::new(image)));
        let material = Material { diffuse, ..Material::default() };
        let camera = CameraParts {
            position: DVec3::Z,
            look_at: DVec3::ZERO,
            up: DVec3::Y,
            fov: 40.0,
            resolution: [1, 1],
        };
        let scene = Scene::new(SceneParts {
            world: World::new(vec![face(0.0), face(5.0)]),
            materials: vec![material.clone(), material],
            material_of: vec![0, 1],
            camera: Camera::new(camera).unwrap(),
            background: Rgb::ZERO,
            ambient: Rgb::ZERO,
            settings: RenderSettings::default(),
        });
        let want = SceneMemory { maps: maps + 6, bounds, meshes: 0 };
        assert_eq!(scene.unwrap().memory(), want);
        assert_eq!(want.total(), maps + 6 + bounds);
    }
}
