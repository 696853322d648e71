//! Tests of the module: schedules as a user writes them, on small meshes.

mod beams;
mod bodies;
mod builder;
mod displacements;
mod errors;
mod functions;
mod naming;
mod options;
mod oscillations;
mod page;
mod poses;
mod rotations;
mod rotor_tables;
mod rotors;
mod schedule;
mod surface;
mod tables;
mod twist;
mod velocity;
mod wrong_files;

use super::{Motion, Schedule};
use azimesh_core::error::Result;
use azimesh_io::mesh::{Boundary, CellKind, Group, Mesh, ZoneSides};
use std::path::Path;

impl Schedule {
    fn resolve_on(&self, mesh: &Mesh) -> Result<Motion> {
        self.resolve(&Boundary::of(mesh), &|cells| Ok(ZoneSides::of(mesh, cells)))
    }
}

/// A schedule named hover.toml.
fn parse(text: &str) -> Result<Schedule> {
    Schedule::parse(text, Path::new("hover.toml"))
}

/// Cases of a text: blocks between empty lines, each an input and, in its last line, an error. A line `# name` begins a group.
pub(in crate::motion) fn cases(text: &str) -> impl Iterator<Item = (&str, &str, &str)> {
    let mut group = "";
    text.trim_end().split("\n\n").filter_map(move |block| {
        match (block.strip_prefix("# "), block.rsplit_once('\n')) {
            (Some(name), None) => {
                group = name;
                None
            }
            (_, Some((input, error))) => Some((group, input, error)),
            (None, None) => Some((group, "", block)),
        }
    })
}

/// A schedule of one body "blade" with tag "blade_1", everything else fixed. `body` continues its `[[body]]`;
/// `head` precedes it.
fn one_body(head: &str, body: &str) -> Schedule {
    let azimuth = if head.contains("[azimuth]") || head.contains("[time]") {
        ""
    } else {
        "[azimuth]\nvalues = [0.0, 30.0, 90.0]\n"
    };
    let text = format!(
        "{head}\n{azimuth}[boundaries]\nothers = \"fixed\"\n[[body]]\nname = \"blade\"\ntags = [\"blade_1\"]\n{body}\n"
    );
    parse(&text).expect("a good schedule")
}

fn group(dimension: u8, name: &str, cells: &[usize]) -> Group {
    Group {
        dimension,
        name: name.into(),
        number: None,
        condition: None,
        cells: cells.iter().copied().collect(),
    }
}

/// Two cubes on one another. Zone "rotor" is the lower one, with tags blade_1 (its bottom) and hub
/// (its side x = 0); zone "background" the upper one, with tags side (x = 0) and farfield (its top).
/// Node 4 k + i is corner i of level k.
fn two_cubes() -> Mesh {
    let mut mesh = Mesh::default();
    for z in [0.0, 1.0, 2.0] {
        for (x, y) in [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)] {
            mesh.points.push([x, y, z]);
        }
    }
    mesh.cells
        .push(CellKind::Hexahedron, &[0, 1, 2, 3, 4, 5, 6, 7]);
    mesh.cells
        .push(CellKind::Hexahedron, &[4, 5, 6, 7, 8, 9, 10, 11]);
    for face in [[0, 1, 2, 3], [0, 3, 7, 4], [4, 7, 11, 8], [8, 9, 10, 11]] {
        mesh.cells.push(CellKind::Quadrilateral, &face);
    }
    mesh.groups = vec![
        group(3, "rotor", &[0]),
        group(3, "background", &[1]),
        group(2, "blade_1", &[2]),
        group(2, "hub", &[3]),
        group(2, "side", &[4]),
        group(2, "farfield", &[5]),
    ];
    mesh.validate().expect("a good mesh");
    mesh
}

/// Two squares on one another, tags blade_1 (bottom) and farfield (top).
fn two_squares() -> Mesh {
    let mut mesh = Mesh::default();
    for y in [0.0, 1.0, 2.0] {
        mesh.points.extend([[0.0, y, 0.0], [1.0, y, 0.0]]);
    }
    mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 3, 2]);
    mesh.cells.push(CellKind::Quadrilateral, &[2, 3, 5, 4]);
    mesh.cells.push(CellKind::Line, &[0, 1]);
    mesh.cells.push(CellKind::Line, &[4, 5]);
    mesh.groups = vec![group(1, "blade_1", &[2]), group(1, "farfield", &[3])];
    mesh.validate().expect("a good mesh");
    mesh
}
