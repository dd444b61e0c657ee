// SPDX-License-Identifier: MIT OR Apache-2.0
//! Work-precision plots: log-log SVG, complete in itself.

use std::fmt::Write;

/// One curve of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// What tells it from other curves of its name, shown beside its first point; may be empty.
    pub detail: String,
    /// As the legend shows it; curves of one name share colour, marker and line of the legend.
    pub name: String,
    /// (x, y), joined in this order.
    pub points: Vec<(f64, f64)>,
    /// Which of the points are on the Pareto front; points past the end are not.
    pub pareto: Vec<bool>,
}

/// Picture and axes rectangle (pixels).
const WIDTH: f64 = 860.0;
const LEFT: f64 = 84.0;
const RIGHT: f64 = 600.0;
const TOP: f64 = 58.0;
const BOTTOM: f64 = 430.0;
/// Where the legend starts, and its line height (pixels).
const LEGEND: f64 = RIGHT + 26.0;
const LINE: f64 = 21.0;

/// Okabe and Ito's palette without its yellow, which is too light for lines on white.
const COLOURS: [&str; 7] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9", "#e69f00", "#222222"];

/// Every rule is confined to the plot: the SVG may stand inside a page, whose text has the same classes.
const STYLE: &str =
    ".plot text{font:12.5px system-ui,-apple-system,'Segoe UI',Roboto,Helvetica,Arial,sans-serif;\
    fill:#222}.plot .title{font-size:16px;font-weight:600}.plot .label{font-size:13px;fill:#444}\
    .plot .note{font-size:11.5px;fill:#666}.plot .detail{font-size:10px;fill:#555;text-anchor:end}.plot .major{stroke:#dcdcdc}.plot .minor{stroke:#f1f1f1}\
    .plot .frame{stroke:#777;fill:none}.plot .front{stroke:#c9c9c9;stroke-width:7;fill:none;\
    stroke-linejoin:round;stroke-linecap:round}.plot .curve{stroke-width:1.8;fill:none;stroke-linejoin:round}\
    .plot .marker{stroke:#fff;stroke-width:1}";

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

/// A log-log plot of `curves` with a legend beside the axes. The points marked as Pareto optimal, small x and
/// small y being good, are joined by a grey staircase. Points that a logarithmic axis cannot show are left
/// out and counted in a note.
pub fn log_log(title: &str, x_label: &str, y_label: &str, curves: &[Curve]) -> String {
    draw(title, x_label, y_label, curves).expect("writing to a String cannot fail")
}

