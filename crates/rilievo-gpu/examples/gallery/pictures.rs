//! Pictures by the scene's own integrator, by the CPU and by the GPU, which shades what its shaders know.

use std::fmt;

use rilievo_gpu::GpuScene;
use rilievo_render::{Integrator, RenderOptions, RenderSettings, Scene, render};

use crate::hits::short;

/// Largest difference of two values that count as one, in means of the picture.
const TOLERANCE: f64 = 1e-3;

pub const HEAD: &str = "\
| scene | integrator | the GPU | pixels | that differ | largest difference | RMSE |
| --- | --- | --- | ---: | ---: | ---: | ---: |";

/// How two pictures differ; in means of the CPU's.
#[derive(Debug)]
pub struct Comparison {
    integrator: Integrator,
    samples: u32,
    /// What the GPU does.
    does: String,
    pixels: usize,
    other: usize,
    largest: f64,
    rmse: f64,
}

impl Comparison {
    /// Draws both.
    pub fn new(scene: &Scene, on_gpu: &GpuScene<'_>) -> Result<Self, String> {
        let RenderSettings { integrator, samples, .. } = *scene.settings();
        let drawn =
            |options: &RenderOptions<'_>| render(scene, options).map_err(|error| error.to_string());
        let cpu = drawn(&RenderOptions::default())?.0;
        let gpu = drawn(&RenderOptions { tracer: Some(on_gpu), ..RenderOptions::default() })?.0;
        let does = match on_gpu.why_not() {
            None => "traces and shades".to_owned(),
            Some(why) => format!("traces: {why} is not shaded there"),
        };
        let values = cpu.radiance().iter().flatten();
        let mean = values.map(|&x| f64::from(x)).sum::<f64>() / (3 * cpu.radiance().len()) as f64;
        let (mut other, mut largest, mut squares) = (0, 0.0f64, 0.0);
        for (a, b) in cpu.radiance().iter().zip(gpu.radiance()) {
            let apart = [0, 1, 2].map(|k| (f64::from(a[k]) - f64::from(b[k])).abs() / mean);
            let most = apart.into_iter().fold(0.0, f64::max);
            other += usize::from(most > TOLERANCE);
            largest = largest.max(most);
            squares += apart.iter().map(|x| x * x).sum::<f64>();
        }
        let pixels = cpu.radiance().len();
        let rmse = (squares / (3 * pixels) as f64).sqrt();
        Ok(Self { integrator, samples, does, pixels, other, largest, rmse })
    }
}

impl fmt::Display for Comparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { integrator, samples, does, pixels, other, largest, rmse } = self;
        let (largest, rmse) = (short(*largest), short(*rmse));
        write!(
            f,
            "`{integrator}`, {samples} samples | {does} | {pixels} | {other} | {largest} | {rmse}"
        )
    }
}
