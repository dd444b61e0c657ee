// SPDX-License-Identifier: MIT OR Apache-2.0
//! The panel: what runs, what it costs, and every key of the scene with its range and unit.

use super::{
    camera::Mode,
    keys::{Action, KEYS},
    times::History,
};
use crate::{
    run::Counters,
    scene::{Given, Parameter, Takes},
};
use egui::{Color32, RichText, Sense, Ui};
use serde_json::Value as Json;

/// What is asked for in the panel.
#[derive(Clone, Debug, PartialEq)]
pub enum Ask {
    /// What a key does too.
    Do(Action),
    /// A key gets numbers; all are whole or none is.
    Numbers(String, Vec<f64>, bool),
    /// A key gets a text.
    Text(String, String),
    /// A key gets a flag.
    Flag(String, bool),
    /// A key is left to its default.
    Remove(String),
    /// The edited scene is written to a file.
    Save,
    /// So many seconds of the scene pass in one.
    Pace(f64),
}

/// What the panel is filled with.
pub struct Contents<'a> {
    /// Title of the scene.
    pub title: &'a str,
    /// Device, driver and size of the picture.
    pub device: &'a str,
    /// Of the scene (s).
    pub time_s: f64,
    /// Frames in a second, of late.
    pub frames_per_s: f64,
    /// Time stands.
    pub is_paused: bool,
    /// Seconds of the scene in one.
    pub pace: f64,
    /// Of the camera.
    pub mode: Mode,
    /// A hand has reached in, or numbers have changed: the run is no longer the scene's from its start.
    pub is_touched: bool,
    /// The scene is not what its file says.
    pub is_edited: bool,
    /// Of the last frames.
    pub times: &'a History,
    /// What clock they are by.
    pub clock: &'a str,
    /// Of every simulation, if they are asked for.
    pub counters: &'a [Counters],
    /// Every key.
    pub parameters: &'a [Parameter],
    /// The scene with its defaults filled in.
    pub scene: &'a Json,
    /// What went wrong, and the last word on what went well.
    pub error: Option<&'a str>,
    /// See `error`.
    pub note: Option<&'a str>,
}

/// What the panel remembers.
#[derive(Default)]
pub struct Panel {
    /// It is not hidden.
    pub is_open: bool,
    /// Passes are to be timed.
    pub has_times: bool,
    /// Counters are to be read.
    pub has_counters: bool,
    filter: String,
}

