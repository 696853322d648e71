//! Parts of a mesh that several ranks hold are judged as the whole mesh is: to the last bit, and cell by cell.

use crate::support::blade_of;
use azimesh::run::{Request, run};
use azimesh::sample::{BladeOptions, CellShape, SizeOptions, blade, naca0012};
use azimesh::{Deformation, ReadOptions, Schedule};
use azimesh_core::ranks::{Ranks, on_threads};
use azimesh_deform::ReadWhole;
use azimesh_io::formats::{SharedFile, read_together};
use azimesh_io::mesh::{CellKind, Cells, Group, Mesh};
use azimesh_quality::{Assessment, QualityEvaluator, Statistic, statistics, worst};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Everything that is told of a mesh, judged by the mesh at rest.
fn judged(mesh: &Mesh, moved: &[[f64; 3]]) -> (Assessment, Vec<Statistic>, String) {
    let judge = QualityEvaluator::new(mesh);
    let found = judge.assess(mesh, moved);
    let all = statistics(mesh, moved, &judge.reference);
    let bad = worst(mesh, moved, &judge.reference, 50);
    let bad = format!("{bad:?} {}", judge.reference.n_reversed());
    (found, all, bad)
}

/// Nodes moved so that some cells fold.
fn moved([x, y, z]: [f64; 3]) -> [f64; 3] {
    let shift = 0.02 * (40.0 * x + 70.0 * z).sin() * (90.0 * y).cos();
    [x + shift, y - shift, z * (1.0 + shift)]
}

fn same_on_any_number_of_ranks(mesh: &Mesh) {
    let places: Vec<_> = mesh.points.iter().map(|&point| moved(point)).collect();
    let whole = judged(mesh, &places);
    assert!(whole.0.cells.n_cells > 3 << 15, "more than three slabs");
    assert!(whole.0.cells.inverted > 0, "{:?}", whole.0);
    for n in [2, 3, 4, 7] {
        let found = on_threads(n, |ranks| {
            let of_first = if ranks.is_first() {
                mesh.clone()
            } else {
                Mesh::default()
            };
            let part = Mesh::shared(Ok(of_first), &ranks).expect("rank 0 has it");
            part.validate().expect("a part is a mesh");
            assert!(part.cells.len() < mesh.cells.len());
            let places: Vec<_> = part.points.iter().map(|&point| moved(point)).collect();
            judged(&part, &places)
        });
        for (rank, found) in found.iter().enumerate() {
            assert_eq!(
                format!("{:?}", found),
                format!("{:?}", whole),
                "rank {rank} of {n}"
            );
        }
    }
}

#[test]
fn hexahedra_and_their_boundary_faces() {
    same_on_any_number_of_ranks(&blade_of(140_000, 6_000, CellShape::Hex));
}

#[test]
fn tetrahedra() {
    same_on_any_number_of_ranks(&blade_of(30_000, 3_000, CellShape::Tet));
}

/// Hexahedra, of which some are two wedges, six pyramids without their common point, or polyhedra.
#[test]
fn many_kinds_of_cells_in_no_order() {
    let mut mesh = blade_of(110_000, 5_000, CellShape::Hex);
    let mut cells = Cells::new();
    for cell in mesh.cells.iter() {
        let n = cell.nodes;
        match (cell.kind, cell.index % 11) {
            (CellKind::Hexahedron, 3) => {
                cells.push(CellKind::Wedge, &[n[0], n[1], n[2], n[4], n[5], n[6]]);
                cells.push(CellKind::Wedge, &[n[0], n[2], n[3], n[4], n[6], n[7]]);
            }
            (CellKind::Hexahedron, 5) => {
                let faces = [
                    [0, 3, 2, 1],
                    [4, 5, 6, 7],
                    [0, 1, 5, 4],
                    [1, 2, 6, 5],
                    [2, 3, 7, 6],
                    [3, 0, 4, 7],
                ];
                let mut stream = vec![6];
                for face in faces {
                    stream.push(4);
                    stream.extend(face.map(|i: usize| n[i]));
                }
                cells.push_polyhedron(&stream).expect("a good stream");
            }
            (CellKind::Hexahedron, 7) => cells.push(CellKind::Pyramid, &n[..5]),
            (CellKind::Hexahedron, 8) => cells.push(CellKind::Tetrahedron, &n[1..5]),
            _ => cells.push(cell.kind, n),
        }
    }
    mesh.groups.clear();
    mesh.cells = cells;
    same_on_any_number_of_ranks(&mesh);
}

