//! Parts of a mesh that ranks read by slabs are those that are cut from the whole.

use crate::support::blade_of;
use azimesh::sample::CellShape;
use azimesh::{DataArray, Error, ReadOptions, Result, Values, WriteOptions};
use azimesh_core::error::Position;
use azimesh_core::ranks::on_threads;
use azimesh_io::formats::{self, Begin, Location, SharedFile, read_parts, read_together};
use azimesh_io::mesh::from_slabs::MeshByRanges;
use azimesh_io::mesh::{CellKind, Cells, Mesh};
use std::path::{Path, PathBuf};

/// Formats that are read by slabs, with what a name ends with.
const FORMATS: &[&str] = &["vtkhdf", "vtu", "cgns", "msh"];

/// The same, for solid meshes alone.
const OF_SOLIDS: &[&str] = &[
    "b8.ugrid",
    "lb4.ugrid",
    "r8.ugrid",
    "lr4.ugrid",
    "lb8l.ugrid",
];

/// A part without what is not read by slabs.
fn bare(part: Mesh) -> Mesh {
    Mesh {
        groups: Vec::new(),
        ..part
    }
}

/// The parts of each of `n` ranks, as they are cut.
fn cut(whole: &Mesh, n: usize) -> Vec<Mesh> {
    on_threads(n, |ranks| {
        let of_first = if ranks.is_first() {
            whole.clone()
        } else {
            Mesh::default()
        };
        bare(Mesh::shared(Ok(of_first), &ranks).unwrap())
    })
}

fn assert_same(found: &Mesh, wanted: &Mesh, what: &str) {
    let (a, b) = (found.part.as_ref().unwrap(), wanted.part.as_ref().unwrap());
    assert_eq!(a.own_cells, b.own_cells, "{what}");
    assert!(a.cells == b.cells, "{what}: cells of the part");
    assert!(a.nodes == b.nodes, "{what}: nodes of the part");
    assert_eq!(a.is_level, b.is_level, "{what}");
    assert_eq!(found.space, wanted.space, "{what}");
    assert!(found.cells == wanted.cells, "{what}: cells");
    assert!(found == wanted, "{what}");
}

/// With how many ranks it is tried.
fn numbers_of_ranks(mesh: &Mesh) -> Vec<usize> {
    match mesh.cells.len() {
        ..100_000 => vec![2, 3, 5, 7],
        _ => vec![3, 7],
    }
}

/// Parts from slabs of a mesh in memory.
fn same_from_memory(mesh: &Mesh) {
    for n in numbers_of_ranks(mesh) {
        let wanted = cut(mesh, n);
        let found = on_threads(n, |ranks| {
            let slabs = MeshByRanges {
                n_nodes: mesh.points.len(),
                n_cells: mesh.cells.len(),
                space: mesh.space,
                points: &|nodes| Ok(mesh.points[nodes].to_vec()),
                cells: &|cells| Ok(mesh.cells.select(cells)),
            };
            Mesh::from_slabs(&slabs, false, &ranks).unwrap()
        });
        for (rank, found) in found.iter().enumerate() {
            assert_same(found, &wanted[rank], &format!("rank {rank} of {n}"));
        }
    }
}

/// What each of `n` ranks reads of a file by slabs, or why it does not.
fn read_by(path: &Path, options: &ReadOptions, n: usize) -> Vec<std::result::Result<Mesh, String>> {
    let file = SharedFile::new(path, None, options);
    let file = match file {
        Ok(file) => file,
        Err(reason) => return vec![Err(reason)],
    };
    on_threads(n, |ranks| read_parts(&file, &ranks))
}

fn read(path: &Path, options: &ReadOptions) -> Result<Mesh> {
    let location = Location::open(path)?;
    Ok(formats::read(&location, options)?.mesh)
}

