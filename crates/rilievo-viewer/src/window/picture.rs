//! [`Shown`]: the frames as textures, and the wipe between them.

use std::sync::Arc;

use eframe::egui::{
    Color32, ColorImage, Context, Painter, Pos2, Rect, Stroke, TextureHandle, TextureOptions, Vec2,
};
use rilievo_render::film::tonemap::ToneMap;
use rilievo_viewer::passes::Frame;
use rilievo_viewer::save;

/// A frame on the graphics card.
#[derive(Default)]
pub struct Uploaded {
    frame: Option<(Arc<Frame>, ToneMap)>,
    texture: Option<TextureHandle>,
}

impl Uploaded {
    /// Shows a frame; uploads it if it is another one, or shown otherwise. Says whether it was.
    pub fn show(&mut self, context: &Context, frame: Option<&Arc<Frame>>, map: ToneMap) -> bool {
        let Some(frame) = frame else {
            *self = Self::default();
            return false;
        };
        if let Some((old, old_map)) = &self.frame
            && Arc::ptr_eq(old, frame)
            && *old_map == map
        {
            return false;
        }
        let size = frame.size.map(|n| n as usize);
        let codes = save::codes(frame, &map);
        let image = ColorImage::from_rgb(size, codes.as_flattened());
        // Coarse pictures are smooth, so that they look like what they will be.
        match &mut self.texture {
            Some(texture) => texture.set(image, TextureOptions::LINEAR),
            None => {
                self.texture = Some(context.load_texture("picture", image, TextureOptions::LINEAR));
            }
        }
        self.frame = Some((Arc::clone(frame), map));
        true
    }

    /// The frame that is shown.
    pub fn frame(&self) -> Option<&Arc<Frame>> {
        self.frame.as_ref().map(|(frame, _)| frame)
    }

    /// Draws the part of the picture in `rect` between two shares of its width.
    pub fn draw(&self, painter: &Painter, rect: Rect, [from, to]: [f32; 2]) {
        let Some(texture) = &self.texture else { return };
        let at = |share: f32| rect.min.x + share * rect.width();
        let part =
            Rect::from_min_max(Pos2::new(at(from), rect.min.y), Pos2::new(at(to), rect.max.y));
        let uv = Rect::from_min_max(Pos2::new(from, 0.0), Pos2::new(to, 1.0));
        painter.image(texture.id(), part, uv, Color32::WHITE);
    }
}

/// Draws the wipe at a share of the width; where its knob is.
pub fn draw_wipe(painter: &Painter, rect: Rect, share: f32) -> Rect {
    let x = rect.min.x + share * rect.width();
    painter.vline(x, rect.y_range(), Stroke::new(1.5, Color32::WHITE));
    let knob = Rect::from_center_size(Pos2::new(x, rect.center().y), Vec2::new(8.0, 36.0));
    painter.rect_filled(knob, 3.0, Color32::WHITE);
    knob
}
