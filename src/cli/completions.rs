//! `azimesh completions`: scripts with which a shell completes commands and options.

use super::{Cli, Context, Outcome};
use azimesh_core::error::Result;
use clap::CommandFactory;
use clap_complete::Shell;
use serde::Serialize;

/// Arguments of `azimesh completions`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Where a shell looks for it:\n  \
bash        ~/.local/share/bash-completion/completions/azimesh\n  \
zsh         _azimesh in a folder of $fpath\n  \
fish        ~/.config/fish/completions/azimesh.fish\n  \
elvish      appended to ~/.config/elvish/rc.elv\n  \
powershell  appended to $PROFILE")]
pub struct CompletionsArgs {
    /// The shell
    #[arg(value_enum)]
    shell: Shell,
}

/// A script for a shell.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Completions {
    /// Name of the shell.
    shell: String,
    /// The script.
    script: String,
}

pub(super) fn run(args: &CompletionsArgs, context: &Context) -> Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "azimesh", &mut script);
    let script = String::from_utf8_lossy(&script);
    if context.common.json {
        context.print_json(&Completions {
            shell: args.shell.to_string(),
            script: script.into_owned(),
        })?
    } else {
        context.print(&script)?
    }
    Ok(Outcome::Fine)
}
