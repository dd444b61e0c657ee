// SPDX-License-Identifier: MIT OR Apache-2.0
//! Work-precision plots: log-log SVG, complete in itself.

use std::fmt::Write;

/// One measurement in a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Mark {
    /// Along the axes.
    pub at: (f64, f64),
    /// What tells it from others of its curve; may be empty.
    pub detail: String,
    /// The curve's line goes through it; others are small dots beside the line.
    pub is_joined: bool,
    /// It is on the Pareto front of all panels.
    pub is_pareto: bool,
}

/// One curve of a panel.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// As the legend shows it; curves of one name share colour, marker and line of the legend, in all panels.
    pub name: String,
    /// Those that are joined, in this order.
    pub marks: Vec<Mark>,
}

/// Curves in one pair of axes. All panels of a plot show the same ranges.
#[derive(Clone, Debug, PartialEq)]
pub struct Panel {
    /// Above the axes; empty if there is one panel only.
    pub title: String,
    /// Those of the first panel are first in the legend.
    pub curves: Vec<Curve>,
}

/// Picture, and the axes rectangle of the first panel (pixels).
const LEFT: f64 = 84.0;
const TOP: f64 = 64.0;
/// Axes rectangle alone, and as one of several (pixels).
const ALONE: (f64, f64) = (520.0, 380.0);
const SMALL: (f64, f64) = (356.0, 262.0);
/// From the end of one panel to the start of the next (pixels).
const GAP: (f64, f64) = (40.0, 78.0);
/// From the last panel to the legend, its width, and its line height (pixels).
const LEGEND_GAP: f64 = 26.0;
const LEGEND_WIDTH: f64 = 230.0;
const LINE: f64 = 21.0;

/// Okabe and Ito's palette without its yellow, which is too light for lines on white, and three more.
const COLOURS: [&str; 10] = [
    "#222222", "#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#7b5bb5", "#8c564b",
    "#7f8c1d",
];

/// Every rule is confined to the plot: the SVG may stand inside a page, whose text has the same classes.
const STYLE: &str =
    ".plot text{font:12.5px system-ui,-apple-system,'Segoe UI',Roboto,Helvetica,Arial,sans-serif;\
    fill:#222}.plot .title{font-size:16px;font-weight:600}.plot .panel{font-weight:600}\
    .plot .label{font-size:13px;fill:#444}.plot .note{font-size:11.5px;fill:#666}\
    .plot .detail{font-size:10px;fill:#555}.plot .major{stroke:#dcdcdc}.plot .minor{stroke:#f1f1f1}\
    .plot .frame{stroke:#777;fill:none}.plot .front{stroke:#c9c9c9;stroke-width:7;fill:none;\
    stroke-linejoin:round;stroke-linecap:round}.plot .curve{stroke-width:1.8;fill:none;stroke-linejoin:round}\
    .plot .marker{stroke:#fff;stroke-width:1}.plot .dot{opacity:.4}";

/// A logarithmic axis that covers whole decades when they are few, else a little more than the data.
struct Axis {
    /// log10 of the values at both ends.
    range: (f64, f64),
    /// Pixels at both ends.
    pixels: (f64, f64),
}

impl Axis {
    fn new(values: impl Iterator<Item = f64> + Clone, pixels: (f64, f64)) -> Self {
        let logs = values.map(f64::log10);
        let (low, high) = logs.clone().fold((f64::MAX, f64::MIN), |(l, h), v| (l.min(v), h.max(v)));
        if low > high {
            return Self { range: (-1.0, 1.0), pixels };
        }
        // A fifth of a decade at the least, for a point alone; whole decades when fewer than two have a
        // label.
        let margin = (0.05 * (high - low)).max(0.1);
        let (mut low, mut high) = (low - margin, high + margin);
        let ticks = (high.floor() - low.ceil() + 1.0) as i32;
        if ticks < 2 {
            (low, high) = (low.floor(), high.ceil());
        }
        Self { range: (low, high), pixels }
    }

    fn at(&self, value: f64) -> f64 {
        let t = (value.log10() - self.range.0) / (self.range.1 - self.range.0);
        self.pixels.0 + t * (self.pixels.1 - self.pixels.0)
    }

