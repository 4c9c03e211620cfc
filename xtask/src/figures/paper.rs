//! The paper's scenes: pictures as they should be and as the paper's method draws them, and the
//! pixels that each method gets wrong.
//!
//! A pixel is *wrong* where the ray through its centre hits for one method and misses for the
//! other, or a coordinate of its hit differs from that of `dda`, which visits every cell: at all for
//! the exact methods, by more than [`TOLERANCE`] for the others.

use std::path::{Path, PathBuf};

use super::Studio;
use super::program::{Report, Threads};
use super::table::{Table, seconds};
use crate::say;

const SCENES: &[&str] = &[
    "cornell_wrong_normals",
    "cornell_elevated",
    "cornell_gaussian",
    "cornell_crossing",
    "cornell_gausscross",
    "cornell_studded",
    "cornell_stud_reflection",
    "cornell_studded_shadows",
    "cornell_reflect",
];

/// 0.5 % of the side of the paper's box, scene units.
const TOLERANCE: &str = "0.01";

const REFERENCE: &str = "dda";

/// A method and whether it must agree with the reference in every bit.
const METHODS: &[(&str, bool)] = &[
    (REFERENCE, true),
    ("pyramid", true),
    ("distance", true),
    ("distance-corrected", true),
    ("distance-published", false),
    ("march", false),
];

/// What is measured of one method in one scene.
struct Measured {
    wrong: u64,
    /// Processor seconds.
    build: f64,
    render: f64,
}

/// A render that only tells hits or times.
struct Sizes {
    picture: &'static str,
    timed: &'static str,
}

pub fn draw(studio: &Studio<'_>) -> Result<(), String> {
    let sizes = if studio.quick {
        Sizes { picture: "64x64", timed: "32x32" }
    } else {
        Sizes { picture: "320x320", timed: "128x128" }
    };
    let mut head = vec!["scene"];
    head.extend(METHODS.iter().map(|method| method.0));
    let mut tables = [(); 3].map(|()| Table::new(&head));
    let mut broken = Vec::new();
    for &scene in SCENES {
        let mut cells = [(); 3].map(|()| vec![scene.replace("cornell_", "")]);
        for &(method, exact) in METHODS {
            let measured = measure(studio, &sizes, (scene, method, exact))?;
            if exact && measured.wrong > 0 {
                broken.push(format!("{scene}, {method}: {} pixels", measured.wrong));
            }
            cells[0].push(measured.wrong.to_string());
            cells[1].push(seconds(measured.build));
            cells[2].push(seconds(measured.render));
        }
        for (table, row) in tables.iter_mut().zip(cells) {
            table.row(row);
        }
        for method in ["pyramid", "distance-published"] {
            let out = studio.picture(&format!("{scene}-{method}.png"));
            let flags = ["--method", method, "--resolution", sizes.picture];
            render(studio, (scene, &out), &flags)?;
        }
    }
    let [wrong, build, render] = tables.map(|table| table.markdown());
    studio.write("docs/paper.md", "wrong-pixels", &wrong)?;
    studio.write("docs/paper.md", "build-times", &build)?;
    studio.write("docs/paper.md", "render-times", &render)?;
    match broken.is_empty() {
        true => Ok(()),
        false => Err(format!("exact methods differ from {REFERENCE}: {}", broken.join("; "))),
    }
}

/// Hits at pixel centres against the reference's, and the time of a small picture.
fn measure(
    studio: &Studio<'_>,
    sizes: &Sizes,
    (scene, method, exact): (&str, &str, bool),
) -> Result<Measured, String> {
    let hits = |method: &str| studio.scratch(&format!("{scene}-{method}.exr"));
    let flags = "--integrator aov --pixel-centers --aov P --method";
    let mut words: Vec<&str> = flags.split(' ').collect();
    words.extend([method, "--resolution", sizes.picture]);
    render(studio, (scene, &hits(method)), &words)?;
    let wrong = differing(studio, [&hits(REFERENCE), &hits(method)], (scene, method, exact))?;
    let out = studio.scratch("timed.png");
    let words = ["--method", method, "--resolution", sizes.timed, "--samples", "4"];
    let timed = render(studio, (scene, &out), &words)?;
    let (build, render) = ("build_cpu_seconds", "render_cpu_seconds");
    say(&format!("{scene}, {method}: {wrong} wrong pixels"));
    Ok(Measured { wrong, build: timed.number(build)?, render: timed.number(render)? })
}

/// Pixels in which two pictures of hits differ. Draws them for the paper's method.
fn differing(
    studio: &Studio<'_>,
    hits: [&Path; 2],
    (scene, method, exact): (&str, &str, bool),
) -> Result<u64, String> {
    let mut words: Vec<PathBuf> = vec!["diff".into()];
    words.extend(hits.map(PathBuf::from));
    words.extend(["--layer", "P", "--tolerance"].map(PathBuf::from));
    words.push(if exact { "0" } else { TOLERANCE }.into());
    if method == "distance-published" {
        words.extend(["-o".into(), studio.picture(&format!("{scene}-wrong.png"))]);
    }
    Ok(studio.program.call(Threads::All, &words)?.number("pixels")? as u64)
}

/// Renders a scene of the gallery to `out`.
pub fn render(
    studio: &Studio<'_>,
    (scene, out): (&str, &Path),
    flags: &[&str],
) -> Result<Report, String> {
    let mut words: Vec<PathBuf> = vec!["render".into(), studio.scene(scene)];
    words.extend(["-o".into(), out.to_owned()]);
    words.extend(flags.iter().map(PathBuf::from));
    studio.program.call(Threads::All, &words)
}
