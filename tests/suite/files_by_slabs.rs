//! Slabs put together are the mesh that the whole file gives; damaged files give errors or sound slabs.

use azimesh_core::error::Result;
use azimesh_io::formats::slabs::{Opened, Slabs};
use azimesh_io::formats::{
    Format, Location, Notes, Precision, ReadOptions, Source, WriteOptions, cgns, gmsh, of, ugrid,
    vtu,
};
use azimesh_io::mesh::{CellKind, Cells, Mesh};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// The formats that are read by slabs here.
static FORMATS: [&Format; 6] = [
    &vtu::VTU,
    &cgns::CGNS,
    &gmsh::MSH41,
    &ugrid::B8,
    &ugrid::LB8L,
    &ugrid::LR4,
];

fn source(bytes: &[u8]) -> Source {
    Source::from_bytes(Path::new("<memory>"), bytes.to_vec())
}

/// All of a mesh, read in slabs of so many nodes or cells.
fn joined(slabs: &dyn Slabs, size: usize) -> Result<(Vec<[f64; 3]>, Cells)> {
    let (mut points, mut cells) = (Vec::new(), Cells::new());
    for start in (0..slabs.n_nodes()).step_by(size) {
        let end = slabs.n_nodes().min(start + size);
        points.extend(slabs.points(start..end)?);
        assert_eq!(points.len(), end);
    }
    for start in (0..slabs.n_cells()).step_by(size) {
        let end = slabs.n_cells().min(start + size);
        cells.append(&slabs.cells(start..end)?);
        assert_eq!(cells.len(), end);
    }
    Ok((points, cells))
}

/// Checks that slabs make up a mesh; gives why they cannot be read where cells have to be read as a whole.
fn compare(slabs: &dyn Slabs, mesh: &Mesh, what: &str) -> std::result::Result<(), String> {
    for size in [7, 101, slabs.n_nodes().max(slabs.n_cells()) / 3 + 1] {
        let (points, cells) = joined(slabs, size).map_err(|error| error.to_string())?;
        assert_eq!(points, mesh.points, "{what}");
        assert!(cells == mesh.cells, "{what}: other cells");
        assert_eq!(slabs.space(), mesh.space, "{what}");
    }
    Ok(())
}

/// Compares the slabs of a file with its mesh; gives why it has to be read as a whole where that is so.
fn compare_file(
    format: &Format,
    source: &Source,
    options: &ReadOptions,
) -> Option<std::result::Result<(), String>> {
    let what = source.path().display().to_string();
    let read = format.read_file(source, options, &mut Notes::default());
    let opened = format.slabs(source, options);
    match read {
        Ok(mesh) => match opened.unwrap_or_else(|error| panic!("{what}: {error}")) {
            Ok(slabs) => Some(compare(&*slabs, &mesh, &what)),
            Err(reason) => Some(Err(reason)),
        },
        Err(_) => {
            look_at_all(opened);
            None
        }
    }
}

/// Reads what can be read of a damaged file, of which slabs have to be sound. Gives whether there are any.
fn look_at_all(opened: Result<Opened>) -> bool {
    let Ok(Ok(slabs)) = opened else { return false };
    let n = slabs.n_nodes();
    let Ok((points, cells)) = joined(&*slabs, n.max(slabs.n_cells()) / 2 + 1) else {
        return false;
    };
    assert_eq!((points.len(), cells.len()), (n, slabs.n_cells()));
    assert!(cells.connectivity().iter().all(|node| (*node as usize) < n));
    let mut outline = Mesh {
        points,
        cells,
        ..Mesh::default()
    };
    let _ = slabs.complete(&mut outline, &mut Notes::default());
    true
}

fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            files_below(&path, found)
        } else {
            found.push(path)
        }
    }
}

/// For each of the formats how many files are read by slabs, and how many are not for each reason. Files that cannot
/// be read at all are not counted.
fn tally(folder: &Path) -> BTreeMap<String, usize> {
    let mut files = Vec::new();
    files_below(folder, &mut files);
    files.sort();
    let mut tally = BTreeMap::new();
    for path in files {
        let Ok(source) = Source::open(&path) else {
            continue;
        };
        let Ok(format) = of(&Location::from(source.clone())) else {
            continue;
        };
        if !FORMATS.iter().any(|known| known.name == format.name) {
            continue;
        }
        let found = compare_file(format, &source, &ReadOptions::default());
        let outcome = match found {
            None => continue,
            Some(Ok(())) => "by slabs".to_owned(),
            Some(Err(reason)) => reason,
        };
        *tally
            .entry(format!("{}: {outcome}", format.name))
            .or_default() += 1;
    }
    tally
}

