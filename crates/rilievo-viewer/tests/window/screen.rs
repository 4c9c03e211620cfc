//! What is on the screen.

use std::path::Path;

/// The pixels of a screen, as Xvfb keeps them in a file of the format XWD.
pub struct Screen {
    width: usize,
    pixels: Vec<[u8; 3]>,
}

impl Screen {
    pub fn read(folder: &Path) -> Self {
        let bytes = std::fs::read(folder.join("Xvfb_screen0")).unwrap();
        let word = |k: usize| u32::from_be_bytes(bytes[4 * k..4 * k + 4].try_into().unwrap());
        let [header, width, height] = [0, 4, 5].map(|k| word(k) as usize);
        let (line, colours) = (word(12) as usize, word(19) as usize);
        assert_eq!((word(7), word(11)), (0, 32), "little endian, 32 bits a pixel");
        let start = header + 12 * colours;
        let pixels = (0..height).flat_map(|y| {
            let row = &bytes[start + y * line..][..4 * width];
            row.chunks_exact(4).map(|p| [p[2], p[1], p[0]])
        });
        Self { width, pixels: pixels.collect() }
    }

    /// The pixels of a rectangle: left, top, width, height.
    pub fn part(&self, [x, y, width, height]: [i32; 4]) -> Vec<[u8; 3]> {
        let rows = y as usize..(y + height) as usize;
        rows.flat_map(|y| {
            self.pixels[y * self.width + x as usize..][..width as usize].iter().copied()
        })
        .collect()
    }
}

/// Pixels that are bright.
pub fn bright(pixels: &[[u8; 3]]) -> usize {
    pixels.iter().filter(|rgb| rgb.iter().all(|&c| c > 150)).count()
}

/// The share of pixels that differ in more than a few steps of a code.
pub fn different(a: &[[u8; 3]], b: &[[u8; 3]]) -> f64 {
    assert_eq!(a.len(), b.len());
    let far = |(a, b): &(&[u8; 3], &[u8; 3])| (0..3).any(|k| a[k].abs_diff(b[k]) > 4);
    a.iter().zip(b).filter(far).count() as f64 / a.len() as f64
}
