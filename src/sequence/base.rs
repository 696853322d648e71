//! Base points on disk: base.toml to go on from, base.vtp to look at.

use super::plan::Plan;
use crate::error::{Error, Result};
use crate::formats::save_text;
use crate::geometry::vector::Vector;
use crate::rbf::select::{self, Selection};
use serde::{Deserialize, Serialize};
use std::path::{Path, PathBuf};

/// What base.toml holds.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseFile {
    /// Version of this layout.
    pub version: u32,
    /// Kernel of the interpolation.
    pub kernel: String,
    /// Support radius, in mesh units.
    pub support_radius: f64,
    /// Tolerance that was asked for, in mesh units.
    pub tolerance: f64,
    /// Largest error at any surface node and step that was reached, in mesh units.
    pub error: f64,
    /// Number of nodes of the mesh.
    pub mesh_nodes: usize,
    /// Hash of the node positions of the mesh.
    pub mesh_points_blake3: String,
    /// Mesh nodes that are base points, in the order chosen.
    pub nodes: Vec<u32>,
}

/// Writes `path` and the .vtp beside it.
pub fn save(plan: &Plan, selection: &Selection, path: &Path) -> Result<()> {
    let file = BaseFile {
        version: 1,
        kernel: plan.basis.kernel.name().to_owned(),
        support_radius: plan.basis.radius,
        tolerance: plan.tolerance,
        error: selection.error,
        mesh_nodes: plan.reference.len(),
        mesh_points_blake3: hash_of(&plan.reference),
        nodes: selection
            .base
            .iter()
            .map(|&i| plan.surface.nodes[i])
            .collect(),
    };
    let text = toml::to_string(&file)
        .map_err(|error| Error::system(format!("the base points cannot be written: {error}")))?;
    save_text(&text, path)?;
    save_text(&polydata(plan, selection), &picture_of(path))
}

/// The .vtp beside a base file.
pub fn picture_of(path: &Path) -> PathBuf {
    path.with_extension("vtp")
}

/// Base points read from `path`, with weights for the plan's motion.
pub fn load(plan: &Plan, path: &Path) -> Result<Selection> {
    let text = std::fs::read_to_string(path).map_err(|error| Error::io(path, &error))?;
    let file: BaseFile = toml::from_str(&text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        let line = text[..start].bytes().filter(|b| *b == b'\n').count() + 1;
        Error::input(error.message().to_owned())
            .line(line as u64)
            .file(path)
    })?;
    check(plan, &file).map_err(|error| error.file(path))?;
    let base = plan
        .surface
        .find(&file.nodes)
        .map_err(|error| error.file(path))?;
    select::from_base(plan.basis, plan.targets(), base)
}

fn check(plan: &Plan, file: &BaseFile) -> Result<()> {
    if file.version != 1 {
        return Err(Error::input(format!(
            "version = {}; this program reads version 1",
            file.version
        )));
    }
    if file.mesh_nodes != plan.reference.len()
        || file.mesh_points_blake3 != hash_of(&plan.reference)
    {
        return Err(Error::input(format!(
            "the base points were chosen on another mesh: one of {} nodes, this has {}",
            file.mesh_nodes,
            plan.reference.len()
        )));
    }
    let (kernel, radius) = (plan.basis.kernel.name(), plan.basis.radius);
    if file.kernel != kernel || file.support_radius != radius {
        return Err(Error::input(format!(
            "the base points were chosen with {} and support radius {}, the schedule has {kernel} and {radius}",
            file.kernel, file.support_radius
        )));
    }
    let mut sorted = file.nodes.clone();
    sorted.sort_unstable();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(Error::input(format!("node {} is listed twice", pair[0])));
    }
    Ok(())
}

fn hash_of(points: &[Vector]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update_rayon(bytemuck::cast_slice(points));
    hasher.finalize().to_string()
}

/// The base points as VTK polydata: vertices in the order chosen, with that order, the mesh node and
/// the body (-1 where the point stays).
fn polydata(plan: &Plan, selection: &Selection) -> String {
    let base = &selection.base;
    let join = |values: Vec<String>| values.join(" ");
    let surface = &plan.surface;
    let points = join(
        base.iter()
            .map(|&i| surface.points[i].map(|x| x.to_string()).join(" "))
            .collect(),
    );
    let order = join((0..base.len()).map(|i| i.to_string()).collect());
    let after = join((1..=base.len()).map(|i| i.to_string()).collect());
    let nodes = join(base.iter().map(|&i| surface.nodes[i].to_string()).collect());
    let body = |i: usize| surface.body[i].map_or("-1".to_owned(), |b| b.to_string());
    let bodies = join(base.iter().map(|&i| body(i)).collect());
    let n = base.len();
    let array = |kind: &str, name: &str, values: &str| {
        format!(
            "        <DataArray type=\"{kind}\" Name=\"{name}\" format=\"ascii\">{values}</DataArray>\n"
        )
    };
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" byte_order=\"LittleEndian\">\n  \
         <PolyData>\n    <Piece NumberOfPoints=\"{n}\" NumberOfVerts=\"{n}\" NumberOfLines=\"0\" \
         NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n      <PointData>\n{}{}{}      </PointData>\n      \
         <Points>\n        <DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">{points}</DataArray>\n      \
         </Points>\n      <Verts>\n{}{}      </Verts>\n    </Piece>\n  </PolyData>\n</VTKFile>\n",
        array("Int32", "Order", &order),
        array("Int32", "Node", &nodes),
        array("Int32", "Body", &bodies),
        array("Int32", "connectivity", &order),
        array("Int32", "offsets", &after),
    )
}