/// A sheet of quadrilaterals and triangles, in a plane and bent.
#[test]
fn plane_and_curved_surfaces() {
    let n = 330;
    let at = |i: u32, j: u32| i * n + j;
    let mut mesh = Mesh::default();
    for i in 0..n {
        for j in 0..n {
            mesh.points
                .push([f64::from(i) / 300.0, f64::from(j) / 300.0, 1.0]);
        }
    }
    for i in 0..n - 1 {
        for j in 0..n - 1 {
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            if (i + j) % 7 == 0 {
                mesh.cells.push(CellKind::Triangle, &[a, b, c]);
                mesh.cells.push(CellKind::Triangle, &[a, c, d]);
            } else {
                mesh.cells.push(CellKind::Quadrilateral, &[a, b, c, d]);
            }
        }
    }
    same_on_any_number_of_ranks(&mesh);
    // A node of no cell that is not in the plane.
    mesh.points.push([0.0, 0.0, 5.0]);
    same_on_any_number_of_ranks(&mesh);
    for point in &mut mesh.points {
        point[2] = (3.0 * point[0]).sin();
    }
    same_on_any_number_of_ranks(&mesh);
}

/// Edges that three sheets share, each of them in slabs of its own: the first two cells in the order of the mesh are
/// neighbours there.
#[test]
fn sheets_that_meet_in_one_edge() {
    let (n, m) = (500, 80);
    let mut mesh = Mesh::default();
    for sheet in 0..3 {
        let (cos, sin) = (2.0 * f64::from(sheet)).sin_cos();
        let at = |i: u32, j: u32| match j {
            0 => i,
            _ => n + (sheet as u32 * m + j - 1) * n + i,
        };
        for j in u32::from(sheet > 0)..=m {
            let r = f64::from(j) / 300.0;
            let row = (0..n).map(|i| [f64::from(i) / 300.0, r * cos, r * sin]);
            mesh.points.extend(row);
        }
        for j in 0..m {
            for i in 0..n - 1 {
                let nodes = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
                mesh.cells.push(CellKind::Quadrilateral, &nodes);
            }
        }
    }
    same_on_any_number_of_ranks(&mesh);
}

/// A mesh of several slabs that moves, so that fields and parts are cut.
#[test]
fn a_large_airfoil_moves_alike() {
    let size = SizeOptions {
        nodes: Some(70_000),
        ..SizeOptions::default()
    };
    let sample = naca0012(&size).expect("a sample");
    let (mesh, text) = (sample.mesh, sample.schedule);
    let scratch = tempfile::tempdir().expect("a folder");
    let path = scratch.path().join("n.toml");
    std::fs::write(&path, text.replace("step = 10.0", "step = 130.0")).expect("it can be written");
    let of = |ranks: &Ranks| {
        let schedule = Schedule::read(&path).expect("a good schedule");
        found(mesh.clone(), schedule, ranks)
    };
    alike(&of);
}

/// Positions and velocities at some steps, and everything about quality.
struct Found {
    quality: Vec<String>,
    values: Vec<Vec<[f64; 3]>>,
    /// The numbers of the nodes of a rank in the whole mesh.
    nodes: Vec<u32>,
}

