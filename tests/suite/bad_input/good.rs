//! Files that are read without an error, to be damaged.

use crate::support::sequence::testdata;
use crate::support::{exodus, plot3d};
use azimesh_core::error::{ErrorKind, Result};
use azimesh_io::formats::{
    self, Begin, Commit, Compression, Encoding, Format, Location, Notes, Precision, ReadOptions,
    Source, WriteOptions,
};
use azimesh_io::mesh::{CellKind, DataArray, Group, Mesh, Values};
use std::fmt::Debug;
use std::fs;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// A file that can be damaged: a mesh, or one that belongs to it.
pub struct Good {
    pub format: &'static Format,
    mesh: PathBuf,
    file: PathBuf,
    pub bytes: Vec<u8>,
}

/// Files of every format.
pub struct All {
    pub files: Vec<Good>,
    /// Those of the small mesh, the others being of `testdata/`.
    pub own: Range<usize>,
    _folder: TempDir,
}

impl Good {
    pub fn all() -> All {
        let folder = tempfile::tempdir().unwrap();
        let mut files = Vec::new();
        // Files of these formats are in `testdata/`.
        for format in formats::FORMATS
            .iter()
            .copied()
            .filter(|format| !["fluent", "medit", "abaqus"].contains(&format.name))
        {
            let at = folder.path().join(format.name);
            let first = files.len();
            if format.is_written() {
                written(format, &at, &mut files)
            } else {
                made(format, &at, &mut files)
            }
            let n = files.len() - first;
            assert!(n > 0, "{} is damaged nowhere", format.name);
        }
        let own = 0..files.len();
        for case in cases_in(&testdata("openfoam")) {
            let location = Location::open(&case).unwrap();
            let format = formats::recognize(&location).expect("it is a case");
            damaged_there(format, &case, &folder.path().join("cases"), &mut files);
        }
        let meshes = all_files(&testdata(""));
        let is_script = |path: &PathBuf| {
            path.extension()
                .is_some_and(|ending| ending == "py" || ending == "pyc")
        };
        for path in meshes.into_iter().filter(|path| !is_script(path)) {
            // A packed file is read by its path alone.
            let small = (1..61_000).contains(&fs::metadata(&path).unwrap().len())
                && path.extension().is_none_or(|ending| ending != "gz");
            let location = Location::open(&path).unwrap();
            if let Some(format) = formats::recognize(&location).filter(|_| small) {
                let bytes = fs::read(&path).unwrap();
                let (mesh, file) = (path.clone(), path);
                files.push(Good {
                    format,
                    mesh,
                    file,
                    bytes,
                });
            }
        }
        assert!(files.len() > own.end + 40, "testdata/ has small files");
        All {
            files,
            own,
            _folder: folder,
        }
    }

    /// The mesh, where the file has these bytes.
    pub fn read(&self, bytes: &[u8]) -> Result<Mesh> {
        let read = |location: Location| {
            // What is wrong with the times of the steps is an error of its own; a panic is a bug.
            let _ = self.format.steps(&location);
            let options = ReadOptions::default();
            self.format.read(&location, &options, &mut Notes::default())
        };
        if self.file == self.mesh {
            return read(Source::from_bytes(&self.mesh, bytes.to_vec()).into());
        }
        fs::write(&self.file, bytes).unwrap();
        let mesh = Location::open(&self.mesh).and_then(read);
        fs::write(&self.file, &self.bytes).unwrap();
        mesh
    }

    /// Returns whether these bytes are read, as a mesh that may fail its checks in words.
    ///
    /// # Errors
    /// If they are neither read nor refused with a place.
    pub fn check(&self, bytes: &[u8], damage: &dyn Debug) -> std::result::Result<bool, String> {
        let read = || {
            self.read(bytes).map(|mut mesh| {
                if mesh.validate().is_ok() {
                    mesh.merge_repeated_faces();
                }
            })
        };
        let wrong = match catch_unwind(AssertUnwindSafe(read)) {
            Ok(Ok(())) => return Ok(true),
            Ok(Err(error)) if error.position.is_none() => format!("no place: {error}"),
            Ok(Err(error)) if error.kind != ErrorKind::Input => {
                format!("{:?}: {error}", error.kind)
            }
            Ok(Err(_)) => return Ok(false),
            Err(_) => "a panic".to_owned(),
        };
        Err(format!("{} with {damage:?}: {wrong}", self.file.display()))
    }
}

