// What the shaders `advance` read and write. Heights are group 1, written by `shaders.rs`.

struct Step {
    // First slot of this dispatch, and one past the last.
    first: u32,
    end: u32,
    // Slots in all: shadow rays of paths lie behind the others.
    slots: u32,
    // Camera rays that a pixel takes in all.
    samples: u32,
}

// A camera ray on its way, as the CPU writes and reads it.
struct Slot {
    // The numbers of its pixel, or of its path.
    key: vec2<u32>,
    // Which of the pixel's samples it is; for paths what their sampler keeps of it.
    sample: u32,
    // Numbers and pairs that were taken.
    dimension: u32,
    radiance: array<f32, 3>,
    stage: u32,
    // Rays sent, by kind: shadow, reflection, diffuse.
    sent: array<u32, 3>,
    unused: u32,
}

@group(0) @binding(0) var<uniform> now: Step;
@group(0) @binding(1) var<storage, read_write> rays: array<Ray>;
@group(0) @binding(2) var<storage, read> hits: array<Hit>;
@group(0) @binding(3) var<storage, read> faces: array<Face>;
@group(0) @binding(4) var<storage, read> scene: array<u32>;
@group(0) @binding(5) var<storage, read_write> slots: array<Slot>;
@group(0) @binding(6) var<storage, read_write> trees: Trees;
