//! A pot: turned body, closed at both ends, and a handle from the belly to the neck.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};
use rilievo::mesh::{MeshData, Triangle};

/// Radius and height of the rings between the two ends.
const PROFILE: [[f64; 2]; 14] = [
    [0.5, -0.8],
    [0.7, -0.72],
    [0.95, -0.4],
    [1.0, -0.1],
    [0.92, 0.2],
    [0.7, 0.45],
    [0.6, 0.5],
    [0.62, 0.56],
    [0.45, 0.68],
    [0.12, 0.74],
    [0.09, 0.8],
    [0.18, 0.88],
    [0.2, 0.96],
    [0.12, 1.02],
];

/// Heights of the ends.
const ENDS: [f64; 2] = [-0.8, 1.04];

/// Rings above which a quad is cut out for either end of the handle.
const BELOW: usize = 2;
const ABOVE: usize = 4;

/// Pieces of the handle.
const PIECES: usize = 6;

/// The pot, turned in so many steps. No normals: all are those of the mesh.
pub(super) fn pot(around: u32) -> MeshData {
    let n = around as usize;
    let rings = PROFILE.len();
    let mut data = MeshData::default();
    for [radius, z] in PROFILE {
        for i in 0..n {
            let angle = TAU * i as f64 / n as f64;
            data.positions.push(DVec3::new(radius * angle.cos(), radius * angle.sin(), z));
        }
    }
    data.positions.extend(ENDS.map(|z| DVec3::new(0.0, 0.0, z)));
    let position = |j: usize, i: usize| (j * n + i % n) as u32;
    let place = |j: f64, i: f64| DVec2::new(2.0 * i / n as f64, j / rings as f64);
    for i in 0..n {
        let step = i as f64;
        for j in 0..rings - 1 {
            if i == 0 && (j == BELOW || j == ABOVE) {
                continue;
            }
            let corners = [[0, 0], [0, 1], [1, 1], [1, 0]];
            let uvs = corners.map(|[y, x]| place((j + y) as f64 + 1.0, step + x as f64));
            quad(&mut data, corners.map(|[y, x]| position(j + y, i + x)), uvs);
        }
        let [bottom, top] = [0, 1].map(|end| (rings * n + end) as u32);
        let last = rings - 1;
        let uvs = [place(0.0, step + 0.5), place(1.0, step + 1.0), place(1.0, step)];
        triangle(&mut data, [bottom, position(0, i + 1), position(0, i)], uvs);
        let high = rings as f64;
        let uvs = [place(high + 1.0, step + 0.5), place(high, step), place(high, step + 1.0)];
        triangle(&mut data, [top, position(last, i), position(last, i + 1)], uvs);
    }
    // From the lower hole to the upper one: what is outside below is outside above.
    let [a, b] = [BELOW, ABOVE];
    let from = [position(a, 0), position(a, 1), position(a + 1, 1), position(a + 1, 0)];
    let to = [position(b + 1, 0), position(b + 1, 1), position(b, 1), position(b, 0)];
    let angle = 0.5 * TAU / n as f64;
    let out = DVec3::new(angle.cos(), angle.sin(), 0.0);
    let mut loops = vec![from];
    for piece in 1..PIECES {
        let share = piece as f64 / PIECES as f64;
        let first = data.positions.len() as u32;
        for k in 0..4 {
            let [p, q] = [from[k], to[k]].map(|p| data.positions[p as usize]);
            let far = if k < 2 { 0.75 } else { 0.45 };
            data.positions.push(p.lerp(q, share) + far * (PI * share).sin() * out);
        }
        loops.push([0, 1, 2, 3].map(|k| first + k));
    }
    loops.push(to);
    for (piece, pair) in loops.windows(2).enumerate() {
        for k in 0..4 {
            let next = (k + 1) % 4;
            let corners = [pair[0][k], pair[0][next], pair[1][next], pair[1][k]];
            let at = |k: usize, piece: usize| DVec2::new(0.25 * k as f64, 0.2 * piece as f64);
            let uvs = [at(k, piece), at(k + 1, piece), at(k + 1, piece + 1), at(k, piece + 1)];
            quad(&mut data, corners, uvs);
        }
    }
    data
}

fn quad(data: &mut MeshData, [a, b, c, d]: [u32; 4], [s, t, u, v]: [DVec2; 4]) {
    triangle(data, [a, b, c], [s, t, u]);
    triangle(data, [a, c, d], [s, u, v]);
}

fn triangle(data: &mut MeshData, positions: [u32; 3], uvs: [DVec2; 3]) {
    let first = data.uvs.len() as u32;
    data.uvs.extend(uvs);
    let uvs = Some([first, first + 1, first + 2]);
    data.triangles.push(Triangle { positions, normals: None, uvs });
}
