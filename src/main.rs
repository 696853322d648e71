//! The `azimesh` program: parse, run, report, exit code.

mod memory;

use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: memory::HugePages = memory::HugePages;

fn main() -> ExitCode {
    memory::return_large_arrays();
    memory::reserve::set_aside();
    azimesh::cli::main()
}
