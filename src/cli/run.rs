// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{check::SceneArgs, print, print_json, progress_bar, Failure, GpuArgs};
use clap::Args;
use std::path::PathBuf;
use whitecap::{
    gpu::Clock,
    run::{self, trace::Trace, Profile, RunOptions},
};

#[derive(Args)]
pub struct RunArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    device: GpuArgs,
    /// Folder of the results
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Write no single pictures, only the contact sheet and the clip
    #[arg(long)]
    no_frames: bool,
    /// Hash the state every so many pictures
    #[arg(long, value_name = "N", default_value_t = 0)]
    hash_every: u32,
    /// Write the state here after the last picture, and every so many before
    #[arg(long, value_name = "FILE")]
    checkpoint: Option<PathBuf>,
    /// Pictures from one checkpoint to the next
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..))]
    checkpoint_every: u32,
    /// Go on from the state in this file, with the picture after it
    #[arg(long, value_name = "FILE")]
    resume: Option<PathBuf>,
    /// Write what happened when to this file, which Perfetto opens: host, passes on the device, counters
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    /// Count the invocations and vertices of each pass, for stats.json and the trace
    #[arg(long)]
    pass_statistics: bool,
    /// Have RenderDoc, which must watch already, capture the picture of this number (the first is 0)
    #[arg(long, value_name = "N")]
    renderdoc_frame: Option<u32>,
    /// Clock of the passes: the device's timestamps or a fence at both ends; which can be believed is found out by default
    #[arg(long, value_name = "gpu|fence", value_parser = clock)]
    clock: Option<Clock>,
    /// Print stats.json to standard output
    #[arg(long)]
    json: bool,
}

pub fn run(args: &RunArgs) -> Result<(), Failure> {
    #[cfg(feature = "tracy")]
    let _tracy = tracy_client::Client::start();
    let trace = args.trace.as_deref().map(Trace::create).transpose()?;
    let scene = timed(&trace, "parse", || args.scene.load())?;
    let plan = timed(&trace, "plan", || scene.plan())?; // what is wrong with it is said before a device is opened
    let gpu = timed(&trace, "open the device", || args.device.open())?;
    args.clock.map_or(Ok(()), |clock| gpu.believe(clock))?;
    timed(&trace, "choose the clock", || gpu.clock())?;
    let options = RunOptions {
        out: args.out.clone(),
        has_frames: !args.no_frames,
        hash_every: args.hash_every,
        checkpoint: args.checkpoint.clone().map(|path| (path, args.checkpoint_every)),
        resume: args.resume.clone(),
        profile: Profile { trace, statistics: args.pass_statistics, captured: args.renderdoc_frame },
    };
    if !args.json {
        let title = if scene.title.is_empty() { "untitled" } else { &scene.title };
        print(&format!("{title} on {} ({}), seed {}", gpu.name(), gpu.adapter().driver, scene.seed));
    }
    let bar = progress_bar(scene.output.frames.into(), "pictures");
    let written = run::run(&gpu, &scene, &plan, &options, |done| bar.set_position(done.into()))?;
    bar.finish_and_clear();
    for warning in &written.stats.warnings {
        eprintln!("warning: {warning}");
    }
    if args.json {
        print_json(&written.stats)?;
    } else {
        let stats = &written.stats;
        print(&format!(
            "{} pictures in {:.1} s, {:.2} s simulated",
            stats.frames, stats.wall_s, stats.simulated_s
        ));
        for water in stats.waters.iter().filter(|water| water.lost_s > 0.0) {
            print(&format!("water `{}` lost {:.3} s to its cap of steps", water.name, water.lost_s));
        }
        for (what, path) in &written.files {
            print(&format!("  {what:<14} {}", path.display()));
        }
    }
    args.device.verdict(&gpu)
}

fn clock(text: &str) -> Result<Clock, String> {
    let clocks = [Clock::Gpu, Clock::Fence];
    clocks.into_iter().find(|it| it.name() == text).ok_or_else(|| "neither `gpu` nor `fence`".into())
}

fn timed<T>(trace: &Option<Trace>, name: &str, body: impl FnOnce() -> T) -> T {
    match trace {
        Some(trace) => trace.time(name, body),
        None => body(),
    }
}
