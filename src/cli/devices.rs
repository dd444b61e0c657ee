// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{pipelines, print, print_json, Failure, GpuArgs};
use clap::Args;
use serde_json::{json, Value};
use whitecap::gpu::{Adapter, Gpu};

#[derive(Args)]
pub struct DevicesArgs {
    /// Build every pipeline on one device, and print what became of it: registers, spills, shared memory, occupancy
    #[arg(long)]
    pipelines: bool,
    /// Only pipelines with such a part in the name, as `water.fused`
    #[arg(value_name = "FILTER", requires = "pipelines")]
    names: Vec<String>,
    #[command(flatten)]
    device: GpuArgs,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &DevicesArgs) -> Result<(), Failure> {
    if args.pipelines {
        let gpu = args.device.open_capturing()?;
        pipelines::run(&gpu, &args.names, args.json)?;
        return args.device.verdict(&gpu);
    }
    if args.device.glsl.is_some() {
        return Err(Failure::input("--glsl goes with --pipelines"));
    }
    let adapters = Gpu::adapters()?;
    if args.json {
        return print_json(&adapters.iter().map(as_json).collect::<Vec<_>>());
    }
    if adapters.is_empty() {
        return Err(Failure { code: 3, text: "no Vulkan device at all".into() });
    }
    for adapter in &adapters {
        let verdict = if adapter.missing.is_empty() {
            "will do".into()
        } else {
            format!("will not do: it lacks {}", adapter.missing.join(", "))
        };
        print(&format!(
            "{} {} ({}, {}, Vulkan {})\n  uuid {}\n  {verdict}",
            adapter.index, adapter.name, adapter.kind, adapter.driver, adapter.api, adapter.uuid
        ));
        let limits = &adapter.limits;
        print(&format!(
            "  subgroup {}, workgroup {} invocations, shared memory {} bytes, storage buffer {} bytes",
            adapter.subgroup,
            limits.max_compute_work_group_invocations,
            limits.max_compute_shared_memory_size,
            limits.max_storage_buffer_range
        ));
        let lacks: Vec<_> = adapter.optional.iter().filter(|(_, has)| !has).map(|(name, _)| *name).collect();
        print(&format!(
            "  optional, not there: {}",
            if lacks.is_empty() { "-".into() } else { lacks.join(", ") }
        ));
        for (simulation, path) in paths(adapter) {
            print(&format!("  {simulation}: {path}"));
        }
        print("");
    }
    Ok(())
}

/// Which path each simulation takes on a device.
fn paths(adapter: &Adapter) -> Vec<(&'static str, String)> {
    let side = f64::from(adapter.limits.max_storage_buffer_range / 4).sqrt() as u32 / 4 * 4;
    let book = f64::from(adapter.limits.max_storage_buffer_range / 20).sqrt() as u32;
    let has_graphics = adapter.has("graphics queue");
    let layers = if adapter.has("shaderOutputLayer") { "vertex shader" } else { "geometry shader" };
    let draws_layers = has_graphics
        && (adapter.has("shaderOutputLayer") || adapter.has("geometryShader"))
        && adapter.has("shaderClipDistance")
        && adapter.has("volumes as layers");
    let volume = [
        Some("conservative".into()),
        (has_graphics && adapter.has("fragmentStoresAndAtomics")).then(|| "one-pass".into()),
        draws_layers.then(|| format!("layered by {layers}")),
    ];
    vec![
        (
            "water",
            format!(
                "waves, up to {0} x {0} columns in one buffer; book, up to {book} x {book}",
                side.min(whitecap::water::Model::MOST_CELLS)
            ),
        ),
        ("volume", volume.into_iter().flatten().collect::<Vec<String>>().join(", ")),
        (
            "pictures",
            if has_graphics { "drawn on the device".into() } else { "none: no graphics queue".into() },
        ),
    ]
}

fn as_json(adapter: &Adapter) -> Value {
    let optional: serde_json::Map<_, _> =
        adapter.optional.iter().map(|(name, has)| ((*name).into(), Value::Bool(*has))).collect();
    let paths: serde_json::Map<_, _> =
        paths(adapter).into_iter().map(|(name, path)| (name.into(), Value::String(path))).collect();
    json!({
        "index": adapter.index, "name": adapter.name, "uuid": adapter.uuid, "driver": adapter.driver,
        "api": adapter.api, "kind": adapter.kind, "missing": adapter.missing, "optional": optional, "paths": paths,
        "subgroup": adapter.subgroup,
        "max_workgroup_invocations": adapter.limits.max_compute_work_group_invocations,
        "max_shared_memory_bytes": adapter.limits.max_compute_shared_memory_size,
        "max_storage_buffer_bytes": adapter.limits.max_storage_buffer_range,
    })
}
