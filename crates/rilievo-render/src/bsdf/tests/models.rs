//! Every model beside the paper's: samples follow their density.

use std::sync::Arc;

use super::*;
use crate::bsdf::GlassTable;
use crate::scene::{Conductor, Diffuse, Glass, Metal, Mix, Model, Principled, ThinGlass};
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
fn samples_of_a_mix_follow_its_density() {
    let materials = [diffuse(0.5, 0.4), conductor(0.9, 0.4)];
    let mix = Mix { materials, share: number(0.3) };
    check("mix", &Material::of_model(Model::Mix(Arc::new(mix))));
}

#[test]
fn a_mix_is_the_sum_of_its_parts() {
    let parts = [diffuse(0.5, 0.4), conductor(0.9, 0.4)];
    let mixed = |share| {
        let (materials, share) = (parts.clone(), number(share));
        Material::of_model(Model::Mix(Arc::new(Mix { materials, share })))
    };
    for (view, hit) in views() {
        let light = direction(0.7, 2.0, hit.front);
        let [(a, p), (b, q)] = [&parts[0], &parts[1]].map(|m| bsdf(m, view, &hit).evaluate(light));
        for share in [0.0, 0.25, 1.0] {
            let (value, pdf) = bsdf(&mixed(share), view, &hit).evaluate(light);
            let (sum, density) = ((1.0 - share) * a + share * b, (1.0 - share) * p + share * q);
            assert!((value - sum).abs().max_element() <= 1e-15 * sum.max_element());
            assert!((pdf - density).abs() <= 1e-15 * density);
        }
    }
}

#[test]
fn a_mirror_in_a_mix_is_drawn_as_often_as_its_share() {
    let materials = [diffuse(0.5, 0.0), conductor(0.9, 0.0)];
    let mix = Material::of_model(Model::Mix(Arc::new(Mix { materials, share: number(0.3) })));
    let (view, hit) = (direction(0.5, 0.0, true), hit(0.0, true));
    let (mixed, mirror) = (bsdf(&mix, view, &hit), bsdf(&conductor(0.9, 0.0), view, &hit));
    assert!(!mixed.is_delta() && mirror.is_delta());
    let mut numbers = Numbers(5);
    let mut mirrored = 0.0;
    for _ in 0..100_000 {
        let scattered = mixed.sample(numbers.one(), numbers.two()).unwrap();
        if scattered.delta {
            let alone = mirror.sample(0.5, DVec2::splat(0.5)).unwrap();
            assert_eq!(scattered.weight, alone.weight);
            assert_eq!(scattered.direction, alone.direction);
            assert!((scattered.pdf - 0.3 * alone.pdf).abs() < 1e-15);
            mirrored += 1e-5;
        }
    }
    // Five standard deviations.
    assert!((mirrored - 0.3_f64).abs() < 5.0 * (0.21_f64 / 1e5).sqrt(), "{mirrored}");
}

#[test]
fn a_mix_within_a_mix_is_chosen_by_its_share() {
    let part = |colour: f64| diffuse(colour, 0.0);
    let inner = Model::Mix(Arc::new(Mix { materials: [part(0.2), part(0.3)], share: number(0.5) }));
    let materials = [part(0.1), Material::of_model(inner)];
    let mix = Material::of_model(Model::Mix(Arc::new(Mix { materials, share: number(0.4) })));
    let mut share = 0.0_f64;
    for k in 0..40_000 {
        let hit = hit(0.0, true);
        let position = hit.position + DVec3::X * f64::from(k) * 1e-5;
        let albedo = bsdf(&mix, DVec3::Z, &Hit { position, ..hit }).albedo().x;
        let inner = (albedo - 0.6 * 0.1) / 0.4;
        assert!((inner - 0.2).abs() < 1e-12 || (inner - 0.3).abs() < 1e-12, "{inner}");
        share += (inner - 0.2) / 0.1 / 40_000.0;
    }
    assert!((share - 0.5).abs() < 0.0125, "{share}");
}
