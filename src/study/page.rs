// SPDX-License-Identifier: MIT OR Apache-2.0
//! A study as one HTML page that needs nothing else: no scripts, no fonts, no other files.

use super::plot::{escaped, short, Curve, Mark, Panel};
use super::shapes::{Headline, Parts, Point, Study, StudyResult};

const STYLE: &str = "
:root{color-scheme:light dark;--text:#1c1e21;--quiet:#5c636b;--line:#d9dce0;--ground:#fff;--mark:#eef5fb}
@media screen and (prefers-color-scheme:dark){
  :root{--text:#e3e5e8;--quiet:#9aa1a9;--line:#363b41;--ground:#15171a;--mark:#1d2a36}}
body{font:15px/1.5 system-ui,-apple-system,'Segoe UI',Roboto,Helvetica,Arial,sans-serif;color:var(--text);
  background:var(--ground);max-width:56rem;margin:2.5rem auto;padding:0 1rem}
h1{font-size:1.6rem;margin:0 0 .6rem}h2{font-size:1.2rem;margin:3rem 0 .3rem}
h3{font-size:1rem;margin:1.4rem 0 .4rem}
p{margin:.3rem 0 .8rem}.quiet{color:var(--quiet)}
dl{display:grid;grid-template-columns:max-content auto;gap:.1rem 1rem;margin:0}
dt{color:var(--quiet)}dd{margin:0}
svg{display:block;max-width:100%;height:auto;margin:.8rem 0;border-radius:4px}
table{border-collapse:collapse;font-variant-numeric:tabular-nums}
th{font-weight:600;text-align:left;border-bottom:2px solid var(--line)}
th,td{padding:.2rem .9rem .2rem 0;vertical-align:top}td{border-bottom:1px solid var(--line)}
.number{text-align:right}tr.pareto{background:var(--mark)}
details{margin:1rem 0}summary{cursor:pointer;color:var(--quiet)}
@media print{body{margin:0;max-width:none;font-size:10.5pt}section{break-inside:avoid}
  details::details-content{content-visibility:visible;display:block}}
";

/// More variants than this are drawn in several panels.
const MOST_CURVES: usize = 8;

/// A study for [`panels`](super::plot::panels), cost along x and error along y: a curve a variant, through those of its
/// points that no other one of the same variant beats, the others as dots. Where there are many variants, those that
/// begin alike, as `waves/fused/w0` and `waves/fused/w1`, share a panel, and what has no such beginning is in each.
pub fn panels(result: &StudyResult) -> Vec<Panel> {
    let mut variants: Vec<&str> = Vec::new();
    for point in &result.points {
        if !variants.contains(&point.variant.as_str()) {
            variants.push(&point.variant);
        }
    }
    let mut parents: Vec<&str> = Vec::new();
    for (parent, _) in variants.iter().filter_map(|variant| variant.rsplit_once('/')) {
        if !parents.contains(&parent) {
            parents.push(parent);
        }
    }
    let curve = |variant: &str, name: &str| Curve { name: name.to_owned(), marks: marks(result, variant) };
    if variants.len() <= MOST_CURVES || parents.len() < 2 {
        let curves = variants.iter().map(|variant| curve(variant, variant)).collect();
        return vec![Panel { title: String::new(), curves }];
    }
    let named = |parent: &str, variant: &&str| match variant.rsplit_once('/') {
        Some((its, name)) if its == parent => Some(curve(variant, name)),
        Some(_) => None,
        None => Some(curve(variant, variant)),
    };
    let curves = |parent: &str| variants.iter().filter_map(|variant| named(parent, variant)).collect();
    parents.iter().map(|parent| Panel { title: (*parent).to_owned(), curves: curves(parent) }).collect()
}

/// The points of a variant, the cheapest first.
fn marks(result: &StudyResult, variant: &str) -> Vec<Mark> {
    let mut own: Vec<&Point> = result.points.iter().filter(|p| p.variant == variant).collect();
    own.sort_by(|a, b| a.ms_per_sim_second.total_cmp(&b.ms_per_sim_second));
    let error = |p: &Point| p.error.unwrap_or(f64::NAN);
    let mark = |(i, p): (usize, &&Point)| Mark {
        at: (p.ms_per_sim_second, error(p)),
        detail: format!("{}, step {} s", p.size, short(p.step)),
        is_joined: !own[..i].iter().any(|cheaper| error(cheaper) <= error(p)),
        is_pareto: p.pareto,
    };
    own.iter().enumerate().map(mark).collect()
}

/// The page: `plots` are SVG texts, one for each study in the same order; a study past their end has none.
pub fn page(study: &Study, title: &str, date: &str, plots: &[String]) -> String {
    let facts =
        [("Device", &*study.device), ("Driver", &study.driver), ("Clocks", &study.clock), ("Date", date)];
    let facts: String =
        facts.iter().map(|(name, fact)| format!("<dt>{name}</dt><dd>{}</dd>\n", escaped(fact))).collect();
    let plots = plots.iter().map(String::as_str).chain(std::iter::repeat(""));
    let sections: String =
        study.studies.iter().zip(plots).map(|(result, plot)| section(result, plot)).collect();
    let (headlines, parts) = (headlines(&study.headlines), parts(&study.parts));
    let title = escaped(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n\
         <dl>\n{facts}</dl>\n</header>\n{headlines}{sections}{parts}</body>\n</html>\n"
    )
}

fn headlines(all: &[Headline]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let item = |headline: &Headline| {
        let value =
            headline.value.map_or("not measured".to_owned(), |x| format!("{} {}", short(x), headline.unit));
        let (what, note) = (escaped(&headline.what), escaped(&headline.note));
        format!(
            "<li>{what}: <strong>{}</strong>. <span class=\"quiet\">{note}</span></li>\n",
            escaped(&value)
        )
    };
    format!(
        "<section>\n<h2>Findings</h2>\n<ul>\n{}</ul>\n</section>\n",
        all.iter().map(item).collect::<String>()
    )
}

fn parts(all: &[Parts]) -> String {
    if all.is_empty() {
        return String::new();
    }
    let or_none = |x: Option<f64>| x.map_or("–".to_owned(), short);
    let line = |part: &Parts| {
        let numbers = [part.truncation, part.model, part.rounding].map(or_none);
        let study = format!("{}: {}", part.sim, part.study);
        let [truncation, model, rounding] = numbers.each_ref().map(String::as_str);
        let (size, step) = (part.size.to_string(), short(part.step));
        row("", &[], &format!("{study}, {}", part.variant), &[&size, &step, truncation, model, rounding])
    };
    let n = "<th class=\"number\">";
    format!(
        "<section>\n<h2>Where the error comes from</h2>\n\
         <p class=\"quiet\">Of the scheme in f64: how far it is from what it converges to (truncation), and how far that is \
         from the exact solution (model). Of the device: how far it is from the scheme in f64 (rounding). All in the \
         metric of the study.</p>\n\
         <table>\n<tr><th>Variant</th>{n}Size</th>{n}Step (s)</th>{n}Truncation</th>{n}Model</th>{n}Rounding</th></tr>\n\
         {}</table>\n</section>\n",
        all.iter().map(line).collect::<String>()
    )
}

fn section(result: &StudyResult, plot: &str) -> String {
    let metric = result.points.first().map_or("error", |p| &p.metric);
    let count = result.points.len();
    let front = result.points.iter().filter(|p| p.pareto).count();
    let heading = escaped(&format!("{}: {}", result.sim, result.study));
    let (reference, metric) = (escaped(&result.reference), escaped(metric));
    let cheapest: String = result
        .cheapest
        .iter()
        .map(|c| {
            let variant = c.variant.as_deref().unwrap_or("none is this accurate");
            let cost = c.ms_per_sim_second.map_or("–".to_owned(), short);
            let speedup = c.speedup_over_seed.map_or("–".to_owned(), |s| format!("{}×", short(s)));
            row("", &[&format!("{:?}", c.tolerance)], variant, &[&cost, &speedup])
        })
        .collect();
    let points: String = result
        .points
        .iter()
        .map(|p| {
            let error = p.error.map_or("not finite".to_owned(), short);
            let numbers =
                [short(p.step), p.size.to_string(), error, short(p.ms_per_sim_second), short(p.ns_per_item)];
            let class = if p.pareto { " class=\"pareto\"" } else { "" };
            row(class, &[], &p.variant, &numbers.each_ref().map(String::as_str))
        })
        .collect();
    let n = "<th class=\"number\">";
    format!(
        "<section>\n<h2>{heading}</h2>\n\
         <p class=\"quiet\">Error: {metric}. Reference: {reference}. \
         {front} of {count} points are on the Pareto \
         front: nothing measured is both as accurate and cheaper, or as cheap and more accurate.</p>\n{plot}\
         <h3>Cheapest within a tolerance</h3>\n\
         <table>\n<tr>{n}Tolerance</th><th>Variant</th>{n}ms per simulated s</th>\
         {n}Against the seed</th></tr>\n\
         {cheapest}</table>\n</section>\n\
         <details>\n<summary>All {count} points</summary>\n\
         <table>\n<tr><th>Variant</th>{n}Step (s)</th>{n}Size</th>{n}Error</th>{n}ms per simulated s</th>\
         {n}ns per item</th></tr>\n{points}</table>\n</details>\n"
    )
}

fn row(class: &str, before: &[&str], name: &str, after: &[&str]) -> String {
    let numbers = |cells: &[&str]| -> String {
        cells.iter().map(|c| format!("<td class=\"number\">{}</td>", escaped(c))).collect()
    };
    format!("<tr{class}>{}<td>{}</td>{}</tr>\n", numbers(before), escaped(name), numbers(after))
}
