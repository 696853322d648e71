//! Base points on disk: base.toml to resume from, base.vtp for viewing.

use crate::record::BaseFile;
use azimesh_core::error::{Error, Result};
use azimesh_deform::{BasePoints, LayerKind, Plan, from_nodes};
use azimesh_io::formats::{Commit, read_input, save_text};
use azimesh_rbf::select::Selection;
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Writes `path` and the .vtp next to it.
pub fn save(plan: &Plan, selections: &[Selection], path: &Path, commit: Commit) -> Result<()> {
    let nodes_of = |selection: &Selection| {
        let base = selection.base.iter();
        base.map(|&i| plan.surface.nodes[i]).collect::<Vec<u32>>()
    };
    let of = |wanted: &str| {
        let mut layers = plan.layers.iter().zip(selections);
        layers
            .find(|(layer, _)| layer.name() == wanted)
            .map(|(_, selection)| nodes_of(selection))
    };
    let file = BaseFile {
        version: 1,
        kernel: plan.basis.kernel.name().to_owned(),
        support_radius: plan.basis.radius,
        tolerance: plan.tolerance,
        error: selections
            .iter()
            .map(|selection| selection.error)
            .fold(0.0, f64::max),
        mesh_nodes: plan.boundary.n_nodes,
        mesh_points_blake3: plan.points_hash.clone(),
        nodes: of("nodes").unwrap_or_default(),
        rotation_nodes: of("rotation_nodes"),
        rotation_radius: plan.schedule.rbf.rotation_radius,
    };
    save_text(&file.text()?, path, commit)?;
    save_picture(plan, selections, &picture_of(path), commit)
}

/// Writes only the .vtp.
pub(super) fn save_picture(
    plan: &Plan,
    selections: &[Selection],
    path: &Path,
    commit: Commit,
) -> Result<()> {
    save_text(&polydata(plan, selections), path, commit)
}

/// Returns the path of the .vtp next to a base file.
pub fn picture_of(path: &Path) -> PathBuf {
    path.with_extension("vtp")
}

/// Reads base points from `path`, with weights for the plan's motion.
pub fn load(plan: &Plan, path: &Path) -> Result<Vec<Selection>> {
    let intervals = plan.selection_intervals();
    let [interval] = intervals.as_slice() else {
        return Err(Error::input(
            "method = \"real\" chooses base points several times along the schedule; leave --base out",
        )
        .file(path));
    };
    load_for(plan, interval, path)
}

/// Returns base points that were selected for an interval of the same plan.
pub(super) fn load_for(
    plan: &Plan,
    interval: &Range<usize>,
    path: &Path,
) -> Result<Vec<Selection>> {
    let file = read(path)?;
    check(plan, &file).map_err(|error| error.file(path))?;
    let base = BasePoints {
        nodes: file.nodes,
        rotation_nodes: file.rotation_nodes,
    };
    from_nodes(plan, interval, &base).map_err(|error| error.file(path))
}

fn read(path: &Path) -> Result<BaseFile> {
    let bytes = read_input(path).map_err(|error| Error::io(path, &error))?;
    BaseFile::parse(&bytes).map_err(|error| error.file(path))
}

fn check(plan: &Plan, file: &BaseFile) -> Result<()> {
    if file.version != 1 {
        return Err(Error::input(format!(
            "version = {}; this program reads version 1",
            file.version
        )));
    }
    if file.mesh_nodes != plan.boundary.n_nodes {
        return Err(Error::input(format!(
            "the base points were chosen on another mesh, of {} nodes; this one has {}",
            file.mesh_nodes, plan.boundary.n_nodes
        )));
    }
    if file.mesh_points_blake3 != plan.points_hash {
        return Err(Error::input(
            "the base points were chosen on another mesh, with as many nodes at other places",
        ));
    }
    let (kernel, radius) = (plan.basis.kernel.name(), plan.basis.radius);
    if file.kernel != kernel || file.support_radius != radius {
        return Err(Error::input(format!(
            "the base points were chosen with {} and support radius {}, the schedule has {kernel} and {radius}",
            file.kernel, file.support_radius
        )));
    }
    let twist = plan
        .layers
        .iter()
        .any(|layer| layer.kind != LayerKind::Displacement);
    if twist != file.rotation_nodes.is_some()
        || file.rotation_radius != plan.schedule.rbf.rotation_radius
    {
        return Err(Error::input(
            "the base points were chosen with another `interpolate` or `rotation_radius` than the schedule has",
        ));
    }
    Ok(())
}

/// Returns the base points as VTK polydata: vertices in the order of selection, with that order, the mesh node and the
/// body (-1 for a fixed point).
fn polydata(plan: &Plan, selections: &[Selection]) -> String {
    let surface = &plan.surface;
    let mut seen = vec![false; surface.nodes.len()];
    let all = selections.iter().flat_map(|selection| &selection.base);
    let mut is_new = |at: &usize| !std::mem::replace(&mut seen[*at], true);
    let base: Vec<usize> = all.copied().filter(|at| is_new(at)).collect();
    let n = base.len();
    let list = |of: &dyn Fn(usize) -> String| (0..n).map(of).collect::<Vec<_>>().join(" ");
    let points = list(&|i| surface.points[base[i]].map(|x| x.to_string()).join(" "));
    let order = list(&|i| i.to_string());
    let after = list(&|i| (i + 1).to_string());
    let nodes = list(&|i| surface.nodes[base[i]].to_string());
    let bodies = list(&|i| surface.body[base[i]].map_or("-1".to_owned(), |body| body.to_string()));
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
