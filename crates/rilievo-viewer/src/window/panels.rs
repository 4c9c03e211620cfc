//! The panels at the left, and the line below.

use eframe::egui::{
    Button, CollapsingHeader, Color32, ComboBox, DragValue, Grid, Rect, RichText, Sense, Slider,
    Ui, Vec2,
};
use rilievo::map::Layout;
use rilievo::relief::Method;
use rilievo_gpu::Backend;
use rilievo_render::film::tonemap::View;
use rilievo_render::{Aov, Integrator};
use rilievo_viewer::brush::Tool;
use rilievo_viewer::session::{Action, Change, Look, Preset, Sun};

use super::hand::{Hand, Other};
use super::state::Viewer;

/// Everything at the left.
pub fn controls(viewer: &mut Viewer, ui: &mut Ui) {
    ui.spacing_mut().slider_width = 130.0;
    ui.horizontal(|ui| {
        for hand in Hand::ALL {
            ui.selectable_value(&mut viewer.hand, hand, hand.name());
        }
        ui.separator();
        if ui.button("Undo").clicked() {
            viewer.undo();
        }
        if ui.button("Redo").clicked() {
            viewer.redo();
        }
    });
    if viewer.session.bare {
        presets(viewer, ui);
    }
    section(ui, "Relief", true, |ui| relief(viewer, ui));
    section(ui, "Light and picture", true, |ui| light(viewer, ui));
    section(ui, "Render", true, |ui| render(viewer, ui));
    section(ui, "Compare", false, |ui| compare(viewer, ui));
    if viewer.hand == Hand::Paint {
        section(ui, "Brush", true, |ui| brush(viewer, ui));
    }
    section(ui, "Heights", true, |ui| heights(viewer, ui));
    section(ui, "Under the mouse", viewer.pick.is_some(), |ui| picked(viewer, ui));
    let place = header(ui, "Save", false, |ui| viewer.save_panel(ui));
    viewer.journal.widget("Save", place, ui.ctx().pixels_per_point());
    section(ui, "Mouse and keys", false, keys);
}

fn section(ui: &mut Ui, name: &str, open: bool, add: impl FnOnce(&mut Ui)) {
    header(ui, name, open, add);
}

/// A section; where its name stands.
fn header(ui: &mut Ui, name: &str, open: bool, add: impl FnOnce(&mut Ui)) -> Rect {
    let header = CollapsingHeader::new(RichText::new(name).strong()).default_open(open);
    header.show(ui, add).header_response.rect
}

/// The line below the picture.
pub fn status(viewer: &Viewer, ui: &mut Ui) {
    ui.horizontal(|ui| {
        ui.label(format!("{} x {}  {}", viewer.size[0], viewer.size[1], viewer.progress));
        let renders = ui.weak(&viewer.renders);
        if let Some(why) = &viewer.why {
            renders.on_hover_text(&why.text);
        }
        if let Some(message) = &viewer.message {
            let (Ok(text) | Err(text)) = message;
            let first = RichText::new(text.lines().next().unwrap_or_default());
            let trouble = Color32::from_rgb(240, 120, 90);
            let first = if message.is_ok() { first } else { first.color(trouble) };
            ui.label(first).on_hover_text(text);
        } else if let Some(note) = viewer.notes.first() {
            ui.weak(note).on_hover_text(viewer.notes.join("\n"));
        }
    });
}

