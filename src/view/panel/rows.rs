// SPDX-License-Identifier: MIT OR Apache-2.0
//! Keys of the scene, a row each: name, range, value, and a way back to its default.

use super::Ask;
use crate::scene::{Given, Parameter, Takes};
use egui::{RichText, Ui};
use serde_json::Value as Json;

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
pub(super) fn row(ui: &mut Ui, parameter: &Parameter, scene: &Json, asks: &mut Vec<Ask>) {
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
            Takes::Text | Takes::File => {
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
        Takes::File => {
            "a file, from the folder of the scene, or a name of what comes with whitecap".to_owned()
        }
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