impl Panel {
    /// Lays it out; what is asked for goes to `asks`.
    pub fn show(&mut self, ui: &mut Ui, contents: &Contents<'_>, asks: &mut Vec<Ask>) {
        let panel = egui::Panel::left("panel").resizable(true).default_size(310.0);
        panel.show(ui, |ui| {
            egui::ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
                self.head(ui, contents, asks);
                ui.separator();
                let times = egui::CollapsingHeader::new("GPU time").default_open(self.has_times);
                let shown = times.show(ui, |ui| bars(ui, contents.times, contents.clock));
                self.has_times = shown.openness > 0.5;
                let counters = egui::CollapsingHeader::new("Counters").default_open(self.has_counters);
                let shown = counters.show(ui, |ui| count(ui, contents.counters));
                self.has_counters = shown.openness > 0.5;
                let scene = egui::CollapsingHeader::new("Scene").default_open(true);
                scene.show(ui, |ui| self.parameters(ui, contents, asks));
                let keys = egui::CollapsingHeader::new("Keys").default_open(false);
                keys.show(ui, help);
            });
        });
    }

    fn head(&mut self, ui: &mut Ui, contents: &Contents<'_>, asks: &mut Vec<Ask>) {
        ui.heading(contents.title);
        ui.label(RichText::new(contents.device).small().weak());
        let touched = if contents.is_touched { ", touched" } else { "" };
        ui.label(format!("{:.2} s{touched}   {:.0} pictures/s", contents.time_s, contents.frames_per_s));
        ui.horizontal_wrapped(|ui| {
            let mut button = |ui: &mut Ui, text: &str, action: Action| {
                if ui.button(text).clicked() {
                    asks.push(Ask::Do(action));
                }
            };
            button(ui, if contents.is_paused { "Go on" } else { "Pause" }, Action::Pause);
            button(ui, "Step", Action::Step);
            button(ui, "Restart", Action::Restart);
            button(ui, "Screenshot", Action::Screenshot);
            button(ui, "Reload", Action::Reload);
        });
        ui.horizontal(|ui| {
            ui.label("Pace");
            let mut pace = contents.pace;
            let slider = egui::Slider::new(&mut pace, 0.05..=4.0).logarithmic(true).suffix(" x");
            if ui.add(slider).changed() {
                asks.push(Ask::Pace(pace));
            }
        });
        ui.horizontal_wrapped(|ui| {
            ui.label("Camera");
            let modes = [
                ("Home", Action::Home, Some(Mode::Home)),
                ("Orbit", Action::Orbit, Some(Mode::Orbit)),
                ("Fly", Action::Fly, Some(Mode::Fly)),
                ("All", Action::Fit, None),
            ];
            for (text, action, mode) in modes {
                if ui.selectable_label(mode == Some(contents.mode), text).clicked() {
                    asks.push(Ask::Do(action));
                }
            }
        });
        if let Some(error) = contents.error {
            ui.label(RichText::new(error).monospace().small().color(Color32::from_rgb(255, 130, 110)));
        } else if let Some(note) = contents.note {
            ui.label(RichText::new(note).small().weak());
        }
    }

    fn parameters(&mut self, ui: &mut Ui, contents: &Contents<'_>, asks: &mut Vec<Ask>) {
        ui.horizontal(|ui| {
            let save = ui.add_enabled(contents.is_edited, egui::Button::new("Save as edited"));
            if save.clicked() {
                asks.push(Ask::Save);
            }
            ui.add(egui::TextEdit::singleline(&mut self.filter).hint_text("find a key").desired_width(120.0));
        });
        let filter = self.filter.trim().to_lowercase();
        let mut tables: Vec<&str> = Vec::new();
        for parameter in contents.parameters {
            if !tables.contains(&parameter.table()) {
                tables.push(parameter.table());
            }
        }
        for table in tables {
            let all = contents.parameters.iter().filter(|it| it.table() == table);
            let shown: Vec<_> = all.filter(|it| filter.is_empty() || it.path.contains(&filter)).collect();
            if shown.is_empty() {
                continue;
            }
            let is_main = table.split('.').count() == 2 && !filter.is_empty();
            let title = if table.is_empty() { "scene" } else { table };
            let header = egui::CollapsingHeader::new(title).id_salt(("table", table)).default_open(false);
            header.open((is_main || !filter.is_empty()).then_some(true)).show(ui, |ui| {
                let grid = egui::Grid::new(("grid", table)).num_columns(2).striped(true);
                grid.show(ui, |ui| {
                    for parameter in shown {
                        row(ui, parameter, contents.scene, asks);
                        ui.end_row();
                    }
                });
            });
        }
    }
}

/// What the scene has where its file says nothing.
fn default_of<'a>(scene: &'a Json, path: &str) -> Option<&'a Json> {
    path.split('.').try_fold(scene, |at, part| match part.parse::<usize>() {
        Ok(index) => at.get(index),
        Err(_) => at.get(part),
    })
}

fn numbers_of(json: &Json) -> Option<Vec<f64>> {
    match json {
        Json::Number(x) => x.as_f64().map(|x| vec![x]),
        Json::Array(items) => items.iter().map(Json::as_f64).collect(),
        _ => None,
    }
}