/// Positions, velocities and quality at every step of a schedule in `testdata`.
fn deformed(schedule: &str, changes: &[(&str, &str)], ranks: &Ranks) -> Found {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("testdata");
    let mesh = schedule.replace("_sliding", "").replace(".toml", ".vtu");
    let mesh = Mesh::read(folder.join(mesh)).expect("a mesh");
    let mut text = std::fs::read_to_string(folder.join(schedule)).expect("a schedule");
    for (from, to) in changes {
        assert!(text.contains(from), "{from} is not in {schedule}");
        text = text.replace(from, to);
    }
    let scratch = tempfile::tempdir().expect("a folder");
    let table = "hart_ii_beam.csv";
    std::fs::copy(folder.join(table), scratch.path().join(table)).expect("a copy");
    let path = scratch.path().join(schedule);
    std::fs::write(&path, text).expect("it can be written");
    let schedule = Schedule::read(&path).expect("a good schedule");
    found(mesh, schedule, ranks)
}

/// The part of a rank; alone the whole mesh.
fn part_of(mesh: Mesh, ranks: &Ranks) -> Mesh {
    Mesh::shared(Ok(mesh), ranks).expect("rank 0 has it")
}

/// Quality before anything has moved; positions, velocities and quality at the first steps.
fn found(mesh: Mesh, schedule: Schedule, ranks: &Ranks) -> Found {
    let whole = mesh.clone();
    let deformation = Deformation::builder(part_of(mesh, ranks), schedule)
        .on_ranks(
            (ranks.n() > 1 && ranks.is_first())
                .then(|| -> ReadWhole { Box::new(move || Ok(Arc::new(whole.clone()))) }),
            None,
        )
        .build()
        .expect("base points");
    let mesh = deformation.mesh();
    let quality = |points: &[[f64; 3]]| {
        let quality = deformation.quality_of(points).expect("its own points");
        format!("{quality:?}")
    };
    let all = 0..mesh.points.len() as u32;
    let part = mesh.part.as_ref();
    let mut found = Found {
        quality: vec![quality(&mesh.points)],
        values: Vec::new(),
        nodes: part.map_or(all.collect(), |part| part.nodes.clone()),
    };
    for step in deformation.steps().iter().take(5) {
        let points = deformation.points_at(step).expect("positions");
        found.quality.push(quality(&points));
        found.values.push(points);
        found.values.extend(deformation.velocities_at(step).ok());
    }
    found
}

fn deforms_alike(schedule: &str, changes: &[(&str, &str)]) {
    alike(&|ranks| deformed(schedule, changes, ranks));
}

fn alike(of: &(dyn Fn(&Ranks) -> Found + Sync)) {
    let alone = of(&Ranks::alone());
    for n in [2, 3, 7] {
        for (rank, found) in on_threads(n, |ranks| of(&ranks)).iter().enumerate() {
            assert_eq!(found.quality, alone.quality, "rank {rank} of {n}");
            assert_eq!(found.values.len(), alone.values.len());
            for (here, all) in found.values.iter().zip(&alone.values) {
                for (x, &node) in here.iter().zip(&found.nodes) {
                    let bits = |x: &[f64; 3]| x.map(f64::to_bits);
                    let same = bits(x) == bits(&all[node as usize]);
                    assert!(same, "rank {rank} of {n}: node {node} is at {x:?}");
                }
            }
        }
    }
}

#[test]
fn every_motion_and_boundary_gives_the_same_nodes_on_any_number_of_ranks() {
    for schedule in [
        "naca0012.toml",
        "block.toml",
        "block_sliding.toml",
        "body_in_duct.toml",
        "hart_ii.toml",
        "rotor_sector.toml",
        "rotor_sector_sliding.toml",
        "wing_on_plane.toml",
    ] {
        deforms_alike(schedule, &[]);
    }
}

