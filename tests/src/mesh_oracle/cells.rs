//! Which cells of the map a triangle shows.

use glam::DVec2;

/// Unfolded cells that a triangle in lattice coordinates touches.
pub fn cells_under(corners: &[DVec2; 3]) -> Vec<[i32; 2]> {
    let low = corners[0].min(corners[1]).min(corners[2]) - 1e-6;
    let high = corners[0].max(corners[1]).max(corners[2]) + 1e-6;
    let mut cells = Vec::new();
    for j in low.y.floor() as i32..=high.y.floor() as i32 {
        for i in low.x.floor() as i32..=high.x.floor() as i32 {
            let centre = DVec2::new(f64::from(i) + 0.5, f64::from(j) + 0.5);
            let apart = (0..3).any(|k| {
                let (a, b, c) = (corners[k], corners[(k + 1) % 3], corners[(k + 2) % 3]);
                let normal = (b - a).perp();
                let side = normal.dot(c - a).signum();
                let reach = 0.5 * (normal.x.abs() + normal.y.abs()) * (1.0 + 1e-6);
                side * normal.dot(centre - a) < -reach - 1e-9 * normal.length()
            });
            if !apart {
                cells.push([i, j]);
            }
        }
    }
    cells
}
