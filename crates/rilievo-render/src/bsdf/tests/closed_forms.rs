//! Values that are known.

use super::models::{conductor, diffuse, glass, number, principled, sheet};
use super::*;
use crate::bsdf::fresnel;
use crate::scene::{Conductor, Glass, Model};

fn at(material: &Material, angle: f64, front: bool) -> Bsdf {
    bsdf(material, direction(angle, 1.0, front), &hit(0.0, front))
}

#[test]
fn a_smooth_diffuser_is_lamberts() {
    let (value, pdf) = at(&diffuse(0.6, 0.0), 0.7, true).evaluate(direction(0.5, 2.0, true));
    assert!((value.x - 0.6 * 0.5_f64.cos() / PI).abs() < 1e-15);
    assert!((pdf - 0.5_f64.cos() / PI).abs() < 1e-15);
}

#[test]
fn a_rough_diffuser_is_reciprocal_and_bright_towards_the_light() {
    let rough = diffuse(0.6, 0.8);
    let value = |view: f64, light: f64| {
        at(&rough, view, true).evaluate(direction(light, 1.0, true)).0.x / light.cos()
    };
    assert!((value(0.3, 1.2) - value(1.2, 0.3)).abs() < 1e-14);
    assert!(value(1.2, 1.2) > 1.5 * 0.6 / PI);
}

#[test]
fn a_metal_straight_on_shows_the_density_of_its_facets() {
    let Model::Conductor(model) = conductor(0.7, 0.5).model else { panic!() };
    let bare = Material::of_model(Model::Conductor(Conductor { compensated: false, ..model }));
    // D / 4, with D = 1 / (pi alpha^2) and nothing masked.
    let (value, pdf) = at(&bare, 0.0, true).evaluate(DVec3::Z);
    let alpha: f64 = 0.25;
    let expected = 1.0 / (4.0 * PI * alpha * alpha);
    assert!((value.x / 0.7 - expected).abs() < 1e-12 && (pdf - expected).abs() < 1e-12);
}

#[test]
fn facets_of_metals_are_reciprocal_without_compensation() {
    let Model::Conductor(model) = conductor(0.7, 0.6).model else { panic!() };
    let bare = Material::of_model(Model::Conductor(Conductor { compensated: false, ..model }));
    let value = |view: f64, light: f64| {
        at(&bare, view, true).evaluate(direction(light, 1.0, true)).0.x / light.cos()
    };
    assert!((value(0.3, 1.2) / value(1.2, 0.3) - 1.0).abs() < 1e-12);
}

#[test]
fn smooth_glass_follows_snell_and_fresnel() {
    for (front, eta) in [(true, 1.5), (false, 1.0 / 1.5)] {
        let (view, angle) = (direction(0.6, 1.0, front), 0.6_f64);
        let bsdf = at(&glass(1.5, 0.0), 0.6, front);
        assert!(bsdf.is_delta());
        let (share, _) = fresnel::clear(angle.cos(), eta);
        let mirrored = bsdf.sample(0.99 * share, DVec2::splat(0.3)).unwrap();
        assert!(!mirrored.transmitted && (mirrored.pdf - share).abs() < 1e-15);
        assert!((mirrored.direction - DVec3::new(-view.x, -view.y, view.z)).length() < 1e-14);
        let refracted = bsdf.sample(1.01 * share, DVec2::splat(0.3)).unwrap();
        assert!(refracted.transmitted && refracted.direction.z * view.z < 0.0);
        let sine = refracted.direction.truncate().length();
        assert!((sine - angle.sin() / eta).abs() < 1e-14);
        assert!((refracted.weight.x - 1.0 / (eta * eta)).abs() < 1e-14);
    }
}

#[test]
fn rough_glass_shows_the_same_through_both_ways() {
    // Radiance over the square of the index is what is reciprocal.
    let Model::Glass(model) = glass(1.5, 0.5).model else { panic!() };
    let bare = Material::of_model(Model::Glass(Glass { compensated: false, ..model }));
    let (above, below) = (direction(0.5, 1.0, true), direction(0.3, 3.5, false));
    let from_above = bsdf(&bare, above, &hit(0.0, true)).evaluate(below).0.x / below.z.abs();
    let from_below = bsdf(&bare, below, &hit(0.0, false)).evaluate(above).0.x / above.z.abs();
    assert!((from_above * 1.5 * 1.5 / from_below - 1.0).abs() < 1e-12);
}

#[test]
fn a_window_lets_92_percent_straight_through() {
    let bsdf = at(&sheet(0.0), 0.0, true);
    let through = bsdf.sample(0.5, DVec2::splat(0.5)).unwrap();
    assert!(through.transmitted && through.delta);
    assert!((through.direction + DVec3::Z).length() < 1e-14);
    assert!((through.pdf - 0.96 / 1.04).abs() < 1e-12);
}

#[test]
fn glass_without_index_is_not_there() {
    let bsdf = at(&glass(1.0, 0.7), 0.8, true);
    let through = bsdf.sample(0.0, DVec2::splat(0.4)).unwrap();
    assert!((through.direction + direction(0.8, 1.0, true)).length() < 1e-14);
    assert_eq!(through.weight, Rgb::ONE);
}

#[test]
fn an_open_surface_lets_its_share_through() {
    let bsdf = at(&principled(|p| p.opacity = number(0.25)), 0.8, true);
    let through = bsdf.sample(0.0, DVec2::splat(0.4)).unwrap();
    assert!(through.delta && through.transmitted);
    assert!((through.direction + direction(0.8, 1.0, true)).length() < 1e-14);
    assert!((through.weight.x * through.pdf - 0.75).abs() < 1e-12);
}