    /// Exponents of the decades inside, and whether each has a label: at most ten have.
    fn decades(&self) -> impl Iterator<Item = (i32, bool)> {
        let every = ((self.range.1 - self.range.0) / 9.0).ceil().max(1.0) as i32;
        let (low, high) = (self.range.0.ceil() as i32, self.range.1.floor() as i32);
        (low..=high).map(move |e| (e, e.rem_euclid(every) == 0))
    }

    /// Where the lines without labels are (pixels): at 2 to 9 times each decade while there is room for them.
    fn minor(&self) -> Vec<f64> {
        let between = if self.range.1 - self.range.0 > 6.0 { 2..2 } else { 2..10 };
        let (low, high) = (self.range.0.floor() as i32, self.range.1.ceil() as i32);
        let values = (low..high).flat_map(|e| between.clone().map(move |n| f64::from(n) * 10f64.powi(e)));
        let inside = values.filter(|v| (self.range.0..=self.range.1).contains(&v.log10()));
        let decades = self.decades().filter(|(_, label)| !label).map(|(e, _)| 10f64.powi(e));
        inside.chain(decades).map(|v| self.at(v)).collect()
    }

    /// Where the labelled lines are (pixels), and their labels.
    fn major(&self) -> Vec<(f64, String)> {
        let labelled = self.decades().filter(|(_, label)| *label);
        labelled.map(|(e, _)| (self.at(10f64.powi(e)), power_of_ten(e))).collect()
    }
}

/// A log-log plot of `curves` with a legend beside the axes. The points marked as Pareto optimal, small x and small y
/// being good, are joined by a grey staircase. Points that a logarithmic axis cannot show are left out and counted in a
/// note.
pub fn log_log(title: &str, x_label: &str, y_label: &str, curves: &[Curve]) -> String {
    panels(title, x_label, y_label, &[Panel { title: String::new(), curves: curves.to_vec() }])
}

/// [`log_log`] in several pairs of axes of the same ranges, two beside each other, each with the one Pareto front of all.
pub fn panels(title: &str, x_label: &str, y_label: &str, panels: &[Panel]) -> String {
    draw(title, x_label, y_label, panels).expect("writing to a String cannot fail")
}

fn is_shown(mark: &&Mark) -> bool {
    let (x, y) = mark.at;
    x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0
}

