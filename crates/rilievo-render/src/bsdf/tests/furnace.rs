//! White furnaces: a surface that absorbs nothing is as bright as what is around it.

use super::models::{conductor, diffuse, everything, glass, grey, number, principled, sheet};
use super::*;
use crate::scene::{Conductor, Model};

const DRAWS: u32 = 60_000;

/// Angles of the view with the normal.
const ANGLES: [f64; 5] = [0.0, 0.5, 1.0, 1.3, 1.5];

/// Checks that a white material keeps its light to `error` at every angle.
fn check(name: &str, material: &Material, error: f64) {
    for angle in ANGLES {
        let white =
            furnace(&bsdf(material, direction(angle, 1.0, true), &hit(0.0, true)), DRAWS, 1.0);
        let off = (white - 1.0).abs().max_element();
        assert!(off < error, "{name} at {angle}: {white}");
    }
}

#[test]
fn white_diffusers_stay_white() {
    for roughness in [0.0, 0.3, 1.0] {
        check(&format!("diffuser {roughness}"), &diffuse(1.0, roughness), 4e-3);
    }
}

#[test]
fn white_metals_stay_white() {
    for roughness in [0.0, 0.1, 0.3, 0.55, 0.8, 1.0] {
        check(&format!("metal {roughness}"), &conductor(1.0, roughness), 8e-3);
    }
}

#[test]
fn without_compensation_a_rough_metal_darkens() {
    let Model::Conductor(model) = conductor(1.0, 1.0).model else { panic!() };
    let bare = Material::of_model(Model::Conductor(Conductor { compensated: false, ..model }));
    let bsdf = bsdf(&bare, direction(0.5, 0.0, true), &hit(0.0, true));
    assert!(furnace(&bsdf, DRAWS, 1.0).x < 0.7);
}

#[test]
fn glass_loses_nothing_on_either_side() {
    for (ior, roughness) in [(1.5, 0.0), (1.5, 0.2), (1.5, 0.5), (1.5, 1.0), (2.4, 0.6), (0.8, 0.4)]
    {
        let material = glass(ior, roughness);
        for front in [true, false] {
            let eta: f64 = if front { ior } else { 1.0 / ior };
            for angle in ANGLES {
                let bsdf = bsdf(&material, direction(angle, 1.0, front), &hit(0.0, front));
                let white = furnace(&bsdf, DRAWS, eta * eta).x;
                assert!((white - 1.0).abs() < 0.035, "{ior} {roughness} {front} {angle}: {white}");
            }
        }
    }
}

#[test]
fn sheets_stay_white() {
    for roughness in [0.0, 0.3, 0.8] {
        check(&format!("sheet {roughness}"), &sheet(roughness), 8e-3);
    }
}

#[test]
fn white_principled_surfaces_stay_white() {
    check("plastic", &principled(|_| {}), 8e-3);
    check("rough plastic", &principled(|p| p.roughness = number(1.0)), 8e-3);
    check("metal", &principled(|p| p.metallic = number(1.0)), 8e-3);
    check("half metal", &principled(|p| p.metallic = number(0.5)), 8e-3);
    check("sheet", &principled(|p| (p.transmission, p.thin) = (number(1.0), true)), 8e-3);
    check("coated", &principled(|p| p.coat = number(1.0)), 8e-3);
    check("open", &principled(|p| p.opacity = number(0.3)), 8e-3);
    let velvet = principled(|p| (p.sheen, p.coat) = (grey(1.0), number(0.5)));
    check("velvet", &velvet, 2e-2);
}

#[test]
fn no_material_gains_light_or_turns_black_under_any_normal() {
    let all =
        [diffuse(1.0, 0.5), conductor(1.0, 0.4), sheet(0.4), everything(), principled(|_| {})];
    for (k, material) in all.iter().enumerate() {
        for angle in [0.0, 0.7, 1.2, 1.5] {
            for tilt in [0.2, 0.6, 1.0, 1.4] {
                for azimuth in [0.0, 1.5, PI] {
                    let bsdf = bsdf(material, direction(angle, azimuth, true), &hit(tilt, true));
                    let back = furnace(&bsdf, 4_000, 1.0).max_element();
                    assert!((0.2..1.05).contains(&back), "{k}: {angle} {tilt} {azimuth}: {back}");
                }
            }
        }
    }
}
