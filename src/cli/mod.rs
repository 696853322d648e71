//! The command line: one file per command. The only layer that prints and knows exit codes.

mod check;
mod completions;
mod context;
mod convert;
mod deform;
mod diff;
mod finish;
mod info;
mod input;
mod man;
mod memory;
#[cfg(feature = "mpi")]
mod mpi;
mod output;
mod progress;
mod quality;
mod repair;
mod report;
mod sample;
#[cfg(test)]
mod schema;
mod select;
mod shared;
#[cfg(unix)]
mod signals;
mod threads;
mod unfinished;

pub use context::Context;

use crate::alloc::limit::{self, SYSTEM_FAILED};
use azimesh_core::error::{Error, ErrorKind, Result, counted, name_options_as_flags};
use azimesh_core::note;
use azimesh_core::numbers::amount;
use azimesh_core::ranks::Ranks;
use azimesh_io::formats::by_name;
use clap::{Args, Parser, Subcommand};
use std::num::NonZeroUsize;
use std::process::ExitCode;

/// Deforms unstructured CFD meshes to follow moving bodies: rotor blades, wings, airfoils.
#[derive(Debug, Parser)]
#[command(name = "azimesh", version, about, max_term_width = 100)]
pub struct Cli {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    common: Common,
}

/// Options common to all commands.
#[derive(Debug, Clone, Default, Args)]
pub struct Common {
    /// Number of threads [default: all that the machine, its control group or the batch system grants]
    #[arg(long, global = true, value_name = "N", value_parser = threads::parse)]
    pub threads: Option<NonZeroUsize>,
    /// Print only errors, failed checks, and what --json asks for
    #[arg(short, long, global = true)]
    pub quiet: bool,
    /// Print details, such as the time of each stage and every warning
    #[arg(short, long, global = true, action = clap::ArgAction::Count, conflicts_with = "quiet")]
    pub verbose: u8,
    /// Print the result as JSON on standard output
    #[arg(long, global = true)]
    pub json: bool,
    /// Format that is written, whatever the file name says; convert -o DIR takes several, as cgns,su2. In commands that write no
    /// mesh it means the same as --input-format
    #[arg(long, global = true, value_name = "F", value_delimiter = ',')]
    pub format: Vec<String>,
    /// Format of the meshes that are read, whatever their content and their names say
    #[arg(long, global = true, value_name = "F")]
    pub input_format: Option<String>,
    /// VTK cell array that holds the boundary tags
    #[arg(long, global = true, value_name = "NAME")]
    pub tag_array: Option<String>,
    /// Most memory to use, such as 4G or 500M (powers of 1024); memory-mapped files do not count. deform and convert keep
    /// arrays that do not fit in files on the disk of the output. Without it, compressed files and input from a pipe may take half
    /// of the free memory
    #[arg(long, global = true, value_name = "SIZE", value_parser = memory::parse)]
    pub max_memory: Option<u64>,
}

impl Common {
    /// The format of `--format`, where it is given; refuses several.
    pub fn one_format(&self) -> Result<Option<&str>> {
        match &self.format[..] {
            [] => Ok(None),
            [name] => Ok(Some(name)),
            several => Err(Error::input(format!(
                "--format {}: one file has one format; convert -o DIR writes each mesh in several",
                several.join(",")
            ))),
        }
    }
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Show what is in a mesh: nodes, cells by type, zones, boundary tags, bounds
    Info(info::InfoArgs),
    /// Convert a mesh or a sequence to another format, with its tags
    Convert(Box<convert::ConvertArgs>),
    /// Show the quality of the cells, also against a reference mesh
    Quality(quality::QualityArgs),
    /// Make the folded cells of a mesh valid
    Repair(repair::RepairArgs),
    /// Check a schedule on a mesh without deforming it: tags, displacements, memory, disk, time
    Check(check::CheckArgs),
    /// Choose base points once, and save them
    Select(select::SelectArgs),
    /// Write a deformed mesh for each step of a schedule
    Deform(deform::DeformArgs),
    /// Join the parts of a sequence that were written separately
    Finish(finish::FinishArgs),
    /// Compare two meshes or sequences: nodes, cells, tags, arrays
    Diff(diff::DiffArgs),
    /// Write a self-contained HTML page of a sequence
    Report(report::ReportArgs),
    /// Write an example mesh and its schedule
    Sample(sample::SampleArgs),
    /// Print completions for a shell
    Completions(completions::CompletionsArgs),
    /// Print the manual page, or write one for each command
    Man(man::ManArgs),
}

