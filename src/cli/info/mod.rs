//! `azimesh info`.

mod facts;
mod json;
mod text;

use super::input::Input;
use super::{Context, Outcome};
use azimesh_core::error::Result;
use facts::Facts;
pub use json::Info;
use json::{MeshInfo, NamedInfo};
use std::path::{Path, PathBuf};

/// Arguments of `azimesh info`.
#[derive(Debug, clap::Args)]
pub struct InfoArgs {
    /// Meshes or sequences; - is standard input
    #[arg(value_name = "MESH", required = true)]
    meshes: Vec<PathBuf>,

    /// Look at this step of a sequence, counted from 0; the last by default
    #[arg(long, value_name = "I")]
    step: Option<usize>,
}

/// Prints each mesh; if one cannot be read, the others all the same.
pub(super) fn run(args: &InfoArgs, context: &Context) -> Result<Outcome> {
    if let [mesh] = &args.meshes[..] {
        let description = describe(mesh, args.step, context)?;
        match description {
            Description::Json(info) => context.print_json(&Info::One(info))?,
            Description::Text(text) => context.print_result(&text)?,
        }
        return Ok(Outcome::Fine);
    }
    let (mut all, mut failed) = (Vec::new(), Vec::new());
    for path in &args.meshes {
        match describe(path, args.step, context) {
            Ok(Description::Json(info)) => all.push(NamedInfo {
                info: *info,
                file: path.display().to_string(),
            }),
            Ok(Description::Text(text)) => {
                context.print_result(&format!("{}:\n{text}\n", path.display()))?;
            }
            Err(error) => failed.push(error),
        }
    }
    if context.common.json {
        let errors = failed.iter().map(Into::into).collect();
        context.print_json(&Info::Several {
            meshes: all,
            errors,
        })?;
    }
    let last = failed.pop();
    for error in failed {
        context.error(&error);
    }
    last.map_or(Ok(Outcome::Fine), Err)
}

/// Text about one mesh.
enum Description {
    Json(Box<MeshInfo>),
    Text(String),
}

fn describe(path: &Path, step: Option<usize>, context: &Context) -> Result<Description> {
    let input = Input::open(path, context)?;
    input.check_step(step)?;
    let loaded = input.read(step, context)?;
    let facts = context.stage("inspecting", || Ok(Facts::of(&input, step, &loaded)))?;
    for note in &facts.notes {
        context.note(note.clone().file(path));
    }
    Ok(if context.common.json {
        Description::Json(Box::new(MeshInfo::of(&facts)))
    } else {
        Description::Text(text::of(&facts))
    })
}
