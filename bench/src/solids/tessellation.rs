//! [`Triangles`]: what a peer gets.

use glam::DVec3;

/// A triangle soup with shared vertices where that is easy.
#[derive(Clone, Debug, Default)]
pub struct Triangles {
    pub positions: Vec<[f32; 3]>,
    pub indices: Vec<[u32; 3]>,
}

impl Triangles {
    /// A grid of `width` x `height` points, two triangles a cell.
    pub fn add_grid(&mut self, [width, height]: [u32; 2], at: impl Fn(u32, u32) -> DVec3) {
        let first = self.positions.len() as u32;
        for j in 0..height {
            for i in 0..width {
                self.positions.push(at(i, j).as_vec3().to_array());
            }
        }
        for j in 0..height - 1 {
            for i in 0..width - 1 {
                let a = first + j * width + i;
                let [b, c, d] = [a + 1, a + width + 1, a + width];
                self.indices.extend([[a, b, c], [a, c, d]]);
            }
        }
    }

    /// A triangle cut into `cuts` x `cuts` by lines along its sides; `at` takes barycentric weights.
    pub fn add_triangle(&mut self, cuts: u32, at: impl Fn([f64; 3]) -> DVec3) {
        let first = self.positions.len() as u32;
        let part = 1.0 / f64::from(cuts);
        // Row j holds cuts + 1 - j points.
        let index = |i: u32, j: u32| first + j * (cuts + 1) - j * j.saturating_sub(1) / 2 + i;
        for j in 0..=cuts {
            for i in 0..=cuts - j {
                let (x, y) = (f64::from(i) * part, f64::from(j) * part);
                self.positions.push(at([1.0 - x - y, x, y]).as_vec3().to_array());
            }
        }
        for j in 0..cuts {
            for i in 0..cuts - j {
                self.indices.push([index(i, j), index(i + 1, j), index(i, j + 1)]);
                if i + 1 < cuts - j {
                    self.indices.push([index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)]);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(triangles: &Triangles) -> f64 {
        let at = |k: u32| DVec3::from(triangles.positions[k as usize].map(f64::from));
        let areas = triangles.indices.iter().map(|&[a, b, c]| {
            let (along, across) = (at(b) - at(a), at(c) - at(a));
            0.5 * along.cross(across).z
        });
        areas.sum()
    }

    #[test]
    fn parts_fill_the_whole_and_keep_its_side() {
        for cuts in [1, 2, 3, 7] {
            let mut triangles = Triangles::default();
            triangles.add_triangle(cuts, |[_, x, y]| DVec3::new(x, y, 0.0));
            assert_eq!(triangles.indices.len(), (cuts * cuts) as usize);
            assert!((area(&triangles) - 0.5).abs() < 1e-6, "{cuts}");
        }
        let mut triangles = Triangles::default();
        triangles.add_grid([4, 3], |i, j| DVec3::new(f64::from(i), f64::from(j), 0.0));
        assert_eq!((triangles.indices.len(), area(&triangles)), (12, 6.0));
    }
}