#[test]
fn substeps_twist_repairs_and_velocities_give_the_same_nodes_on_any_number_of_ranks() {
    let radius = ("support_radius = 10.0 ", "support_radius = 1.5 ");
    deforms_alike("naca0012.toml", &[radius]);
    let substeps = ("[rbf]", "[rbf]\nsubsteps = 3\npolynomial = \"linear\"");
    deforms_alike("naca0012.toml", &[substeps]);
    let folds = [
        ("angle = 60.0", "angle = 170.0"),
        ("stop = 60.0", "stop = 40.0"),
    ];
    deforms_alike("block.toml", &folds);
    let improve = ("[rbf]", "[output]\nimprove = 0.5\n[rbf]");
    deforms_alike("block.toml", &[improve]);
    let twist = ("[rbf]", "[rbf]\ninterpolate = \"twist\"");
    deforms_alike("hart_ii.toml", &[twist]);
    let velocity = ("[rbf]", "[output]\nvelocity = true\n[rbf]");
    deforms_alike("hart_ii.toml", &[velocity]);
    let carried_round = [
        ("[rotor]", "[rotor]\nframe = \"inertial\""),
        ("[rbf]", "[rbf]\nsubsteps = 2"),
    ];
    deforms_alike("hart_ii.toml", &carried_round);
}

/// The files of a run that turns a blade, with their content; the folder is that of all ranks.
fn written(
    [format, precision, ramp, way]: [&str; 4],
    mesh: &Mesh,
    ranks: &Ranks,
) -> Vec<(String, Vec<u8>)> {
    let folder = tempfile::tempdir().expect("a folder");
    let angle = if way.ends_with("folds") {
        "120.0"
    } else {
        "10.0"
    };
    let zone = match way {
        "turns" => "zones = [\"near\"]\n[rotor]\nframe = \"inertial\"\n",
        "fast" | "fast folds" | "fast, rigid" => "[rotor]\nrpm = 300.0\nframe = \"inertial\"\n",
        "fast in a zone" => "zones = [\"near\"]\n[rotor]\nrpm = 300.0\nframe = \"inertial\"\n",
        _ => "",
    };
    let moves = if way == "fast, rigid" {
        "zones = [\"near\"]"
    } else {
        "tags = [\"blade\"]"
    };
    let arrays = if way.starts_with("fast") {
        "velocity = true\ndisplacement = true\n"
    } else {
        ""
    };
    // Where all steps are the same, a file of all has their positions once.
    let text = format!(
        "version = 1\nangle_unit = \"deg\"\n[azimuth]\nstart = 0.0\nstop = 60.0\nstep = 20.0\n\
         [[body]]\nname = \"blade\"\n{moves}\n[body.rigid]\nramp = {ramp}\n\
         rotate = {{ axis = [1.0, 0.0, 0.0], origin = [0.0, 0.0, 0.0], angle = {angle} }}\n\
         [boundaries]\nfixed = [\"outer\"]\n{zone}[rbf]\nkernel = \"wendland-c2\"\nsupport_radius = 6.0\n\
         [selection]\ntolerance = 1e-3\n[output]\nformat = \"{format}\"\nprecision = \"{precision}\"\n{arrays}"
    );
    let path = folder.path().join("s.toml");
    std::fs::write(&path, text).expect("it can be written");
    let schedule = Schedule::read(&path).expect("a good schedule");
    let request = Request {
        mesh: path,
        folder: folder.path().join("out"),
        // The zone is not round.
        allow_outside: true,
        ..Request::default()
    };
    let file = folder.path().join("mesh.vtkhdf");
    if ranks.is_first() {
        mesh.write(&file).expect("it can be written");
    }
    let shared = SharedFile::new(&file, None, &ReadOptions::default());
    let shared = ranks.broadcast(ranks.is_first().then_some(shared));
    let (part, layout) = match (ranks.n(), way) {
        (1, _) => (mesh.clone(), None),
        (_, "whole") => (part_of(mesh.clone(), ranks), None),
        _ => {
            let shared = shared.clone().expect("a file");
            let read = read_together(&shared, ranks, |_| Ok(())).expect("ranks read it");
            (read.part, read.layout.map(|layout| layout.mesh))
        }
    };
    let whole = mesh.clone();
    let read = (ranks.n() > 1 && ranks.is_first())
        .then(|| -> ReadWhole { Box::new(move || Ok(Arc::new(whole.clone()))) });
    let deformation = Deformation::builder(part, schedule).on_ranks(read, layout);
    let mut deformation = deformation.plan().expect("they fit");
    if !ranks.is_first() {
        deformation.follow();
        return Vec::new();
    }
    deformation.lead();
    let finished = run(&deformation, &request);
    deformation.end();
    let finished = finished.expect("it runs");
    // Of a zone that turns out of the mesh, and of what UGRID does not hold, there are others.
    let is_plain =
        !zone.starts_with("zones") && way != "fast, rigid" && !format.starts_with("ugrid");
    let warns = !finished.warnings.is_empty();
    assert!(!is_plain || warns == way.ends_with("folds"), "{finished:?}");
    let files = std::fs::read_dir(&request.folder).expect("the folder is there");
    let names = files.map(|file| file.expect("it is listed").path());
    let mut names: Vec<_> = names
        .filter(|path| !path.ends_with("run.json") && !path.ends_with("steps.csv"))
        .collect();
    names.sort();
    let content = |path: &PathBuf| {
        let name = path.file_name().expect("a name").to_string_lossy();
        (name.into_owned(), std::fs::read(path).expect("a file"))
    };
    names.iter().map(content).collect()
}

