// SPDX-License-Identifier: MIT OR Apache-2.0
//! Arguments, exit codes and what the commands share.

mod bench;
mod check;
mod devices;
mod hardcases;
mod pipelines;
mod run;
mod scenes;
mod study_command;
mod view;

use clap::{Args, Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use std::{env, fmt::Display, io::Write, path::PathBuf, process::ExitCode};
use whitecap::{
    gpu::{
        self,
        files::{Compiled, Files},
        Gpu, GpuOptions,
    },
    mesh::MeshesError,
    paint, particles,
    run::{atomic::FileError, RunError},
    scene::SceneError,
    study, water,
};

/// GPU simulations for real-time scenes, in Vulkan and GLSL, each checked against an f64 twin.
#[derive(Parser)]
#[command(version, about, after_help = EXIT_CODES)]
struct Cli {
    #[command(subcommand)]
    command: Command,
}

const EXIT_CODES: &str =
    "Exit codes: 0 ok, 1 a check failed, 2 bad input, 3 no Vulkan device, layer or display, or a full disk, 4 device lost, 5 out of \
                          memory.";

#[derive(Subcommand)]
enum Command {
    /// Simulate and render a scene without a window: pictures, contact sheet, clip, stats.json
    Run(run::RunArgs),
    /// Show a scene in a window: camera, live numbers, times of passes (feature `viewer`)
    View(view::ViewArgs),
    /// Explain a scene without running it: models, passes, buffers and bytes, and why
    Check(check::CheckArgs),
    /// List the built-in scenes, or print one to start from
    Scenes(scenes::ScenesArgs),
    /// List the Vulkan devices, what each lacks, and which path each simulation takes on it
    Devices(devices::DevicesArgs),
    /// Run the hard cases on a device, and compare with the limits
    Hardcases(hardcases::HardcasesArgs),
    /// Measure the throughput of every variant against the device's copy rate
    Bench(bench::BenchArgs),
    /// Measure speed against error on a device: JSON, CSV, plots and a page
    Study(study_command::StudyArgs),
}

/// Which device, and how it is watched.
#[derive(Args)]
struct DeviceArgs {
    /// Index, UUID or part of the name (see `whitecap devices`); the fastest kind by default
    #[arg(long, value_name = "NAME|INDEX|UUID", env = "WHITECAP_DEVICE")]
    device: Option<String>,
    /// Run under the Khronos validation layer with synchronization validation; any message fails the command
    #[arg(long)]
    validate: bool,
}

/// A device, and what is run on it.
#[derive(Args)]
struct GpuArgs {
    #[command(flatten)]
    device: DeviceArgs,
    /// Folder of GLSL: shaders that differ from the binary's are compiled from there (what is bound and its size stay the binary's)
    #[arg(long, value_name = "DIR")]
    glsl: Option<PathBuf>,
}

impl GpuArgs {
    fn open(&self) -> Result<Gpu, Failure> {
        self.with_shaders(Gpu::headless(&self.device.options())?)
    }

    /// As [`GpuArgs::open`], to look at pipelines: none comes from a cache.
    fn open_capturing(&self) -> Result<Gpu, Failure> {
        self.with_shaders(Gpu::capturing(&GpuOptions { cache: None, ..self.device.options() })?)
    }

    fn with_shaders(&self, gpu: Gpu) -> Result<Gpu, Failure> {
        let Some(dir) = &self.glsl else { return Ok(gpu) };
        let compiled = Files::new(dir).compile(|_| true).map_err(Failure::input)?;
        let none = || Failure::input(format!("{}: no folder of GLSL", dir.display()));
        let Compiled { replacements, names, includes } = compiled.ok_or_else(none)?;
        gpu.replace_shaders(replacements);
        gpu::include(includes);
        match &names[..] {
            [] => eprintln!("{}: as the binary's shaders", dir.display()),
            names => eprintln!("{}: other than the binary's are {}", dir.display(), names.join(", ")),
        }
        Ok(gpu)
    }

    /// What validation said, as a failure.
    fn verdict(&self, gpu: &Gpu) -> Result<(), Failure> {
        verdict(&gpu.messages())
    }
}

impl DeviceArgs {
    fn options(&self) -> GpuOptions {
        let cache = cache_dir().map(|dir| dir.join("whitecap"));
        GpuOptions { device: self.device.clone(), validate: self.validate, cache }
    }
}

/// What validation said, as a failure.
fn verdict(messages: &gpu::Messages) -> Result<(), Failure> {
    let messages = messages.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
    if messages.is_empty() {
        return Ok(());
    }
    let list = messages.join("\n");
    Err(Failure { code: 1, text: format!("{} validation messages:\n{list}", messages.len()) })
}

/// Folder of the user's caches.
fn cache_dir() -> Option<PathBuf> {
    let dir = |name: &str| env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    dir("XDG_CACHE_HOME")
        .or_else(|| dir("HOME").map(|home| home.join(".cache")))
        .or_else(|| dir("LOCALAPPDATA"))
}

/// Why a command ends, and with which exit code.
struct Failure {
    code: u8,
    text: String,
}

impl Failure {
    fn check(text: impl Into<String>) -> Self {
        Self { code: 1, text: text.into() }
    }

    fn input(text: impl Display) -> Self {
        Self { code: 2, text: text.to_string() }
    }
}

impl From<gpu::Error> for Failure {
    fn from(error: gpu::Error) -> Self {
        let code = match &error {
            it if it.is_device_lost() => 4,
            gpu::Error::Timeout { .. } => 4,
            it if it.is_out_of_memory() => 5,
            gpu::Error::Limit { .. } | gpu::Error::NoSuchDevice { .. } | gpu::Error::NoClock { .. } => 2,
            gpu::Error::Loader(_)
            | gpu::Error::NoDevice { .. }
            | gpu::Error::NoGraphics { .. }
            | gpu::Error::NoDisplay { .. }
            | gpu::Error::NoValidation => 3,
            _ => 1,
        };
        Self { code, text: error.to_string() }
    }
}

impl From<water::Error> for Failure {
    fn from(error: water::Error) -> Self {
        match error {
            water::Error::Gpu(error) => error.into(),
            water::Error::Invalid(invalid) => Self::input(invalid),
        }
    }
}

impl From<whitecap::disks::Error> for Failure {
    fn from(error: whitecap::disks::Error) -> Self {
        match error {
            whitecap::disks::Error::Gpu(error) => error.into(),
            whitecap::disks::Error::Invalid(invalid) => Self::input(invalid),
        }
    }
}

impl From<paint::Error> for Failure {
    fn from(error: paint::Error) -> Self {
        match error {
            paint::Error::Gpu(error) => error.into(),
            error => Self::input(error),
        }
    }
}

impl From<MeshesError> for Failure {
    fn from(error: MeshesError) -> Self {
        match error {
            MeshesError::Gpu(error) => error.into(),
            error => Self::input(error),
        }
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Self::input(error)
    }
}

impl From<FileError> for Failure {
    fn from(error: FileError) -> Self {
        let code = if error.cause.kind() == std::io::ErrorKind::StorageFull { 3 } else { 2 };
        Self { code, text: error.to_string() }
    }
}

impl From<study::Error> for Failure {
    fn from(error: study::Error) -> Self {
        match error {
            study::Error::Water(error) => error.into(),
            study::Error::Run(error) => error.into(),
            study::Error::Particles(particles::Error::Gpu(error)) | study::Error::Gpu(error) => error.into(),
            study::Error::Particles(particles::Error::Invalid(invalid)) => Self::input(invalid),
            study::Error::Disks(error) => error.into(),
            study::Error::Paint(error) => error.into(),
            study::Error::Meshes(error) => error.into(),
            study::Error::File(error) => error.into(),
            study::Error::NoSuch { .. } => Self::input(error),
            study::Error::Lacks { .. } | study::Error::Wrong { .. } | study::Error::BlownUp { .. } => {
                Self::check(error.to_string())
            }
        }
    }
}

impl From<RunError> for Failure {
    fn from(error: RunError) -> Self {
        match error {
            RunError::Scene(error) => error.into(),
            RunError::Water(error) => error.into(),
            RunError::Disks(error) => error.into(),
            RunError::Particles(particles::Error::Gpu(error)) | RunError::Gpu(error) => error.into(),
            RunError::Particles(particles::Error::Invalid(invalid)) => Self::input(invalid),
            RunError::Meshes(error) => error.into(),
            RunError::Paint(error) => error.into(),
            RunError::File(error) => error.into(),
            RunError::Checkpoint(error) => Self::input(error),
            RunError::NoRenderDoc => Self { code: 3, text: error.to_string() },
        }
    }
}

#[cfg(feature = "viewer")]
impl From<whitecap::view::ViewError> for Failure {
    fn from(error: whitecap::view::ViewError) -> Self {
        use whitecap::view::ViewError;
        match error {
            ViewError::Run(error) => error.into(),
            ViewError::Script(_) => Self::input(error),
            ViewError::Window(_) | ViewError::Panel(_) => Self { code: 3, text: error.to_string() },
        }
    }
}

/// Runs the command that the arguments ask for.
pub fn main() -> ExitCode {
    let done = match Cli::parse().command {
        Command::Run(args) => run::run(&args),
        Command::View(args) => view::run(&args),
        Command::Check(args) => check::run(&args),
        Command::Scenes(args) => scenes::run(&args),
        Command::Devices(args) => devices::run(&args),
        Command::Hardcases(args) => hardcases::run(&args),
        Command::Bench(args) => bench::run(&args),
        Command::Study(args) => study_command::run(&args),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            eprintln!("error: {}", failure.text.trim_end());
            ExitCode::from(failure.code)
        }
    }
}

/// Prints to standard output; a reader that has gone (`| head`) is no error.
fn print(text: &str) {
    let _ = writeln!(std::io::stdout(), "{text}");
}

fn print_json(value: &impl serde::Serialize) -> Result<(), Failure> {
    let text =
        serde_json::to_string_pretty(value).map_err(|e| Failure::check(format!("cannot write JSON: {e}")))?;
    print(&text);
    Ok(())
}

/// A bar of `length`, hidden where standard error is no terminal.
fn progress_bar(length: u64, unit: &str) -> ProgressBar {
    let style = format!("{{bar:32}} {{pos}}/{{len}} {unit}, {{eta}} left {{msg}}");
    let style = ProgressStyle::with_template(&style).unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

/// Runs `measure` with a bar that follows it.
fn progress<T>(
    unit: &str,
    measure: impl FnOnce(study::OnProgress<'_>) -> study::Result<T>,
) -> Result<T, Failure> {
    let bar = progress_bar(0, unit);
    let done = measure(&mut |at| {
        bar.set_length(at.of as u64);
        bar.set_position(at.done as u64);
        bar.set_message(at.now.to_string());
    });
    bar.finish_and_clear();
    Ok(done?)
}