fn draw(title: &str, x_label: &str, y_label: &str, curves: &[Curve]) -> Result<String, std::fmt::Error> {
    let shown = |&&(x, y): &&(f64, f64)| x.is_finite() && y.is_finite() && x > 0.0 && y > 0.0;
    let points = || curves.iter().flat_map(|c| &c.points).filter(shown);
    let x = Axis::new(points().map(|p| p.0), (LEFT, RIGHT));
    let y = Axis::new(points().map(|p| p.1), (BOTTOM, TOP));
    let dropped = curves.iter().map(|c| c.points.len()).sum::<usize>() - points().count();
    let front = pareto_front(curves);
    let mut names: Vec<&str> = Vec::new();
    for curve in curves {
        if !names.contains(&curve.name.as_str()) {
            names.push(&curve.name);
        }
    }
    let height = (BOTTOM + 84.0).max(TOP + LINE * (names.len() as f64 + 2.0));

    let mut svg = String::new();
    let s = &mut svg;
    writeln!(
        s,
        r#"<svg xmlns="http://www.w3.org/2000/svg" class="plot" viewBox="0 0 {WIDTH} {height}" width="{WIDTH}">"#
    )?;
    writeln!(s, "<title>{}</title>\n<style>{STYLE}</style>", escaped(title))?;
    writeln!(s, r##"<rect width="100%" height="100%" fill="#fff"/>"##)?;
    writeln!(s, r#"<text class="title" x="{LEFT}" y="32">{}</text>"#, escaped(title))?;
    grid(s, &x, &y)?;
    let middle = ((LEFT + RIGHT) / 2.0, (TOP + BOTTOM) / 2.0);
    writeln!(
        s,
        r#"<text class="label" x="{}" y="{}" text-anchor="middle">{}</text>"#,
        middle.0,
        BOTTOM + 46.0,
        escaped(x_label)
    )?;
    writeln!(
        s,
        r#"<text class="label" transform="translate(24 {}) rotate(-90)" text-anchor="middle">{}</text>"#,
        middle.1,
        escaped(y_label)
    )?;

    if let Some(first) = front.first() {
        let mut path = format!("M{:.1} {:.1}", x.at(first.0), y.at(first.1));
        for p in &front[1..] {
            write!(path, "H{:.1}V{:.1}", x.at(p.0), y.at(p.1))?;
        }
        writeln!(s, r#"<path class="front" d="{path}"/>"#)?;
    }
    let mut listed = 0;
    for curve in curves {
        let index = names.iter().position(|name| *name == curve.name).unwrap_or(0);
        let colour = COLOURS[index % COLOURS.len()];
        let visible: Vec<(f64, f64)> = curve.points.iter().filter(shown).copied().collect();
        let line: Vec<String> =
            visible.iter().map(|p| format!("{:.1},{:.1}", x.at(p.0), y.at(p.1))).collect();
        writeln!(s, r#"<g><polyline class="curve" stroke="{colour}" points="{}"/>"#, line.join(" "))?;
        if let Some(first) = visible.first().filter(|_| !curve.detail.is_empty()) {
            let (left, below) = (x.at(first.0) - 8.0, y.at(first.1) + 14.0);
            writeln!(
                s,
                r#"<text class="detail" x="{left:.1}" y="{below:.1}">{}</text>"#,
                escaped(&curve.detail)
            )?;
        }
        for p in visible {
            let tip = format!("{} {}: {}, {}", curve.name, curve.detail, short(p.0), short(p.1));
            marker(s, index, colour, (x.at(p.0), y.at(p.1)), &tip)?;
        }
        if index < listed {
            writeln!(s, "</g>")?;
            continue;
        }
        listed = index + 1;
        let line = TOP + 8.0 + LINE * index as f64;
        writeln!(s, r#"<path class="curve" stroke="{colour}" d="M{LEGEND} {line}h26"/>"#)?;
        marker(s, index, colour, (LEGEND + 13.0, line), &curve.name)?;
        writeln!(s, r#"<text x="{}" y="{}">{}</text></g>"#, LEGEND + 34.0, line + 4.5, escaped(&curve.name))?;
    }
    if !front.is_empty() {
        let line = TOP + 8.0 + LINE * names.len() as f64;
        writeln!(s, r#"<path class="front" d="M{} {line}h20"/>"#, LEGEND + 3.0)?;
        writeln!(s, r#"<text x="{}" y="{}">Pareto front</text>"#, LEGEND + 34.0, line + 4.5)?;
    }
    if dropped > 0 {
        let points = if dropped == 1 { "1 point is" } else { &format!("{dropped} points are") };
        writeln!(
            s,
            r#"<text class="note" x="{LEFT}" y="{}">{points} not shown: not finite or not positive.</text>"#,
            BOTTOM + 70.0
        )?;
    }
    s.push_str("</svg>\n");
    Ok(svg)
}

fn grid(s: &mut String, x: &Axis, y: &Axis) -> std::fmt::Result {
    let (columns, rows) = (x.major(), y.major());
    for at in x.minor() {
        writeln!(s, r#"<path class="minor" d="M{at:.1} {TOP}V{BOTTOM}"/>"#)?;
    }
    for at in y.minor() {
        writeln!(s, r#"<path class="minor" d="M{LEFT} {at:.1}H{RIGHT}"/>"#)?;
    }
    for (at, label) in &columns {
        writeln!(s, r#"<path class="major" d="M{at:.1} {TOP}V{BOTTOM}"/>"#)?;
        writeln!(s, r#"<text x="{at:.1}" y="{}" text-anchor="middle">{label}</text>"#, BOTTOM + 20.0)?;
    }
    for (at, label) in &rows {
        writeln!(s, r#"<path class="major" d="M{LEFT} {at:.1}H{RIGHT}"/>"#)?;
        writeln!(s, r#"<text x="{}" y="{:.1}" text-anchor="end">{label}</text>"#, LEFT - 9.0, at + 4.5)?;
    }
    writeln!(s, r#"<path class="frame" d="M{LEFT} {TOP}V{BOTTOM}H{RIGHT}"/>"#)
}

/// The marked points from the left to the right, those that another one beats left out, so that the line
/// between them never turns up.
fn pareto_front(curves: &[Curve]) -> Vec<(f64, f64)> {
    let marked = curves.iter().flat_map(|c| c.points.iter().zip(&c.pareto));
    let mut front: Vec<(f64, f64)> = marked
        .filter(|((x, y), on)| **on && x.is_finite() && y.is_finite() && *x > 0.0 && *y > 0.0)
        .map(|(p, _)| *p)
        .collect();
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
fn marker(s: &mut String, index: usize, colour: &str, (x, y): (f64, f64), tip: &str) -> std::fmt::Result {
    let shape = match index % 7 {
        0 => "M-4.5 0a4.5 4.5 0 1 0 9 0a4.5 4.5 0 1 0-9 0z",
        1 => "M-4-4h8v8h-8z",
        2 => "M0-5.6L5 3.6h-10z",
        3 => "M0-5.8L5.8 0L0 5.8L-5.8 0z",
        4 => "M0 5.6L5-3.6h-10z",
        5 => "M-1.8-5.2h3.6v3.4h3.4v3.6h-3.4v3.4h-3.6v-3.4h-3.4v-3.6h3.4z",
        _ => "M-5-2.9L0-5.8L5-2.9V2.9L0 5.8L-5 2.9z",
    };
    write!(s, r#"<path class="marker" fill="{colour}" transform="translate({x:.1} {y:.1})" d="{shape}">"#)?;
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