fn same_from_file(path: &Path, options: &ReadOptions) {
    let whole = read(path, options).unwrap();
    for n in numbers_of_ranks(&whole) {
        let found = read_by(path, options, n);
        for (rank, wanted) in cut(&whole, n).iter().enumerate() {
            let what = format!("{}: rank {rank} of {n}", path.display());
            let found = found[rank].as_ref();
            let found = found.unwrap_or_else(|reason| panic!("{what}: {reason}"));
            assert_same(found, wanted, &what);
        }
        layout_is_that_of(&whole, path, options, n);
    }
}

/// The layout of a mesh in a file is what it should be of the whole.
fn layout_is_that_of(whole: &Mesh, path: &Path, options: &ReadOptions, n: usize) {
    let what = format!("{}: layout on {n} ranks", path.display());
    let file = SharedFile::new(path, None, options).unwrap();
    let found = on_threads(n, |ranks| read_together(&file, &ranks, |_| Ok(())));
    let is_cgns = path.extension().unwrap() == "cgns";
    let has_none = is_cgns && !whole.cell_arrays.is_empty();
    let found = match found.into_iter().next().unwrap() {
        Ok(found) => found.layout.unwrap().mesh,
        Err(_) if has_none || whole.dimension() < 3 => return,
        Err(reason) => panic!("{what}: {reason}"),
    };
    assert!(!has_none, "{what}");
    assert!(found.groups == whole.groups, "{what}: groups");
    assert!(found.point_arrays == whole.point_arrays, "{what}: arrays");
    assert!(found.cell_arrays == whole.cell_arrays, "{what}: arrays");
    assert!(found.field_arrays == whole.field_arrays, "{what}: arrays");
    assert_eq!(found.space, whole.space, "{what}");
    let runs = |mesh: &Mesh| -> Vec<_> {
        let runs = mesh.cells.runs();
        runs.map(|run| (run.kind, run.n_nodes, run.n_cells()))
            .collect()
    };
    assert!(runs(&found) == runs(whole), "{what}: kinds of cells");
    assert_eq!(found.points.len(), whole.points.len(), "{what}");
}

fn same_in_all_formats(mesh: &Mesh) {
    let folder = tempfile::tempdir().unwrap();
    let of_solids = match mesh.dimension() {
        3 => OF_SOLIDS,
        _ => &[],
    };
    for ending in FORMATS.iter().chain(of_solids) {
        let path = folder.path().join(format!("m.{ending}"));
        mesh.view().write(&path).unwrap();
        same_from_file(&path, &ReadOptions::default());
    }
}

fn testdata(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("testdata")
        .join(name)
}

#[test]
fn small_meshes() {
    for name in [
        "naca0012.vtu",
        "hart_ii.vtu",
        "block.vtu",
        "mixed_cells.su2",
        "sphere_in_box_raw.vtu",
        "sphere_in_box_v41_binary.msh",
        "mixed_cells_v41_binary.msh",
    ] {
        let mesh = read(&testdata(name), &ReadOptions::default()).unwrap();
        same_from_memory(&mesh);
        same_in_all_formats(&mesh);
    }
    same_from_memory(&read(&testdata("polyhedra_ascii.vtu"), &ReadOptions::default()).unwrap());
}

#[test]
fn large_meshes_of_several_slabs() {
    for mesh in [
        blade_of(230_000, 8_000, CellShape::Hex),
        blade_of(45_000, 4_000, CellShape::Tet),
    ] {
        assert!(mesh.cells.len() > 200_000);
        same_from_memory(&mesh);
        same_in_all_formats(&mesh);
    }
}