fn draw(title: &str, x_label: &str, y_label: &str, panels: &[Panel]) -> Result<String, std::fmt::Error> {
    let all = || panels.iter().flat_map(|panel| &panel.curves).flat_map(|curve| &curve.marks);
    let shown = || all().filter(is_shown).map(|mark| mark.at);
    let front =
        pareto_front(all().filter(is_shown).filter(|mark| mark.is_pareto).map(|mark| mark.at).collect());
    let mut names: Vec<&str> = Vec::new();
    for curve in panels.iter().flat_map(|panel| &panel.curves) {
        if !names.contains(&curve.name.as_str()) {
            names.push(&curve.name);
        }
    }

    let columns = panels.len().clamp(1, 2);
    let (width, height) = if panels.len() > 1 { SMALL } else { ALONE };
    let rows = panels.len().div_ceil(columns).max(1);
    // With one place left in the last row, the legend stands there.
    let legend_inside = panels.len() > 1 && panels.len() % 2 == 1;
    let right = LEFT + columns as f64 * (width + GAP.0) - GAP.0;
    let bottom = TOP + rows as f64 * (height + GAP.1) - GAP.1;
    let (legend, legend_top) = match legend_inside {
        true => (LEFT + width + GAP.0 + 30.0, bottom - height + 16.0),
        false => (right + LEGEND_GAP, TOP + 8.0),
    };
    let whole_width = right + if legend_inside { 24.0 } else { LEGEND_GAP + LEGEND_WIDTH };
    let whole_height = (bottom + 84.0).max(legend_top + LINE * (names.len() as f64 + 2.0));

    let mut svg = String::new();
    let s = &mut svg;
    writeln!(
        s,
        r#"<svg xmlns="http://www.w3.org/2000/svg" class="plot" viewBox="0 0 {whole_width} {whole_height}" width="{whole_width}">"#
    )?;
    writeln!(s, "<title>{}</title>\n<style>{STYLE}</style>", escaped(title))?;
    writeln!(s, r##"<rect width="100%" height="100%" fill="#fff"/>"##)?;
    writeln!(s, r#"<text class="title" x="{LEFT}" y="28">{}</text>"#, escaped(title))?;
    for (i, panel) in panels.iter().enumerate() {
        let left = LEFT + (i % columns) as f64 * (width + GAP.0);
        let top = TOP + (i / columns) as f64 * (height + GAP.1);
        let x = Axis::new(shown().map(|p| p.0), (left, left + width));
        let y = Axis::new(shown().map(|p| p.1), (top + height, top));
        let is_lowest = i + columns >= panels.len();
        axes(s, &x, &y, is_lowest.then_some(x_label), (i % columns == 0).then_some(y_label))?;
        writeln!(s, r#"<text class="panel" x="{left}" y="{}">{}</text>"#, top - 8.0, escaped(&panel.title))?;
        if let Some(first) = front.first() {
            let mut path = format!("M{:.1} {:.1}", x.at(first.0), y.at(first.1));
            for p in &front[1..] {
                write!(path, "H{:.1}V{:.1}", x.at(p.0), y.at(p.1))?;
            }
            writeln!(s, r#"<path class="front" d="{path}"/>"#)?;
        }
        // All dots below all lines.
        for is_joined in [false, true] {
            for curve in &panel.curves {
                let index = names.iter().position(|name| *name == curve.name).unwrap_or(0);
                draw_curve(s, index, curve, is_joined, |p| (x.at(p.0), y.at(p.1)))?;
            }
        }
    }
    for (index, name) in names.iter().enumerate() {
        let (colour, line) = (COLOURS[index % COLOURS.len()], legend_top + LINE * index as f64);
        writeln!(s, r#"<g><path class="curve" stroke="{colour}" d="M{legend} {line}h26"/>"#)?;
        marker(s, index, colour, (legend + 13.0, line), 1.0, name)?;
        writeln!(s, r#"<text x="{}" y="{}">{}</text></g>"#, legend + 34.0, line + 4.5, escaped(name))?;
    }
    if !front.is_empty() {
        let line = legend_top + LINE * names.len() as f64;
        writeln!(s, r#"<path class="front" d="M{} {line}h20"/>"#, legend + 3.0)?;
        writeln!(s, r#"<text x="{}" y="{}">Pareto front</text>"#, legend + 34.0, line + 4.5)?;
    }
    let dropped = all().count() - shown().count();
    if dropped > 0 {
        let points = if dropped == 1 { "1 point is" } else { &format!("{dropped} points are") };
        writeln!(
            s,
            r#"<text class="note" x="{LEFT}" y="{}">{points} not shown: not finite or not positive.</text>"#,
            bottom + 70.0
        )?;
    }
    s.push_str("</svg>\n");
    Ok(svg)
}

/// The marks of a curve that are joined, and the line through them; or the others, as dots.
fn draw_curve(
    s: &mut String,
    index: usize,
    curve: &Curve,
    is_joined: bool,
    place: impl Fn((f64, f64)) -> (f64, f64),
) -> std::fmt::Result {
    let colour = COLOURS[index % COLOURS.len()];
    let marks: Vec<&Mark> =
        curve.marks.iter().filter(is_shown).filter(|mark| mark.is_joined == is_joined).collect();
    writeln!(s, "<g>")?;
    if is_joined {
        let at = marks.iter().map(|mark| place(mark.at)).map(|(x, y)| format!("{x:.1},{y:.1}"));
        let line: Vec<String> = at.collect();
        writeln!(s, r#"<polyline class="curve" stroke="{colour}" points="{}"/>"#, line.join(" "))?;
    }
    for mark in &marks {
        let tip = format!("{} {}: {}, {}", curve.name, mark.detail, short(mark.at.0), short(mark.at.1));
        marker(s, index, colour, place(mark.at), if is_joined { 1.0 } else { 0.45 }, &tip)?;
    }
    writeln!(s, "</g>")
}

/// Lines, numbers and, where there is one, the label of each axis.
fn axes(
    s: &mut String,
    x: &Axis,
    y: &Axis,
    x_label: Option<&str>,
    y_label: Option<&str>,
) -> std::fmt::Result {
    let ((left, right), (bottom, top)) = (x.pixels, y.pixels);
    for at in x.minor() {
        writeln!(s, r#"<path class="minor" d="M{at:.1} {top}V{bottom}"/>"#)?;
    }
    for at in y.minor() {
        writeln!(s, r#"<path class="minor" d="M{left} {at:.1}H{right}"/>"#)?;
    }
    for (at, label) in &x.major() {
        writeln!(s, r#"<path class="major" d="M{at:.1} {top}V{bottom}"/>"#)?;
        writeln!(s, r#"<text x="{at:.1}" y="{}" text-anchor="middle">{label}</text>"#, bottom + 20.0)?;
    }
    for (at, label) in &y.major() {
        writeln!(s, r#"<path class="major" d="M{left} {at:.1}H{right}"/>"#)?;
        if y_label.is_some() {
            writeln!(s, r#"<text x="{}" y="{:.1}" text-anchor="end">{label}</text>"#, left - 9.0, at + 4.5)?;
        }
    }
    writeln!(s, r#"<path class="frame" d="M{left} {top}V{bottom}H{right}"/>"#)?;
    if let Some(label) = x_label {
        let (middle, below) = (0.5 * (left + right), bottom + 44.0);
        let label = escaped(label);
        writeln!(s, r#"<text class="label" x="{middle}" y="{below}" text-anchor="middle">{label}</text>"#)?;
    }
    if let Some(label) = y_label {
        let (beside, middle) = (left - 60.0, 0.5 * (top + bottom));
        let label = escaped(label);
        writeln!(
            s,
            r#"<text class="label" transform="translate({beside} {middle}) rotate(-90)" text-anchor="middle">{label}</text>"#
        )?;
    }
    Ok(())
}

/// From the left to the right, those that another one beats left out, so that the line between them never turns up.
fn pareto_front(mut front: Vec<(f64, f64)>) -> Vec<(f64, f64)> {
    front.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut lowest = f64::INFINITY;
    front.retain(|p| {
        let lower = p.1 < lowest;
        lowest = lowest.min(p.1);
        lower
    });
    front
}

/// One of seven shapes, so that curves are told apart without their colours; every shape covers about the
/// same area.
fn marker(
    s: &mut String,
    index: usize,
    colour: &str,
    (x, y): (f64, f64),
    scale: f64,
    tip: &str,
) -> std::fmt::Result {
    let shape = match index % 7 {
        0 => "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0-9 0z",
        1 => "M-4-4h8v8h-8z",
        2 => "M0-5.6L5 3.6h-10z",
        3 => "M0-5.8L5.8 0L0 5.8L-5.8 0z",
        4 => "M0 5.6L5-3.6h-10z",
        5 => "M-1.8-5.2h3.6v3.4h3.4v3.6h-3.4v3.4h-3.6v-3.4h-3.4v-3.6h3.4z",
        _ => "M-5-2.9L0-5.8L5-2.9V2.9L0 5.8L-5 2.9z",
    };
    let (class, scaled) = match scale < 1.0 {
        true => ("marker dot", format!(" scale({scale})")),
        false => ("marker", String::new()),
    };
    write!(
        s,
        r#"<path class="{class}" fill="{colour}" transform="translate({x:.1} {y:.1}){scaled}" d="{shape}">"#
    )?;
    writeln!(s, "<title>{}</title></path>", escaped(tip))
}

/// 10 to the power of `e`, in superscript digits; 1 and 10 are plain.
fn power_of_ten(e: i32) -> String {
    let raised = |c| match c {
        '-' => '⁻',
        c => "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().nth(c as usize - '0' as usize).expect("a number is written in digits"),
    };
    match e {
        0 => "1".to_owned(),
        1 => "10".to_owned(),
        _ => format!("10{}", e.to_string().chars().map(raised).collect::<String>()),
    }
}

/// Three digits, as a person writes them.
pub(super) fn short(value: f64) -> String {
    let size = value.abs();
    if value == 0.0 || (0.01..1000.0).contains(&size) {
        let digits = if value == 0.0 { 0 } else { (2.0 - size.log10().floor()).max(0.0) as usize };
        format!("{value:.digits$}")
    } else {
        format!("{value:.2e}")
    }
}

/// Text for SVG and HTML, in attributes too.
pub(super) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
