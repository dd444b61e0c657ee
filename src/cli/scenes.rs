// SPDX-License-Identifier: MIT OR Apache-2.0
use super::{print, print_json, Failure};
use clap::Args;
use serde_json::json;
use whitecap::{
    scene::{builtin, SceneError},
    study::shapes::table,
};

#[derive(Args)]
pub struct ScenesArgs {
    /// Print this scene as TOML
    name: Option<String>,
    /// Print JSON
    #[arg(long)]
    json: bool,
}

pub fn run(args: &ScenesArgs) -> Result<(), Failure> {
    if let Some(name) = &args.name {
        let toml = builtin::toml(name).ok_or_else(|| SceneError::NoBuiltin { name: name.clone() })?;
        if args.json {
            return print_json(&builtin::load(name, &[])?);
        }
        print(toml.trim_end());
        return Ok(());
    }
    if args.json {
        let list: Vec<_> =
            builtin::list().map(|(name, title)| json!({"name": name, "title": title})).collect();
        return print_json(&list);
    }
    let rows: Vec<_> = builtin::list().map(|(name, title)| vec![name.into(), title.into()]).collect();
    print(&table(&["scene", "what it shows"], &rows));
    Ok(())
}
