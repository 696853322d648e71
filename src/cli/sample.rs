//! `azimesh sample`: creates a mesh and its schedule, and describes them.

use super::context::Entries;
use super::{Context, Outcome};
use crate::sample::{self, BladeOptions, Sample, SizeOptions};
use azimesh_core::error::{Error, Result, path_in_line};
use azimesh_core::note;
use azimesh_io::formats::{self, Commit, WriteOptions, save_text};
use azimesh_io::mesh::{Group, Mesh};
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Arguments of `azimesh sample`.
#[derive(Debug, clap::Args)]
#[command(subcommand_value_name = "NAME", subcommand_help_heading = "Samples")]
pub struct SampleArgs {
    #[command(subcommand)]
    name: Name,
}

#[derive(Debug, clap::Subcommand)]
enum Name {
    /// 2D: a NACA 0012 in a circle of five chords' diameter, quadrilaterals
    Naca0012 {
        #[command(flatten)]
        output: OutputArgs,
        #[command(flatten)]
        size: SizeOptions,
    },
    /// 3D: a rotor blade of NACA 0012 sections in a cylinder
    Blade {
        #[command(flatten)]
        output: OutputArgs,
        #[command(flatten)]
        blade: BladeOptions,
    },
    /// 3D: a blade in a cylinder, zone "rotor", inside a zone "background"; or several blades around a hub
    Rotor {
        #[command(flatten)]
        output: OutputArgs,
        #[command(flatten)]
        blade: BladeOptions,
        /// Number of blades around a hub, 3 to 5, without a background; --cylinder-radius is half the height then
        #[arg(long, value_name = "N")]
        blades: Option<usize>,
    },
    /// Any other name.
    #[command(external_subcommand)]
    Unknown(Vec<String>),
    /// 2D: the unit square with a block of 5 by 1 cells cut out, which turns and moves
    Block {
        #[command(flatten)]
        output: OutputArgs,
        /// Divide each of the 25 by 25 cells into N by N
        #[arg(long, value_name = "N", default_value_t = 1)]
        refine: usize,
    },
}

#[derive(Debug, clap::Args)]
struct OutputArgs {
    /// The mesh file; the schedule is written next to it, with the ending .toml
    #[arg(short, long, value_name = "MESH")]
    output: PathBuf,
    /// Replace existing files
    #[arg(long)]
    force: bool,
}

impl Name {
    fn output(&self) -> Result<&OutputArgs> {
        match self {
            Self::Naca0012 { output, .. }
            | Self::Blade { output, .. }
            | Self::Rotor { output, .. }
            | Self::Block { output, .. } => Ok(output),
            Self::Unknown(words) => Err(unknown(words)),
        }
    }

    fn make(&self) -> Result<Sample> {
        match self {
            Self::Naca0012 { size, .. } => sample::naca0012(size),
            Self::Blade { blade, .. } => sample::blade(blade),
            Self::Rotor { blade, blades, .. } => match blades {
                Some(n_blades) => sample::rotor_of(blade, *n_blades),
                None => sample::rotor(blade),
            },
            Self::Block { refine, .. } => sample::block(*refine),
            Self::Unknown(words) => Err(unknown(words)),
        }
    }
}

/// Returns the error for an unknown sample, named by the first of some words.
fn unknown(words: &[String]) -> Error {
    const KNOWN: [&str; 4] = ["naca0012", "blade", "rotor", "block"];
    let name = words.first().map_or("", String::as_str);
    let known = KNOWN.join(", ");
    Error::input(format!("there is no sample \"{name}\"; there are: {known}"))
}

pub(super) fn run(args: &SampleArgs, context: &Context) -> Result<Outcome> {
    let output = args.name.output()?;
    let path = &output.output;
    context.check_json_beside(path)?;
    let format = match context.common.one_format()? {
        Some(name) => formats::to_write(formats::by_name(name)?)?,
        None if is_stdout(path) => {
            return Err(Error::input("standard output needs --format"));
        }
        None => formats::by_extension(path)?,
    };
    let commit = Commit::with_force(output.force);
    let schedule = schedule_path(path, commit)?;
    let made = args.name.make()?;
    let (view, options) = (made.mesh.view(), WriteOptions::default());
    let write = || formats::save(&view, path, format, &options, commit);
    for loss in context.stage("writing", write)? {
        context.warn(loss);
    }
    if let Some(schedule) = &schedule {
        save_text(&made.schedule, schedule, commit)?;
    }
    report(&made.mesh, path, schedule.as_deref(), context)?;
    Ok(Outcome::Fine)
}

