//! Textures in tiles: the same picture; a tile that cannot be read ends the render.

use std::sync::Arc;

use glam::DVec3;
use rilievo_render::texture::{ColourImage, Texels, Texture, TileCache, TileSource};
use rilievo_render::{
    Film, Integrator, Material, MemoryUse, Reflectance, RenderError, RenderOptions, RenderSettings,
    Rgb, Scene, render,
};

use crate::scenes::{Builder, camera};

/// Bytes in memory, up to a place.
#[derive(Debug)]
struct Memory {
    bytes: Vec<u8>,
    end: usize,
}

impl TileSource for Memory {
    fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<(), String> {
        let part = self.bytes[..self.end].get(offset as usize..offset as usize + bytes.len());
        bytes.copy_from_slice(part.ok_or_else(|| "the disk is gone".to_owned())?);
        Ok(())
    }
}

/// A board of 500 x 300 texels.
fn board() -> ColourImage {
    let texel = |k: u32| [k, k >> 4, k >> 9].map(|x| (x.wrapping_mul(61) & 255) as u8);
    ColourImage::new(500, 300, Texels::Srgb8((0..150_000).map(texel).collect())).unwrap()
}

/// The board in tiles, with a cache of so many bytes; of the source there is a share.
fn tiled(capacity: u64, share: f64) -> ColourImage {
    let cut = |cache: &Arc<TileCache>, bytes: &mut Vec<u8>| {
        let image = board().tiled::<()>(cache, 0, &mut |tile| {
            bytes.extend_from_slice(tile);
            Ok(())
        });
        image.unwrap()
    };
    let mut bytes = Vec::new();
    let none = Memory { bytes: Vec::new(), end: 0 };
    cut(&Arc::new(TileCache::new(Box::new(none), 0)), &mut bytes);
    let end = (share * bytes.len() as f64) as usize;
    let cache = TileCache::new(Box::new(Memory { bytes, end }), capacity);
    cut(&Arc::new(cache), &mut Vec::new())
}

/// The board as a floor, near and far.
fn scene(image: ColourImage, integrator: Integrator) -> Scene {
    let diffuse = Reflectance::Textured(Texture::new(Arc::new(image)));
    let floor = [DVec3::new(-4.0, -4.0, 0.0), 8.0 * DVec3::X, 8.0 * DVec3::Y];
    let settings = RenderSettings { integrator, samples: 4, ..RenderSettings::default() };
    Builder::default()
        .quad(floor, Material { diffuse, ..Material::default() })
        .background(Rgb::ONE)
        .scene(camera([0.0, -4.0, 0.4], [0.0, 0.0, 0.0], 50.0, [64, 48]), settings)
}

fn bits(film: &Film) -> Vec<u32> {
    film.radiance().iter().flatten().map(|x| x.to_bits()).collect()
}

#[test]
fn tiles_show_the_same_for_any_cap_and_number_of_threads() {
    for integrator in [Integrator::Path, Integrator::Distributed, Integrator::Aov] {
        let picture = |image, threads| {
            let options = RenderOptions { threads, ..RenderOptions::default() };
            bits(&render(&scene(image, integrator), &options).unwrap().0)
        };
        let whole = picture(board(), 1);
        for capacity in [0, 30_000, 10_000_000] {
            for threads in [1, 3] {
                assert!(picture(tiled(capacity, 1.0), threads) == whole, "{integrator} {capacity}");
            }
        }
    }
}

#[test]
fn a_tile_that_cannot_be_read_ends_the_render() {
    for integrator in [Integrator::Path, Integrator::Distributed] {
        let scene = scene(tiled(30_000, 0.7), integrator);
        assert_eq!(scene.texture_failure(), None);
        let error = render(&scene, &RenderOptions::default()).unwrap_err();
        assert_eq!(error, RenderError::Texture("the disk is gone".to_owned()));
        assert_eq!(error.to_string(), "a texture could not be read: the disk is gone");
    }
}

#[test]
fn memory_counts_the_cap() {
    let options = RenderOptions { threads: 2, ..RenderOptions::default() };
    let textures = |image| MemoryUse::predict(&scene(image, Integrator::Path), &options).textures;
    assert_eq!(textures(board()), board().bytes() + board().coarser_bytes());
    assert_eq!(textures(tiled(30_000, 1.0)), 30_000 + 2 * TileCache::SLACK);
}
