//! Every model beside the paper's: samples follow their density.

use std::sync::Arc;

use super::*;
use crate::bsdf::GlassTable;
use crate::scene::{
    Conductor, Diffuse, Glass, Metal, Mix, Model, Principled, Reflectance, ThinGlass,
};
use crate::texture::{ColourInput, NumberInput};

pub(super) fn number(value: f64) -> NumberInput {
    NumberInput::uniform(value)
}

pub(super) fn grey(value: f64) -> ColourInput {
    ColourInput::uniform(Rgb::splat(value))
}

pub(super) fn diffuse(colour: f64, roughness: f64) -> Material {
    let (colour, roughness) = (grey(colour), number(roughness));
    Material::of_model(Model::Diffuse(Diffuse { colour, roughness }))
}

pub(super) fn conductor(facing: f64, roughness: f64) -> Material {
    let metal = Metal::Colours { facing: grey(facing), edge: grey(1.0) };
    let roughness = number(roughness);
    Material::of_model(Model::Conductor(Conductor { metal, roughness, compensated: true }))
}

pub(super) fn glass(ior: f64, roughness: f64) -> Material {
    let table = Arc::new(GlassTable::new(ior).unwrap());
    let (colour, roughness) = (grey(1.0), number(roughness));
    Material::of_model(Model::Glass(Glass { table, colour, roughness, compensated: true }))
}

pub(super) fn sheet(roughness: f64) -> Material {
    let (colour, roughness) = (grey(1.0), number(roughness));
    Material::of_model(Model::ThinGlass(ThinGlass { ior: 1.5, colour, roughness }))
}

pub(super) fn principled(change: impl FnOnce(&mut Principled)) -> Material {
    let mut model = Principled::new();
    model.base_colour = grey(1.0);
    change(&mut model);
    Material::of_model(Model::Principled(Box::new(model)))
}

/// A principled surface with something of everything.
pub(super) fn everything() -> Material {
    principled(|p| {
        p.metallic = number(0.3);
        p.transmission = number(0.4);
        p.roughness = number(0.6);
        p.coat = number(0.8);
        p.coat_roughness = number(0.4);
        p.sheen = grey(0.5);
        p.diffuse_roughness = number(0.5);
    })
}

fn check(name: &str, material: &Material) {
    for (k, (view, hit)) in views().enumerate() {
        check_density(&format!("{name}, view {k}"), &bsdf(material, view, &hit));
    }
}

#[test]
fn samples_of_diffusers_and_metals_follow_their_density() {
    check("rough diffuser", &diffuse(0.8, 0.7));
    check("metal", &conductor(0.7, 0.4));
    let metal = Metal::Index { eta: Rgb::new(0.2, 0.9, 1.4), k: Rgb::new(3.9, 2.5, 1.6) };
    let model = Conductor { metal, roughness: number(0.6), compensated: false };
    check("index", &Material::of_model(Model::Conductor(model)));
}

#[test]
fn samples_of_clear_bodies_follow_their_density() {
    for (ior, roughness) in [(1.5, 0.5), (0.7, 0.8)] {
        check(&format!("glass {ior} {roughness}"), &glass(ior, roughness));
    }
    check("sheet", &sheet(0.6));
}

#[test]
fn samples_of_principled_surfaces_follow_their_density() {
    check("plastic", &principled(|_| {}));
    check("everything", &everything());
    let open = principled(|p| (p.opacity, p.metallic) = (number(0.5), number(1.0)));
    let (view, hit) = (direction(0.5, 0.0, true), hit(0.0, true));
    check_density("open", &bsdf(&open, view, &hit));
}

#[test]
fn a_mix_is_one_of_its_parts_in_the_share_that_it_names() {
    let part = |emitted: f64| Material {
        diffuse: Reflectance::Uniform(Rgb::splat(emitted)),
        ..Material::default()
    };
    let inner = Model::Mix(Arc::new(Mix { materials: [part(0.2), part(0.3)], share: number(0.5) }));
    let materials = [part(0.1), Material::of_model(inner)];
    let mix = Material::of_model(Model::Mix(Arc::new(Mix { materials, share: number(0.4) })));
    let mut counts = [0.0_f64; 4];
    let view = DVec3::Z;
    for k in 0..40_000 {
        let hit = hit(0.0, true);
        let position = hit.position + DVec3::X * f64::from(k) * 1e-5;
        let albedo = bsdf(&mix, view, &Hit { position, ..hit }).albedo().x;
        counts[(10.0 * albedo).round() as usize] += 1.0 / 40_000.0;
    }
    for (k, share) in [(1, 0.6), (2, 0.2), (3, 0.2)] {
        assert!((counts[k] - share).abs() < 0.01, "{counts:?}");
    }
}
