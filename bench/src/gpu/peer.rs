//! [`Peer`]: the same map as triangles under a tree, traced by a compute shader of its own (`peer.wgsl`).
//!
//! Two triangles a cell, corners at the samples; rilievo's own binned builder makes the tree (surface area heuristic, at
//! most four triangles a leaf). 48 bytes a triangle and 64 a node, which holds both children's boxes. Sizes that the device cannot
//! bind are halved, and the record says which was traced.

use glam::DVec3;
use rayon::prelude::*;
use rilievo::accel::{Aabb, Bvh, BvhNode};
use rilievo::map::HeightMap;
use rilievo_gpu::{Gpu, GpuError, wgpu};
use wgpu::util::DeviceExt as _;

use crate::rays::Ray32;

/// Most triangles in a leaf.
const LEAF_TRIANGLES: u32 = 4;

/// Bytes of a triangle on the device.
const TRIANGLE_BYTES: u64 = 48;

/// Workgroups of a dispatch along an axis.
const LARGEST_GROUPS: u32 = 65_535;

/// Triangles on a device.
pub struct Peer {
    pipeline: wgpu::ComputePipeline,
    nodes: wgpu::Buffer,
    triangles: wgpu::Buffer,
    /// Samples a side of the grid that was cut into triangles.
    pub side: u32,
}

/// Rays on a device, and what they met.
pub struct PeerRays {
    group: wgpu::BindGroup,
    found: wgpu::Buffer,
    count: u32,
}

impl Peer {
    /// `map` on the unit square, one unit of height being `depth` scene units, thinned out until a device binds its
    /// triangles and `largest` samples a side are not exceeded.
    ///
    /// # Errors
    /// As the device says.
    pub fn new(gpu: &Gpu, map: &HeightMap, depth: f64, largest: u32) -> Result<Self, GpuError> {
        let limits = gpu.device().limits();
        let allowed = limits.max_storage_buffer_binding_size.min(limits.max_buffer_size);
        let mut side = map.width().min(largest.max(2));
        while 2 * TRIANGLE_BYTES * u64::from(side - 1).pow(2) > allowed {
            side = (side / 2).max(2);
        }
        let corners = triangles(map, depth, side);
        let boxes: Vec<Aabb> =
            corners.par_iter().map(|corners| Aabb::around(corners.iter().copied())).collect();
        let tree = Bvh::build(&boxes, LEAF_TRIANGLES);
        drop(boxes);
        let (nodes, order) = flattened(&tree);
        let words: Vec<[f32; 12]> =
            order.par_iter().map(|&index| triangle_words(&corners[index as usize])).collect();
        let buffer = |contents: &[u8]| {
            gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("triangles"),
                contents,
                usage: wgpu::BufferUsages::STORAGE,
            })
        };
        let module = gpu.device().create_shader_module(wgpu::include_wgsl!("peer.wgsl"));
        let pipeline = gpu.device().create_compute_pipeline(&wgpu::ComputePipelineDescriptor {
            label: Some("peer"),
            layout: None,
            module: &module,
            entry_point: Some("closest"),
            compilation_options: Default::default(),
            cache: None,
        });
        let (nodes, triangles) =
            (buffer(bytemuck::cast_slice(&nodes)), buffer(bytemuck::cast_slice(&words)));
        Ok(Self { pipeline, nodes, triangles, side })
    }

    /// Bytes on the device.
    pub fn bytes(&self) -> u64 {
        self.nodes.size() + self.triangles.size()
    }

    /// Brings rays to the device.
    pub fn hold(&self, gpu: &Gpu, rays: &[Ray32]) -> PeerRays {
        let words: Vec<[f32; 8]> = rays
            .iter()
            .map(|Ray32 { origin: [x, y, z], direction: [dx, dy, dz], t_max }| {
                [*x, *y, *z, t_max.min(f32::MAX), *dx, *dy, *dz, 0.0]
            })
            .collect();
        let buffer = gpu.device().create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("rays"),
            contents: bytemuck::cast_slice(&words),
            usage: wgpu::BufferUsages::STORAGE,
        });
        let found = gpu.device().create_buffer(&wgpu::BufferDescriptor {
            label: Some("found"),
            size: rays.len() as u64 * 8,
            usage: wgpu::BufferUsages::STORAGE | wgpu::BufferUsages::COPY_SRC,
            mapped_at_creation: false,
        });
        let entries: Vec<_> = (0..)
            .zip([&buffer, &found, &self.nodes, &self.triangles])
            .map(|(binding, buffer)| wgpu::BindGroupEntry {
                binding,
                resource: buffer.as_entire_binding(),
            })
            .collect();
        let group = gpu.device().create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("peer"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &entries,
        });
        PeerRays { group, found, count: rays.len() as u32 }
    }

    /// Device seconds of finding the nearest hits of all rays.
    ///
    /// # Errors
    /// As the device says.
    pub fn time(&self, gpu: &Gpu, rays: &PeerRays) -> Result<f64, GpuError> {
        let groups = rays.count.div_ceil(64);
        let across = groups.min(LARGEST_GROUPS);
        gpu.time_pass(|pass| {
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &rays.group, &[]);
            pass.dispatch_workgroups(across, groups.div_ceil(across.max(1)), 1);
        })
    }

    /// The parameters of the hits that were found last.
    ///
    /// # Errors
    /// As the device says.
    pub fn hits(&self, gpu: &Gpu, rays: &PeerRays) -> Result<Vec<Option<f64>>, GpuError> {
        let bytes = gpu.copy_out(&rays.found)?;
        let words = bytes.chunks_exact(8).map(|word| {
            let t = f32::from_le_bytes([word[0], word[1], word[2], word[3]]);
            (t < 1e38).then_some(f64::from(t))
        });
        Ok(words.collect())
    }
}

