//! Upright walls: around a closed face, and between two tiles whose heights differ.
//!
//! A wall is hit where the gap above what lies before its line and the gap above what lies behind it
//! have different signs. Both gaps are the leaf's own numbers at that line, so that no ray slips
//! through between a wall and the surface it ends on (see `tile`).

use crate::map::HeightMap;
use crate::ray::Wall;

use super::map_ray::MapRay;
use super::tile::Tile;
use super::trace::{Met, Trace};

/// The wall between what lies before a line and what lies behind it, if the ray meets it there.
fn wall_between(wall: Wall, s: f32, before: f32, behind: f32, face: &Trace<'_>) -> Option<Met> {
    // The rim itself belongs to the wall.
    let from_above = before > 0.0;
    let crosses = from_above != (behind > 0.0);
    (crosses && face.admitted().admits(from_above)).then_some(Met::Wall { wall, s, from_above })
}

/// Gap above offset 0, which the border's walls go down to.
fn gap_to_base(face: &Trace<'_>, ray: &MapRay, s: f32) -> f32 {
    ray.z(s) - face.placement.raw_zero as f32
}

/// The border's wall where the ray enters the window at `s`.
#[cold]
pub(super) fn entry_wall(face: &Trace<'_>, ray: &MapRay, s: f32) -> Option<Met> {
    let heights = face.relief.heights();
    let tile = Tile::new(heights, ray, [ray.cell_at(0, s), ray.cell_at(1, s)]);
    let behind = tile.gap_at_enter(heights, ray);
    let axis = usize::from(ray.t(0, ray.lo[0]) < ray.t(1, ray.lo[1]));
    let wall = border(axis, !ray.backward[axis]);
    wall_between(wall, s, gap_to_base(face, ray, s), behind, face)
}

/// The border's wall where the ray leaves the window at `s`.
#[cold]
pub(super) fn exit_wall(face: &Trace<'_>, ray: &MapRay, s: f32) -> Option<Met> {
    let heights = face.relief.heights();
    let tile = Tile::new(heights, ray, [ray.cell_before(0, s), ray.cell_before(1, s)]);
    let before = tile.gap_at_leave(heights, ray);
    let axis = usize::from(ray.t(0, ray.hi[0]) > ray.t(1, ray.hi[1]));
    let wall = border(axis, ray.backward[axis]);
    wall_between(wall, s, before, gap_to_base(face, ray, s), face)
}

/// The border wall of an axis at its low or high end.
fn border(axis: usize, low: bool) -> Wall {
    match (axis, low) {
        (0, true) => Wall::LowU,
        (0, false) => Wall::HighU,
        (_, true) => Wall::LowV,
        (_, false) => Wall::HighV,
    }
}

/// The wall between a tile and the one that begins at `cell`, across the lines `crossed`.
pub(super) fn seam_wall(
    face: &Trace<'_>,
    ray: &MapRay,
    tile: &Tile,
    (cell, crossed): ([i32; 2], [bool; 2]),
) -> Option<Met> {
    let heights: &HeightMap = face.relief.heights();
    let before = tile.gap_at_leave(heights, ray);
    let behind = Tile::new(heights, ray, cell).gap_at_enter(heights, ray);
    let axis = usize::from(!crossed[0]);
    let line = ray.unfolded_line(axis, cell[axis]);
    let wall = if axis == 0 { Wall::SeamU(line) } else { Wall::SeamV(line) };
    wall_between(wall, tile.leave, before, behind, face)
}
