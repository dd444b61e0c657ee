// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{check::SceneArgs, DeviceArgs, Failure};
use clap::Args;
use std::path::PathBuf;

#[derive(Args)]
#[command(after_help = KEYS)]
pub struct ViewArgs {
    #[command(flatten)]
    scene: SceneArgs,
    #[command(flatten)]
    device: DeviceArgs,
    /// Folder of screenshots and edited scenes
    #[arg(long, value_name = "DIR", default_value = "out")]
    out: PathBuf,
    /// Folder of the GLSL that F5 reads again
    #[arg(long, value_name = "DIR", default_value = "glsl")]
    glsl: PathBuf,
    /// Begin without the panel
    #[arg(long)]
    no_panel: bool,
    /// Begin with passes timed and counters read: both sections of the panel opened
    #[arg(long)]
    timings: bool,
    /// Write the last picture here: with --frames, and without --script
    #[arg(long, value_name = "FILE", requires = "frames", conflicts_with = "script")]
    screenshot: Option<PathBuf>,
    /// Do this instead of waiting for hands, and close: commands with ; between, listed below
    #[arg(long, value_name = "COMMANDS")]
    script: Option<String>,
}

const KEYS: &str = "\
With --frames N the window shows N pictures as `whitecap run` makes them, and closes.

Keys: Space pause, . one picture further, R start again, H home camera, O orbit, F fly, V view all, F1 panel, F2 screenshot, F5 \
reload scene and shaders, F9 trace, F12 RenderDoc, Esc leave. Left button: ripples, stirs disks, drags emitters; right \
turns, middle pans, wheel zooms.

Commands of --script: frames N; resize WxH; minimise; restore; renew; key NAME; set KEY.PATH=VALUE; find TEXT; touch X,Y N; drag X,Y \
X,Y; screenshot FILE; window FILE; save FILE; wait FILE; say; exit";

#[cfg(feature = "viewer")]
pub fn run(args: &ViewArgs) -> Result<(), Failure> {
    use whitecap::view::{view, Script, ViewOptions};
    let source = args.scene.source()?;
    let mut script: Script = args.script.as_deref().unwrap_or("").parse().map_err(Failure::input)?;
    if let Some(frames) = args.scene.frames().filter(|_| args.script.is_none()) {
        script = format!("frames {frames}").parse().map_err(Failure::input)?;
        if let Some(path) = &args.screenshot {
            script.keep(path);
        }
    }
    let options = ViewOptions {
        source,
        gpu: args.device.options(),
        script,
        out: args.out.clone(),
        glsl: args.glsl.clone(),
        has_times: args.timings,
        has_panel: !args.no_panel,
    };
    let shown = view(options)?;
    super::verdict(&shown.messages)
}

/// Without the feature there is a word about it.
#[cfg(not(feature = "viewer"))]
pub fn run(args: &ViewArgs) -> Result<(), Failure> {
    let ViewArgs { scene, device, out, glsl, no_panel, timings, screenshot, script } = args;
    let _ = (scene.load()?, device, out, glsl, no_panel, timings, screenshot, script);
    let text =
        "this whitecap was built without its window: cargo build --release --features viewer (Rust 1.95)";
    Err(Failure { code: 3, text: text.into() })
}