#[test]
fn meshes_with_arrays() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = read(&testdata("block.vtu"), &ReadOptions::default()).unwrap();
    let (n_nodes, n_cells) = (mesh.points.len() as u32, mesh.cells.len() as u32);
    let places = mesh.points.as_flattened().iter().map(|x| *x as f32);
    let numbers = (0..n_nodes).map(|node| i64::from(node) + 5).collect();
    mesh.point_arrays = vec![
        DataArray::tuples("place", 3, Values::F32(places.collect())),
        // The tags of nodes in MSH.
        DataArray::scalar("node_number", Values::I64(numbers)),
    ];
    let path = folder.path().join("m.cgns");
    mesh.view().write(&path).unwrap();
    same_from_file(&path, &ReadOptions::default());
    let part = (0..n_cells).map(|cell| f64::from(cell / 7)).collect();
    mesh.cell_arrays = vec![DataArray::scalar("part", Values::F64(part))];
    same_in_all_formats(&mesh);
}

/// Cells of several kinds, faces among them and edges, in no order, with nodes in no order either.
#[test]
fn cells_in_no_order() {
    let mut mesh = blade_of(110_000, 5_000, CellShape::Hex);
    let n = mesh.points.len() as u32;
    let new = |node: u32| (u64::from(node) * 7919 % u64::from(n)) as u32;
    assert_ne!(n % 7919, 0);
    let mut cells = Cells::new();
    for at in 0..mesh.cells.len() {
        let cell = mesh.cells.get(at * 104_729 % mesh.cells.len());
        let nodes: Vec<u32> = cell.nodes.iter().map(|&node| new(node)).collect();
        match (cell.kind, at % 13) {
            (CellKind::Hexahedron, 3) => {
                let n = &nodes;
                cells.push(CellKind::Wedge, &[n[0], n[1], n[2], n[4], n[5], n[6]]);
                cells.push(CellKind::Wedge, &[n[0], n[2], n[3], n[4], n[6], n[7]]);
            }
            (CellKind::Hexahedron, 5) => cells.push(CellKind::Line, &nodes[..2]),
            (CellKind::Hexahedron, 7) => cells.push(CellKind::Pyramid, &nodes[..5]),
            (kind, _) => cells.push(kind, &nodes),
        }
    }
    let mut points = mesh.points.clone();
    for (node, point) in (0..).zip(&mesh.points) {
        points[new(node) as usize] = *point;
    }
    mesh.groups.clear();
    (mesh.points, mesh.cells) = (points, cells);
    same_from_memory(&mesh);
    same_in_all_formats(&mesh);
}

/// The number of a symmetry plane in UGRID says which axis it is normal to.
#[test]
fn a_symmetry_plane_whose_nodes_lie_everywhere_in_the_mesh() {
    let mut mesh = read(&testdata("wing_on_plane.vtu"), &ReadOptions::default()).unwrap();
    let n = mesh.points.len();
    let new = |node: usize| node * 7919 % n;
    assert_ne!(n % 7919, 0);
    let mut points = mesh.points.clone();
    for (node, point) in mesh.points.iter().enumerate() {
        points[new(node)] = *point;
    }
    let mut cells = Cells::new();
    for run in mesh.cells.runs() {
        for nodes in run.cells() {
            let nodes: Vec<u32> = nodes
                .iter()
                .map(|&node| new(node as usize) as u32)
                .collect();
            cells.push(run.kind, &nodes);
        }
    }
    (mesh.points, mesh.cells) = (points, cells);
    let symmetry = mesh
        .groups
        .iter_mut()
        .find(|group| group.name == "symmetry");
    symmetry.unwrap().condition = Some("BCSymmetryPlane".into());
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.b8.ugrid");
    mesh.view().write(&path).unwrap();
    let numbers = std::fs::read_to_string(folder.path().join("m.mapbc")).unwrap();
    assert!(numbers.contains("6663 symmetry"), "{numbers}");
    same_from_file(&path, &ReadOptions::default());
}

#[test]
fn steps_and_parts_that_other_programs_have_written() {
    let path = testdata("moving_parts_by_h5py.vtkhdf");
    let location = Location::open(&path).unwrap();
    let format = formats::of(&location).unwrap();
    let n = format.steps(&location).unwrap().len();
    assert!(n > 1);
    steps_are_the_same(&path, n);
}

