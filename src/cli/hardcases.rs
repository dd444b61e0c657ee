// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{print, print_json, progress, Failure, GpuArgs};
use clap::Args;
use whitecap::study::{
    hard,
    shapes::{table, HardCase},
};

#[derive(Args)]
pub struct HardcasesArgs {
    /// Cases by id (`W4`), by the start of it (`W`), or by a word of the title or a variant; all by default
    #[arg(value_name = "FILTER")]
    filters: Vec<String>,
    #[command(flatten)]
    device: GpuArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &HardcasesArgs) -> Result<(), Failure> {
    hard::select(&args.filters)?; // a name that is none is said before a device is opened
    let gpu = args.device.open()?;
    let results = progress("cases", |on| hard::run(&gpu, &args.filters, on))?;
    if args.json {
        print_json(&results)?;
    } else {
        print(&format!("{} ({}), clock: {}\n", results.device, results.driver, results.clock));
        let headers = ["id", "case", "variant", "measured", "limit", "unit", "seed", ""];
        print(&table(&headers, &results.cases.iter().map(row).collect::<Vec<_>>()));
        for case in results.cases.iter().filter(|case| case.note.is_some()) {
            print(&format!("{} {}: {}", case.id, case.variant, case.note.as_deref().unwrap_or_default()));
        }
    }
    let failed = results.cases.iter().filter(|case| !case.pass).count();
    if failed > 0 {
        return Err(Failure::check(format!("{failed} of {} rows failed", results.cases.len())));
    }
    args.device.verdict(&gpu)
}

fn row(case: &HardCase) -> Vec<String> {
    let number = |x: Option<f64>| x.map_or("not finite".into(), short);
    vec![
        case.id.clone(),
        case.title.clone(),
        case.variant.clone(),
        number(case.measured),
        short(case.limit),
        case.unit.clone(),
        case.seed_measured.map_or("-".into(), short),
        if case.pass { "pass" } else { "FAIL" }.into(),
    ]
}

/// Three digits, in the shorter of two ways.
pub fn short(x: f64) -> String {
    match x.abs() {
        a if a == 0.0 || (0.01..10_000.0).contains(&a) => {
            let digits = (2 - a.max(1e-9).log10().floor() as i32).clamp(0, 4) as usize;
            format!("{x:.digits$}")
        }
        _ => format!("{x:.2e}"),
    }
}
