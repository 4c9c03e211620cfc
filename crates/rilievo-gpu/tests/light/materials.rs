//! Rooms of several models of materials.

use std::sync::Arc;

use rilievo::map::NormalConvention;

use rilievo_render::bsdf::GlassTable;
use rilievo_render::scene::{Conductor, Diffuse, Glass, Metal, Mix, Model, Principled, ThinGlass};
use rilievo_render::texture::{Channel, ColourInput, NormalInput, NumberInput, Texture};
use rilievo_render::{Material, Rgb};

use crate::room::{Room, Shapes, image};

fn colour(r: f64, g: f64, b: f64) -> ColourInput {
    ColourInput::uniform(Rgb::new(r, g, b))
}

fn clay(roughness: f64) -> Material {
    let roughness = NumberInput::uniform(roughness);
    Material::of_model(Model::Diffuse(Diffuse { colour: colour(0.7, 0.5, 0.4), roughness }))
}

fn metal(metal: Metal, roughness: f64, compensated: bool) -> Material {
    let roughness = NumberInput::uniform(roughness);
    Material::of_model(Model::Conductor(Conductor { metal, roughness, compensated }))
}

fn copper(roughness: f64) -> Material {
    let (facing, edge) = (colour(0.9, 0.6, 0.4), colour(0.9, 0.8, 0.7));
    metal(Metal::Colours { facing, edge }, roughness, true)
}

fn glass(roughness: f64, ior: f64) -> Material {
    let table = Arc::new(GlassTable::new(ior).unwrap());
    let (colour, roughness) = (colour(0.9, 1.0, 0.8), NumberInput::uniform(roughness));
    Material::of_model(Model::Glass(Glass { table, colour, roughness, compensated: true }))
}

fn window(roughness: f64) -> Material {
    let (colour, roughness) = (colour(0.9, 0.9, 1.0), NumberInput::uniform(roughness));
    Material::of_model(Model::ThinGlass(ThinGlass { ior: 1.5, colour, roughness }))
}

/// A room of clay, copper, a metal by its index, rough glass and clear sheets.
pub fn room() -> Room {
    let index = Metal::Index { eta: Rgb::new(0.2, 0.9, 1.1), k: Rgb::new(3.9, 2.4, 2.2) };
    Room {
        floor: clay(0.8),
        wall: copper(0.4),
        ball: glass(0.4, 1.5),
        pyramid: metal(index, 0.0, false),
        ..Room::default()
    }
}

/// The same room with clear glass and panes.
pub fn clear_room() -> Room {
    Room { ball: glass(0.0, 1.5), pyramid: window(0.5), ..room() }
}

fn textured(texture: Texture) -> ColourInput {
    ColourInput { texture: Some(texture), ..ColourInput::uniform(Rgb::ONE) }
}

fn channel(channel: Channel, invert: bool) -> NumberInput {
    NumberInput { texture: Some((image(true), channel)), invert, ..NumberInput::uniform(0.9) }
}

fn detailed(material: Material) -> Material {
    let (texture, convention) = (image(true), NormalConvention::DirectX);
    Material { normals: Some(NormalInput { texture, convention, strength: 0.6 }), ..material }
}

fn principled(change: impl FnOnce(&mut Principled)) -> Material {
    let mut principled = Principled::new();
    change(&mut principled);
    Material::of_model(Model::Principled(Box::new(principled)))
}

fn mix(first: Material, second: Material, share: NumberInput) -> Material {
    Material::of_model(Model::Mix(Arc::new(Mix { materials: [first, second], share })))
}

/// A painted floor under a clear coat, cloth with bumps, a ball that is partly glass, and sheets with holes.
fn layers() -> [Material; 4] {
    let painted = principled(|p| {
        p.base_colour = textured(image(false));
        p.roughness = channel(Channel::Green, true);
        p.coat = NumberInput::uniform(0.5);
        p.coat_roughness = NumberInput::uniform(0.2);
    });
    let cloth = principled(|p| {
        p.sheen = colour(0.3, 0.2, 0.5);
        p.diffuse_roughness = NumberInput::uniform(0.7);
        p.metallic = channel(Channel::Blue, false);
    });
    let body = principled(|p| {
        p.transmission = NumberInput::uniform(0.7);
        p.roughness = NumberInput::uniform(0.3);
        p.metallic = NumberInput::uniform(0.2);
    });
    let sheet = principled(|p| {
        p.opacity = NumberInput::uniform(0.6);
        p.transmission = NumberInput::uniform(0.5);
        p.thin = true;
    });
    [painted, detailed(cloth), body, sheet]
}

/// A material that shines by itself.
fn glowing(material: Material, emitted: Rgb) -> Material {
    Material { emitted, ..material }
}

/// One that shines by an image.
fn pictured(material: Material, brightness: f64) -> Material {
    Material { emission: Some(image(false)), emitted: Rgb::splat(brightness), ..material }
}

/// A room of principled surfaces with images and bumps, a mix of two metals, and a displaced ball. The floor shines by an
/// image.
pub fn painted_room() -> Room {
    let [floor, cloth, ball, sheet] = layers();
    let wall = mix(detailed(copper(0.5)), cloth, channel(Channel::Blue, false));
    let pyramid = mix(window(0.3), sheet, NumberInput::uniform(0.5));
    let floor = pictured(floor, 0.3);
    Room { floor, wall, ball, pyramid, shapes: Shapes::Ball, ..Room::default() }
}

/// The same materials on other surfaces; the ball and the pyramids shine.
pub fn repainted_room() -> Room {
    let [painted, cloth, body, sheet] = layers();
    let ball = mix(detailed(clay(0.5)), painted, NumberInput::uniform(0.4));
    let ball = pictured(ball, 1.5);
    let wall = mix(copper(0.3), body, NumberInput::uniform(1.0));
    let pyramid = glowing(sheet, Rgb::new(0.8, 0.4, 0.2));
    Room { floor: cloth, wall, ball, pyramid, shapes: Shapes::Ball, ..Room::default() }
}

/// Displaced meshes that shine, by an image and in other places, before a wall that shines by an image.
pub fn glowing_room() -> Room {
    let [ball, pyramid] = [pictured(clay(0.0), 1.0), glowing(clay(0.5), Rgb::new(0.5, 0.8, 0.3))];
    Room {
        wall: pictured(clay(0.2), 0.6),
        ball,
        pyramid,
        shapes: Shapes::Meshes,
        ..Room::default()
    }
}

/// A mix of which a part is one.
pub fn mix_of_mixes() -> Material {
    let half = || NumberInput::uniform(0.5);
    mix(mix(clay(0.0), copper(0.2), half()), clay(0.5), half())
}