/// The small mesh, written to `folder` in every way that the format has.
fn written(format: &'static Format, folder: &Path, files: &mut Vec<Good>) {
    let extension = format.extensions[0];
    let mut n = 0;
    let mut add = |write: &dyn Fn(&Path) -> Result<()>| -> Result<()> {
        let folder = folder.join(n.to_string());
        n += 1;
        fs::create_dir_all(&folder).unwrap();
        let mesh = folder.join(format!("small.{extension}"));
        write(&mesh)?;
        for file in all_files(&folder) {
            let bytes = fs::read(&file).unwrap();
            // What belongs to a mesh is read the same whichever way that is written.
            let is_known = files.iter().any(|known| known.bytes == bytes);
            let is_new = !bytes.is_empty() && !is_known;
            if is_new && (file == mesh || n == 1 || format.is_folder()) {
                let mesh = mesh.clone();
                files.push(Good {
                    format,
                    mesh,
                    file,
                    bytes,
                });
            }
        }
        Ok(())
    };
    let ways = ways(format);
    let solids = [(true, true), (true, false), (false, true), (false, false)];
    let fits = |&mesh: &(bool, bool)| {
        let view = solid(mesh);
        let mut nowhere = formats::OutputSet::nowhere(Path::new("small"));
        format.write(&view.view(), &mut nowhere, &ways[0]).is_ok()
    };
    let solid = solid(solids.into_iter().find(fits).expect("it holds tetrahedra"));
    let commit = Commit {
        sync: false,
        ..Commit::REPLACE
    };
    let save = |mesh: &Mesh, path: &Path, options: &WriteOptions| {
        formats::save(&mesh.view(), path, format, options, commit).map(drop)
    };
    for options in &ways {
        add(&|path| save(&solid, path, options)).unwrap();
    }
    // Solids alone, in some formats.
    let single = WriteOptions {
        precision: Precision::F32,
        ..ways[0].clone()
    };
    let _ = add(&|path| save(&plane(), path, &single));
    if let Some(create) = format.sequence {
        let sequence = |path: &Path| {
            if format.case.is_some() {
                let options = WriteOptions::default();
                let fill = |file: &mut dyn formats::SequenceFile| {
                    file.push(0.0, &solid.view())?;
                    file.push(0.5, &solid.view()).map(drop)
                };
                let (_, staged) = formats::stage_sequence(path, format, &options, commit, fill)?;
                return staged.keep();
            }
            let mut file = create(path, &WriteOptions::default(), Begin::Create, false)?;
            file.push(0.0, &solid.view())?;
            file.push(0.5, &solid.view()).map(drop)
        };
        add(&sequence).unwrap();
    }
}

/// Files of a format that is only read, of 16 nodes.
fn made(format: &'static Format, folder: &Path, files: &mut Vec<Good>) {
    fs::create_dir_all(folder).unwrap();
    let contents: Vec<Vec<u8>> = match format.name {
        "exodus" => [1, 2, 5].map(exodus::small).to_vec(),
        name => {
            let every = plot3d::every_way().into_iter();
            let all = every.flat_map(|stored| {
                let kinds = [(true, 3), (true, 2), (false, 3), (false, 2)];
                kinds.map(|(is_multi, n_axes)| plot3d::file(stored, is_multi, n_axes))
            });
            let is_read =
                |bytes: &Vec<u8>| formats::parse(format, bytes, &ReadOptions::default()).is_ok();
            let most = if name == "plot3d" { usize::MAX } else { 2 };
            all.filter(is_read).take(most).collect()
        }
    };
    for (i, bytes) in contents.into_iter().enumerate() {
        let file = folder.join(format!("{i}"));
        fs::write(&file, &bytes).unwrap();
        let mesh = file.clone();
        files.push(Good {
            format,
            mesh,
            file,
            bytes,
        });
    }
    if format.name == "plot3d" {
        let mesh = folder.join("mapped.p3dfmt");
        fs::write(&mesh, plot3d::file(plot3d::TEXT, true, 3)).unwrap();
        let (file, bytes) = (
            folder.join("mapped.nmf"),
            plot3d::NEUTRAL.as_bytes().to_vec(),
        );
        fs::write(&file, &bytes).unwrap();
        files.push(Good {
            format,
            mesh,
            file,
            bytes,
        });
    }
}

/// Every encoding and compression of a format.
fn ways(format: &Format) -> Vec<WriteOptions> {
    let mut ways = Vec::new();
    for encoding in [Encoding::Raw, Encoding::Base64, Encoding::Ascii] {
        for compression in [
            Compression::None,
            Compression::Zlib,
            Compression::Lz4,
            Compression::Lzma,
        ] {
            let options = WriteOptions {
                encoding,
                compression,
                pieces: NonZeroUsize::new(2).filter(|_| format.is_in_pieces),
                ..WriteOptions::default()
            };
            if options.without_effect(format).is_empty() {
                ways.push(options);
            }
        }
    }
    ways
}

/// The cases in a folder.
fn cases_in(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    let mut cases: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    cases.retain(|path| path.is_dir());
    cases.sort();
    cases
}

