//! Scenes built in a few lines.

use std::sync::Arc;

use glam::{DAffine3, DVec3};
use rilievo::surface::{Instance, Quad, Sphere, Surface, World};
use rilievo_render::{
    Aov, Camera, CameraParts, Film, Material, Reflectance, RenderOptions, RenderSettings,
    RenderStats, Rgb, Scene, SceneParts, render,
};

/// A diffuser of one grey.
pub fn diffuse(grey: f64) -> Material {
    Material { diffuse: Reflectance::Uniform(Rgb::splat(grey)), ..Material::default() }
}

/// A black body that emits.
pub fn emitter(emitted: Rgb) -> Material {
    Material { emitted, ..diffuse(0.0) }
}

/// Collects surfaces, each with its own material.
#[derive(Default)]
pub struct Builder {
    surfaces: Vec<Surface>,
    materials: Vec<Material>,
    background: Rgb,
}

impl Builder {
    /// Adds a two-sided quad from a corner and the edges along u and v.
    pub fn quad(self, [corner, u, v]: [DVec3; 3], material: Material) -> Self {
        self.corners([corner, corner + u, corner + u + v, corner + v], material)
    }

    /// Adds a two-sided quad with any corners.
    pub fn corners(mut self, corners: [DVec3; 4], material: Material) -> Self {
        self.surfaces.push(Surface::Quad(Quad::new(corners, false).unwrap()));
        self.materials.push(material);
        self
    }

    /// Adds any surface.
    pub fn surface(mut self, surface: Surface, material: Material) -> Self {
        self.surfaces.push(surface);
        self.materials.push(material);
        self
    }

    /// Sets the radiance where a ray meets nothing.
    pub fn background(self, background: Rgb) -> Self {
        Self { background, ..self }
    }

    /// Adds a sphere.
    pub fn sphere(mut self, center: DVec3, radius: f64, material: Material) -> Self {
        self.surfaces.push(Surface::Sphere(Sphere::new(center, radius).unwrap()));
        self.materials.push(material);
        self
    }

    /// Adds the six walls of the cube `center +- half`, their fronts inside.
    pub fn room(mut self, center: DVec3, half: f64, material: &Material) -> Self {
        for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
            for normal in [axis, -axis] {
                let u = DVec3::new(axis.z, axis.x, axis.y) * half;
                let v = normal.cross(u);
                let middle = center - normal * half;
                self = self.quad([middle - u - v, 2.0 * u, 2.0 * v], material.clone());
            }
        }
        self
    }

    /// The scene; its surroundings are black unless said otherwise.
    pub fn scene(self, camera: CameraParts, settings: RenderSettings) -> Scene {
        let material_of = (0..self.surfaces.len() as u32).collect();
        Scene::new(SceneParts {
            world: World::new(self.surfaces),
            materials: self.materials,
            material_of,
            camera: Camera::new(camera).unwrap(),
            background: self.background,
            ambient: Rgb::ZERO,
            settings,
        })
        .unwrap()
    }
}

/// The quad of a corner and two edges as an instance: no light of the paper's integrator.
pub fn glowing([corner, u, v]: [DVec3; 3]) -> Surface {
    let quad = Quad::new([corner, corner + u, corner + u + v, corner + v], false).unwrap();
    Instance::new(Arc::new(quad.into()), DAffine3::IDENTITY).unwrap().into()
}

/// The walls of the cube [-1, 1]^3 seen from within, their fronts inside, as quads or as instances.
pub fn room(walls: &Material, as_instances: bool, settings: RenderSettings) -> Scene {
    let view = camera([0.1, 0.2, 0.05], [1.0, 0.3, 0.2], 100.0, [24, 24]);
    if !as_instances {
        return Builder::default().room(DVec3::ZERO, 1.0, walls).scene(view, settings);
    }
    let mut builder = Builder::default();
    for axis in DVec3::AXES {
        for normal in [axis, -axis] {
            let u = DVec3::new(axis.z, axis.x, axis.y);
            let v = normal.cross(u);
            let wall = glowing([-normal - u - v, 2.0 * u, 2.0 * v]);
            builder = builder.surface(wall, walls.clone());
        }
    }
    builder.scene(view, settings)
}

/// Mean of the red channel and its standard error, over pixels that are samples of one number.
pub fn mean_of(film: &Film) -> (f64, f64) {
    let n = film.radiance().len() as f64;
    let values = || film.radiance().iter().map(|p| f64::from(p[0]));
    let mean = values().sum::<f64>() / n;
    (mean, (values().map(|x| (x - mean).powi(2)).sum::<f64>() / n / n).sqrt())
}

/// A camera with +z up.
pub fn camera(
    position: [f64; 3],
    look_at: [f64; 3],
    fov: f64,
    resolution: [u32; 2],
) -> CameraParts {
    let [position, look_at] = [position, look_at].map(DVec3::from_array);
    CameraParts { position, look_at, up: DVec3::Z, fov, resolution }
}

/// Renders with one ray through each pixel's centre and keeps P.
pub fn pixel_centers(scene: &Scene) -> (Film, RenderStats) {
    let options =
        RenderOptions { pixel_centers: true, aovs: &[Aov::P], ..RenderOptions::default() };
    render(scene, &options).unwrap()
}

/// A square lamp of side `side` around `center`, its front down.
pub fn lamp(center: [f64; 3], side: f64) -> Surface {
    let corners = [[-0.5, -0.5], [-0.5, 0.5], [0.5, 0.5], [0.5, -0.5]]
        .map(|[x, y]| DVec3::from_array(center) + side * DVec3::new(x, y, 0.0));
    Surface::Quad(Quad::new(corners, false).unwrap())
}