fn n_by_slabs(tally: &BTreeMap<String, usize>, format: &str) -> usize {
    *tally.get(&format!("{format}: by slabs")).unwrap_or(&0)
}

#[test]
fn slabs_of_files_make_up_their_meshes() {
    let found = tally(Path::new("testdata"));
    assert!(n_by_slabs(&found, "vtu") >= 3, "{found:#?}");
    assert!(n_by_slabs(&found, "msh") >= 4, "{found:#?}");
    assert!(n_by_slabs(&found, "cgns") >= 4, "{found:#?}");
    assert!(n_by_slabs(&found, "ugrid-b8") >= 1, "{found:#?}");
    assert!(n_by_slabs(&found, "ugrid-lb8l") >= 1, "{found:#?}");
}

/// Skipped where the folder is not given, which is said loudly.
#[test]
fn slabs_of_real_files_make_up_their_meshes() {
    let Some(folder) = std::env::var_os("AZIMESH_TESTDATA") else {
        eprintln!("AZIMESH_TESTDATA is not set: NO REAL MESH IS READ BY SLABS");
        return;
    };
    let found = tally(Path::new(&folder));
    for format in ["vtu", "cgns", "msh"] {
        assert!(n_by_slabs(&found, format) > 3, "{found:#?}");
    }
}

/// Files of the folder testdata, and why each has to be read as a whole.
const WHOLE: [(&str, &str); 14] = [
    ("airfoil_hybrid_ascii.vtu", "text or base64"),
    ("mixed_cells_base64.vtu", "text or base64"),
    ("sphere_in_box_raw_zlib.vtu", "compressed"),
    ("mixed_cells_raw_big_endian.vtu", "order of nodes"),
    ("mixed_cells_by_vtk.vtkhdf", "order of nodes"),
    ("airfoil_hybrid_v41.msh", "not in binary MSH 4.1"),
    ("sphere_in_box_v22_binary.msh", "not in binary MSH 4.1"),
    ("gmsh/partitioned_v41_binary.msh", "do not count up"),
    ("mixed_cells.ugrid", "it is text"),
    ("cgns/adf_version_b.cgns", "not in HDF5"),
    ("cgns/structured_rind.cgns", "structured zones"),
    ("cgns/polyhedra_offsets.cgns", "type NGON_n"),
    ("cgns/linked_families.cgns", "ElementStartOffset"),
    (
        "cgns/by_nodes_big_endian_packed.cgns",
        "given by their nodes",
    ),
];

#[test]
fn files_that_are_read_as_a_whole_say_why() {
    for (name, why) in WHOLE {
        let source = Source::open(&Path::new("testdata").join(name)).unwrap();
        let format = of(&Location::from(source.clone())).unwrap();
        let found = compare_file(format, &source, &ReadOptions::default());
        let reason = found.unwrap().unwrap_err();
        assert!(reason.contains(why), "{name}: {reason}");
    }
}

/// The faces of a tetrahedron, all of them in one tag.
fn surface(space: Option<u8>) -> Mesh {
    let mut mesh = Mesh {
        points: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        space,
        ..Mesh::default()
    };
    for face in [[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]] {
        mesh.cells.push(CellKind::Triangle, &face);
    }
    if space.is_some() {
        mesh.add_tag("wall", 0..4).unwrap();
    }
    mesh
}

#[test]
fn the_tagged_surface_of_a_solid_is_read_as_a_whole() {
    let compared = |mesh: &Mesh| {
        let source = source(&file_of(&vtu::VTU, mesh));
        compare_file(&vtu::VTU, &source, &ReadOptions::default()).unwrap()
    };
    assert_eq!(compared(&surface(None)), Ok(()));
    let reason = compared(&surface(Some(3))).unwrap_err();
    assert!(reason.contains("surface of a solid"), "{reason}");
}

#[test]
fn every_step_of_a_sequence_is_read_by_slabs() {
    let path = Path::new("testdata/cgns/sequence.cgns");
    let source = Source::open(path).unwrap();
    let n = (cgns::CGNS.steps)(&source).unwrap().len();
    assert!(n > 1);
    for step in 0..n {
        let options = ReadOptions {
            step: Some(step),
            ..ReadOptions::default()
        };
        assert_eq!(compare_file(&cgns::CGNS, &source, &options), Some(Ok(())));
    }
}