/// Corners of all triangles, two a cell, of a grid of `side` x `side` samples of the map.
fn triangles(map: &HeightMap, depth: f64, side: u32) -> Vec<[DVec3; 3]> {
    let last = f64::from(side - 1);
    let point = |i: u32, j: u32| {
        let (u, v) = (f64::from(i) / last, f64::from(j) / last);
        // At the far border a map that repeats shows its first samples.
        let sample = |k: u32| {
            let steps = u64::from(k) * u64::from(map.width() - 1) + u64::from(side - 1) / 2;
            (steps / u64::from(side - 1)) as u32
        };
        let height = f64::from(map.raw(sample(i), sample(j))) * map.unit();
        DVec3::new(u, v, depth * height)
    };
    (0..side - 1)
        .into_par_iter()
        .flat_map_iter(|j| {
            (0..side - 1).flat_map(move |i| {
                let [a, b, c, d] =
                    [point(i, j), point(i + 1, j), point(i + 1, j + 1), point(i, j + 1)];
                [[a, b, c], [a, c, d]]
            })
        })
        .collect()
}

fn triangle_words(&[a, b, c]: &[DVec3; 3]) -> [f32; 12] {
    let mut words = [0.0; 12];
    for (place, vector) in words.chunks_exact_mut(4).zip([a, b - a, c - a]) {
        place[..3].copy_from_slice(&vector.as_vec3().to_array());
    }
    words
}

/// The nodes as the shader reads them, and the triangles in the order of the leaves.
fn flattened(tree: &Bvh) -> (Vec<[u32; 16]>, Vec<u32>) {
    let all: Vec<BvhNode<'_>> = tree.nodes().collect();
    let mut order = Vec::new();
    // Where a node is: among the inner ones, or its first triangle.
    let mut places = Vec::with_capacity(all.len());
    let mut inner = 0;
    for node in &all {
        match node {
            BvhNode::Inner { .. } => {
                places.push([inner, 0]);
                inner += 1;
            }
            BvhNode::Leaf { items, .. } => {
                places.push([order.len() as u32, items.len() as u32]);
                order.extend_from_slice(items);
            }
        }
    }
    let child = |at: usize| {
        let (BvhNode::Inner { bounds, .. } | BvhNode::Leaf { bounds, .. }) = all[at];
        let [place, count] = places[at];
        let low = bounds.min.to_array().map(|x| (x as f32).next_down().to_bits());
        let high = bounds.max.to_array().map(|x| (x as f32).next_up().to_bits());
        [low[0], low[1], low[2], place, high[0], high[1], high[2], count]
    };
    let mut nodes: Vec<[u32; 16]> = Vec::with_capacity(inner as usize);
    for (at, node) in all.iter().enumerate() {
        if let BvhNode::Inner { second, .. } = node {
            let mut words = [0; 16];
            words[..8].copy_from_slice(&child(at + 1));
            words[8..].copy_from_slice(&child(*second as usize));
            nodes.push(words);
        }
    }
    (nodes, order)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::MapName;

    #[test]
    fn every_triangle_hangs_below_one_leaf() {
        let map = MapName::Fbm.load(17).unwrap();
        let all = triangles(&map, 0.1, 17);
        assert_eq!(all.len(), 2 * 16 * 16);
        let boxes: Vec<Aabb> = all.iter().map(|c| Aabb::around(c.iter().copied())).collect();
        let (nodes, mut order) = flattened(&Bvh::build(&boxes, LEAF_TRIANGLES));
        order.sort_unstable();
        assert!(order.iter().copied().eq(0..512));
        let counted: u32 = nodes.iter().map(|node| node[7] + node[15]).sum();
        assert_eq!(counted, 512);
        // The far corner of the map is that of the grid.
        let far = all[all.len() - 2][2];
        assert!(
            (far - DVec3::new(1.0, 1.0, 0.1 * f64::from(map.raw(16, 16)) / 65535.0)).length()
                < 1e-12
        );
        assert_eq!(triangles(&map, 0.1, 5)[0][1].x, 0.25);
    }
}