fn is_stdout(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// Returns the path of the schedule: next to a mesh in a file. Refuses to replace files unless forced.
fn schedule_path(mesh: &Path, commit: Commit) -> Result<Option<PathBuf>> {
    if is_stdout(mesh) {
        return Ok(None);
    }
    let schedule = mesh.with_extension("toml");
    if schedule == mesh {
        let message = "the schedule would have the same name; give the mesh another ending";
        return Err(Error::input(message).file(mesh));
    }
    for path in [mesh, &schedule] {
        commit.check(path)?;
    }
    Ok(Some(schedule))
}

/// The mesh that was made.
#[derive(Serialize)]
#[cfg_attr(test, derive(schemars::JsonSchema))]
pub(super) struct Sampled {
    /// Path of the mesh.
    mesh: String,
    /// Path of the schedule.
    schedule: String,
    /// Number of nodes.
    nodes: usize,
    /// Nodes on boundary faces.
    surface_nodes: usize,
    /// Cells by kind.
    cells: Entries<usize>,
    /// Cells by zone.
    zones: Entries<usize>,
    /// Faces by boundary tag.
    tags: Entries<usize>,
}

/// Prints one line, or JSON; to stderr if the mesh itself is written to stdout.
fn report(mesh: &Mesh, path: &Path, schedule: Option<&Path>, context: &Context) -> Result<()> {
    let n_surface = surface_nodes(mesh);
    let Some(schedule) = schedule else {
        context.note(note!("sampled", "{}", summary(mesh, n_surface)));
        return Ok(());
    };
    if context.common.json {
        let sizes = |group: &Group| (group.name.clone(), group.cells.len());
        return context.print_json(&Sampled {
            mesh: path.display().to_string(),
            schedule: schedule.display().to_string(),
            nodes: mesh.points.len(),
            surface_nodes: n_surface,
            cells: cells_by_kind(mesh).into_iter().collect(),
            zones: mesh.zones().map(sizes).collect(),
            tags: mesh.boundary_tags().map(sizes).collect(),
        });
    }
    context.print_result(&format!(
        "{}: {}; schedule: {}\n",
        path_in_line(path),
        summary(mesh, n_surface),
        path_in_line(schedule)
    ))
}

fn summary(mesh: &Mesh, n_surface: usize) -> String {
    let cells: Vec<String> = cells_by_kind(mesh)
        .into_iter()
        .map(|(kind, n)| format!("{n} {kind}"))
        .collect();
    let names: Vec<&str> = mesh.boundary_tags().map(|tag| tag.name.as_str()).collect();
    let zones: Vec<&str> = mesh.zones().map(|zone| zone.name.as_str()).collect();
    let zones = match zones.as_slice() {
        [] => String::new(),
        zones => format!("; zones {}", zones.join(", ")),
    };
    format!(
        "{} nodes, {n_surface} of them on boundaries; cells: {}; tags {}{zones}",
        mesh.points.len(),
        cells.join(", "),
        names.join(", "),
    )
}

fn cells_by_kind(mesh: &Mesh) -> Vec<(&'static str, usize)> {
    let mut counts = BTreeMap::new();
    for run in mesh.cells.runs() {
        *counts.entry(run.kind).or_insert(0) += run.n_cells();
    }
    let named = |(kind, n): (azimesh_io::mesh::CellKind, usize)| (kind.name(), n);
    counts.into_iter().rev().map(named).collect()
}

/// Counts the nodes of the cells with a boundary tag, each once.
fn surface_nodes(mesh: &Mesh) -> usize {
    let mut on_surface = vec![false; mesh.points.len()];
    for tag in mesh.boundary_tags() {
        for run in tag
            .cells
            .ranges()
            .flat_map(|range| mesh.cells.runs_in(range))
        {
            for &node in run.connectivity {
                on_surface[node as usize] = true;
            }
        }
    }
    on_surface.into_iter().filter(|&on| on).count()
}