impl Command {
    /// True if all ranks run the command.
    fn is_shared(&self) -> bool {
        match self {
            Self::Quality(args) => args.is_shared(),
            Self::Deform(_) | Self::Convert(_) => true,
            _ => false,
        }
    }

    /// Returns whether it writes no mesh, so that `--format` is about the input.
    fn only_reads(&self) -> bool {
        match self {
            Self::Quality(args) => args.is_shared(),
            Self::Info(_) | Self::Check(_) | Self::Select(_) | Self::Diff(_) => true,
            _ => false,
        }
    }

    /// Refuses common options that have no effect here, and formats that are not known.
    fn takes(&self, common: &Common) -> Result<()> {
        let reads_mesh = !matches!(
            self,
            Self::Finish(_)
                | Self::Report(_)
                | Self::Sample(_)
                | Self::Completions(_)
                | Self::Man(_)
        );
        let known = common.input_format.iter().chain(&common.format);
        known
            .map(|name| by_name(name))
            .collect::<Result<Vec<_>>>()?;
        if common.input_format.is_some() && !reads_mesh {
            let message =
                "--input-format does nothing here: no mesh is read whose format could be chosen";
            return Err(Error::input(message));
        }
        if self.only_reads()
            && let (Some(given), Some(input)) = (common.one_format()?, &common.input_format)
            && given != input
        {
            return Err(Error::input(format!(
                "--format {given} and --input-format {input}: this command writes no mesh, and both are the format of the input; \
                 give one of them"
            )));
        }
        let why = match self {
            Self::Finish(_) => {
                "steps are joined as they were written; `azimesh convert` gives a sequence another format"
            }
            Self::Report(_) => "the files of a sequence say what they are",
            Self::Convert(_) => return Ok(()),
            _ => return common.one_format().map(|_| ()),
        };
        if common.format.is_empty() {
            return Ok(());
        }
        Err(Error::input(format!("--format does nothing here: {why}")))
    }
}

/// The result of a command that has completed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// Success: exit code 0.
    Fine,
    /// A check failed: exit code 1.
    CheckFailed,
}

/// Parses the arguments, runs the command, prints its error and returns the exit code.
pub fn main() -> ExitCode {
    ExitCode::from(run_with(std::env::args_os()))
}

/// Like [`main`], with these arguments; the first is the program's name. If MPI has started several processes, one of them
/// prints.
pub fn run_with(arguments: impl IntoIterator<Item = std::ffi::OsString>) -> u8 {
    limit::end_where_threads_fail();
    name_options_as_flags();
    #[cfg(feature = "mpi")]
    let session = match mpi::start() {
        Ok(session) => session,
        Err(error) => return failed(&error, &Context::new(Common::default())),
    };
    #[cfg(feature = "mpi")]
    let (ranks, n_on_node) = session.as_ref().map_or((Ranks::alone(), 1), |session| {
        (session.ranks().clone(), session.n_on_node())
    });
    #[cfg(not(feature = "mpi"))]
    let (ranks, n_on_node) = (Ranks::alone(), 1);
    let mut arguments: Vec<_> = arguments.into_iter().collect();
    convert::bind_distance(&mut arguments);
    let shown = arguments.iter().skip(1);
    let shown = shown.map(|argument| argument.to_string_lossy().into_owned());
    let shown: Vec<String> = shown.collect();
    let cli = match Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            if ranks.is_first() {
                // A closed stderr is ignored.
                let _ = error.print();
                if error.use_stderr() && shown.iter().any(|argument| argument == "--json") {
                    print_json_of(&error);
                }
            }
            return u8::try_from(error.exit_code()).unwrap_or(u8::MAX);
        }
    };
    let is_shared = cli.command.is_shared();
    // The processors of the machine are reserved for the working ranks.
    let n_on_node = if is_shared { n_on_node } else { 1 };
    let mut context = Context::new(cli.common).on_ranks(&ranks, n_on_node);
    context.arguments = shown;
    let ready = prepare(&cli.command, &context);
    if cli.command.only_reads() {
        let common = &mut context.common;
        let given = common.format.first().cloned();
        common.input_format = common.input_format.take().or(given);
    }
    warn_of_ranks(&context);
    let ready = ready.and_then(|()| context.start_threads());
    let ready = ranks.all_ok(ready);
    if !is_shared && ranks.is_first() {
        context = context.on_ranks(&Ranks::alone(), n_on_node);
    }
    let outcome = match ready {
        Ok(()) if is_shared || ranks.is_first() => run(cli.command, &context),
        ready => ready.map(|()| Outcome::Fine),
    };
    let code = match outcome {
        Ok(Outcome::Fine) => 0,
        Ok(Outcome::CheckFailed) => 1,
        Err(error) => failed(&error, &context),
    };
    report_messages(&ranks, &context);
    ranks.broadcast(ranks.is_first().then_some(code))
}

