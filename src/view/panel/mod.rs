// SPDX-License-Identifier: MIT OR Apache-2.0
//! The panel: what runs, what it costs, and every key of the scene with its range and unit.

mod rows;

use super::{
    camera::Mode,
    keys::{Action, KEYS},
    times::History,
};
use crate::{run::Counters, scene::Parameter};
use egui::{Color32, RichText, Sense, Ui};
use rows::row;
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
    /// Only keys with this text in their path are shown.
    pub filter: String,
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
    egui::Grid::new("passes").num_columns(2).show(ui, |ui| {
        for (i, (name, ms)) in means.iter().enumerate() {
            ui.horizontal(|ui| {
                let (swatch, _) = ui.allocate_exact_size(egui::vec2(10.0, 10.0), Sense::hover());
                ui.painter().rect_filled(swatch, 2.0, color(i));
                ui.label(RichText::new(name).small());
            });
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
        egui::Grid::new(("counters", i)).num_columns(4).striped(true).show(ui, |ui| {
            for two in of.counts.chunks(2) {
                for (what, n) in two {
                    ui.label(RichText::new(*what).small());
                    ui.label(RichText::new(n.to_string()).small().monospace());
                }
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
