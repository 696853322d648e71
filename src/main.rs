//! The `azimesh` program: parse, run, report, exit code.

use azimesh::alloc::global;
use std::panic::resume_unwind;
use std::process::ExitCode;

/// Stack size in bytes of the program: the system's default for the first thread, unless `ulimit -s` is smaller.
const STACK: u32 = 8 << 20;

#[global_allocator]
static ALLOCATOR: global::HugePages = global::HugePages;

fn main() -> ExitCode {
    if !global::is_stack_below(STACK) {
        return run();
    }
    let thread = std::thread::Builder::new().name("main".to_owned());
    match thread.stack_size(STACK as usize).spawn(run) {
        Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
        Err(_) => run(),
    }
}

fn run() -> ExitCode {
    global::prepare();
    azimesh::cli::main()
}
