//! The `azimesh` program: parse, run, report, exit code.

use std::process::ExitCode;

fn main() -> ExitCode {
    azimesh::cli::main()
}
