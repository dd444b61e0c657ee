// SPDX-License-Identifier: MIT OR Apache-2.0
//! The command-line tool. Each command is a file under `cli/`.

mod cli;

use std::process::ExitCode;

fn main() -> ExitCode {
    cli::main()
}
