//! Tiles say what the image says, whoever asks, and take no more memory than they may.

use std::sync::atomic::AtomicUsize;

use glam::DVec2;
use rilievo::map::Wrap;

use super::*;
use crate::texture::{ColourImage, Texels};

/// A file in memory that breaks off at a place, and counts.
#[derive(Debug)]
struct Memory {
    bytes: Vec<u8>,
    end: usize,
    reads: Arc<AtomicUsize>,
}

impl TileSource for Memory {
    fn read(&self, offset: u64, bytes: &mut [u8]) -> Result<(), String> {
        self.reads.fetch_add(1, Ordering::Relaxed);
        let end = offset as usize + bytes.len();
        if end > self.end {
            return Err(format!("nothing at byte {offset}"));
        }
        bytes.copy_from_slice(&self.bytes[offset as usize..end]);
        Ok(())
    }
}

/// Hashed bits, the same every time.
fn bits(k: u64) -> u64 {
    let mut z = k.wrapping_mul(0x9e37_79b9_7f4a_7c15);
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z ^ (z >> 31)
}

/// Images of every coding, of sizes that tiles do not divide.
fn images() -> Vec<ColourImage> {
    let texels = |count: u64, seed: u64| (0..count).map(move |k| bits(k ^ seed << 40));
    let bytes = |z: u64| [z as u8, (z >> 8) as u8, (z >> 16) as u8];
    let words = |z: u64| [z as u16, (z >> 16) as u16, (z >> 32) as u16];
    let floats = |z: u64| words(z).map(|w| f32::from(w) / 100.0);
    let new = |[width, height]: [u32; 2], texels| ColourImage::new(width, height, texels).unwrap();
    vec![
        new([300, 257], Texels::Srgb8(texels(300 * 257, 1).map(bytes).collect())),
        new([64, 1], Texels::Linear8(texels(64, 2).map(bytes).collect())),
        new([1, 1000], Texels::Srgb16(texels(1000, 3).map(words).collect())),
        new([129, 400], Texels::Linear16(texels(129 * 400, 4).map(words).collect())),
        new([333, 190], Texels::Linear(texels(333 * 190, 5).map(floats).collect())),
    ]
}

/// The images in tiles behind one cache; what is beyond `end` of all bytes cannot be read.
fn tiled(
    images: &[ColourImage],
    capacity: u64,
    end: f64,
) -> (Vec<ColourImage>, Arc<TileCache>, Arc<AtomicUsize>) {
    // Where tiles go is known only when they are written, so this is done twice.
    let (mut file, reads) = (Vec::new(), Arc::<AtomicUsize>::default());
    let blank = Memory { bytes: Vec::new(), end: 0, reads: Arc::clone(&reads) };
    let blank = Arc::new(TileCache::new(Box::new(blank), 0));
    for image in images {
        let first = file.len() as u64;
        image
            .tiled::<()>(&blank, first, &mut |tile| {
                file.extend_from_slice(tile);
                Ok(())
            })
            .unwrap();
    }
    let end = (end * file.len() as f64) as usize;
    let mut first = 0;
    let source = Memory { bytes: file, end, reads: Arc::clone(&reads) };
    let cache = Arc::new(TileCache::new(Box::new(source), capacity));
    let all = images.iter().map(|image| {
        let here = first;
        let made = image.tiled::<()>(&cache, here, &mut |tile| {
            first += tile.len() as u64;
            Ok(())
        });
        made.unwrap()
    });
    (all.collect(), cache, reads)
}

fn total(images: &[ColourImage]) -> u64 {
    images.iter().map(|image| image.bytes() + image.coarser_bytes()).sum()
}