/// Meshes of all kinds of cells but polyhedra.
fn meshes() -> Vec<(&'static str, Mesh)> {
    let names = [
        "mixed_cells_v22.msh",
        "airfoil_hybrid.su2",
        "naca0012.vtu",
        "hart_ii.vtu",
        "curved_solids_complete_v22.msh",
        "curved_solids_serendipity_v22.msh",
        "curved_plate_complete_v41.msh",
        "curved_plate_serendipity_v41.msh",
        "shared_faces_v41.msh",
        "gmsh/order3_v41.msh",
        "gmsh/cylinder_v41_binary.msh",
    ];
    let folder = Path::new("testdata");
    let read = |name| Mesh::read(folder.join(name)).unwrap_or_else(|error| panic!("{error}"));
    names.map(|name| (name, read(name))).into()
}

#[test]
fn what_azimesh_writes_is_read_by_slabs() {
    let mut n_compared = 0;
    for (name, mesh) in meshes() {
        for format in FORMATS {
            for precision in [Precision::F64, Precision::F32] {
                let options = WriteOptions {
                    precision,
                    ..WriteOptions::default()
                };
                let mut bytes = Vec::new();
                if format
                    .write_file(&mesh.view(), &mut bytes, &options)
                    .is_err()
                {
                    continue;
                }
                let found = compare_file(format, &source(&bytes), &ReadOptions::default());
                assert_eq!(found, Some(Ok(())), "{name} as {}", format.name);
                n_compared += 1;
            }
        }
    }
    assert!(n_compared > 60, "{n_compared}");
}

#[test]
fn threads_read_slabs_at_once() {
    let mesh = Mesh::read("testdata/hart_ii.vtu").unwrap();
    for format in FORMATS {
        let (source, options) = (source(&file_of(format, &mesh)), ReadOptions::default());
        // Its cells are in the order of the format.
        let mesh = format.read_file(&source, &options, &mut Notes::default());
        let mesh = mesh.unwrap_or_else(|error| panic!("{error}"));
        let slabs = format.slabs(&source, &options);
        let slabs = slabs.unwrap().unwrap_or_else(|reason| panic!("{reason}"));
        std::thread::scope(|scope| {
            for size in [11, 12, 13, 14] {
                let slabs = &*slabs;
                let (points, cells) = (&mesh.points, &mesh.cells);
                scope.spawn(move || {
                    let found = joined(slabs, size).unwrap();
                    assert!(found.0 == *points && found.1 == *cells);
                });
            }
        });
    }
}

/// A hexahedron and a pyramid on it, with a tag and a zone.
fn small() -> Mesh {
    let mut mesh = Mesh {
        points: (0..9)
            .map(|i| [f64::from(i & 1), f64::from(i >> 1 & 1), f64::from(i >> 2)])
            .collect(),
        ..Mesh::default()
    };
    mesh.cells
        .push(CellKind::Hexahedron, &[0, 1, 3, 2, 4, 5, 7, 6]);
    mesh.cells.push(CellKind::Pyramid, &[4, 5, 7, 6, 8]);
    mesh.cells.push(CellKind::Quadrilateral, &[0, 1, 3, 2]);
    mesh.cells.push(CellKind::Triangle, &[4, 5, 8]);
    mesh.add_tag("floor", [2]).unwrap();
    mesh.add_tag("side", [3]).unwrap();
    mesh
}

fn file_of(format: &Format, mesh: &Mesh) -> Vec<u8> {
    let mut bytes = Vec::new();
    let written = format.write_file(&mesh.view(), &mut bytes, &WriteOptions::default());
    written.unwrap_or_else(|error| panic!("{error}"));
    bytes
}

#[test]
fn damaged_files_give_errors_or_sound_slabs() {
    for format in FORMATS {
        let bytes = file_of(format, &small());
        let mut n_sound = 0;
        let mut random = 1_u64;
        for i in 0..600 {
            random = random
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(99);
            let mut damaged = bytes.clone();
            let at = (random >> 33) as usize % bytes.len();
            match i % 3 {
                0 => damaged.truncate(at),
                _ => damaged[at] ^= 1 << (random >> 30 & 7),
            }
            let source = source(&damaged);
            n_sound += usize::from(look_at_all(format.slabs(&source, &ReadOptions::default())));
        }
        assert!(n_sound > 50, "{} of {}", n_sound, format.name);
        // Twice the same file, of which one after the other has sections of MSH that are there once.
        look_at_all(format.slabs(&source(&bytes.repeat(2)), &ReadOptions::default()));
    }
}
