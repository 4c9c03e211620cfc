//! [`Camera`]: where camera rays start and go; right-handed, image x to the right and y down.
//!
//! A camera is a pinhole unless it is given a [`Lens`], another [`Projection`] or a second pose to
//! move to. Rays of a pinhole at rest are those they were before any of these came: the same
//! arithmetic, bit for bit. Its shutter says at which times rays are traced: surfaces may move, too.

mod lens;
mod pose;

pub use lens::Lens;
pub use pose::Pose;

use std::f64::consts::{PI, TAU};

use glam::{DMat4, DVec2, DVec3};
use rilievo::Ray;

use pose::Frame;

/// What a camera is made of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraParts {
    /// The pinhole, world space, scene units.
    pub position: DVec3,
    /// A point on the view axis.
    pub look_at: DVec3,
    /// A direction whose projection points up in the image; any length but zero.
    pub up: DVec3,
    /// Vertical field of view, degrees, between 0 and 180, both excluded.
    pub fov: f64,
    /// Pixels along image x and y.
    pub resolution: [u32; 2],
}

/// How the image plane is reached.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Projection {
    /// Through a point: lines stay straight and far things are small.
    #[default]
    Perspective,
    /// Along the view axis: things are as large near as far.
    Orthographic {
        /// Height of the image in scene units.
        height: f64,
    },
    /// All directions at once, longitude along x and latitude along y: the middle of the image is
    /// the view axis, its upper border the direction `up` made perpendicular to it.
    Panoramic,
}

/// Why a camera was refused.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CameraError {
    /// A coordinate is NaN or infinite.
    #[error("camera position, look_at and up must be finite")]
    NotFinite,
    /// `position` and `look_at` are the same point.
    #[error("camera position and look_at are the same point")]
    NoDirection,
    /// `up` is zero or parallel to the view axis.
    #[error("camera up must not be zero or parallel to the view direction")]
    UpIsParallel,
    /// The field of view is out of range.
    #[error("camera fov is {found} degrees; it must be above 0 and below 180")]
    FieldOfView {
        /// The value found.
        found: f64,
    },
    /// An axis has no pixel, or the image has too many.
    #[error(
        "camera resolution is {} x {}; 1 to {} pixels along an axis are allowed",
        found[0], found[1], Camera::MAX_RESOLUTION
    )]
    Resolution {
        /// The value found.
        found: [u32; 2],
    },
    /// An orthographic image without height, or infinitely high.
    #[error("camera height is {found}; it must be finite and above 0")]
    Height {
        /// The value found.
        found: f64,
    },
    /// A lens that no light comes through, or that focuses nowhere.
    #[error("the lens must have a finite radius of at least 0 and focus at a distance above 0")]
    Lens,
    /// Too few blades for an opening.
    #[error("an aperture has 0 blades (round) or 3 to {}, not {found}", Lens::MAX_BLADES)]
    Blades {
        /// The value found.
        found: u32,
    },
    /// A pose on the way between the first and the last has no direction.
    #[error("the camera passes through a pose without a direction on its way")]
    Motion,
    /// The shutter closes before it opens, or is open outside of the motion.
    #[error("the shutter opens at {} and closes at {}; 0 <= open <= close <= 1", found[0], found[1])]
    Shutter {
        /// The values found.
        found: [f64; 2],
    },
}

/// A camera; valid by construction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    parts: CameraParts,
    projection: Projection,
    lens: Option<Lens>,
    /// At rest, or before it moves.
    frame: Frame,
    /// Where it is at time 1.
    end: Option<Pose>,
    shutter: [f64; 2],
}

impl Camera {
    /// Most pixels along an axis.
    pub const MAX_RESOLUTION: u32 = 65_536;

    /// The pinhole camera of `parts`.
    ///
    /// # Errors
    /// [`CameraError`] says which part is wrong.
    pub fn new(parts: CameraParts) -> Result<Self, CameraError> {
        let CameraParts { position, look_at, up, fov, resolution } = parts;
        let pose = Pose { position, look_at, up };
        if !pose.is_finite() {
            return Err(CameraError::NotFinite);
        }
        if !(fov > 0.0 && fov < 180.0) {
            return Err(CameraError::FieldOfView { found: fov });
        }
        if resolution.iter().any(|n| !(1..=Self::MAX_RESOLUTION).contains(n)) {
            return Err(CameraError::Resolution { found: resolution });
        }
        let frame = Frame::new(pose, pixel_of(fov, resolution))?;
        let (projection, shutter) = (Projection::Perspective, [0.0, 1.0]);
        Ok(Self { parts, projection, lens: None, frame, end: None, shutter })
    }

