//! Normals for meshes that have none.
//!
//! The normal of a corner is the sum of the unit normals of the triangles that meet there, each
//! weighted by its angle at the corner: it does not depend on how faces were cut into triangles
//! \[Thurmer1998\].

use std::collections::HashMap;

use glam::DVec3;

use super::data::MeshData;

impl MeshData {
    /// Gives triangles without normals smooth ones. `groups` holds a number for each triangle:
    /// corners at the same position are joined within a group, triangles of group 0 stay flat.
    /// Positions are the same if their bits are. Indices must hold; a shorter `groups` leaves
    /// the rest flat.
    pub fn smooth(&mut self, groups: &[u32]) {
        let mut sums: HashMap<([u64; 3], u32), (DVec3, u32)> = HashMap::new();
        let wanted: Vec<(usize, u32)> = (groups.iter().enumerate())
            .take(self.triangles.len())
            .filter(|&(k, &group)| group != 0 && self.triangles[k].normals.is_none())
            .map(|(k, &group)| (k, group))
            .collect();
        // Adding zero makes both zeros the same.
        let key = |p: DVec3, group| (p.to_array().map(|c| (c + 0.0).to_bits()), group);
        for &(k, group) in &wanted {
            let corners = self.triangles[k].positions.map(|i| self.positions[i as usize]);
            let normal = unit_normal(corners);
            for (c, corner) in corners.into_iter().enumerate() {
                let edges = [1, 2].map(|step| corners[(c + step) % 3] - corner);
                let angle = edges[0].angle_between(edges[1]);
                let part = if angle.is_finite() { angle * normal } else { DVec3::ZERO };
                sums.entry(key(corner, group)).or_default().0 += part;
            }
        }
        for &(k, group) in &wanted {
            let positions = self.triangles[k].positions;
            let mut normals = [0; 3];
            for (slot, i) in normals.iter_mut().zip(positions) {
                let at = key(self.positions[i as usize], group);
                let (sum, index) = sums.entry(at).or_default();
                // Indices count from 1, so that 0 says there is none yet.
                if *index == 0 {
                    self.normals.push(sum.normalize_or_zero());
                    *index = self.normals.len() as u32;
                }
                *slot = *index - 1;
            }
            self.triangles[k].normals = Some(normals);
        }
    }
}

/// The unit normal of a triangle of any size; zero without area.
fn unit_normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    let (along, across) = (b - a, c - a);
    along.normalize_or_zero().cross(across.normalize_or_zero()).normalize_or_zero()
}

#[cfg(test)]
mod tests {
    use crate::mesh::{Mesh, solids};

    #[test]
    fn a_cube_gets_its_diagonals_however_its_faces_are_cut() {
        let mut data = solids::cube();
        data.smooth(&[1; 12]);
        assert_eq!(data.normals.len(), 8);
        for t in &data.triangles {
            for (p, n) in t.positions.into_iter().zip(t.normals.unwrap()) {
                let outwards = data.positions[p as usize].normalize();
                assert!((data.normals[n as usize] - outwards).length() < 1e-12);
            }
        }
        assert!(Mesh::new(data).is_ok());
    }

    #[test]
    fn groups_are_not_joined_and_group_0_stays_flat() {
        let mut data = solids::cube();
        let groups: Vec<u32> = (0..12).map(|k| k / 4).collect();
        data.smooth(&groups);
        assert!(data.triangles[..4].iter().all(|t| t.normals.is_none()));
        assert!(data.triangles[4..].iter().all(|t| t.normals.is_some()));
        let of = |k: usize| data.triangles[k].normals.unwrap();
        assert!(of(4).iter().all(|n| !of(8).contains(n)));
    }

    #[test]
    fn triangles_without_area_add_nothing() {
        let mut data = solids::cube();
        let flat = crate::mesh::Triangle { positions: [0, 0, 6], normals: None, uvs: None };
        data.triangles.push(flat);
        data.smooth(&[1; 13]);
        assert!(data.normals.iter().all(|n| n.is_finite()));
    }
}
