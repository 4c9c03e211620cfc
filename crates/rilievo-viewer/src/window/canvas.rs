//! The picture, and what mouse and keys do over it.

use eframe::egui::{Color32, Key, PointerButton, Pos2, Rect, Sense, Stroke, StrokeKind, Ui, Vec2};
use glam::{DVec2, DVec3};
use rilievo_viewer::brush::Dab;
use rilievo_viewer::navigation;
use rilievo_viewer::passes::fitted;
use rilievo_viewer::session::{Action, Change};
use rilievo_viewer::studio::{PaintError, Painting, Touch};

use super::hand::{Hand, Other};
use super::picture::draw_wipe;
use super::state::Viewer;

/// How far the mouse turns the camera, radian a point.
const TURN: f64 = 0.007;
/// How far from the wipe the mouse takes hold of it, points.
const REACH: f32 = 8.0;

pub fn show(viewer: &mut Viewer, ui: &mut Ui) {
    let (all, response) = ui.allocate_exact_size(ui.available_size(), Sense::click_and_drag());
    let scale = ui.ctx().pixels_per_point();
    let window = [all.width(), all.height()].map(|n| (n * scale).max(1.0) as u32);
    let size = fitted(viewer.session.camera.resolution, window);
    if size != viewer.size {
        viewer.size = size;
        viewer.need(Change::Rendered);
    }
    let points = Vec2::new(size[0] as f32, size[1] as f32) / scale;
    let rect = Rect::from_center_size(all.center(), points);
    viewer.journal.widget("picture", rect, scale);

    let painter = ui.painter_at(all);
    let compared = !matches!(viewer.other, Other::Nothing);
    let edge = if compared { viewer.wipe } else { 1.0 };
    viewer.sides[0].draw(&painter, rect, [0.0, edge]);
    if compared {
        viewer.sides[1].draw(&painter, rect, [edge, 1.0]);
        let knob = draw_wipe(&painter, rect, edge);
        viewer.journal.widget("wipe", knob, scale);
    }
    keys(viewer, ui, response.hovered());
    let pointer = response.interact_pointer_pos().or(response.hover_pos());
    let Some(pointer) = pointer else {
        lift(viewer);
        return;
    };
    if compared && wipe(viewer, ui, &response, rect, pointer) {
        return;
    }
    let share = (pointer - rect.min) / rect.size();
    let at = DVec2::new(f64::from(share.x), f64::from(share.y));
    let inside = rect.contains(pointer);
    match viewer.hand {
        Hand::Paint => {
            let radius = viewer.brush.radius;
            paint(viewer, ui, &response, inside.then_some(at));
            // About as large as the brush is: the picture of a map is as wide as the window.
            let shown = brush_points(viewer, rect, at, radius);
            painter.circle_stroke(pointer, shown, Stroke::new(1.5, Color32::WHITE));
        }
        Hand::Pick if response.clicked() && inside => pick(viewer, at),
        Hand::Move | Hand::Pick => {}
    }
    if response.double_clicked() && viewer.hand == Hand::Move {
        look_at(viewer, at);
    }
    drag(viewer, ui, &response, points);
    if response.hovered() {
        let wheel = ui.input(|input| input.smooth_scroll_delta().y);
        if wheel != 0.0 {
            let camera = navigation::zoom(viewer.session.camera, (-0.004 * f64::from(wheel)).exp());
            viewer.act(Action::Camera(camera));
        }
    }
    if let Some(pick) = viewer.pick.as_ref().filter(|_| viewer.hand == Hand::Pick) {
        mark(&painter, rect, viewer, pick.position);
    }
}

/// Turns and moves the camera.
fn drag(viewer: &mut Viewer, ui: &Ui, response: &eframe::egui::Response, points: Vec2) {
    let by = response.drag_delta();
    if by == Vec2::ZERO {
        return;
    }
    let camera = viewer.session.camera;
    let turn = -TURN * DVec2::new(f64::from(by.x), f64::from(-by.y));
    let pan = DVec2::new(f64::from(-by.x), f64::from(by.y)) / f64::from(points.y);
    let shift = ui.input(|input| input.modifiers.shift);
    let moved = if response.dragged_by(PointerButton::Middle) {
        navigation::pan(camera, pan)
    } else if response.dragged_by(PointerButton::Secondary) {
        navigation::look(camera, DVec2::new(turn.x, -turn.y))
    } else if viewer.hand == Hand::Paint {
        return;
    } else if shift {
        navigation::pan(camera, pan)
    } else {
        navigation::orbit(camera, turn)
    };
    viewer.act(Action::Camera(moved));
}