    /// The same camera with another projection. A panorama has no lens and no field of view.
    ///
    /// # Errors
    /// [`CameraError::Height`].
    pub fn with_projection(self, projection: Projection) -> Result<Self, CameraError> {
        match projection {
            Projection::Orthographic { height: found } if !(found.is_finite() && found > 0.0) => {
                Err(CameraError::Height { found })
            }
            _ => Ok(Self { projection, ..self }),
        }
    }

    /// The same camera with a lens in place of the pinhole.
    ///
    /// # Errors
    /// [`CameraError::Lens`], [`CameraError::Blades`].
    pub fn with_lens(self, lens: Lens) -> Result<Self, CameraError> {
        lens.check()?;
        Ok(Self { lens: (lens.radius > 0.0).then_some(lens), ..self })
    }

    /// The same camera on its way from where it is, at time 0, to another pose, at time 1; its
    /// shutter is open from `shutter[0]` to `shutter[1]`.
    ///
    /// # Errors
    /// [`CameraError`] if the pose or the shutter is out of range, or the way leads through a pose
    /// without direction.
    pub fn with_motion(self, end: Pose, shutter: [f64; 2]) -> Result<Self, CameraError> {
        if !end.is_finite() {
            return Err(CameraError::NotFinite);
        }
        let moved = Self { end: Some(end), ..self.with_shutter(shutter)? };
        for step in 0..=64 {
            moved.frame_at(f64::from(step) / 64.0).ok_or(CameraError::Motion)?;
        }
        Ok(moved)
    }

    /// The same camera with its shutter open from `shutter[0]` to `shutter[1]`, within the time from 0
    /// to 1 in which it and surfaces move.
    ///
    /// # Errors
    /// [`CameraError::Shutter`].
    pub fn with_shutter(self, shutter: [f64; 2]) -> Result<Self, CameraError> {
        let [open, close] = shutter;
        if !(0.0 <= open && open <= close && close <= 1.0) {
            return Err(CameraError::Shutter { found: shutter });
        }
        Ok(Self { shutter, ..self })
    }

    /// What the camera was made of, at time 0.
    pub fn parts(&self) -> CameraParts {
        self.parts
    }

    /// The same view with other pixels; the vertical field of view stays.
    ///
    /// # Errors
    /// [`CameraError::Resolution`].
    pub fn with_resolution(&self, resolution: [u32; 2]) -> Result<Self, CameraError> {
        let Self { parts, frame, .. } = Self::new(CameraParts { resolution, ..self.parts })?;
        Ok(Self { parts, frame, ..*self })
    }

    /// Pixels along image x and y.
    pub fn resolution(&self) -> [u32; 2] {
        self.parts.resolution
    }

    /// The angle between rays through neighbouring pixels in the middle of the image, radian; 0 of
    /// parallel rays.
    pub(crate) fn pixel_angle(&self) -> f64 {
        match self.projection {
            Projection::Perspective => self.frame.step_x.length(),
            Projection::Orthographic { .. } => 0.0,
            Projection::Panoramic => TAU / f64::from(self.parts.resolution[0]),
        }
    }

    /// Width of a pixel at the camera, scene units, and how much it grows per unit of distance.
    pub(crate) fn pixel_width(&self) -> [f64; 2] {
        match self.projection {
            Projection::Orthographic { .. } => [self.frame.step_x.length(), 0.0],
            Projection::Perspective | Projection::Panoramic => [0.0, self.pixel_angle()],
        }
    }

    /// How the image plane is reached.
    pub fn projection(&self) -> Projection {
        self.projection
    }

    /// Whether its rays depend on a point of the lens.
    pub fn has_lens(&self) -> bool {
        self.lens.is_some()
    }

    /// Whether its rays start and go elsewhere at other times.
    pub fn moves(&self) -> bool {
        self.end.is_some()
    }