/// Where a slider begins and ends, its step (0: any) and the unit behind its number.
type Scale = ([f64; 2], f64, &'static str);

/// A slider that acts when it is moved; its place is told to scripts.
fn slider(
    viewer: &mut Viewer,
    ui: &mut Ui,
    (name, value): (&'static str, f64),
    (ends, step, unit): Scale,
    action: impl FnOnce(f64) -> Action,
) {
    let mut now = value;
    // Numbers beyond the ends stay as they are until the slider is moved.
    let ends = [ends[0].min(value), ends[1].max(value)];
    let slider = Slider::new(&mut now, ends[0]..=ends[1]).text(name).suffix(unit).step_by(step);
    // Five of an angle would push its name out of the panel.
    let decimals = if unit == "°" { 1 } else { 5 };
    let response = ui.add(slider.max_decimals(decimals));
    viewer.journal.widget(name, response.rect, ui.ctx().pixels_per_point());
    if response.changed() && now != value {
        viewer.act(action(now));
    }
}

fn presets(viewer: &mut Viewer, ui: &mut Ui) {
    ui.horizontal(|ui| {
        for preset in Preset::ALL {
            let can = preset != Preset::Mesh || viewer.session.mesh.is_some();
            let button = Button::selectable(viewer.session.preset == preset, preset.name());
            let response = ui.add_enabled(can, button);
            viewer.journal.widget(preset.name(), response.rect, ui.ctx().pixels_per_point());
            if response.on_disabled_hover_text("start with --mesh MODEL").clicked() {
                viewer.act(Action::Preset(preset));
            }
        }
    });
}

fn relief(viewer: &mut Viewer, ui: &mut Ui) {
    let Some(shape) = viewer.session.shape().cloned() else {
        ui.weak("no shape of this scene is displaced");
        return;
    };
    if viewer.session.shapes.len() > 1 {
        let shown = format!("{} ({})", shape.name, shape.map);
        let before = viewer.session.selected;
        ComboBox::from_id_salt("shape").selected_text(shown).show_ui(ui, |ui| {
            for (place, shape) in viewer.session.shapes.iter().enumerate() {
                let name = format!("{} ({})", shape.name, shape.map);
                ui.selectable_value(&mut viewer.session.selected, place, name);
            }
        });
        ui.checkbox(&mut viewer.session.together, "all with this map");
        if viewer.session.selected != before {
            viewer.histogram_anew();
        }
    }
    if shape.terrain {
        let factor = viewer.session.document().exaggeration(shape.index);
        let ends = ([0.1, 10.0], 0.1, "");
        slider(viewer, ui, ("exaggeration", factor), ends, Action::Exaggeration);
    } else {
        let laid = shape.displacement;
        let most = viewer.deepest();
        let ends = ([-most, most], most / 1000.0, "");
        slider(viewer, ui, ("depth", laid.scale), ends, Action::Depth);
        slider(viewer, ui, ("zero", laid.zero), ([0.0, 1.0], 0.0, ""), Action::Zero);
        let ratio = laid.tile[1] / laid.tile[0];
        let both = |u| Action::Tile([u, ratio * u]);
        slider(viewer, ui, ("tile", laid.tile[0]), ([0.25, 8.0], 0.25, ""), both);
    }
    let material = viewer.session.document().material(shape.index);
    let rough = material.map_or(0.3, |name| viewer.session.document().roughness(&name));
    slider(viewer, ui, ("roughness", rough), ([0.0, 1.0], 0.0, ""), Action::Roughness);
}

fn light(viewer: &mut Viewer, ui: &mut Ui) {
    match viewer.session.document().sun() {
        None => {
            if ui.button("Add a sun").clicked() {
                viewer.act(Action::Sun(Sun::default()));
            }
        }
        Some(sun) => {
            let turned = |azimuth| Action::Sun(Sun { azimuth, ..sun });
            slider(viewer, ui, ("sun from", sun.azimuth), ([-180.0, 180.0], 0.0, "°"), turned);
            let lifted = |elevation| Action::Sun(Sun { elevation, ..sun });
            slider(viewer, ui, ("sun height", sun.elevation), ([0.0, 90.0], 0.0, "°"), lifted);
            let strong = |strength| Action::Sun(sun.with_strength(strength));
            slider(viewer, ui, ("strength", sun.strength()), ([0.0, 20.0], 0.0, ""), strong);
            let soft = |angle| Action::Sun(Sun { angle, ..sun });
            slider(viewer, ui, ("softness", sun.angle), ([0.0, 30.0], 0.0, "°"), soft);
        }
    }
    let exposure = viewer.session.tone_map.exposure;
    slider(viewer, ui, ("exposure", exposure), ([-6.0, 6.0], 0.0, ""), Action::Exposure);
    let view = viewer.session.tone_map.view;
    if let Some(view) = choose(ui, "view", view, View::ALL, View::name) {
        viewer.act(Action::View(view));
    }
}

fn render(viewer: &mut Viewer, ui: &mut Ui) {
    let looks = std::iter::once(Look::Colour).chain(Aov::ALL.map(Look::Layer));
    if let Some(look) = choose(ui, "show", viewer.session.look, looks, Look::name) {
        viewer.act(Action::Look(look));
    }
    let settings = viewer.session.settings;
    let all = [Integrator::Distributed, Integrator::Path];
    if let Some(chosen) = choose(ui, "integrator", settings.integrator, all, Integrator::name) {
        viewer.act(Action::Integrator(chosen));
    }
    if let Some(method) = choose(ui, "method", viewer.session.method, Method::ALL, Method::name) {
        viewer.act(Action::Method(method));
    }
    let layouts = [Layout::Default, Layout::Tiny];
    if let Some(layout) = choose(ui, "layout", viewer.session.layout, layouts, Layout::name) {
        viewer.act(Action::Layout(layout));
    }
    if let Some(backend) = choose(ui, "backend", viewer.backend, Backend::ALL, Backend::name) {
        viewer.backend = backend;
        viewer.need(Change::Rendered);
    }
    let mut samples = settings.samples;
    let drag = DragValue::new(&mut samples).range(1..=65_536).suffix(" samples");
    if ui.add(drag).changed() {
        viewer.act(Action::Samples(samples));
    }
}

/// A box with a list; what was chosen, if it is another one.
fn choose<T: Copy + PartialEq>(
    ui: &mut Ui,
    label: &str,
    now: T,
    all: impl IntoIterator<Item = T>,
    name: impl Fn(T) -> &'static str,
) -> Option<T> {
    let mut chosen = now;
    ComboBox::from_label(label).selected_text(name(now)).show_ui(ui, |ui| {
        for one in all {
            ui.selectable_value(&mut chosen, one, name(one));
        }
    });
    (chosen != now).then_some(chosen)
}

fn compare(viewer: &mut Viewer, ui: &mut Ui) {
    let named = match &viewer.other {
        Other::Nothing => "nothing",
        Other::Method(method) => method.name(),
        Other::Scene(_) => "another scene",
    };
    let mut chosen = None;
    ComboBox::from_label("beyond the wipe").selected_text(named).show_ui(ui, |ui| {
        if ui.selectable_label(named == "nothing", "nothing").clicked() {
            chosen = Some(Other::Nothing);
        }
        for method in Method::ALL {
            if ui.selectable_label(named == method.name(), method.name()).clicked() {
                chosen = Some(Other::Method(method));
            }
        }
    });
    if let Some(other) = chosen {
        viewer.other = other;
        viewer.need(Change::Scene);
    }
    ui.weak("Drag the white line. Another file: --compare.");
}

fn brush(viewer: &mut Viewer, ui: &mut Ui) {
    let brush = &mut viewer.brush;
    ui.horizontal(|ui| {
        for tool in Tool::ALL {
            ui.selectable_value(&mut brush.tool, tool, tool.name());
        }
    });
    ui.add(Slider::new(&mut brush.radius, 1.0..=1000.0).logarithmic(true).text("samples wide"));
    ui.add(Slider::new(&mut brush.strength, 0.001..=1.0).logarithmic(true).text("strength"));
}

fn heights(viewer: &Viewer, ui: &mut Ui) {
    let Some(histogram) = &viewer.histogram else {
        ui.weak("of displaced shapes");
        return;
    };
    let (rect, _) = ui.allocate_exact_size(Vec2::new(250.0, 60.0), Sense::hover());
    let painter = ui.painter_at(rect);
    painter.rect_filled(rect, 2.0, ui.visuals().extreme_bg_color);
    let most = histogram.counts.iter().copied().max().unwrap_or(1).max(1) as f32;
    let width = rect.width() / histogram.counts.len() as f32;
    for (bin, &count) in histogram.counts.iter().enumerate() {
        let height = rect.height() * count as f32 / most;
        let left = rect.min.x + width * bin as f32;
        let bar = Rect::from_min_max(
            (left, rect.max.y - height).into(),
            (left + width, rect.max.y).into(),
        );
        painter.rect_filled(bar, 0.0, Color32::from_rgb(150, 180, 210));
    }
    let [low, high] = histogram.range;
    if let Some(shape) = viewer.session.shape() {
        let zero = ((shape.displacement.zero - low) / (high - low).max(1e-300)) as f32;
        if (0.0..=1.0).contains(&zero) {
            let x = rect.min.x + zero * rect.width();
            painter.vline(x, rect.y_range(), (1.0, Color32::from_rgb(240, 160, 60)));
        }
    }
    ui.weak(format!("{low:.4} to {high:.4}; the line is zero"));
}

fn picked(viewer: &Viewer, ui: &mut Ui) {
    let Some(pick) = &viewer.pick else {
        ui.weak("take the tool Pick and click");
        return;
    };
    let rows = [
        ("shape", format!("{}", pick.shape + 1)),
        ("u, v", format!("{:.5}, {:.5}", pick.uv.x, pick.uv.y)),
        ("height", format!("{:.5}", pick.height)),
        ("normal", format!("{:.3}, {:.3}, {:.3}", pick.normal.x, pick.normal.y, pick.normal.z)),
        (
            "position",
            format!("{:.4}, {:.4}, {:.4}", pick.position.x, pick.position.y, pick.position.z),
        ),
        (
            "steps",
            format!(
                "{} ({} nodes, {} cells, {} steps)",
                pick.work.total(),
                pick.work.nodes,
                pick.work.cells,
                pick.work.steps
            ),
        ),
    ];
    Grid::new("picked").show(ui, |ui| {
        for (name, value) in rows {
            ui.weak(name);
            ui.label(value);
            ui.end_row();
        }
    });
}

fn keys(ui: &mut Ui) {
    Grid::new("keys").show(ui, |ui| {
        for (what, does) in [
            ("left button", "orbit; Shift: pan"),
            ("middle button", "pan"),
            ("right button", "turn the head"),
            ("wheel", "zoom"),
            ("double click", "look there"),
            ("W A S D Q E", "fly; Shift: faster"),
            ("F", "frame everything"),
            ("1 2 3", "Move, Pick, Paint"),
            ("Ctrl+Z, Ctrl+Y", "undo, redo"),
            ("Ctrl+S", "save the scene"),
            ("Ctrl+Q", "close the window"),
        ] {
            ui.weak(what);
            ui.label(does);
            ui.end_row();
        }
    });
}
