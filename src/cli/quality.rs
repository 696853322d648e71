//! `azimesh quality`.

use super::output::OutputArgs;
use super::{Context, Outcome};
use crate::error::{Error, Result};
use crate::formats::{self, Format};
use crate::geometry::vector::{add, scale};
use crate::mesh::{DataArray, Mesh};
use crate::quality::{CellMetrics, Criterion, Extreme, Judge, Quality, per_cell};
use serde_json::{Map, Value, json};
use std::fmt::Write;
use std::path::PathBuf;

/// Arguments of `azimesh quality`.
#[derive(Debug, clap::Args)]
#[command(
    after_help = "A cell is inverted when it is valid in the reference mesh and a corner of it \
has turned over or become flat. Without --reference the mesh is its own reference: nothing can be \
inverted then, and cells that are bad as they are count as inverted_reference."
)]
pub struct QualityArgs {
    /// Mesh to judge; - is standard input
    mesh: PathBuf,
    /// Mesh with the same cells that says how each is oriented
    #[arg(long, value_name = "MESH")]
    reference: Option<PathBuf>,
    /// List the N cells with the smallest scaled Jacobian
    #[arg(long, value_name = "N", default_value_t = 0)]
    worst: usize,
    /// Exit with 1 where this holds, as in "inverted>0" or "min_scaled_jacobian<0.1"; repeatable
    #[arg(long, value_name = "EXPR")]
    fail_on: Vec<Criterion>,
    /// Write the mesh with its quality as cell arrays
    #[arg(short, long, value_name = "OUT")]
    output: Option<PathBuf>,
    #[command(flatten)]
    write: OutputArgs,
}

pub(super) fn run(args: &QualityArgs, context: &Context) -> Result<Outcome> {
    let columns = Quality::default().columns();
    for criterion in &args.fail_on {
        criterion.check_column(columns.iter().map(|(name, _)| *name))?;
    }
    let format = output_format(args)?;
    let mesh = context.read_mesh(&args.mesh)?;
    let other = reference(args, context, &mesh)?;
    let before = other.as_ref().unwrap_or(&mesh);
    let judge = context.stage("faces", || Ok(Judge::new(before)))?;
    let quality = context.stage("quality", || {
        Ok(judge.assess(&mesh, &mesh.points, &before.points))
    })?;
    let wanted = args.worst > 0;
    let metrics = wanted.then(|| per_cell(&mesh, &mesh.points, &judge.reference));
    let worst = metrics
        .as_ref()
        .map_or_else(Vec::new, |metrics| worst_cells(&mesh, metrics, args.worst));
    let mut met = Vec::new();
    for criterion in &args.fail_on {
        if criterion.is_met(&quality.columns())? {
            met.push(criterion);
        }
    }
    if context.common.json {
        context.print_json(as_json(&quality, &worst, &met))?;
    } else {
        context.print(&as_text(&quality, &worst))?;
        for criterion in &met {
            context.warn(&format!("{criterion} holds"));
        }
    }
    if let (Some(path), Some(format)) = (&args.output, format) {
        let arrays = judge.arrays(&mesh, &mesh.points, &before.points);
        args.write
            .save(&with_arrays(mesh, arrays), path, format, context)?;
    }
    Ok(match met.is_empty() {
        true => Outcome::Fine,
        false => Outcome::CheckFailed,
    })
}

/// The output's format by its ending; also refuses to replace a file.
fn output_format(args: &QualityArgs) -> Result<Option<&'static dyn Format>> {
    let Some(path) = &args.output else {
        return Ok(None);
    };
    let format = formats::by_extension(path)?;
    args.write.check(path)?;
    Ok(Some(format))
}

fn reference(args: &QualityArgs, context: &Context, mesh: &Mesh) -> Result<Option<Mesh>> {
    let Some(path) = &args.reference else {
        return Ok(None);
    };
    let other = context.read_mesh(path)?;
    if other.cells != mesh.cells {
        return Err(Error::input(format!(
            "its cells are not those of {}: a reference has the same cells in the same order",
            args.mesh.display()
        ))
        .file(path));
    }
    Ok(Some(other))
}

fn with_arrays(mut mesh: Mesh, arrays: Vec<DataArray>) -> Mesh {
    mesh.cell_arrays
        .retain(|old| arrays.iter().all(|new| new.name != old.name));
    mesh.cell_arrays.extend(arrays);
    mesh
}

/// A cell of the list of the worst.
struct WorstCell {
    cell: usize,
    kind: &'static str,
    /// Mean of its nodes.
    position: [f64; 3],
    scaled_jacobian: f64,
    volume: f64,
    /// Tags that hold a face with one of its nodes.
    tags: Vec<String>,
}