/// The small files of a case, copied so that they can be damaged.
fn damaged_there(format: &'static Format, case: &Path, to: &Path, files: &mut Vec<Good>) {
    let mesh = to.join(case.file_name().unwrap());
    for file in all_files(case) {
        let bytes = fs::read(&file).unwrap();
        let copy = mesh.join(file.strip_prefix(case).unwrap());
        fs::create_dir_all(copy.parent().unwrap()).unwrap();
        fs::write(&copy, &bytes).unwrap();
        let is_of_mesh = copy.parent().unwrap().ends_with("polyMesh");
        let is_packed = copy.extension().is_some_and(|ending| ending == "gz");
        if is_of_mesh && !is_packed {
            let (mesh, file) = (mesh.clone(), copy);
            files.push(Good {
                format,
                mesh,
                file,
                bytes,
            });
        }
    }
}

/// Every file in a folder and the folders in it, by name.
fn all_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap();
    let mut paths: Vec<PathBuf> = entries.map(|entry| entry.unwrap().path()).collect();
    paths.sort();
    let files = paths.into_iter().map(|path| {
        if path.is_dir() {
            all_files(&path)
        } else {
            vec![path]
        }
    });
    files.flatten().collect()
}

/// A few solid cells with tags, zones and arrays; with a polyhedron, with a curved cell.
fn solid((polyhedron, curved): (bool, bool)) -> Mesh {
    let mut mesh = Mesh {
        points: (0..16)
            .map(|i| [f64::from(i), 0.5, -f64::from(i * i)])
            .collect(),
        ..Mesh::default()
    };
    let cells = &mut mesh.cells;
    cells.push(CellKind::Tetrahedron, &[0, 1, 2, 3]);
    cells.push(CellKind::Wedge, &[0, 1, 2, 3, 4, 5]);
    if polyhedron {
        let stream = [4, 3, 5, 6, 7, 3, 5, 6, 8, 3, 6, 7, 8, 3, 5, 7, 8];
        cells.push_polyhedron(&stream).unwrap();
    }
    if curved {
        let nodes = [2, 3, 9, 5, 10, 11, 12, 13, 14, 15];
        cells.push(CellKind::Tetrahedron10, &nodes);
    }
    let n_solid = cells.len();
    cells.push(CellKind::Triangle, &[0, 1, 2]);
    cells.push(CellKind::Triangle, &[1, 2, 3]);
    cells.push(CellKind::Quadrilateral, &[0, 1, 4, 3]);
    let [first, last] = [n_solid, n_solid + 3];
    tag(&mut mesh, 2, "upper wall", first..last - 1);
    tag(&mut mesh, 2, "hub", last - 1..last);
    tag(&mut mesh, 3, "air", 0..n_solid);
    with_arrays(mesh)
}

/// A triangle and a quadrilateral with two boundary tags.
fn plane() -> Mesh {
    let points = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [2.0, 0.0], [1.5, 1.0]];
    let mut mesh = Mesh {
        points: points.map(|[x, y]| [x, y, 0.0]).to_vec(),
        ..Mesh::default()
    };
    mesh.cells.push(CellKind::Triangle, &[0, 1, 2]);
    mesh.cells.push(CellKind::Quadrilateral, &[1, 3, 4, 2]);
    mesh.cells.push(CellKind::Line, &[0, 1]);
    mesh.cells.push(CellKind::Line, &[1, 3]);
    tag(&mut mesh, 1, "wall", 2..3);
    tag(&mut mesh, 1, "far", 3..4);
    with_arrays(mesh)
}

fn tag(mesh: &mut Mesh, dimension: u8, name: &str, cells: Range<usize>) {
    mesh.groups.push(Group {
        dimension,
        name: name.into(),
        number: Some(mesh.groups.len() as i32 + 1),
        condition: None,
        cells: cells.collect(),
    });
}

fn with_arrays(mut mesh: Mesh) -> Mesh {
    let (n_points, n_cells) = (mesh.points.len(), mesh.cells.len());
    let velocity = Values::F64((0..3 * n_points).map(|i| i as f64 / 7.0).collect());
    mesh.point_arrays = vec![
        DataArray::scalar("p", Values::F32(vec![0.25; n_points])),
        DataArray::tuples("velocity", 3, velocity),
    ];
    let numbers = Values::I64((0..n_cells as i64).map(|i| i - 1).collect());
    mesh.cell_arrays = vec![DataArray::scalar("number", numbers)];
    mesh
}

#[test]
fn every_file_is_read_before_it_is_damaged() {
    let all = Good::all();
    for (at, file) in all.files.iter().enumerate() {
        let mesh = file.read(&file.bytes);
        let mesh = mesh.unwrap_or_else(|error| panic!("{}: {error}", file.file.display()));
        mesh.validate().unwrap();
        let n = mesh.points.len();
        // A surface is without the nodes inside and those of curved edges.
        let is_small = all.own.contains(&at) && !file.format.is_surface;
        assert!(!is_small || n == 5 || n == 16, "{n} nodes");
    }
}
