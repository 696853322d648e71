//! `azimesh report`: one HTML page of a sequence.

use super::unfinished::unfinished;
use super::{Context, Outcome};
use crate::report;
use azimesh_core::error::{Error, Result, counted, path_in_line};
use azimesh_core::numbers::amount;
use azimesh_io::formats::{self, Commit};
use serde::Serialize;
use std::path::{Path, PathBuf};

/// Arguments of `azimesh report`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The page needs no other file and no network. If the run is not finished, the page has the steps \
written so far."
)]
pub struct ReportArgs {
    /// Folder that `azimesh deform -o` has written
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// File of the page, - for standard output [default: report.html in the folder]
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ReportArgs, context: &Context) -> Result<Outcome> {
    let output = args.output.clone();
    let output = output.unwrap_or_else(|| args.folder.join("report.html"));
    let is_stdout = output.as_os_str() == "-";
    if is_stdout && context.common.json {
        return Err(Error::input(
            "--json and a page cannot both go to standard output; give -o a file",
        ));
    }
    let commit = Commit::with_force(args.force);
    let records = formats::records_in(&args.folder);
    let records = records.as_deref().unwrap_or(&args.folder);
    // All that the run has left, but for earlier pages.
    let is_page = |path: &PathBuf| path.extension().is_some_and(|ending| ending == "html");
    for folder in [records, &args.folder] {
        let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
        let files = entries.map(|entry| entry.path());
        formats::guard_inputs(files.filter(|path| path.is_file() && !is_page(path)));
    }
    formats::guard_inputs([&args.folder]);
    commit.check(&output)?;
    let unfinished = unfinished(&args.folder);
    let page = context.stage("reading", || {
        report::page(&args.folder, &context.read_options())
    });
    let mut page = page.map_err(|mut error| {
        let how = unfinished.iter().map(|how| format!("; {}", how.text));
        error.message.extend(how);
        error
    })?;
    page.notes.extend(unfinished);
    formats::save_text(&page.html, &output, commit)?;
    for note in page.notes {
        context.note(note);
    }
    if !is_stdout {
        tell(page.html.len(), page.n_steps, &output, context)?;
    }
    Ok(Outcome::Fine)
}

/// The page that was written.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Written {
    /// Path of the page.
    file: String,
    /// Its size.
    bytes: usize,
    /// Steps on it.
    steps: usize,
}

fn tell(bytes: usize, steps: usize, output: &Path, context: &Context) -> Result<()> {
    if context.common.json {
        return context.print_json(&Written {
            file: output.display().to_string(),
            bytes,
            steps,
        });
    }
    if context.common.quiet {
        Ok(())
    } else {
        context.print_result(&format!(
            "{}: {}, {}\n",
            path_in_line(output),
            counted(steps, "step"),
            amount(bytes as u64)
        ))
    }
}
