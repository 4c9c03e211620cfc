//! Rooms of several models of materials.

use std::sync::Arc;

use rilievo_render::bsdf::GlassTable;
use rilievo_render::scene::{Conductor, Diffuse, Glass, Metal, Model, ThinGlass};
use rilievo_render::texture::{ColourInput, NumberInput};
use rilievo_render::{Material, Rgb};

use crate::room::Room;

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
