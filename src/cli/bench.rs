// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{hardcases::short, print, print_json, progress, Failure, GpuArgs};
use clap::Args;
use serde_json::json;
use whitecap::{
    gpu::Gpu,
    study::{
        bench::{self, Options},
        shapes::table,
    },
    water::{FusedTuning, Tuning},
};

#[derive(Args)]
pub struct BenchArgs {
    /// Simulations (`water`), variants or the start of one (`waves`); all by default
    #[arg(value_name = "NAME")]
    names: Vec<String>,
    #[command(flatten)]
    device: GpuArgs,
    /// Sizes, as in 512,1024: edges of grids (cells), numbers of particles
    #[arg(long, value_delimiter = ',', value_name = "N,N")]
    sizes: Option<Vec<u32>>,
    /// Time for each row (s)
    #[arg(long, value_name = "SECONDS")]
    budget: Option<f64>,
    /// Instead, try every tuning of the kernels that have one, on grids of the sizes
    #[arg(long)]
    tune: bool,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &BenchArgs) -> Result<(), Failure> {
    let gpu = args.device.open()?;
    if args.tune {
        tune(args, &gpu)?;
        return args.device.verdict(&gpu);
    }
    let options = Options { sizes: args.sizes.clone(), budget_s: args.budget };
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
                row.ms_per_sim_second.map_or_else(String::new, short),
                row.runs.to_string(),
            ]
        })
        .collect();
    let headers =
        ["variant", "size", "rate", "unit", "bytes/item", "of copy", "median ms", "ms/sim s", "runs"];
    print(&table(&headers, &rows));
    for skipped in &results.skipped {
        print(&format!("skipped: {} {}: {}", skipped.variant, skipped.size, skipped.reason));
    }
    args.device.verdict(&gpu)
}

fn tune(args: &BenchArgs, gpu: &Gpu) -> Result<(), Failure> {
    let is_named =
        |variant: &&str| args.names.is_empty() || args.names.iter().any(|name| variant.starts_with(name));
    let variants = ["waves/w0.25", "waves/fused/w0.25", "pipes/fused/w0.25", "wet", "shallow"];
    let variants: Vec<_> = variants.into_iter().filter(is_named).collect();
    let mut all = Vec::new();
    for &size in args.sizes.as_deref().unwrap_or(&[1024]) {
        for variant in &variants {
            let rates = progress("tunings", |on| match *variant {
                fused if fused.contains("/fused/") => bench::water::sweep_fused(gpu, fused, size, on),
                plain => {
                    Ok(bench::water::sweep_tuning(gpu, plain, size, on)?.into_iter().map(one_step).collect())
                }
            })?;
            if !args.json {
                let headers = ["group", "rows", "steps", "buffers", "G cell-steps/s"];
                let rows: Vec<_> = rates.iter().take(12).map(row).collect();
                print(&format!(
                    "{variant}, {size} x {size}, on {}\n{}\n",
                    gpu.name(),
                    table(&headers, &rows)
                ));
            }
            all.extend(rates.iter().map(|(tuning, rate)| {
                json!({
                    "variant": variant, "size": size, "group": tuning.group.to_array(), "rows": tuning.rows,
                    "steps": tuning.steps, "buffers": tuning.buffers, "cells_per_s": rate,
                })
            }));
        }
    }
    if args.json {
        let adapter = gpu.adapter();
        let clock = gpu.clock()?.name();
        print_json(
            &json!({"device": adapter.name, "driver": adapter.driver, "clock": clock, "tunings": all}),
        )?;
    }
    Ok(())
}

/// One step a dispatch, nothing shared.
fn one_step((tuning, rate): (Tuning, f64)) -> (FusedTuning, f64) {
    (FusedTuning { group: tuning.group, rows: tuning.rows, steps: 1, buffers: 0 }, rate)
}

fn row((tuning, rate): &(FusedTuning, f64)) -> Vec<String> {
    let group = format!("{}x{}", tuning.group.x, tuning.group.y);
    let [rows, steps, buffers] = [tuning.rows, tuning.steps, tuning.buffers].map(|n| n.to_string());
    vec![group, rows, steps, buffers, short(1e-9 * rate)]
}