fn steps_are_the_same(path: &Path, n: usize) {
    for step in (0..n).map(Some).chain([None]) {
        let options = ReadOptions {
            step,
            ..ReadOptions::default()
        };
        same_from_file(path, &options);
    }
}

#[test]
fn steps_of_a_sequence() {
    let folder = tempfile::tempdir().unwrap();
    let mut mesh = read(&testdata("wing_on_plane.vtu"), &ReadOptions::default()).unwrap();
    for ending in FORMATS {
        let path = folder.path().join(format!("m.{ending}"));
        let Some(create) = formats::by_name(ending).unwrap().sequence else {
            continue;
        };
        let options = WriteOptions::default();
        let mut sequence = create(&path, &options, Begin::Create, false).unwrap();
        for step in 0..3 {
            for point in &mut mesh.points {
                point[0] += 0.25;
            }
            sequence.push(f64::from(step), &mesh.view()).unwrap();
        }
        drop(sequence);
        steps_are_the_same(&path, 3);
    }
}

fn reason(path: &Path, options: &ReadOptions) -> String {
    let mut found = read_by(path, options, 3);
    let first = found.swap_remove(0).unwrap_err();
    assert!(
        found
            .iter()
            .all(|other| other.as_ref().unwrap_err() == &first)
    );
    first
}

#[test]
fn what_has_to_be_read_whole_says_why() {
    let options = ReadOptions::default();
    let of = |name: &str| reason(&testdata(name), &options);
    assert_eq!(of("polyhedra_by_vtk.vtkhdf"), "it has polyhedra");
    assert!(of("airfoil_hybrid.su2").contains("not read by slabs"));
    assert!(of("none.vtkhdf").contains("there is no such file"));
    assert_eq!(reason(Path::new("-"), &options), "it is standard input");

    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.vtkhdf");
    let mut mesh = read(&testdata("block.vtu"), &options).unwrap();
    mesh.view().write(&path).unwrap();
    let chosen = ReadOptions {
        tag_array: Some("none".to_owned()),
        ..ReadOptions::default()
    };
    assert_eq!(reason(&path, &chosen), "the array of its tags is not one");

    let face = mesh.boundary_tags().next().unwrap().cells.iter().next();
    let face = mesh.cells.get(face.unwrap());
    let (kind, mut nodes) = (face.kind, face.nodes.to_vec());
    nodes.reverse();
    mesh.cells.push(kind, &nodes);
    mesh.view().write(&path).unwrap();
    let why = reason(&path, &options);
    assert_eq!(why, "boundary faces have the same nodes");

    let name = mesh.groups[0].name.clone();
    mesh.groups[1].name = name;
    mesh.view().write(&path).unwrap();
    assert_eq!(reason(&path, &options), "tags share a name");

    assert_eq!(of("mixed_cells.ugrid"), "it is text");
    let path = folder.path().join("m.r8.ugrid");
    let solid = read(&testdata("mixed_cells.ugrid"), &options).unwrap();
    solid.view().write(&path).unwrap();
    let mut bytes = std::fs::read(&path).unwrap();
    bytes[0] ^= 1;
    std::fs::write(&path, bytes).unwrap();
    assert_eq!(
        reason(&path, &options),
        "its Fortran records have wrong marks"
    );

    let packed = folder.path().join("m.vtkhdf.gz");
    std::fs::write(&packed, [0x1f, 0x8b, 8, 0]).unwrap();
    assert_eq!(reason(&packed, &options), "it is compressed");
}

#[test]
fn a_surface_of_a_solid_is_read_whole() {
    let options = ReadOptions::default();
    let mut mesh = read(&testdata("sphere_in_box_raw.vtu"), &options).unwrap();
    mesh.keep_boundary().unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.vtkhdf");
    mesh.view().write(&path).unwrap();
    let whole = read(&path, &options).unwrap();
    assert_eq!(whole.space, Some(3));
    let why = reason(&path, &options);
    assert_eq!(why, "it may be the surface of a solid");
}

