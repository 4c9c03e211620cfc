//! Light in words, for shaders: the twins of these modules read them.

mod shapes;

use glam::DVec3;
use rilievo::surface::Surface;

use super::bounds::LightBounds;
use super::distribution::Distribution;
use super::environment::Environment;
use super::tree::LightTree;
use super::{Light, PointLight, QuadLight, SphereLight, SunLight};
use crate::device::{NOTHING, Parts, Uncovered, Words};
use crate::scene::Scene;

/// Words of a light.
pub const LIGHT_WORDS: u32 = 32;
/// Words of a node of the tree over lights.
pub const TREE_WORDS: u32 = 20;

/// Most lights that are written one by one.
const MOST_LIGHTS: usize = 1 << 20;

const QUAD: u32 = 0;
const TRIANGLE: u32 = 1;
const SPHERE: u32 = 2;
const POINT: u32 = 3;
const SUN: u32 = 4;
const EMITTER: u32 = 5;

/// Writes lights one after the other; returns the place of the first.
pub(crate) fn write_lights(words: &mut Words, lights: &[Light], anchor: DVec3) -> u32 {
    let first = words.place();
    lights.iter().for_each(|light| write_light(words, light, anchor));
    first
}

fn write_light(words: &mut Words, light: &Light, anchor: DVec3) {
    let place = words.place();
    let kind = match light {
        Light::Quad(quad) => {
            let (corner, edges, normal) = quad.frame();
            write_flat(words, corner - anchor, edges, normal);
            words.float(quad.area());
            words.triple(quad.emitted());
            QUAD
        }
        Light::Triangle(triangle) => {
            let (corner, edges, normal) = triangle.frame();
            write_flat(words, corner - anchor, edges, normal);
            words.float(0.5 * edges[0].cross(edges[1]).length());
            words.triple(triangle.emitted());
            TRIANGLE
        }
        Light::Sphere(SphereLight { center, radius, emitted, .. }) => {
            words.point(center - anchor);
            words.float(*radius);
            words.fill(place, 22);
            words.triple(*emitted);
            SPHERE
        }
        Light::Point(light) => {
            let PointLight { position, intensity, axis, cosines } = *light;
            words.point(position - anchor);
            words.triple(axis);
            cosines.into_iter().for_each(|cosine| words.float(cosine));
            words.fill(place, 22);
            words.triple(intensity);
            POINT
        }
        Light::Sun(SunLight { towards, irradiance, height, radiance }) => {
            words.triple(*towards);
            words.float(*height);
            words.triple(*radiance);
            words.fill(place, 22);
            words.triple(*irradiance);
            SUN
        }
    };
    words.push(kind);
    words.push(light.surface().unwrap_or(NOTHING));
    let rectangular = matches!(light, Light::Quad(QuadLight { rectangular: true, .. }));
    words.push(u32::from(rectangular));
    words.fill(place, LIGHT_WORDS);
}

fn write_flat(words: &mut Words, corner: DVec3, edges: [DVec3; 2], normal: DVec3) {
    words.point(corner);
    edges.into_iter().for_each(|edge| words.point(edge));
    words.triple(normal);
}

