//! The library inside a foreign loop: a hand-made camera, one lamp, hard shadows, ASCII output.
//!
//! `cargo run --release -p rilievo --example own_renderer`

#![expect(clippy::print_stdout, reason = "an example prints what it found")]

use std::sync::Arc;

use rilievo::glam::DVec3;
use rilievo::map::{Lattice, Procedural, Wrap};
use rilievo::relief::{Displacement, FaceOptions, Relief, ReliefFace};
use rilievo::{Counters, Ray};

const WIDTH: u32 = 72;
const HEIGHT: u32 = 30;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let studs = Procedural::Studded { studs: [4, 4] };
    let relief =
        Arc::new(Relief::new(studs.height_map([65, 65], Lattice::Vertex, Wrap::Repeat)?));
    let displacement = Displacement { scale: 0.12, ..Displacement::default() };
    let options = FaceOptions { displacement, ..FaceOptions::default() };
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let face = ReliefFace::new(corners, relief, options)?;

    let eye = DVec3::new(0.5, -1.1, 1.2);
    let lamp = DVec3::new(-0.8, 0.2, 0.7);
    let mut work = Counters::default();
    for y in 0..HEIGHT {
        let row = (0..WIDTH).map(|x| {
            let aim = DVec3::new(
                f64::from(x) / f64::from(WIDTH) * 1.4 - 0.2,
                1.25 - f64::from(y) / f64::from(HEIGHT) * 1.6,
                0.0,
            );
            let Some(hit) = face.closest(&Ray::new(eye, aim - eye), &mut work) else {
                return ' ';
            };
            let to_lamp = lamp - hit.position;
            let lit = hit.geometric_normal.dot(to_lamp) > 0.0
                && !face.occludes(&hit.spawn_to(lamp), &mut work);
            let light =
                if lit { hit.shading_normal.dot(to_lamp.normalize()).max(0.0) } else { 0.0 };
            b".:-=+*#%@"[(light * 8.99) as usize] as char
        });
        println!("{}", row.collect::<String>());
    }
    println!("{} nodes and {} cells for {} pixels", work.nodes, work.cells, WIDTH * HEIGHT);
    Ok(())
}