#[test]
fn a_file_that_has_changed_is_another() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.vtkhdf");
    let mesh = read(&testdata("block.vtu"), &ReadOptions::default()).unwrap();
    mesh.view().write(&path).unwrap();
    let old = SharedFile::new(&path, None, &ReadOptions::default()).unwrap();
    let before = std::time::UNIX_EPOCH - std::time::Duration::from_nanos(1_500_000_001);
    let opened = std::fs::File::options().write(true).open(&path).unwrap();
    opened.set_modified(before).unwrap();
    let new = SharedFile::new(&path, None, &ReadOptions::default()).unwrap();
    assert_ne!(old, new);
    let found = on_threads(2, |ranks| read_parts(&old, &ranks).unwrap_err());
    assert_eq!(found, ["ranks see different files"; 2]);
    assert!(on_threads(2, |ranks| read_parts(&new, &ranks).is_ok()) == [true; 2]);
}

#[test]
fn a_file_that_one_rank_does_not_see_is_read_by_none() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = read(&testdata("block.vtu"), &ReadOptions::default()).unwrap();
    let files = ["here.vtkhdf", "gone.vtkhdf"].map(|name| {
        let path = folder.path().join(name);
        mesh.view().write(&path).unwrap();
        SharedFile::new(&path, None, &ReadOptions::default()).unwrap()
    });
    std::fs::remove_file(files[1].path()).unwrap();
    let found = on_threads(3, |ranks| {
        let file = &files[usize::from(ranks.rank() == 1)];
        read_parts(file, &ranks).unwrap_err()
    });
    assert_eq!(found, ["there is no such file"; 3]);
}

/// Returns whether an error is about the values of an array, which ranks do not read.
fn is_of_array(error: &Error) -> bool {
    const READ: [&str; 4] = ["Points", "Types", "Offsets", "Connectivity"];
    match &error.position {
        Some(Position::Dataset(name)) => !READ.contains(&&name[..]) && name != "VTKHDF",
        _ => false,
    }
}

/// Damaged files give the parts of what is read as a whole, or are to be read as a whole.
#[test]
fn damaged_files_are_read_as_they_are_as_a_whole() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("m.vtkhdf");
    let options = ReadOptions::default();
    let own = folder.path().join("own.vtkhdf");
    let mesh = read(&testdata("mixed_cells.su2"), &options).unwrap();
    mesh.view().write(&own).unwrap();
    let mut n_read = 0;
    for file in [
        own,
        testdata("mixed_cells_by_vtk.vtkhdf"),
        testdata("moving_parts_by_h5py.vtkhdf"),
    ] {
        let good = std::fs::read(file).unwrap();
        let mut number = 1u64;
        let mut next = |below: usize| {
            number = number.wrapping_mul(6_364_136_223_846_793_005) + 1;
            (number >> 33) as usize % below
        };
        for i in 0..100 {
            let mut bytes = good.clone();
            match i % 10 {
                9 => bytes.truncate(next(good.len())),
                _ => bytes[next(good.len())] ^= 1 << next(8),
            }
            std::fs::write(&path, bytes).unwrap();
            let found = read_by(&path, &options, 2);
            if found.iter().any(|part| part.is_err()) {
                assert!(found.iter().all(|part| part.is_err()));
                continue;
            }
            let whole = match read(&path, &options) {
                Ok(whole) => whole,
                Err(error) if is_of_array(&error) => continue,
                Err(error) => panic!("damage {i}: {error}"),
            };
            n_read += 1;
            for (found, wanted) in found.iter().zip(&cut(&whole, 2)) {
                assert_same(found.as_ref().unwrap(), wanted, &format!("damage {i}"));
            }
        }
    }
    assert!(n_read > 30, "{n_read}");
}
