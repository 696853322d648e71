//! `azimesh diff`: two meshes, or two sequences step by step.

mod sequence;
mod told;

use super::input::Input;
use super::{Context, Outcome};
use azimesh_core::error::{Error, Result};
use azimesh_core::note;
use azimesh_io::mesh::{Difference, Mesh, Tolerance};
use sequence::SequenceDifference;
use serde::Serialize;
use std::path::PathBuf;
use told::MeshDifference;

/// Arguments of `azimesh diff`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Exit code 0: the same; 1: different. -v lists every difference. Sequences (a .pvd, a file of \
several steps, a folder with one of them) are compared step by step."
)]
pub struct DiffArgs {
    /// First mesh or sequence; - is standard input
    a: PathBuf,
    /// Second mesh or sequence
    b: PathBuf,
    /// Nodes, and values of arrays, that differ by no more than this are the same
    #[arg(long, value_name = "T", default_value_t = 0.0)]
    tolerance: f64,
    /// Take tolerances as fractions of the first mesh's diagonal, and of the largest value of an array
    #[arg(long)]
    relative: bool,
    /// Pairing of the nodes and cells of both meshes
    #[arg(
        long = "match",
        value_name = "HOW",
        value_enum,
        default_value = "order"
    )]
    matching: Matching,
    /// With --match position: largest distance between nodes that are paired
    /// [default: the tolerance, and at least 1e-9 of the diagonal]
    #[arg(long, value_name = "T")]
    match_tolerance: Option<f64>,
    /// Compare these only; repeatable, or several behind commas [default: all]
    #[arg(long, value_name = "WHAT", value_enum, value_delimiter = ',')]
    only: Vec<Part>,
}

/// Part of two meshes to compare.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Part {
    /// Number and positions of nodes
    Nodes,
    /// Cells: kinds and nodes
    Cells,
    /// Boundary tags, zones and other groups
    Tags,
    /// Arrays of nodes, of cells and of the mesh
    Arrays,
}

/// Pairing of nodes and cells.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
enum Matching {
    /// By their numbers
    Order,
    /// Nodes by their positions, and cells by their nodes, whatever their numbers
    Position,
}

pub(super) fn run(args: &DiffArgs, context: &Context) -> Result<Outcome> {
    args.check()?;
    let a = Input::open(&args.a, context)?;
    let b = Input::open(&args.b, context)?;
    let same = match (a.times(), b.times()) {
        (None, None) => one_mesh(args, &a, &b, context)?,
        (Some(ours), Some(theirs)) => {
            let sequences = [(&a, &ours[..]), (&b, &theirs[..])];
            sequence::compare(args, sequences, context)?
        }
        (ours, _) => {
            let (many, one) = if ours.is_some() { (&a, &b) } else { (&b, &a) };
            return Err(Error::input(format!(
                "this is a sequence, and {} is one mesh; `azimesh convert --step I` writes one step of \
                 a sequence to a file",
                one.path().display()
            ))
            .file(many.path()));
        }
    };
    Ok(if same {
        Outcome::Fine
    } else {
        Outcome::CheckFailed
    })
}

/// The differences of two meshes, at the top, or of two sequences, in `steps`.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(super) enum Differences {
    /// Two meshes.
    Meshes(Box<MeshDifference>),
    /// Two sequences.
    Sequences(SequenceDifference),
}

fn one_mesh(args: &DiffArgs, a: &Input, b: &Input, context: &Context) -> Result<bool> {
    let difference = args.difference(&a.mesh(None, context)?, &b.mesh(None, context)?, context)?;
    if context.common.json {
        context.print_json(&Differences::Meshes(Box::new(MeshDifference::of(
            &difference,
        ))))?;
    } else {
        let details = match context.common.verbose {
            0 => String::new(),
            _ => told::details(&difference, "  "),
        };
        tell(
            &difference.to_string(),
            &details,
            difference.is_same(),
            context,
        )?;
    }
    Ok(difference.is_same())
}

/// Prints a line and its details; if quiet, only the difference.
fn tell(line: &str, details: &str, same: bool, context: &Context) -> Result<()> {
    if context.common.quiet && !same {
        context.complain(note!("differs", "{line}"));
    }
    context.print_result(&format!("{line}\n{details}"))
}

impl DiffArgs {
    fn check(&self) -> Result<()> {
        let tolerances = [
            ("--tolerance", Some(self.tolerance)),
            ("--match-tolerance", self.match_tolerance),
        ];
        for (option, value) in tolerances {
            if let Some(value) = value.filter(|value| !(*value >= 0.0 && value.is_finite())) {
                return Err(Error::input(format!(
                    "{option} {value}: it must be 0 or larger"
                )));
            }
        }
        if self.match_tolerance.is_some() && self.matching == Matching::Order {
            return Err(Error::input("--match-tolerance needs --match position"));
        }
        Ok(())
    }

    /// Compares two meshes as requested; notes report decisions made on the way.
    fn difference(&self, a: &Mesh, b: &Mesh, context: &Context) -> Result<Difference> {
        let tolerance = Tolerance {
            value: self.tolerance,
            relative: self.relative,
        };
        let mut found = context.stage("comparing", || match self.matching {
            Matching::Order => Ok(Difference::between(a, b, tolerance)),
            Matching::Position => Difference::by_position(a, b, tolerance, self.match_tolerance),
        })?;
        for note in &found.notes {
            context.note(note.clone());
        }
        if !self.only.is_empty() {
            let parts = [Part::Nodes, Part::Cells, Part::Tags, Part::Arrays];
            found.keep(parts.map(|part| self.only.contains(&part)));
        }
        Ok(found)
    }
}
