//! The `azimesh` program: parse, run, report, exit code.

mod memory;

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: memory::HugePages = memory::HugePages;

fn main() -> ExitCode {
    memory::prepare();
    azimesh::cli::main()
}
