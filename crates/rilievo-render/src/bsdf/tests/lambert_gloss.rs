//! The paper's material.

use super::*;
use crate::scene::Reflectance;

/// A diffuser with gloss.
fn material(diffuse: f64, reflective: f64, roughness: f64) -> Material {
    Material {
        diffuse: Reflectance::Uniform(Rgb::splat(diffuse)),
        reflective: Rgb::splat(reflective),
        roughness,
        ..Material::default()
    }
}

#[test]
fn samples_follow_their_density() {
    for (k, (view, hit)) in views().enumerate() {
        for (diffuse, reflective, roughness) in [(0.3, 0.6, 0.5), (0.0, 1.0, 0.8)] {
            let name = format!("view {k}, {diffuse} {reflective} {roughness}");
            check_density(&name, &bsdf(&material(diffuse, reflective, roughness), view, &hit));
        }
    }
}

#[test]
fn gloss_keeps_all_energy_under_any_normal() {
    for (view, hit) in views() {
        for roughness in [0.0, 0.1, 0.5, 1.0] {
            let white = furnace(&bsdf(&material(0.0, 1.0, roughness), view, &hit), 10_000, 1.0);
            assert!((white - 1.0).abs().max_element() < 1e-9, "{roughness}: {white}");
        }
    }
}

#[test]
fn lambert_is_reciprocal_and_sends_nothing_through() {
    let hit = hit(0.0, true);
    let [a, b] = [direction(0.4, 1.0, true), direction(1.2, 4.0, true)];
    let lambert = material(0.7, 0.0, 0.0);
    let [there, back] = [(a, b), (b, a)]
        .map(|(view, light)| bsdf(&lambert, view, &hit).evaluate(light).0 / light.z);
    assert!((there - back).abs().max_element() < 1e-15);
    assert!((there.x - 0.7 / PI).abs() < 1e-15);
    assert_eq!(bsdf(&lambert, a, &hit).evaluate(-b), (Rgb::ZERO, 0.0));
}

#[test]
fn mirrors_are_known_as_such() {
    let (view, hit) = (direction(0.4, 1.0, true), hit(0.0, true));
    let mirror = bsdf(&material(0.0, 0.9, 0.0), view, &hit);
    assert!(mirror.is_delta());
    let scattered = mirror.sample(0.3, DVec2::splat(0.5)).unwrap();
    assert!(scattered.delta && !scattered.transmitted);
    assert!((scattered.direction - view * DVec3::new(-1.0, -1.0, 1.0)).length() < 1e-12);
    assert_eq!(scattered.weight, Rgb::splat(0.9));
    assert!(!bsdf(&material(0.1, 0.9, 0.0), view, &hit).is_delta());
    assert!(bsdf(&material(0.0, 0.0, 0.5), view, &hit).sample(0.5, DVec2::splat(0.5)).is_none());
}