    /// The ray through a point of the image in continuous pixel coordinates: (0, 0) is the top
    /// left corner, the centre of pixel (i, j) is (i + 0.5, j + 0.5). Through the middle of the lens,
    /// when the shutter opens.
    ///
    /// But for panoramas, whose directions are unit vectors, the direction's part along the view
    /// axis is 1, so a hit's `t` is its camera-space depth.
    #[inline]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        self.sample(x, y, DVec2::splat(0.5), 0.0)
    }

    /// The same through the point of the lens and at the time between opening and closing that
    /// numbers in `[0, 1)` stand for, uniformly. A pinhole ignores the one; of a camera at rest the other
    /// is the time of the ray and nothing else.
    #[inline]
    pub fn sample(&self, x: f64, y: f64, lens: DVec2, time: f64) -> Ray {
        let [open, close] = self.shutter;
        let time = open + time * (close - open);
        let frame = match self.end {
            None => self.frame,
            Some(_) => self.frame_at(time).unwrap_or(self.frame),
        };
        let mut ray = self.through(&frame, x, y, lens);
        ray.time = time;
        ray
    }

    /// The ray of a frame through a point of the image and one of the lens.
    #[inline]
    fn through(&self, frame: &Frame, x: f64, y: f64, lens: DVec2) -> Ray {
        let [width, height] = self.parts.resolution.map(f64::from);
        let (x, y) = (x - 0.5 * width, y - 0.5 * height);
        let ray = match self.projection {
            Projection::Perspective => {
                let direction = frame.forward + x * frame.step_x + y * frame.step_y;
                Ray::new(frame.position, direction)
            }
            Projection::Orthographic { height: tall } => {
                let pixel = tall / height;
                let offset = pixel * (x * frame.right() + y * frame.down());
                Ray::new(frame.position + offset, frame.forward)
            }
            Projection::Panoramic => {
                let (longitude, latitude) = (TAU * x / width, PI * y / height);
                let ([s, c], [down, level]) =
                    (longitude.sin_cos().into(), latitude.sin_cos().into());
                let flat = c * frame.forward + s * frame.right();
                return Ray::new(frame.position, level * flat + down * frame.down());
            }
        };
        match self.lens {
            None => ray,
            Some(through) => {
                let place = through.point(lens);
                let shift = place.x * frame.right() - place.y * frame.down();
                // All rays of one image point meet where it is in focus.
                Ray::new(ray.origin + shift, ray.direction - shift / through.focus_distance)
            }
        }
    }

    /// Where the camera is at a time in `[0, 1]`.
    fn frame_at(&self, time: f64) -> Option<Frame> {
        let CameraParts { position, look_at, up, fov, resolution } = self.parts;
        let begin = Pose { position, look_at, up };
        let pose = self.end.map_or(begin, |end| begin.towards(end, time));
        Frame::new(pose, pixel_of(fov, resolution)).ok()
    }

    /// World space to that of the camera when the shutter opens: x right, y up, looking along -z.
    pub fn camera_from_world(&self) -> DMat4 {
        let frame = self.frame_at(if self.moves() { self.shutter[0] } else { 0.0 });
        let frame = frame.unwrap_or(self.frame);
        let axes = [frame.right(), -frame.down(), -frame.forward];
        let rows = axes.map(|axis| axis.extend(-axis.dot(frame.position)));
        DMat4::from_cols(rows[0], rows[1], rows[2], glam::DVec4::W).transpose()
    }

    /// World space to the image when the shutter opens, in homogeneous coordinates: (0, 0) is the
    /// image's top left corner and (1, 1) its bottom right one, z is 1 over the depth. None of a
    /// panorama, which no matrix can say.
    pub fn image_from_world(&self) -> Option<DMat4> {
        let [width, height] = self.parts.resolution.map(f64::from);
        let image_from_camera = match self.projection {
            Projection::Panoramic => return None,
            Projection::Perspective => {
                // Half the image's height one unit away.
                let half = (0.5 * self.parts.fov.to_radians()).tan();
                let (x, y) = (0.5 * height / (width * half), 0.5 / half);
                DMat4::from_cols_array(&[
                    x, 0.0, 0.0, 0.0, 0.0, -y, 0.0, 0.0, -0.5, -0.5, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0,
                ])
            }
            Projection::Orthographic { height: tall } => {
                let (x, y) = (height / (width * tall), 1.0 / tall);
                DMat4::from_cols_array(&[
                    x, 0.0, 0.0, 0.0, 0.0, -y, 0.0, 0.0, 0.0, 0.0, -1.0, 0.0, 0.5, 0.5, 0.0, 1.0,
                ])
            }
        };
        Some(image_from_camera * self.camera_from_world())
    }
}

/// Side of a pixel on the plane one unit in front of the pinhole.
fn pixel_of(fov: f64, resolution: [u32; 2]) -> f64 {
    2.0 * (0.5 * fov.to_radians()).tan() / f64::from(resolution[1])
}

#[cfg(test)]
mod tests;
