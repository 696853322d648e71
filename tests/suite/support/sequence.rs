//! What a finished run has left: its table and the nodes of its meshes.

use super::succeed;
use azimesh_io::formats::{self, WriteOptions};
use azimesh_io::mesh::Mesh;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

pub type Vector = [f64; 3];

/// A finished run.
pub struct Sequence {
    /// The mesh that was deformed.
    pub reference: Mesh,
    folder: PathBuf,
    header: Vec<String>,
    rows: Vec<Vec<String>>,
}

pub fn read(path: &Path) -> Mesh {
    Mesh::read(path).unwrap()
}

/// Writes a mesh as VTU.
pub fn write(mesh: &Mesh, path: &Path) {
    write_as("vtu", mesh, path);
}

/// Writes a mesh in the format of this name.
pub fn write_as(format: &str, mesh: &Mesh, path: &Path) {
    let format = formats::FORMATS.iter().find(|known| known.name == format);
    let mut bytes = Vec::new();
    let options = WriteOptions::default();
    format
        .unwrap()
        .write_file(&mesh.view(), &mut bytes, &options)
        .unwrap();
    std::fs::write(path, bytes).unwrap();
}

/// A file of testdata/.
pub fn testdata(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("testdata")
        .join(name)
}

/// The nodes of boundary tags.
pub fn nodes_of(mesh: &Mesh, tags: &[&str]) -> BTreeSet<usize> {
    faces_of(mesh, tags).into_iter().flatten().collect()
}

/// The faces of boundary tags, as their nodes.
pub fn faces_of(mesh: &Mesh, tags: &[&str]) -> Vec<Vec<usize>> {
    let groups = mesh.boundary_tags();
    let named: Vec<_> = groups
        .filter(|group| tags.contains(&group.name.as_str()))
        .collect();
    assert_eq!(named.len(), tags.len(), "the mesh has the tags {tags:?}");
    let cells = named.iter().flat_map(|group| group.cells.iter());
    cells
        .map(|cell| {
            mesh.cells
                .get(cell)
                .nodes
                .iter()
                .map(|&n| n as usize)
                .collect()
        })
        .collect()
}

/// Returns whether two points are the same to the last bit.
pub fn same(a: Vector, b: Vector) -> bool {
    a.map(f64::to_bits) == b.map(f64::to_bits)
}

pub fn distance(a: Vector, b: Vector) -> f64 {
    (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>().sqrt()
}

/// Diagonal of the box around the points.
pub fn diagonal(points: &[Vector]) -> f64 {
    let end = |axis: usize, pick: fn(f64, f64) -> f64, from: f64| {
        points.iter().map(|x| x[axis]).fold(from, pick)
    };
    let low = [0, 1, 2].map(|axis| end(axis, f64::min, f64::INFINITY));
    let high = [0, 1, 2].map(|axis| end(axis, f64::max, f64::NEG_INFINITY));
    distance(low, high)
}

impl Sequence {
    /// Deforms a mesh into `out` of `folder`; the program must have nothing to complain about.
    pub fn of(folder: &Path, mesh: &Path, schedule: &Path, out: &str) -> Self {
        let [mesh_name, schedule] = [mesh, schedule].map(|path| path.to_str().unwrap());
        succeed(
            folder,
            ["-q", "deform", mesh_name, schedule, "-o", out, "--force"],
        );
        Self::left_in(&folder.join(out), mesh)
    }

    /// A run of testdata/`mesh`.vtu by testdata/`schedule`.toml.
    pub fn of_testdata(folder: &Path, mesh: &str, schedule: &str) -> Self {
        let mesh = testdata(&format!("{mesh}.vtu"));
        let file = testdata(&format!("{schedule}.toml"));
        Self::of(folder, &mesh, &file, schedule)
    }

    /// What a run that is over has left in `folder`.
    pub fn left_in(folder: &Path, mesh: &Path) -> Self {
        let table = std::fs::read_to_string(folder.join("steps.csv")).unwrap();
        let cut = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = table.lines().map(cut);
        Self {
            reference: read(mesh),
            folder: folder.to_owned(),
            header: lines.next().unwrap(),
            rows: lines.collect(),
        }
    }

    pub fn n_steps(&self) -> usize {
        self.rows.len()
    }

    /// A column of steps.csv.
    pub fn column(&self, name: &str) -> Vec<&str> {
        let at = self.header.iter().position(|column| column == name);
        let at = at.unwrap();
        self.rows.iter().map(|row| row[at].as_str()).collect()
    }

    /// A column of steps.csv that holds numbers.
    pub fn numbers(&self, name: &str) -> Vec<f64> {
        let column = self.column(name).into_iter();
        column.map(|text| text.parse().unwrap()).collect()
    }

    /// Node positions at a step.
    pub fn points(&self, step: usize) -> Vec<Vector> {
        let points = read(&self.folder.join(self.column("file")[step])).points;
        assert_eq!(points.len(), self.reference.points.len());
        points
    }

    /// No cell is inverted at any step, and surface nodes are where they belong, to round-off.
    pub fn assert_sound(&self) {
        assert_eq!(self.column("inverted"), vec!["0"; self.n_steps()]);
        let limit = 1e-12 * diagonal(&self.reference.points);
        for (step, error) in self.numbers("max_surface_error").into_iter().enumerate() {
            assert!(
                error <= limit,
                "step {step}: surface nodes off by {error:e}"
            );
        }
    }
}