/// One key: its name and range, its value to be changed, and a way back to its default.
fn row(ui: &mut Ui, parameter: &Parameter, scene: &Json, asks: &mut Vec<Ask>) {
    let is_given = parameter.given.is_some();
    let name = RichText::new(parameter.key());
    let name = if is_given { name } else { name.weak() };
    ui.label(name).on_hover_text(about(parameter));
    let default = default_of(scene, &parameter.path);
    ui.horizontal(|ui| {
        match &parameter.takes {
            Takes::Numbers { count, is_whole, range } => {
                let given = match &parameter.given {
                    Some(Given::Numbers(numbers)) => Some(numbers.clone()),
                    _ => default.and_then(numbers_of),
                };
                match given.filter(|numbers| numbers.len() == *count) {
                    Some(mut numbers) => {
                        let before = numbers.clone();
                        for x in &mut numbers {
                            drag(ui, x, *range, *is_whole, parameter.unit());
                        }
                        if numbers != before {
                            asks.push(Ask::Numbers(parameter.path.clone(), numbers, *is_whole));
                        }
                    }
                    None => {
                        if ui.small_button("not set").on_hover_text("give it a value").clicked() {
                            let [least, most] = *range;
                            let start = if least <= 1.0 && most >= 1.0 { 1.0 } else { least };
                            asks.push(Ask::Numbers(parameter.path.clone(), vec![start; *count], *is_whole));
                        }
                    }
                }
            }
            Takes::OneOf(words) => {
                let given = match &parameter.given {
                    Some(Given::Text(text)) => Some(text.as_str()),
                    _ => default.and_then(Json::as_str),
                };
                let combo =
                    egui::ComboBox::from_id_salt(&parameter.path).selected_text(given.unwrap_or("default"));
                combo.show_ui(ui, |ui| {
                    for word in words {
                        if ui.selectable_label(given == Some(word), word).clicked() {
                            asks.push(Ask::Text(parameter.path.clone(), word.clone()));
                        }
                    }
                });
            }
            Takes::OneOfNumbers(choices) => {
                let given = match &parameter.given {
                    Some(Given::Numbers(numbers)) => numbers.first().copied(),
                    _ => default.and_then(Json::as_f64),
                };
                for &choice in choices {
                    let is_this = given == Some(f64::from(choice));
                    if ui.selectable_label(is_this, choice.to_string()).clicked() {
                        asks.push(Ask::Numbers(parameter.path.clone(), vec![choice.into()], true));
                    }
                }
            }
            Takes::Flag => {
                let given = match parameter.given {
                    Some(Given::Flag(flag)) => flag,
                    _ => default.and_then(Json::as_bool).unwrap_or(false),
                };
                let mut flag = given;
                if ui.checkbox(&mut flag, "").changed() {
                    asks.push(Ask::Flag(parameter.path.clone(), flag));
                }
            }
            Takes::Text => {
                let given = match &parameter.given {
                    Some(Given::Text(text)) => text.as_str(),
                    _ => default.and_then(Json::as_str).unwrap_or(""),
                };
                // Typed text is kept until it is finished: half a name is no name.
                let id = ui.make_persistent_id(("text", &parameter.path));
                let kept = ui.data(|data| data.get_temp::<String>(id));
                let mut text = kept.unwrap_or_else(|| given.to_owned());
                let edit = ui.add(egui::TextEdit::singleline(&mut text).desired_width(130.0));
                if edit.lost_focus() {
                    ui.data_mut(|data| data.remove::<String>(id));
                    if text != given {
                        asks.push(Ask::Text(parameter.path.clone(), text));
                    }
                } else if edit.changed() {
                    ui.data_mut(|data| data.insert_temp(id, text));
                }
            }
        }
        if is_given && ui.small_button("x").on_hover_text("back to the default").clicked() {
            asks.push(Ask::Remove(parameter.path.clone()));
        }
    });
}

fn about(parameter: &Parameter) -> String {
    let unit = parameter.unit();
    let takes = match &parameter.takes {
        Takes::Numbers { count, is_whole, range: [least, most] } => {
            let what = match (count, is_whole) {
                (1, true) => "a whole number".to_owned(),
                (1, false) => "a number".to_owned(),
                (n, true) => format!("{n} whole numbers"),
                (n, false) => format!("{n} numbers"),
            };
            match (*least > -f64::MAX, *most < f64::MAX) {
                (true, true) => format!("{what}, {least} to {most} {unit}"),
                (true, false) => format!("{what}, {least} {unit} or more"),
                _ => format!("{what} {unit}"),
            }
        }
        Takes::OneOf(words) => words.join(" or "),
        Takes::OneOfNumbers(choices) => choices.iter().map(u32::to_string).collect::<Vec<_>>().join(" or "),
        Takes::Flag => "true or false".to_owned(),
        Takes::Text => "a text".to_owned(),
    };
    let default = if parameter.given.is_none() { "\nnot in the file: this is its default" } else { "" };
    format!("{}\n{}{default}", parameter.path, takes.trim_end())
}

