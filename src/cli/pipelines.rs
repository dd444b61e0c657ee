// SPDX-License-Identifier: MIT OR Apache-2.0
//! `whitecap devices --pipelines`: what the driver makes of every kernel and graphics pipeline.

use super::{print, print_json, progress, Failure};
use serde_json::{json, Map, Value};
use whitecap::{
    gpu::{Executable, Gpu, PipelineReport, Statistic},
    study::{
        occupancy::{Multiprocessor, Needs, Occupancy},
        pipelines::{pipelines, Found},
        shapes::table,
    },
};

/// What drivers call the registers of an invocation, in small letters.
const REGISTERS: &[&str] = &["register count", "registers", "vgprs"];
/// What did not fit in them: bytes of memory, or a count of instructions or registers, by driver.
const SPILLS: &[&str] = &[
    "local memory size",
    "spill count",
    "spilled vgprs",
    "scratch size",
    "scratch memory size",
    "stack size",
];
const SHARED: &[&str] = &["shared memory size", "lds size", "workgroup memory size"];
const BINARY: &[&str] = &["binary size", "code size"];

/// One executable, or a pipeline of which the driver tells none.
struct Row<'a> {
    pipeline: &'a PipelineReport,
    executable: Option<&'a Executable>,
    occupancy: Option<Occupancy>,
}

impl<'a> Row<'a> {
    fn all(pipeline: &'a PipelineReport, on: Option<&Multiprocessor>) -> Vec<Self> {
        let row = |executable: Option<&'a Executable>| {
            let mut row = Self { pipeline, executable, occupancy: None };
            row.occupancy = on.and_then(|on| on.occupancy(row.needs()?));
            row
        };
        if pipeline.executables.is_empty() {
            return vec![row(None)];
        }
        pipeline.executables.iter().map(|it| row(Some(it))).collect()
    }

    /// The first statistic with one of these names. What cannot be true, as some drivers say, is not taken for a count.
    fn said(&self, names: &[&str]) -> Option<u64> {
        let statistics = self.executable?.statistics.iter();
        let known = |name: &str| statistics.clone().find(|(it, _)| it.to_lowercase() == name);
        names.iter().find_map(|name| known(name)).and_then(|(_, value)| value.count())
    }

    /// Shared memory (bytes): what the driver says, or else what the SPIR-V declares.
    fn shared_bytes(&self) -> Option<u64> {
        self.said(SHARED).or(self.pipeline.shared_bytes)
    }

    /// Of a kernel whose registers are known.
    fn needs(&self) -> Option<Needs> {
        Some(Needs {
            invocations: self.pipeline.local_size?.map(u64::from).iter().product(),
            registers: self.said(REGISTERS)?,
            shared_bytes: self.shared_bytes()?,
        })
    }

    fn words(&self) -> Vec<String> {
        let pipeline = self.pipeline;
        let or_none = |count: Option<u64>| count.map_or("-".into(), |it| it.to_string());
        let joined =
            |numbers: &[u32], by: &str| numbers.iter().map(u32::to_string).collect::<Vec<_>>().join(by);
        let executable = match (self.executable, pipeline.shaders.len()) {
            // What is drawn has no constants to tell it by.
            (Some(it), 2..) => format!("{}: {} of {}", pipeline.name, it.name, pipeline.shaders.join(" + ")),
            (None, 2..) => format!("{}: {}", pipeline.name, pipeline.shaders.join(" + ")),
            _ => pipeline.name.clone(),
        };
        vec![
            executable,
            if pipeline.constants.is_empty() { "-".into() } else { joined(&pipeline.constants, ",") },
            pipeline.local_size.map_or("-".into(), |size| joined(&size, "x")),
            or_none(self.said(REGISTERS)),
            or_none(self.said(SPILLS)),
            or_none(self.shared_bytes()),
            or_none(self.executable.map(|it| it.subgroup.into()).filter(|&it: &u64| it > 0)),
            or_none(self.said(BINARY)),
            self.occupancy.map_or("-".into(), |it| {
                format!("{:.0} % ({} groups, by {})", 100.0 * it.share, it.groups, it.limit)
            }),
        ]
    }

    fn json(&self) -> Value {
        let statistics: Option<Map<_, _>> = self
            .executable
            .map(|it| it.statistics.iter().map(|(name, value)| (name.clone(), statistic(*value))).collect());
        json!({
            "executable": self.executable.map(|it| &it.name),
            "stages": self.executable.map(|it| format!("{:?}", it.stages)),
            "subgroup": self.executable.map(|it| it.subgroup),
            "registers": self.said(REGISTERS),
            "spills": self.said(SPILLS),
            "shared_bytes": self.shared_bytes(),
            "binary_bytes": self.said(BINARY),
            "occupancy": self.occupancy.map(|it| json!({
                "groups": it.groups, "warps": it.warps, "share": it.share, "limit": it.limit,
            })),
            "statistics": statistics,
        })
    }
}

