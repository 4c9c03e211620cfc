//! `--backend`: pictures of the GPU beside those of the CPU, and what is said where there is none.

use std::io::Write;

use rilievo_io::Limits;
use rilievo_io::image::ChannelImage;

use crate::support::{Folder, Run};

/// Runs a command that finds no GPU.
fn run_without_a_gpu(folder: &Folder, words: &str) -> Run {
    let mut command = folder.command(words);
    command.env("WGPU_BACKEND", "vulkan");
    for name in ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"] {
        command.env(name, folder.path("no-driver.json"));
    }
    command.output().unwrap().into()
}

#[test]
fn without_a_gpu_it_says_how_to_get_one_and_auto_takes_the_cpu() {
    let folder = Folder::new().with_scene();
    let render = "render scene.toml --samples 1 -o";
    let run = run_without_a_gpu(&folder, &format!("{render} gpu.png --backend gpu")).expect(1);
    assert!(run.stderr.contains("mesa-vulkan-drivers"), "{}", run.stderr);
    let run = run_without_a_gpu(&folder, &format!("{render} auto.png --backend auto")).expect(0);
    assert!(run.stderr.contains("the CPU takes over"), "{}", run.stderr);
    folder.run(&format!("{render} cpu.png")).expect(0);
    assert!(folder.bytes("auto.png") == folder.bytes("cpu.png"));
}

/// A relief, a ball and a lamp: each of the layers of either, pixel by pixel.
#[test]
fn a_gpu_draws_the_picture_of_the_cpu() {
    let folder = Folder::new().with_scene();
    let render = "render scene.toml --integrator aov --pixel-centers --aov P,N,Z";
    folder.run(&format!("{render} -o cpu.exr")).expect(0);
    let mut command = folder.command(&format!("{render} -o gpu.exr --backend gpu"));
    // Mesa complains where it is not set.
    let run: Run = command.env("XDG_RUNTIME_DIR", folder.path("")).output().unwrap().into();
    if run.code == Some(1) && run.stderr.contains("no GPU was found") {
        let _ = writeln!(std::io::stderr(), "SKIPPED, nothing was drawn on a GPU: {}", run.stderr);
        return;
    }
    run.expect(0);
    let [cpu, gpu] = ["cpu.exr", "gpu.exr"]
        .map(|name| ChannelImage::read(&folder.path(name), &Limits::default()).unwrap());
    for name in ["P.X", "P.Y", "P.Z", "N.X", "N.Y", "N.Z", "Z"] {
        let [a, b] = [&cpu, &gpu].map(|image| &image.channel(name).unwrap().samples);
        assert!(a.iter().any(|x| x.is_finite()), "{name}");
        for (k, (a, b)) in a.iter().zip(b).enumerate() {
            let same = (a - b).abs() <= 1e-5 || a.is_nan() && b.is_nan() || a == b;
            assert!(same, "{name} of pixel {k}: {a} {b}");
        }
    }
}
