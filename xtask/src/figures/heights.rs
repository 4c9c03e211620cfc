//! [`Shape`]: height maps of any size for measurements, as 16-bit PNG.

use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;

/// What a map shows. Both use most of the range of codes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Shape {
    /// Eight octaves of value noise, each half as high and half as wide as the one before.
    Fbm,
    /// 8 x 8 studs with sides one sample wide.
    Studs,
}

const OCTAVES: u32 = 8;

impl Shape {
    pub const ALL: [Self; 2] = [Self::Fbm, Self::Studs];

    pub fn name(self) -> &'static str {
        match self {
            Self::Fbm => "fbm",
            Self::Studs => "studs",
        }
    }

    /// The code of one of `side * side` samples.
    fn code(self, x: u32, y: u32, side: u32) -> u16 {
        match self {
            Self::Studs => {
                let raised = |i: u32| (1..3).contains(&(i * 32 / side % 4));
                if raised(x) && raised(y) { u16::MAX } else { 0 }
            }
            Self::Fbm => {
                let at = [x, y].map(|i| f64::from(i) / f64::from(side));
                let octave = |o: u32| noise(at, 2 << o, o) * 0.5f64.powi(o as i32 + 1);
                ((0..OCTAVES).map(octave).sum::<f64>() * 65535.0) as u16
            }
        }
    }

    /// Writes a map of `side * side` samples.
    pub fn write(self, path: &Path, side: u32) -> Result<(), String> {
        let told = |e: &dyn std::fmt::Display| format!("{}: {e}", path.display());
        let file = File::create(path).map_err(|e| told(&e))?;
        let mut encoder = png::Encoder::new(BufWriter::new(file), side, side);
        encoder.set_color(png::ColorType::Grayscale);
        encoder.set_depth(png::BitDepth::Sixteen);
        encoder.set_compression(png::Compression::Fast);
        let mut writer = encoder.write_header().map_err(|e| told(&e))?;
        let mut stream = writer.stream_writer().map_err(|e| told(&e))?;
        for y in 0..side {
            let row: Vec<u8> =
                (0..side).flat_map(|x| self.code(x, y, side).to_be_bytes()).collect();
            stream.write_all(&row).map_err(|e| told(&e))?;
        }
        stream.finish().map_err(|e| told(&e))
    }
}

/// Noise in [0, 1) on a periodic lattice of `cells * cells`, smooth between its points.
fn noise(at: [f64; 2], cells: u32, seed: u32) -> f64 {
    let point = at.map(|x| x * f64::from(cells));
    let corner = point.map(|x| x as u32);
    let t = [0, 1].map(|i| point[i] - f64::from(corner[i])).map(|t| t * t * (3.0 - 2.0 * t));
    let value = |dx: u32, dy: u32| {
        let cell = (corner[1] + dy) % cells * cells + (corner[0] + dx) % cells;
        f64::from(scramble(cell ^ seed.wrapping_mul(0x9e37_79b9))) / (f64::from(u32::MAX) + 1.0)
    };
    let row = |dy: u32| value(0, dy) * (1.0 - t[0]) + value(1, dy) * t[0];
    row(0) * (1.0 - t[1]) + row(1) * t[1]
}

/// A permutation of 32-bit numbers that mixes all bits.
fn scramble(mut x: u32) -> u32 {
    x = (x ^ (x >> 16)).wrapping_mul(0x7feb_352d);
    x = (x ^ (x >> 15)).wrapping_mul(0x846c_a68b);
    x ^ (x >> 16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_of_the_studs_is_high() {
        let codes = |i: u32| Shape::Studs.code(i % 64, i / 64, 64);
        let high = (0..64 * 64).filter(|&i| codes(i) == u16::MAX).count();
        assert_eq!(high, 64 * 64 / 4);
    }

    #[test]
    fn noise_is_continuous_and_uses_the_range() {
        let side = 512;
        let row: Vec<_> = (0..side).map(|x| i32::from(Shape::Fbm.code(x, 77, side))).collect();
        let steepest = row.windows(2).map(|w| (w[1] - w[0]).abs()).max().unwrap();
        let range = row.iter().max().unwrap() - row.iter().min().unwrap();
        assert!(steepest < 3000 && range > 10_000, "{steepest} {range}");
    }

    #[test]
    fn what_is_written_can_be_read() {
        let folder = std::env::temp_dir().join(format!("xtask-heights-{}", std::process::id()));
        Shape::Studs.write(&folder, 32).unwrap();
        let decoder = png::Decoder::new(std::io::BufReader::new(File::open(&folder).unwrap()));
        let reader = decoder.read_info().unwrap();
        let info = reader.info();
        assert_eq!((info.width, info.height, info.bit_depth), (32, 32, png::BitDepth::Sixteen));
        std::fs::remove_file(&folder).unwrap();
    }
}