/// Sets the limit of memory and signals. From here on a signal leaves no unfinished file behind; `deform` and `finish`
/// handle signals themselves, and on ranks other than the first signals have no effect.
fn prepare(command: &Command, context: &Context) -> Result<()> {
    if let Some(limit) = context.common.max_memory {
        limit::allow(limit);
    }
    let possible = command.takes(&context.common);
    #[cfg(unix)]
    {
        signals::outlive_file_limits();
        signals::end_where_inputs_shrink();
        let heard = match command {
            _ if !context.ranks.is_first() => signals::ignore(),
            Command::Deform(_) | Command::Finish(_) => Ok(()),
            Command::Info(_) | Command::Check(_) | Command::Diff(_) => signals::end("interrupted"),
            _ => signals::end("interrupted; files that are complete are kept"),
        };
        possible.and(heard)
    }
    #[cfg(not(unix))]
    possible
}

/// Warns of ranks that do not work together, and of ranks that compute differently.
fn warn_of_ranks(context: &Context) {
    #[cfg(not(feature = "mpi"))]
    {
        // Set by the launchers of Open MPI, and of those with PMI.
        let sizes = ["OMPI_COMM_WORLD_SIZE", "PMI_SIZE"].into_iter();
        let mut sizes = sizes.filter_map(|name| std::env::var(name).ok()?.parse::<usize>().ok());
        if let Some(n) = sizes.find(|n| *n > 1) {
            context.warn(note!(
                "no_mpi",
                "this azimesh was built without MPI: each of the {n} processes works for itself (cargo feature `mpi`)"
            ));
        }
    }
    if let Some(kinds) = context.ranks.kinds_of_processors() {
        context.warn(note!(
            "several_processors",
            "ranks run on processors of several kinds ({kinds}), which round sums in different ways: the last digits of \
             results depend on how many ranks there are, and where"
        ));
    }
}

/// Prints with `-v` the messages between ranks.
fn report_messages(ranks: &Ranks, context: &Context) {
    for sent in ranks.sent_by_all() {
        context.detail(&format!(
            "{}: {} sent, {}; at most {} by one rank",
            sent.what,
            counted(sent.messages as usize, "message"),
            amount(sent.bytes),
            amount(sent.most)
        ));
    }
}

/// Prints wrong arguments as JSON: the part of clap's message before the usage.
fn print_json_of(error: &clap::Error) {
    let text = error.to_string();
    let text = text.strip_prefix("error: ").unwrap_or(&text);
    let text = text.split("\n\nUsage:").next().unwrap_or_default();
    let parts = text.split("\n\n");
    let in_one_line = |part: &str| part.split_whitespace().collect::<Vec<_>>().join(" ");
    let parts: Vec<String> = parts.map(in_one_line).collect();
    let common = Common {
        json: true,
        ..Common::default()
    };
    Context::new(common).print_json_of(&Error::input(parts.join("; ")));
}

/// Prints an error and returns its exit code.
fn failed(error: &Error, context: &Context) -> u8 {
    context.error(error);
    if error.kind != ErrorKind::Check {
        context.print_json_of(error);
    }
    match error.kind {
        ErrorKind::Check => 1,
        ErrorKind::Input => 2,
        ErrorKind::System => SYSTEM_FAILED,
        // Returns the exit code that a shell reports for a program ended by a signal.
        ErrorKind::Interrupted { signal } => u8::try_from(128 + signal).unwrap_or(u8::MAX),
    }
}

fn run(command: Command, context: &Context) -> Result<Outcome> {
    match command {
        Command::Info(args) => info::run(&args, context),
        Command::Convert(args) => convert::run(&args, context),
        Command::Quality(args) => quality::run(&args, context),
        Command::Repair(args) => repair::run(&args, context),
        Command::Check(args) => check::run(&args, context),
        Command::Select(args) => select::run(&args, context),
        Command::Deform(args) => deform::run_command(&args, context),
        Command::Finish(args) => finish::run(&args, context),
        Command::Diff(args) => diff::run(&args, context),
        Command::Report(args) => report::run(&args, context),
        Command::Sample(args) => sample::run(&args, context),
        Command::Completions(args) => completions::run(&args, context),
        Command::Man(args) => man::run(&args, context),
    }
}