/// Flies, and frames.
fn keys(viewer: &mut Viewer, ui: &Ui, hovered: bool) {
    if ui.ctx().egui_wants_keyboard_input() || !hovered {
        return;
    }
    let (way, step, framed) = ui.input(|input| {
        let axis = |plus: Key, minus: Key| {
            f64::from(i8::from(input.key_down(plus)) - i8::from(input.key_down(minus)))
        };
        let held = input.modifiers.command;
        let way = DVec3::new(axis(Key::D, Key::A), axis(Key::Q, Key::E), axis(Key::W, Key::S));
        let speed = if input.modifiers.shift { 3.0 } else { 0.7 };
        let step = speed * f64::from(input.stable_dt.min(0.1));
        (if held { DVec3::ZERO } else { way }, step, input.key_pressed(Key::F))
    });
    if way != DVec3::ZERO {
        let camera = viewer.session.camera;
        let reach = (camera.look_at - camera.position).length();
        viewer.act(Action::Camera(navigation::fly(camera, way * step * reach)));
        ui.ctx().request_repaint();
    }
    if framed {
        let bounds = viewer.worker.with_shown(|shown| shown.scene.world().bounds());
        if let Some(bounds) = bounds.filter(|b| b.min.is_finite() && b.max.is_finite()) {
            let (center, radius) = ((bounds.min + bounds.max) * 0.5, bounds.max - bounds.min);
            let camera = navigation::frame(viewer.session.camera, center, 0.5 * radius.length());
            viewer.act(Action::Camera(camera));
        }
    }
}

/// Drags the wipe; whether the mouse has hold of it.
fn wipe(
    viewer: &mut Viewer,
    ui: &Ui,
    response: &eframe::egui::Response,
    rect: Rect,
    pointer: Pos2,
) -> bool {
    let x = rect.min.x + viewer.wipe * rect.width();
    if response.drag_started() {
        // A quick hand is far away before it counts as dragging.
        let pressed = ui.input(|input| input.pointer.press_origin()).unwrap_or(pointer);
        viewer.wiping = (pressed.x - x).abs() <= REACH;
    }
    if response.drag_stopped() {
        viewer.wiping = false;
    }
    if viewer.wiping {
        viewer.wipe = ((pointer.x - rect.min.x) / rect.width()).clamp(0.0, 1.0);
    }
    viewer.wiping
}

fn pick(viewer: &mut Viewer, at: DVec2) {
    viewer.pick = viewer.worker.pick(at);
    if let Some(pick) = &viewer.pick {
        let shape = pick.shape as usize;
        if let Some(place) = viewer.session.shapes.iter().position(|s| s.index == shape) {
            viewer.session.selected = place;
        }
    }
}

fn look_at(viewer: &mut Viewer, at: DVec2) {
    if let Some(pick) = viewer.worker.pick(at) {
        let mut camera = viewer.session.camera;
        camera.look_at = pick.position;
        viewer.act(Action::Camera(camera));
    }
}

/// Touches the map while the left button is down.
fn paint(viewer: &mut Viewer, ui: &Ui, response: &eframe::egui::Response, at: Option<DVec2>) {
    let down = response.is_pointer_button_down_on() && ui.input(|i| i.pointer.primary_down());
    let Some(at) = at.filter(|_| down) else {
        lift(viewer);
        return;
    };
    let Some(pick) = viewer.worker.pick(at) else { return };
    let Some((map, _)) = pick.map else {
        if !viewer.brush.down {
            viewer.message = Some(Err(PaintError::NoMap.to_string()));
        }
        return;
    };
    if !viewer.brush.down {
        viewer.brush.down = true;
        viewer.brush.stroke += 1;
        viewer.session.painted(viewer.brush.stroke);
    }
    let brush = &viewer.brush;
    let dab = Dab { tool: brush.tool, at: map, radius: brush.radius, strength: brush.strength };
    let touch = Touch { stroke: brush.stroke, surface: pick.surface, dab };
    viewer.paint(Painting::Touch(touch));
    ui.ctx().request_repaint();
}

fn lift(viewer: &mut Viewer) {
    viewer.brush.down = false;
}

/// The radius of the brush on the screen, where it is.
fn brush_points(viewer: &Viewer, rect: Rect, at: DVec2, radius: f64) -> f32 {
    let Some(pick) = viewer.worker.pick(at) else { return 4.0 };
    let near = viewer.worker.pick(at + DVec2::new(0.01, 0.0));
    let (Some((here, size)), Some((there, _))) = (pick.map, near.and_then(|near| near.map)) else {
        return 4.0;
    };
    let samples = ((there - here) * DVec2::new(f64::from(size[0]), f64::from(size[1]))).length();
    let points = 0.01 * f64::from(rect.width()) * radius / samples.max(1e-9);
    (points as f32).clamp(2.0, 400.0)
}

/// A cross where something was picked.
fn mark(painter: &eframe::egui::Painter, rect: Rect, viewer: &Viewer, position: DVec3) {
    let seen = viewer.worker.with_shown(|shown| shown.scene.camera().image_from_world()).flatten();
    let Some(seen) = seen else { return };
    let clip = seen * position.extend(1.0);
    if clip.w <= 0.0 {
        return;
    }
    let ndc = clip.truncate() / clip.w;
    let place = Vec2::new(ndc.x as f32, ndc.y as f32) * rect.size();
    let cross = Rect::from_center_size(rect.min + place, Vec2::splat(9.0));
    painter.rect_stroke(cross, 1.0, Stroke::new(1.5, Color32::RED), StrokeKind::Middle);
}