/// The cells with the smallest scaled Jacobian; cells without one come by volume after them.
fn worst_cells(mesh: &Mesh, metrics: &CellMetrics, n: usize) -> Vec<WorstCell> {
    let rank = |cell: &usize| (metrics.scaled_jacobian[*cell], metrics.volume[*cell]);
    let mut cells: Vec<usize> = (0..mesh.cells.len())
        .filter(|&cell| !metrics.volume[cell].is_nan())
        .collect();
    let order = |a: &usize, b: &usize| {
        let ((a0, a1), (b0, b1)) = (rank(a), rank(b));
        let by_first = a0.is_nan().cmp(&b0.is_nan()).then(a0.total_cmp(&b0));
        by_first.then(a1.total_cmp(&b1)).then(a.cmp(b))
    };
    if n < cells.len() {
        cells.select_nth_unstable_by(n, order);
        cells.truncate(n);
    }
    cells.sort_unstable_by(order);
    let tags = touching_tags(mesh, &cells);
    cells
        .into_iter()
        .zip(tags)
        .map(|(cell, tags)| {
            let nodes = mesh.cells.get(cell).nodes;
            let sum = nodes
                .iter()
                .fold([0.0; 3], |sum, &node| add(sum, mesh.points[node as usize]));
            WorstCell {
                cell,
                kind: mesh.cells.get(cell).kind.name(),
                position: scale(sum, 1.0 / nodes.len() as f64),
                scaled_jacobian: metrics.scaled_jacobian[cell],
                volume: metrics.volume[cell],
                tags,
            }
        })
        .collect()
}

fn touching_tags(mesh: &Mesh, cells: &[usize]) -> Vec<Vec<String>> {
    let mut found = vec![Vec::new(); cells.len()];
    if cells.is_empty() {
        return found;
    }
    for tag in mesh.boundary_tags() {
        let mut on_tag = vec![false; mesh.points.len()];
        for node in tag.cells.iter().flat_map(|face| mesh.cells.get(face).nodes) {
            on_tag[*node as usize] = true;
        }
        for (cell, tags) in cells.iter().zip(&mut found) {
            let nodes = mesh.cells.get(*cell).nodes;
            if nodes.iter().any(|&node| on_tag[node as usize]) {
                tags.push(tag.name.clone());
            }
        }
    }
    found
}

fn as_text(quality: &Quality, worst: &[WorstCell]) -> String {
    let summary = &quality.cells;
    let mut text = String::new();
    let mut row = |name: &str, value: String| {
        writeln!(text, "{name:24}{value}").expect("a string takes any text");
    };
    row("cells", summary.n_cells.to_string());
    row(
        "faces",
        (quality.faces.n_inner + quality.faces.n_outer).to_string(),
    );
    for (name, value) in quality.columns() {
        let at =
            extreme(quality, name).map_or_else(String::new, |e| format!("  (cell {})", e.cell));
        let value = value.map_or_else(|| "-".into(), number);
        row(name, format!("{value}{at}"));
    }
    row("total_volume", number(summary.total_volume));
    if !summary.inverted_cells.is_empty() {
        let first: Vec<String> = summary
            .inverted_cells
            .iter()
            .map(usize::to_string)
            .collect();
        row("inverted cells", first.join(" "));
    }
    for cell in worst {
        let [x, y, z] = cell.position;
        let tags = match cell.tags.is_empty() {
            true => String::new(),
            false => format!(", at {}", cell.tags.join(", ")),
        };
        let (i, kind, scaled) = (cell.cell, cell.kind, cell.scaled_jacobian);
        let line = format!("scaled Jacobian {scaled:.6e}, volume {:.6e}", cell.volume);
        writeln!(
            text,
            "{kind} {i} at ({x:.6e} {y:.6e} {z:.6e}): {line}{tags}"
        )
        .expect("a string takes any text");
    }
    text
}

/// A count without a point, anything else with an exponent where it is very small or large.
fn number(x: f64) -> String {
    if x == x.trunc() && x.abs() < 1e15 {
        format!("{x}")
    } else {
        format!("{x:?}")
    }
}

fn extreme(quality: &Quality, column: &str) -> Option<Extreme> {
    let (summary, faces) = (&quality.cells, &quality.faces);
    match column {
        "min_volume" => summary.min_volume,
        "min_scaled_jacobian" => summary.min_scaled_jacobian,
        "max_edge_ratio" => summary.max_edge_ratio,
        "max_skew" => summary.max_skew,
        "max_non_orthogonality" => faces.max_non_orthogonality,
        "max_face_skewness" => faces.max_face_skewness,
        "min_volume_ratio" => faces.min_volume_ratio,
        "min_face_weight" => faces.min_face_weight,
        "min_size_skew" => quality.size_skew.min,
        _ => None,
    }
}

fn as_json(quality: &Quality, worst: &[WorstCell], met: &[&Criterion]) -> Value {
    let summary = &quality.cells;
    let mut object = Map::new();
    object.insert("cells".into(), summary.n_cells.into());
    object.insert("inner_faces".into(), quality.faces.n_inner.into());
    object.insert("outer_faces".into(), quality.faces.n_outer.into());
    for (name, value) in quality.columns() {
        let value = match (name, value) {
            ("inverted" | "inverted_reference", Some(count)) => json!(count as u64),
            (_, value) => json!(value),
        };
        object.insert(name.into(), value);
        if let Some(extreme) = extreme(quality, name) {
            object.insert(format!("{name}_cell"), extreme.cell.into());
        }
    }
    object.insert("total_volume".into(), json!(summary.total_volume));
    object.insert("inverted_cells".into(), json!(summary.inverted_cells));
    let worst: Vec<Value> = worst
        .iter()
        .map(|cell| {
            json!({
                "cell": cell.cell,
                "kind": cell.kind,
                "position": cell.position,
                "scaled_jacobian": cell.scaled_jacobian,
                "volume": cell.volume,
                "tags": cell.tags,
            })
        })
        .collect();
    object.insert("worst".into(), worst.into());
    let met: Vec<String> = met.iter().map(ToString::to_string).collect();
    object.insert("failed_on".into(), json!(met));
    Value::Object(object)
}