/// Writes what lights paths; returns for each surface the first of the drawn lights that it is. `parts.emitters` says
/// whether anything is drawn by its shape.
///
/// # Errors
/// [`Uncovered`] for too many lights.
pub(crate) fn write_lighting(
    words: &mut Words,
    parts: &mut Parts,
    scene: &Scene,
    anchor: DVec3,
) -> Result<Vec<Option<u32>>, Uncovered> {
    let suns: Vec<Light> = scene.lights().iter().filter(|light| is_sun(light)).copied().collect();
    words.set("SUNS", suns.len() as u32);
    let first = write_lights(words, &suns, anchor);
    words.set("FIRST_SUN", first);
    let sky = scene.environment().map_or(NOTHING, |sky| write_sky(words, sky));
    words.set("SKY", sky);
    if !scene.settings().integrator.sums() {
        return Ok(vec![None; scene.world().surfaces().len()]);
    }
    let lighting = scene.lighting();
    let drawn = lighting.drawn(scene.world());
    let (emitters, _) = lighting.emitters();
    let world = scene.world();
    let moves =
        |surface: u32| matches!(world.surfaces().get(surface as usize), Some(Surface::Moving(_)));
    if emitters.iter().any(|emitter| moves(emitter.surface)) {
        return Err(Uncovered("light from a shape in motion"));
    }
    if drawn.len() + emitters.len() > MOST_LIGHTS {
        return Err(Uncovered("light from a mesh of more than a million triangles"));
    }
    words.set("CHOOSES", u32::from(lighting.chooses()));
    words.set("GROUPS", lighting.groups() as u32);
    parts.emitters = !emitters.is_empty();
    let shapes = shapes::write(words, lighting, scene.world(), anchor);
    let first = write_lights(words, &drawn, anchor);
    words.set("FIRST_DRAWN", first);
    for emitter in emitters {
        let place = words.place();
        words.fill(place, 25);
        words.push(EMITTER);
        words.push(emitter.surface);
        words.push(0);
        words.push(shapes[emitter.shape as usize]);
        words.fill(place, LIGHT_WORDS);
    }
    let [nodes, ways] = write_tree(words, lighting.tree(), anchor);
    words.set("TREE", nodes);
    words.set("TREE_NODES", lighting.tree().nodes().len() as u32);
    words.set("WAYS", ways);
    Ok(lighting.first_of_surfaces().collect())
}

fn is_sun(light: &Light) -> bool {
    matches!(light, Light::Sun(_))
}

/// Writes a tree; returns the places of its nodes and of the ways to its lights.
fn write_tree(words: &mut Words, tree: &LightTree, anchor: DVec3) -> [u32; 2] {
    let nodes = words.place();
    for (bounds, next, leaf) in tree.nodes() {
        write_node(words, &bounds, (next, leaf), anchor);
    }
    let ways = words.place();
    for way in tree.ways() {
        words.push(*way as u32);
        words.push((*way >> 32) as u32);
    }
    [nodes, ways]
}

fn write_node(words: &mut Words, bounds: &LightBounds, (next, leaf): (u32, bool), anchor: DVec3) {
    let place = words.place();
    let half = 0.5 * (bounds.max - bounds.min);
    words.point(bounds.min + half - anchor);
    words.triple(half);
    words.triple(bounds.axis);
    let sin_normals = (1.0 - bounds.cos_normals * bounds.cos_normals).max(0.0).sqrt();
    for x in [bounds.intensity, bounds.cos_normals, sin_normals, bounds.cos_emission] {
        words.float(x);
    }
    words.float(bounds.held);
    words.float(bounds.most);
    words.push(next);
    words.push(u32::from(leaf));
    debug_assert_eq!(words.place() - place, TREE_WORDS);
}

/// Writes an image of the sky; returns its place.
fn write_sky(words: &mut Words, sky: &Environment) -> u32 {
    let texels = words.place();
    for texel in &sky.texels {
        texel.iter().for_each(|&channel| words.float(f64::from(channel)));
    }
    let rows = words.place();
    let (mut sums, mut cells, mut columns, mut count) = (NOTHING, NOTHING, 0, 0);
    if let Some(distribution) = &sky.cells {
        let Distribution { columns: across, rows: of_rows, cells: of_cells } = distribution;
        (columns, count) = (*across as u32, of_rows.len() as u32 - 1);
        // Of each row its lower edge and its height, which floats would lose near the poles.
        for row in 0..count as usize {
            let [low, high] = sky.heights(row);
            words.float(low);
            words.float(high - low);
        }
        sums = words.place();
        of_rows.iter().for_each(|&sum| words.float(f64::from(sum)));
        cells = words.place();
        of_cells.iter().for_each(|&sum| words.float(f64::from(sum)));
    }
    let place = words.place();
    let head = [sky.width as u32, sky.height as u32, texels, sky.side as u32, columns, count];
    head.into_iter().chain([rows, sums, cells]).for_each(|word| words.push(word));
    let axes = sky.world_from_image;
    [axes.x_axis, axes.y_axis, axes.z_axis].into_iter().for_each(|axis| words.triple(axis));
    place
}
