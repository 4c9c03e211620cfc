// The twin of `texture/input.rs` and `scene/material.rs`: inputs of materials. `IMAGES` and its like are written by
// `shaders.rs`: drivers drop what a scene has none of.

// A colour, or a texture tinted by it.
fn colour_at(place: u32, at: Footprint) -> vec3<f32> {
    let value = triple(place);
    if IMAGES {
        if scene[place + 3u] != NOTHING {
            return value * mean_colour(scene[place + 3u], at);
        }
    }
    return value;
}

// A number, or a channel of a texture scaled by it.
fn number_at_place(place: u32, at: Footprint) -> f32 {
    let value = number(place);
    if IMAGES {
        if scene[place + 1u] != NOTHING {
            let rgb = mean_colour(scene[place + 1u], at);
            let x = rgb[scene[place + 2u]];
            return value * select(x, 1.0 - x, scene[place + 3u] != 0u);
        }
    }
    return value;
}

fn point_at(uv: vec2<f32>) -> Footprint {
    return Footprint(uv, vec2<f32>(0.0));
}

fn diffuse_of(material: u32, at: Footprint) -> vec3<f32> {
    return colour_at(material, at);
}

fn reflective_of(material: u32) -> vec3<f32> {
    return triple(material + 4u);
}

// The square of the roughness.
fn alpha_of(material: u32) -> f32 {
    return number(material + 7u);
}

fn emitted_of(material: u32, uv: vec2<f32>) -> vec3<f32> {
    return colour_at(material + 8u, point_at(uv));
}

const MODEL_KIND: u32 = 12u;
// The words of a model: three of its own, then four for each input.
const MODEL: u32 = 16u;

fn input_of(material: u32, index: u32) -> u32 {
    return material + MODEL + 3u + 4u * index;
}
