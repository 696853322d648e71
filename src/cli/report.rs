//! `azimesh report`: one HTML page of a sequence.

use super::{Context, Outcome};
use crate::error::{Error, Result, path_in_line};
use crate::formats::{self, Commit};
use crate::report;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Arguments of `azimesh report`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "The page needs no other file and no network. A sequence that is not finished gives a page of \
the steps there are."
)]
pub struct ReportArgs {
    /// Folder that `azimesh deform -o` has made
    #[arg(value_name = "DIR")]
    folder: PathBuf,
    /// Where the page goes, in place of report.html in the folder; - is standard output
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Replace a page that exists
    #[arg(long)]
    force: bool,
}

pub(super) fn run(args: &ReportArgs, context: &Context) -> Result<Outcome> {
    let output = args.output.clone();
    let output = output.unwrap_or_else(|| args.folder.join("report.html"));
    let is_stdout = output.as_os_str() == "-";
    if is_stdout && context.common.json {
        return Err(Error::input(
            "--json and a page on standard output do not go together; give -o a file",
        ));
    }
    let commit = Commit::with_force(args.force);
    commit.check(&output)?;
    let page = context.stage("reading", || {
        report::page(&args.folder, &context.read_options())
    })?;
    formats::save_text(&page.html, &output, commit)?;
    for note in &page.notes {
        context.note(note);
    }
    if !is_stdout {
        tell(&page, &output, context)?;
    }
    Ok(Outcome::Fine)
}

fn tell(page: &report::Page, output: &Path, context: &Context) -> Result<()> {
    let bytes = page.html.len();
    if context.common.json {
        return context.print_json(json!({
            "file": output.display().to_string(),
            "bytes": bytes,
            "steps": page.n_steps,
            "notes": page.notes,
        }));
    }
    match context.common.quiet {
        true => Ok(()),
        false => context.print_result(&format!(
            "{}: {} steps, {bytes} bytes\n",
            path_in_line(output),
            page.n_steps
        )),
    }
}
