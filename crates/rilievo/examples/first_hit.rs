//! One face, one map, one ray: prints where they meet.
//!
//! `cargo run -p rilievo --example first_hit`

#![expect(clippy::print_stdout, reason = "an example prints what it found")]

use std::sync::Arc;

use rilievo::Ray;
use rilievo::glam::DVec3;
use rilievo::map::{Lattice, Procedural, Wrap};
use rilievo::relief::{Displacement, FaceOptions, Relief, ReliefFace};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let bump = Procedural::Gaussian.height_map([256, 256], Lattice::Vertex, Wrap::Repeat)?;
    let relief = Arc::new(Relief::new(bump));
    let displacement = Displacement { scale: 0.3, ..Displacement::default() };
    let options = FaceOptions { displacement, ..FaceOptions::default() };
    let corners = [DVec3::ZERO, DVec3::X, DVec3::new(1.0, 1.0, 0.0), DVec3::Y];
    let face = ReliefFace::new(corners, relief, options)?;

    let ray = Ray::new(DVec3::new(-1.0, 0.5, 0.8), DVec3::new(1.0, 0.0, -0.45));
    match face.closest(&ray, &mut ()) {
        Some(hit) => println!(
            "hit at {:.6}, t = {:.6}, height {:.4}, normal {:.4}",
            hit.position, hit.t, hit.height, hit.geometric_normal
        ),
        None => println!("no hit"),
    }
    Ok(())
}