fn statistic(value: Statistic) -> Value {
    match value {
        Statistic::Flag(is) => is.into(),
        Statistic::Signed(n) => n.into(),
        Statistic::Unsigned(n) => n.into(),
        Statistic::Float(x) => x.into(),
    }
}

/// Prints those that `names` name, all if there are none.
pub fn run(gpu: &Gpu, names: &[String], is_json: bool) -> Result<(), Failure> {
    let Found { pipelines: found, left_out } = progress("groups", |on| Ok(pipelines(gpu, names, on)))?;
    if found.is_empty() {
        return Err(Failure::input(format!("no pipeline is called {}", names.join(" or "))));
    }
    let on = Multiprocessor::of(gpu.name());
    let mut absent = absent(gpu, &found);
    absent.extend(left_out.iter().map(|(group, why)| format!("some of {group}: {why}")));
    if is_json {
        let each = |it: &PipelineReport| {
            let rows: Vec<_> = Row::all(it, on.as_ref()).iter().map(Row::json).collect();
            json!({
                "name": it.name, "shaders": it.shaders, "constants": it.constants, "workgroup": it.local_size,
                "declared_shared_bytes": it.shared_bytes, "executables": rows,
            })
        };
        return print_json(&json!({
            "device": gpu.name(), "driver": gpu.adapter().driver, "occupancy_of": on.map(|it| it.name),
            "absent": absent, "pipelines": found.iter().map(each).collect::<Vec<_>>(),
        }));
    }
    print(&format!("{} ({}), {} pipelines\n", gpu.name(), gpu.adapter().driver, found.len()));
    let rows: Vec<_> = found.iter().flat_map(|it| Row::all(it, on.as_ref())).map(|row| row.words()).collect();
    let headers = [
        "pipeline",
        "constants",
        "workgroup",
        "registers",
        "spilled",
        "shared (bytes)",
        "subgroup",
        "binary (bytes)",
        "occupancy",
    ];
    print(&table(&headers, &rows));
    if let Some(on) = on {
        print(&format!("\noccupancy: an estimate for {}; its formula is in docs/profiling.md", on.name));
    }
    absent.iter().for_each(|what| print(&format!("\n{what}")));
    Ok(())
}

/// What the table cannot show, and why.
fn absent(gpu: &Gpu, found: &[PipelineReport]) -> Vec<String> {
    let mut absent = Vec::new();
    if !gpu.adapter().has("pipeline executable properties") {
        absent.push(format!(
            "registers, spills, subgroups and binaries: {} has no VK_KHR_pipeline_executable_properties; shared memory is \
             what the SPIR-V declares",
            gpu.name()
        ));
    } else if !found.iter().flat_map(|it| Row::all(it, None)).any(|row| row.said(REGISTERS).is_some()) {
        absent.push("registers: the driver has no statistic of a name that is known here; see --json".into());
    }
    if Multiprocessor::of(gpu.name()).is_none() {
        absent.push(format!("occupancy: what a multiprocessor of {} has is not known here", gpu.name()));
    }
    absent
}