/// Look-ups of every kind, by number.
fn looked_up(image: &ColourImage, k: u64) -> [u64; 3] {
    let unit = |which: u64| (bits(4 * k + which) >> 11) as f64 / (1u64 << 53) as f64;
    let uv = DVec2::new(3.0 * unit(0) - 1.0, 3.0 * unit(1) - 1.0);
    let wrap = [Wrap::Repeat, Wrap::Clamp, Wrap::Mirror];
    let wrap = [wrap[k as usize % 3], wrap[k as usize / 3 % 3]];
    let width = DVec2::splat((0.1 / unit(2)).min(2.0) * unit(3));
    let found = match k % 4 {
        0 => image.lookup(uv),
        1 => image.texel(
            (unit(0) * f64::from(image.width())) as u32,
            (unit(1) * f64::from(image.height())) as u32,
        ),
        _ => image.lookup_mean(uv, width, wrap),
    };
    found.to_array().map(f64::to_bits)
}

#[test]
fn many_threads_see_the_image_itself_within_the_memory_allowed() {
    const THREADS: u64 = 4;
    let images = images();
    let all = total(&images);
    for capacity in [0, all / 20, all / 2, 2 * all] {
        let (tiles, cache, reads) = tiled(&images, capacity, 1.0);
        std::thread::scope(|scope| {
            for thread in 0..THREADS {
                let (images, tiles, cache) = (&images, &tiles, &cache);
                scope.spawn(move || {
                    for k in 0..8000 {
                        let k = THREADS * k + thread;
                        let which = bits(!k) as usize % images.len();
                        let same = looked_up(&tiles[which], k) == looked_up(&images[which], k);
                        assert!(same, "image {which}, look-up {k}");
                        let most = capacity + THREADS * TileCache::SLACK;
                        assert!(cache.held() <= most, "{} of {most}", cache.held());
                    }
                });
            }
        });
        assert_eq!(cache.failure(), None);
        assert!(cache.held() <= capacity);
        if capacity > all {
            // Each once, or twice where two threads asked at the same time.
            assert!(reads.load(Ordering::Relaxed) < 4 * (all / LARGEST) as usize + 500);
        }
    }
}

#[test]
fn what_was_looked_at_last_stays() {
    let images = &images()[..1];
    // Room for four tiles of 64 x 64 x 3 bytes.
    let (tiles, cache, reads) = tiled(images, 4 * 3 * 64 * 64, 1.0);
    let look = |column: u32| {
        let before = reads.load(Ordering::Relaxed);
        assert_eq!(tiles[0].texel(64 * column, 0), images[0].texel(64 * column, 0));
        reads.load(Ordering::Relaxed) - before
    };
    let order = [0, 1, 2, 3, 0, 4, 0, 2, 3, 4, 1];
    assert_eq!(order.map(look), [1, 1, 1, 1, 0, 1, 0, 0, 0, 0, 1]);
    assert!(cache.held() <= cache.capacity());
    drop(tiles);
}

#[test]
fn the_tiles_of_an_image_are_as_many_bytes_as_its_texels() {
    for image in images() {
        let mut written = 0;
        let blank = Memory { bytes: Vec::new(), end: 0, reads: Arc::default() };
        let blank = Arc::new(TileCache::new(Box::new(blank), 0));
        let tiled = image.tiled::<()>(&blank, 0, &mut |tile| {
            written += tile.len() as u64;
            Ok(())
        });
        let tiled = tiled.unwrap();
        assert_eq!(written, image.bytes() + image.coarser_bytes());
        assert_eq!((tiled.bytes(), tiled.coarser_bytes()), (image.bytes(), image.coarser_bytes()));
        assert_eq!((tiled.width(), tiled.height()), (image.width(), image.height()));
        let failed = image.tiled(&blank, 0, &mut |_| Err("full"));
        assert_eq!(failed.err(), Some("full"));
    }
}

#[test]
fn a_tile_that_cannot_be_read_is_black_and_told() {
    let images = images();
    let (tiles, cache, _) = tiled(&images, 1 << 20, 0.1);
    assert_eq!(tiles[0].texel(0, 0), images[0].texel(0, 0));
    assert_eq!(cache.failure(), None);
    let last = &tiles[4];
    assert_eq!(last.texel(300, 150), crate::Rgb::ZERO);
    assert!(cache.failure().unwrap().starts_with("nothing at byte"));
}