#[test]
fn ranks_write_what_one_process_writes() {
    let size = SizeOptions {
        nodes: Some(40_000),
        surface_nodes: Some(3_000),
        // Numbers of 32 bits hold its height.
        first_cell: Some(0.02),
        ..SizeOptions::default()
    };
    let options = BladeOptions {
        size,
        ..BladeOptions::default()
    };
    let mut mesh = blade(&options).expect("a sample").mesh;
    // Rounded to 32 bits the first step of a ramp is the reference mesh, though it lies in a window of repair.
    for x in mesh.points.as_flattened_mut() {
        *x = f64::from(*x as f32);
    }
    let solids = mesh.volume_runs().next().expect("it has solid cells");
    let near = solids.first_cell..solids.first_cell + solids.n_cells() / 2;
    mesh.groups.push(Group {
        dimension: 3,
        name: "near".to_owned(),
        number: None,
        condition: None,
        cells: near.collect(),
    });
    for case in [
        ["vtu", "f64", "true", "whole"],
        ["vtkhdf", "f32", "true", "whole"],
        ["vtkhdf", "f64", "false", "whole"],
        ["cgns", "f64", "true", "whole"],
        ["vtu", "f32", "true", "together"],
        ["vtkhdf", "f64", "true", "together"],
        ["cgns", "f64", "true", "together"],
        ["vtkhdf", "f64", "true", "folds"],
        ["cgns", "f64", "true", "turns"],
        ["ugrid-b8", "f64", "true", "turns"],
        ["vtkhdf", "f64", "true", "fast"],
        ["vtkhdf", "f32", "true", "fast folds"],
        ["vtu", "f32", "true", "fast in a zone"],
        ["cgns", "f64", "true", "fast in a zone"],
        ["ugrid-lb8l", "f64", "true", "together"],
        ["vtkhdf", "f64", "true", "fast, rigid"],
        ["cgns", "f64", "true", "fast, rigid"],
    ] {
        let alone = written(case, &mesh, &Ranks::alone());
        assert!(!alone.is_empty());
        for n in [2, 5] {
            let found = on_threads(n, |ranks| written(case, &mesh, &ranks)).swap_remove(0);
            for (found, alone) in found.iter().zip(&alone) {
                assert!(found == alone, "{case:?}, {n} ranks: {} differs", alone.0);
            }
            assert_eq!(found.len(), alone.len());
        }
    }
}
