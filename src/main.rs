//! The `azimesh` program: parse, run, report, exit code.

mod memory;

use std::panic::resume_unwind;
use std::process::ExitCode;

/// Bytes of the stack that the program runs on: those that systems give the first thread, unless `ulimit -s` says less.
const STACK: usize = 8 << 20;

#[global_allocator]
static ALLOCATOR: memory::HugePages = memory::HugePages;

fn main() -> ExitCode {
    if !memory::is_stack_below(STACK) {
        return run();
    }
    let thread = std::thread::Builder::new().name("main".to_owned());
    match thread.stack_size(STACK).spawn(run) {
        Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
        Err(_) => run(),
    }
}

fn run() -> ExitCode {
    memory::prepare();
    azimesh::cli::main()
}
