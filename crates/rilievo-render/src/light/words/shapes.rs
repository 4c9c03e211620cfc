//! Shapes of emitters in words: those of a light that is seen in the same way, then what only a shape has.

use glam::DVec3;
use rilievo::surface::{Surface, World};

use super::super::distribution::Distribution;
use super::super::emission::EmissionTable;
use super::super::lighting::{Lighting, prototype};
use super::super::shape::Shape;
use super::{LIGHT_WORDS, NOTHING, QUAD, SPHERE, TRIANGLE, write_flat, write_tree};
use crate::device::Words;

/// Words of a light before its kind.
const KIND: u32 = 25;

/// Writes the shapes of emitters, in the frames in which their surfaces were made; returns their places.
pub(super) fn write(
    words: &mut Words,
    lighting: &Lighting,
    world: &World,
    anchor: DVec3,
) -> Vec<u32> {
    let (emitters, shapes) = lighting.emitters();
    let mut anchors = vec![anchor; shapes.len()];
    for emitter in emitters {
        if let Some(Surface::Instance(_)) = world.surfaces().get(emitter.surface as usize) {
            let bounds = prototype(&world.surfaces()[emitter.surface as usize]).bounds();
            let middle = if bounds.is_empty() { DVec3::ZERO } else { bounds.centre() };
            anchors[emitter.shape as usize] = middle;
        }
    }
    shapes.iter().zip(anchors).map(|(shape, anchor)| write_shape(words, shape, anchor)).collect()
}

fn write_shape(words: &mut Words, shape: &Shape, anchor: DVec3) -> u32 {
    let (kind, rectangular, own) = match shape {
        Shape::Flat(flat) => {
            let table = flat.table.as_ref().map_or(NOTHING, |table| write_table(words, table));
            let half_range = (flat.half_range as f32).to_bits();
            (QUAD, flat.base.rectangular, [table, half_range])
        }
        Shape::Ball { .. } => (SPHERE, false, [NOTHING; 2]),
        Shape::Triangles(tree) => (TRIANGLE, false, write_tree(words, tree, anchor)),
    };
    let place = words.place();
    match shape {
        Shape::Flat(flat) => {
            let (corner, edges, normal) = flat.base.frame();
            write_flat(words, corner - anchor, edges, normal);
            words.float(flat.base.area());
        }
        Shape::Ball { center, radius } => {
            words.point(*center - anchor);
            words.float(*radius);
        }
        Shape::Triangles(_) => {}
    }
    words.fill(place, KIND);
    words.push(kind);
    words.push(NOTHING);
    words.push(u32::from(rectangular));
    own.into_iter().for_each(|word| words.push(word));
    words.fill(place, LIGHT_WORDS);
    place
}

/// Columns, rows, and the places of the sums over rows and over the cells of each.
fn write_table(words: &mut Words, table: &EmissionTable) -> u32 {
    let Distribution { rows, cells, .. } = &table.cells;
    let sums = words.place();
    rows.iter().for_each(|&sum| words.float(f64::from(sum)));
    let of_cells = words.place();
    cells.iter().for_each(|&sum| words.float(f64::from(sum)));
    let place = words.place();
    let [columns, count] = table.size.map(|n| n as u32);
    [columns, count, sums, of_cells].into_iter().for_each(|word| words.push(word));
    place
}
