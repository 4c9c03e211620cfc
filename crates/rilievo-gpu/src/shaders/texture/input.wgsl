// The twin of `texture/input.rs` and `scene/material.rs`: inputs of materials. All of a material's are read in one loop, by
// their places: drivers put every function where it is called, and reading an image is many branches. `IMAGES` and its
// like are written by `shaders.rs`: drivers drop what a scene has none of.

// The words of a material: what it is, three numbers of its model, what reflects in the paper's model and the square of
// its roughness, the strengths of its normals, which of its inputs are colours, how many there are, then four words each.
const MODEL: u32 = 1u;
const REFLECTIVE: u32 = 4u;
const ALPHA: u32 = 7u;
const STRENGTHS: u32 = 8u;
const COLOURS: u32 = 10u;
const INPUTS: u32 = 11u;
const FIRST_INPUT: u32 = 12u;

// What every material has: what is dull in the paper's model, what it sends out, and the normals of its texture.
const DULL: u32 = 0u;
const EMITTED: u32 = 1u;
const DETAIL: u32 = 2u;
// The first of its model.
const OWN: u32 = 3u;
const MOST_INPUTS: u32 = 15u;

// Those of the material at hand; of a number all three.
var<private> inputs: array<vec3<f32>, MOST_INPUTS>;

// Reads so many inputs of a material over a footprint; what it sends out at the place alone.
fn read_inputs(material: u32, count: u32, at: Footprint) {
    let colours = scene[material + COLOURS];
    for (var k = 0u; k < count; k++) {
        let place = material + FIRST_INPUT + 4u * k;
        let is_colour = ((colours >> k) & 1u) == 1u;
        let second = scene[place + 1u];
        let third = scene[place + 2u];
        var value = vec3<f32>(number(place));
        if is_colour {
            value = vec3<f32>(value.x, bitcast<f32>(second), bitcast<f32>(third));
        }
        if IMAGES {
            let last = scene[place + 3u];
            // A number has its texture second, then the channel, and whether that is turned around.
            let texture = select(second, last, is_colour);
            if texture != NOTHING {
                let width = select(at.width, vec2<f32>(0.0), k == EMITTED);
                let rgb = mean_colour(texture, Footprint(at.uv, width));
                let x = rgb[third % 3u];
                value *= select(vec3<f32>(select(x, 1.0 - x, last != 0u)), rgb, is_colour);
            }
        }
        inputs[k] = value;
    }
}

// The number that is one of the model's inputs, within 0 and 1.
fn share_of(input: u32) -> f32 {
    return clamp(inputs[OWN + input].x, 0.0, 1.0);
}

fn reflective_of(material: u32) -> vec3<f32> {
    return triple(material + REFLECTIVE);
}

// The square of the roughness.
fn alpha_of(material: u32) -> f32 {
    return number(material + ALPHA);
}
