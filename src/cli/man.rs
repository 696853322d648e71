//! `azimesh man`: manual pages, one for the program and one for each command.

use super::{Cli, Context, Outcome};
use azimesh_core::error::{Error, Result};
use azimesh_io::formats::{Commit, save_text};
use clap::{Command, CommandFactory};
use serde::Serialize;
use std::path::PathBuf;

/// Arguments of `azimesh man`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Try `azimesh man | man -l -`, or put the pages of -o where man looks: \
~/.local/share/man/man1."
)]
pub struct ManArgs {
    /// Folder for the pages azimesh.1, azimesh-info.1 and so on; without it azimesh.1 is printed
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

/// Text in the footer of each page.
const SOURCE: &str = concat!("azimesh ", env!("CARGO_PKG_VERSION"));

/// The manual page as text, or the pages that were written with `-o DIR`.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(super) enum Manual {
    /// One page.
    Page(Page),
    /// Pages in a folder.
    Written {
        /// The folder.
        folder: String,
        /// Names of the files.
        pages: Vec<String>,
    },
}

/// A manual page.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Page {
    /// Name of the page.
    page: String,
    /// Its text.
    text: String,
}

pub(super) fn run(args: &ManArgs, context: &Context) -> Result<Outcome> {
    let mut pages = Vec::new();
    let mut program = Cli::command().disable_help_subcommand(true);
    program.build();
    add_pages(&program, &mut pages)?;
    match &args.output {
        Some(folder) => {
            let paths: Vec<PathBuf> = pages.iter().map(|page| folder.join(&page.page)).collect();
            let commit = Commit::with_force(args.force);
            paths.iter().try_for_each(|path| commit.check(path))?;
            std::fs::create_dir_all(folder).map_err(|error| Error::io(folder, &error))?;
            for (page, path) in pages.iter().zip(&paths) {
                save_text(&page.text, path, commit)?;
            }
            let files: Vec<String> = pages.into_iter().map(|page| page.page).collect();
            if context.common.json {
                context.print_json(&Manual::Written {
                    folder: folder.display().to_string(),
                    pages: files,
                })?;
            } else {
                files.iter().for_each(|file| context.detail(file));
            }
        }
        None if context.common.json => {
            context.print_json(&Manual::Page(pages.swap_remove(0)))?;
        }
        None => context.print(&pages[0].text)?,
    }
    Ok(Outcome::Fine)
}

/// Returns the page of a command, followed by the pages of its subcommands.
fn add_pages(command: &Command, pages: &mut Vec<Page>) -> Result<()> {
    let man = clap_mangen::Man::new(command.clone())
        .manual("azimesh")
        .source(SOURCE);
    let mut text = Vec::new();
    man.render(&mut text)
        .map_err(|error| Error::system(format!("a manual page cannot be made: {error}")))?;
    pages.push(Page {
        page: man.get_filename(),
        text: String::from_utf8_lossy(&text).into_owned(),
    });
    command
        .get_subcommands()
        .filter(|command| !command.is_hide_set())
        .try_for_each(|command| add_pages(command, pages))
}
