// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{hardcases::short, print, print_json, progress, Failure, GpuArgs};
use clap::Args;
use std::{
    path::PathBuf,
    time::{SystemTime, UNIX_EPOCH},
};
use whitecap::study::{self, shapes::table};

#[derive(Args)]
pub struct StudyArgs {
    /// Studies, by a part of the name; all by default
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    #[command(flatten)]
    device: GpuArgs,
    /// Fewer sizes and steps
    #[arg(long)]
    quick: bool,
    /// Folder of the report: study.json, study.csv, a plot a study, index.html
    #[arg(long, value_name = "DIR", default_value = "out/study")]
    out: PathBuf,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &StudyArgs) -> Result<(), Failure> {
    let gpu = args.device.open()?;
    let results = progress("points", |on| study::study(&gpu, &args.names, args.quick, on))?;
    study::write_report(&results, &args.out, &today())?;
    if args.json {
        print_json(&results)?;
        return args.device.verdict(&gpu);
    }
    print(&format!("{} ({}), clock: {}\n", results.device, results.driver, results.clock));
    for study in &results.studies {
        let or_none = |x: Option<f64>| x.map_or("-".into(), short);
        let rows: Vec<_> = study
            .cheapest
            .iter()
            .map(|row| {
                let variant = row.variant.clone().unwrap_or_else(|| "none".into());
                vec![
                    format!("{} %", 100.0 * row.tolerance),
                    variant,
                    or_none(row.ms_per_sim_second),
                    or_none(row.speedup_over_seed),
                ]
            })
            .collect();
        print(&format!(
            "{}, {}: {} points, reference: {}",
            study.sim,
            study.study,
            study.points.len(),
            study.reference
        ));
        print(&format!(
            "{}\n",
            table(&["error", "cheapest", "ms per simulated s", "times the seed's"], &rows)
        ));
    }
    for it in &results.headlines {
        let value = it.value.map_or("not measured".into(), |x| format!("{} {}", short(x), it.unit));
        print(&format!("{}: {value}; {}", it.what, it.note));
    }
    print(&format!("report: {}", args.out.join("index.html").display()));
    args.device.verdict(&gpu)
}

/// Today in UTC, year-month-day (Hinnant, "chrono-Compatible Low-Level Date Algorithms", 2013, civil_from_days).
fn today() -> String {
    let days = SystemTime::now().duration_since(UNIX_EPOCH).map_or(0, |now| now.as_secs() / 86_400) + 719_468;
    let (era, day_of_era) = (days / 146_097, days % 146_097);
    let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
    let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
    let month = (5 * day_of_year + 2) / 153;
    let day = day_of_year - (153 * month + 2) / 5 + 1;
    let (month, next_year) = if month < 10 { (month + 3, 0) } else { (month - 9, 1) };
    format!("{}-{month:02}-{day:02}", year_of_era + era * 400 + next_year)
}
