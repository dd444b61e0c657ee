// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{hardcases::short, print, print_json, progress, DeviceArgs, Failure};
use clap::Args;
use serde_json::json;
use whitecap::study::{
    bench::{self, Options},
    shapes::table,
};

#[derive(Args)]
pub struct BenchArgs {
    /// Simulations (`water`), variants or the start of one (`waves`); all by default
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    #[command(flatten)]
    device: DeviceArgs,
    /// Edges of the grids (cells), as in 512,1024
    #[arg(long, value_delimiter = ',', value_name = "N,N")]
    sizes: Option<Vec<u32>>,
    /// Time for each row (s)
    #[arg(long, value_name = "SECONDS")]
    budget: Option<f64>,
    /// Instead, try every tuning of the first NAME (`waves/w0.25`, `wet`, `shallow`) on grids of the sizes
    #[arg(long)]
    tune: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let gpu = args.device.open()?;
    if args.tune {
        return tune(args, &gpu);
    }
    let options = Options { sizes: args.sizes.clone(), max_size: None, budget_s: args.budget };
    let results = progress("rows", |on| bench::bench(&gpu, &args.names, &options, on))?;
    if args.json {
        print_json(&results)?;
        return args.device.verdict(&gpu);
    }
    print(&format!(
        "{} ({}), clock: {}, copy {:.1} GB/s\n",
        results.device,
        results.driver,
        results.clock,
        1e-9 * results.copy_bytes_per_s
    ));
    let rows: Vec<_> = results
        .results
        .iter()
        .map(|row| {
            vec![
                format!("{}/{}", row.sim, row.variant),
                row.size.clone(),
                short(1e-9 * row.items_per_s),
                format!("G {}s/s", row.unit),
                short(row.bytes_per_item),
                short(row.fraction_of_copy),
                format!("{:.4}", row.median_ms),
                row.runs.to_string(),
            ]
        })
        .collect();
    let headers = ["variant", "size", "rate", "unit", "bytes/item", "of copy", "median ms", "runs"];
    print(&table(&headers, &rows));
    for skipped in &results.skipped {
        print(&format!("skipped: {} {}: {}", skipped.variant, skipped.size, skipped.reason));
    }
    args.device.verdict(&gpu)
}

fn tune(args: &BenchArgs, gpu: &whitecap::gpu::Gpu) -> Result<(), Failure> {
    let variant = args.names.first().map_or("waves/w0.25", String::as_str);
    let mut all = Vec::new();
    for &size in args.sizes.as_deref().unwrap_or(&[1024]) {
        let rates = progress("tunings", |on| bench::sweep_tuning(gpu, variant, size, on))?;
        let entry = |(tuning, rate): &(whitecap::water::Tuning, f64)| json!({"variant": variant, "size": size, "group": tuning.group.to_array(), "rows": tuning.rows, "cells_per_s": rate});
        all.extend(rates.iter().map(entry));
        if !args.json {
            let rows: Vec<_> = rates
                .iter()
                .take(12)
                .map(|(tuning, rate)| {
                    vec![
                        format!("{}x{}", tuning.group.x, tuning.group.y),
                        tuning.rows.to_string(),
                        short(1e-9 * rate),
                    ]
                })
                .collect();
            print(&format!("{size} x {size} on {}", gpu.name()));
            print(&format!("{}\n", table(&["group", "rows", "G cells/s"], &rows)));
        }
    }
    if args.json {
        print_json(
            &json!({"device": gpu.name(), "driver": gpu.adapter().driver, "clock": gpu.clock()?.name(), "tunings": all}),
        )?;
    }
    Ok(())
}
