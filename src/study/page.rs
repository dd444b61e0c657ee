// SPDX-License-Identifier: MIT OR Apache-2.0
//! A study as one HTML page that needs nothing else: no scripts, no fonts, no other files.

use super::plot::{escaped, short, Curve};
use super::shapes::{Study, StudyResult};

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

/// The curves of a study for [`log_log`](super::plot::log_log), error along x and cost along y: one for each
/// variant and size, from the largest step to the smallest, in the order in which the variants first appear.
pub fn curves(result: &StudyResult) -> Vec<Curve> {
    let one_size = result.points.iter().all(|p| p.size == result.points[0].size);
    let mut keys: Vec<(&str, u32)> = Vec::new();
    for p in &result.points {
        if !keys.contains(&(&p.variant, p.size)) {
            keys.push((&p.variant, p.size));
        }
    }
    let curve = |(variant, size): (&str, u32)| {
        let mut points: Vec<_> =
            result.points.iter().filter(|p| p.variant == variant && p.size == size).collect();
        points.sort_by(|a, b| b.step.total_cmp(&a.step));
        Curve {
            name: variant.to_owned(),
            detail: if one_size { String::new() } else { size.to_string() },
            points: points.iter().map(|p| (p.error.unwrap_or(f64::NAN), p.ms_per_sim_second)).collect(),
            pareto: points.iter().map(|p| p.pareto).collect(),
        }
    };
    keys.into_iter().map(curve).collect()
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
    let title = escaped(title);
    format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>{title}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n<header>\n<h1>{title}</h1>\n\
         <dl>\n{facts}</dl>\n</header>\n{sections}</body>\n</html>\n"
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