/// A number to be dragged or typed: by a hundredth of itself a pixel.
fn drag(ui: &mut Ui, x: &mut f64, [least, most]: [f64; 2], is_whole: bool, unit: &str) {
    let speed = if is_whole { (x.abs() * 0.01).max(0.1) } else { (x.abs() * 0.01).max(1e-4) };
    let suffix = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let mut value = egui::DragValue::new(x).range(least..=most).clamp_existing_to_range(false).speed(speed);
    value = if is_whole { value.fixed_decimals(0) } else { value.max_decimals(6) };
    ui.add(value.suffix(suffix));
}

/// Colours that stay apart: equal steps of hue by the golden section.
fn color(i: usize) -> Color32 {
    let hue = (0.58 + 0.618_034 * i as f32).fract();
    egui::ecolor::Hsva::new(hue, 0.62, 0.85, 1.0).into()
}

/// Stacked bars, a frame each, oldest on the left; then each pass with its mean.
fn bars(ui: &mut Ui, times: &History, clock: &str) {
    let longest_ms = times.longest_ms();
    let size = egui::vec2(ui.available_width(), 90.0);
    let (area, _) = ui.allocate_exact_size(size, Sense::hover());
    let painter = ui.painter_at(area);
    painter.rect_filled(area, 2.0, Color32::from_gray(18));
    if longest_ms > 0.0 {
        let frames = times.frames();
        let wide = area.width() / 120.0;
        let first = area.right() - wide * frames.len() as f32;
        for (n, row) in frames.enumerate() {
            let (left, mut bottom) = (first + wide * n as f32, area.bottom());
            for (i, ms) in row.iter().enumerate().filter(|(_, ms)| **ms > 0.0) {
                let top = bottom - area.height() * ms / longest_ms;
                let bar = egui::Rect::from_min_max(egui::pos2(left, top), egui::pos2(left + wide, bottom));
                painter.rect_filled(bar, 0.0, color(i));
                bottom = top;
            }
        }
        let text = format!("{longest_ms:.2} ms");
        let font = egui::FontId::monospace(10.0);
        painter.text(
            area.left_top() + egui::vec2(4.0, 2.0),
            egui::Align2::LEFT_TOP,
            text,
            font,
            Color32::GRAY,
        );
    }
    let means = times.means();
    egui::Grid::new("passes").num_columns(3).show(ui, |ui| {
        for (i, (name, ms)) in means.iter().enumerate() {
            let (swatch, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), Sense::hover());
            ui.painter().rect_filled(swatch, 2.0, color(i));
            ui.label(RichText::new(name).small());
            ui.label(RichText::new(format!("{ms:.3} ms")).small().monospace());
            ui.end_row();
        }
    });
    let note = match clock {
        "gpu" => "Timestamps of the GPU. Timed passes do not overlap.",
        _ => "The host's clock, a submission a pass: this driver's timestamps cannot be believed.",
    };
    ui.label(RichText::new(note).small().weak());
}

fn count(ui: &mut Ui, counters: &[Counters]) {
    for (i, of) in counters.iter().enumerate() {
        ui.label(&of.name);
        egui::Grid::new(("counters", i)).num_columns(2).striped(true).show(ui, |ui| {
            for (what, n) in &of.counts {
                ui.label(RichText::new(*what).small());
                ui.label(RichText::new(n.to_string()).small().monospace());
                ui.end_row();
            }
        });
    }
}

fn help(ui: &mut Ui) {
    egui::Grid::new("keys").num_columns(2).striped(true).show(ui, |ui| {
        for key in &KEYS {
            ui.label(RichText::new(key.name).small().monospace());
            ui.label(RichText::new(key.about).small());
            ui.end_row();
        }
        ui.label(RichText::new("left button").small());
        ui.label(RichText::new("ripples in water, stirs disks, drags emitters").small());
        ui.end_row();
    });
}
