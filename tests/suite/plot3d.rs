//! Plot3D grids: every way to store them, boundaries by neutral map files and by sides, and what is refused.

use crate::support::plot3d::{NEUTRAL, Stored, TEXT, blocks, every_way, file, nodes};
use crate::support::{assert_says, azimesh, json, succeed};
use azimesh_core::error::Position;
use azimesh_io::formats::{self, Format, ReadOptions, Source, parse, plot3d};
use azimesh_io::mesh::{CellKind, Mesh};
use std::path::Path;

fn read(format: &Format, bytes: &[u8]) -> azimesh::Result<Mesh> {
    let mesh = parse(format, bytes, &ReadOptions::default())?;
    mesh.validate()?;
    Ok(mesh)
}

#[test]
fn a_grid_is_the_same_however_it_is_stored() {
    for stored in every_way() {
        for (is_multi, n_axes) in [(true, 3), (true, 2), (false, 3), (false, 2)] {
            let bytes = file(stored, is_multi, n_axes);
            let what = format!("{stored:?}, multi {is_multi}, {n_axes}D");
            let mesh = read(&plot3d::ANY, &bytes).unwrap_or_else(|error| panic!("{what}: {error}"));
            let expected = nodes(blocks(is_multi, n_axes)).concat();
            assert_eq!(mesh.points, expected, "{what}");
            let kind = mesh.cells.get(0).kind;
            let solid = [CellKind::Quadrilateral, CellKind::Hexahedron][n_axes - 2];
            assert_eq!(kind, solid, "{what}");
            let source = Source::from_bytes(Path::new("grid.xyz"), bytes);
            let found = formats::recognize(&source.into()).map(|format| format.name);
            assert_eq!(found, Some("plot3d"), "{what}");
        }
    }
}

#[test]
fn blocks_are_zones_and_their_sides_tags_where_they_lie_on_no_other() {
    let mesh = read(&plot3d::ANY, &file(TEXT, true, 3)).unwrap();
    let zones: Vec<_> = mesh
        .zones()
        .map(|zone| (zone.name.as_str(), zone.cells.len()))
        .collect();
    assert_eq!(zones, [("block1", 1), ("block2", 1)]);
    let tags: Vec<_> = mesh.tags().map(|tag| tag.name.as_str()).collect();
    let of_block = |block: &str, sides: [&str; 5]| sides.map(|side| format!("{block}_{side}"));
    let expected = [
        of_block("block1", ["imin", "jmin", "jmax", "kmin", "kmax"]),
        of_block("block2", ["imax", "jmin", "jmax", "kmin", "kmax"]),
    ];
    assert_eq!(tags, expected.concat());
    // Each face points out of its block.
    let imin = mesh.tag_nodes("block1_imin").unwrap();
    assert!(
        imin.iter()
            .all(|node| mesh.points[*node as usize][0] == 0.25)
    );
    let single = read(&plot3d::ANY, &file(TEXT, false, 2)).unwrap();
    let tags: Vec<_> = single
        .tags()
        .map(|tag| (tag.name.as_str(), tag.cells.len()))
        .collect();
    assert_eq!(tags, [("imin", 3), ("imax", 3), ("jmin", 3), ("jmax", 3)]);
}

#[test]
fn sides_that_meet_in_part_are_no_tags_and_are_told() {
    let folder = tempfile::tempdir().unwrap();
    // The second block of this grid in a plane is one cell high, the first two.
    std::fs::write(folder.path().join("grid.p3d"), file(TEXT, true, 2)).unwrap();
    let run = succeed(folder.path(), "info grid.p3d");
    assert_says(&run.err, &["block1_imax", "partly"]);
    let info = json(folder.path(), "info grid.p3d");
    let tags = info["boundary_tags"].as_array().unwrap();
    assert!(
        !tags.iter().any(|tag| tag["name"] == "block1_imax"),
        "{info}"
    );
    assert!(
        tags.iter().any(|tag| tag["name"] == "block1_imin"),
        "{info}"
    );
}

#[test]
fn a_neutral_map_file_names_the_boundaries() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let map = NEUTRAL;
    std::fs::write(at.join("grid.p3dfmt"), file(TEXT, true, 3)).unwrap();
    std::fs::write(at.join("grid.nmf"), map).unwrap();
    let info = json(at, "info grid.p3dfmt");
    let tags: Vec<_> = info["boundary_tags"]
        .as_array()
        .unwrap()
        .iter()
        .map(|tag| tag["name"].as_str().unwrap())
        .collect();
    assert_eq!(
        tags,
        [
            "viscous_solid",
            "farfield",
            "symmetry_y",
            "inflow",
            "outflow"
        ],
        "{info}"
    );
    let told = succeed(at, "info grid.p3dfmt").err;
    assert_says(&told, &["interfaces to other zones are not kept (1)"]);
    for (old, new, parts) in [
        (
            "'inflow'        1 3 1 2 1 2\n",
            "",
            &["cover 5 faces of block 1", "have 6"][..],
        ),
        (
            "1  2 2 2\n",
            "1  2 3 2\n",
            &["grid.nmf:4", "block 1 has 2 x 3 x 2"],
        ),
        (
            "2 4 1 2 1 2 \\",
            "2 7 1 2 1 2 \\",
            &["grid.nmf:17", "no side 7"],
        ),
        (
            "'farfield'      1 2 1 2",
            "'farfield'      1 2 1 3",
            &["grid.nmf:10", "range 1 to 3"],
        ),
        (
            "  2 \\\n",
            "  3 \\\n",
            &["grid.nmf:2", "3 blocks; the grid has 2"],
        ),
    ] {
        assert!(map.contains(old), "{old}");
        std::fs::write(at.join("grid.nmf"), map.replacen(old, new, 1)).unwrap();
        let run = succeed(at, "info grid.p3dfmt");
        assert_says(&run.err, parts);
        assert_says(&run.out, &["block1_imin"]);
    }
}

/// A map of two planes beside a grid of 4 x 4 nodes in one: j and k of the map are the indices of the grid.
const OF_TWO_PLANES: &str = "1\n1 2 4 4\nsymmetry 1 3 1 4 1 4\nsymmetry 1 4 1 4 1 4\n\
    wall 1 1 1 2 1 3\nwake 1 1 1 2 3 4\nfarfield 1 2 1 2 1 4\ninflow 1 5 1 4 1 2\noutflow 1 6 1 4 1 2\n";

#[test]
fn a_neutral_map_file_of_two_planes_names_the_edges_of_a_grid_in_one() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("grid.p2dfmt"), file(TEXT, false, 2)).unwrap();
    std::fs::write(at.join("grid.nmf"), OF_TWO_PLANES).unwrap();
    let mesh = Mesh::read(at.join("grid.p2dfmt")).unwrap();
    let tags: Vec<_> = mesh
        .tags()
        .map(|tag| {
            let faces = tag.cells.iter().map(|face| mesh.cells.get(face).nodes);
            let mut nodes: Vec<u32> = faces.flatten().copied().collect();
            nodes.sort_unstable();
            nodes.dedup();
            (tag.name.as_str(), nodes)
        })
        .collect();
    let expected = [
        ("wall", vec![0, 1, 2]),
        ("wake", vec![2, 3]),
        ("farfield", vec![12, 13, 14, 15]),
        ("inflow", vec![0, 4, 8, 12]),
        ("outflow", vec![3, 7, 11, 15]),
    ];
    assert_eq!(tags, expected);
    let short = OF_TWO_PLANES.replace("1 2 3 4", "1 2 2 3");
    std::fs::write(at.join("grid.nmf"), short).unwrap();
    let run = succeed(at, "info grid.p2dfmt");
    assert_says(
        &run.err,
        &["cover 12 faces of block 1, 11 of them once", "have 12"],
    );
    assert_says(&run.out, &["imin", "jmax"]);
}

/// The map that Construct2D writes of an O-grid of 4 x 4 nodes in a plane.
const OF_ONE_PLANE: &str = "1\n\n1 4 4 1\n\nONE_TO_ONE 1 1 1 4 1 1 1 2 1 4 1 1 FALSE\n\
    VISCOUS 1 3 1 4 1 1 TRUE\nFARFIELD 1 4 1 4 1 1\n";

#[test]
fn a_neutral_map_file_of_one_plane_names_the_edges_of_its_grid() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("grid.p2dfmt"), file(TEXT, false, 2)).unwrap();
    std::fs::write(at.join("grid.nmf"), OF_ONE_PLANE).unwrap();
    let mesh = Mesh::read(at.join("grid.p2dfmt")).unwrap();
    let tags: Vec<_> = mesh
        .tags()
        .map(|tag| (tag.name.as_str(), mesh.tag_nodes(&tag.name).unwrap()))
        .collect();
    let expected = [
        ("VISCOUS", vec![0, 1, 2, 3]),
        ("FARFIELD", vec![12, 13, 14, 15]),
    ];
    assert_eq!(tags, expected);
    for (old, new, says) in [
        (
            "FARFIELD 1 4",
            "FARFIELD 1 5",
            "there is no side 5; it must be 1 to 4",
        ),
        (
            "1 4 1 4 1 1\n",
            "1 4 1 3 1 1\n",
            "cover 11 faces of block 1",
        ),
    ] {
        let map = OF_ONE_PLANE.replace(old, new);
        assert_ne!(map, OF_ONE_PLANE);
        std::fs::write(at.join("grid.nmf"), map).unwrap();
        assert_says(&succeed(at, "info grid.p2dfmt").err, &[says]);
    }
}

#[test]
fn an_interface_may_be_spelled_with_underscores() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("grid.p3dfmt"), file(TEXT, true, 3)).unwrap();
    let tags = |map: &str| {
        std::fs::write(at.join("grid.nmf"), map).unwrap();
        json(at, "info grid.p3dfmt")["boundary_tags"].clone()
    };
    let other = NEUTRAL.replace("'one-to-one'", "ONE_TO_ONE");
    assert_eq!(tags(&other), tags(NEUTRAL));
}

#[test]
fn a_neutral_map_file_of_another_grid_is_not_used_and_told() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("grid.p2dfmt"), file(TEXT, false, 2)).unwrap();
    for (sizes, says) in [
        ("4 4 1", "grid.nmf:3: the range 1 to 4 does not fit 1 nodes"),
        (
            "2 5 4",
            "grid.nmf:2: block 1 has 2 x 5 x 4 nodes; block 1 of the grid has 4 x 4 x 1",
        ),
    ] {
        let map = OF_TWO_PLANES.replace("2 4 4\n", &format!("{sizes}\n"));
        std::fs::write(at.join("grid.nmf"), map).unwrap();
        let run = succeed(at, "info grid.p2dfmt");
        assert_says(&run.err, &[says]);
        assert_says(&run.out, &["imin", "jmax"]);
    }
}

#[test]
fn a_grid_that_can_be_read_in_two_ways_is_refused_until_one_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    // One block of 2 x 2 nodes in a plane with blanking, or without it in space: 12 numbers, each time after 3 counts.
    std::fs::write(at.join("grid.xyz"), "1 2 2\n0 1 0 1  0 0 1 1  1 1 1 1\n").unwrap();
    let run = azimesh(at, "info grid.xyz");
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(
        &run.err,
        &[
            "can be read in 2 ways",
            "multi-block, 2D, with iblank",
            "single block, 3D",
        ],
    );
    assert_says(
        &run.err,
        &["--input-format plot3d-multi or plot3d-single", "text"],
    );
    let stated = json(at, "info grid.xyz --format plot3d-multi");
    assert_eq!(stated["nodes"], 4, "{stated}");
    let other = json(at, "info grid.xyz --format plot3d-3d");
    assert_ne!(stated["bounds"], other["bounds"]);
    assert_eq!(
        json(at, "info grid.xyz --input-format plot3d-multi"),
        stated
    );
}

#[test]
fn every_command_reads_a_mesh_in_the_format_that_is_stated() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    std::fs::write(at.join("grid.xyz"), "1 2 2\n0 1 0 1  0 0 1 1  1 1 1 1\n").unwrap();
    let schedule = "steps = 2\n[[body]]\nname = \"side\"\ntags = [\"imin\"]\n\
                    [body.rigid]\ntranslate = [-0.1, 0.0, 0.0]\n[boundaries]\nothers = \"fixed\"\n";
    std::fs::write(at.join("s.toml"), schedule).unwrap();
    for command in [
        "convert grid.xyz c.vtu",
        "convert grid.xyz -o all --format vtu",
        "repair grid.xyz -o r.vtu",
        "quality grid.xyz",
        "quality grid.xyz -o q.vtu --reference grid.xyz",
        "diff grid.xyz grid.xyz",
        "check grid.xyz s.toml",
        "select grid.xyz s.toml -o base.toml",
        "deform grid.xyz s.toml -o out --format vtk",
    ] {
        let refused = azimesh(at, command);
        assert_eq!(refused.code, 2, "{command}: {refused:?}");
        assert_says(&refused.err, &["can be read in 2 ways"]);
        succeed(at, format!("{command} --input-format plot3d-multi"));
    }
    assert_eq!(json(at, "info c.vtu")["nodes"], 4);
    assert!(at.join("out/grid_0001.vtk").exists());
}

#[test]
fn formats_that_are_not_known_are_refused_by_every_command() {
    let folder = crate::support::short();
    let at = folder.path();
    for command in [
        "info n.vtu",
        "check n.vtu few.toml",
        "select n.vtu few.toml -o base.toml",
        "deform n.vtu few.toml -o out",
        "diff n.vtu n.vtu",
        "quality n.vtu",
        "convert n.vtu o.vtu",
        "repair n.vtu -o o.vtu",
    ] {
        for option in ["--format", "--input-format"] {
            let run = azimesh(at, format!("{command} {option} nonsense"));
            assert_eq!(run.code, 2, "{command} {option}: {run:?}");
            assert_says(&run.err, &["nonsense"]);
        }
    }
    let both = azimesh(at, "info n.vtu --format vtu --input-format su2");
    assert_eq!(both.code, 2, "{both:?}");
    assert_says(&both.err, &["--format vtu and --input-format su2"]);
    let useless = azimesh(at, "report out --input-format vtu");
    assert_eq!(useless.code, 2, "{useless:?}");
    assert_says(&useless.err, &["--input-format does nothing here"]);
}

#[test]
fn a_grid_whose_counts_fit_nothing_is_refused_with_what_would_fit() {
    let mut text = file(TEXT, true, 3);
    text.extend(b" 7.0\n");
    let error = read(&plot3d::ANY, &text).unwrap_err();
    assert_says(
        &error.message,
        &["56 numbers", "multi-block, 3D, without iblank, text: 55"],
    );
    for stored in every_way()
        .into_iter()
        .filter(|stored| stored.real.is_some())
    {
        let mut binary = file(stored, true, 3);
        binary.pop();
        let error = read(&plot3d::ANY, &binary).unwrap_err();
        assert_says(&error.message, &["fit the length of the file in no layout"]);
    }
    let error = read(&plot3d::ANY, b" 1\n 2 2 2\n 8*0.0, 8*1.0, 8*2.0\n").unwrap_err();
    assert_says(&error.message, &["3*0.0", "are not read"]);
    let word = String::from_utf8(file(TEXT, true, 3))
        .unwrap()
        .replacen("0.250", "x.250", 1);
    let error = read(&plot3d::ANY, word.as_bytes()).unwrap_err();
    assert_eq!(error.position, Some(Position::Line(3)), "{error}");
    assert_says(&error.message, &["a coordinate", "x.250"]);
}

#[test]
fn coordinates_of_any_size_are_read_and_infinite_ones_are_named_by_their_byte() {
    let stored = Stored {
        real: Some(8),
        is_big_endian: true,
        has_records: true,
        has_blanking: false,
    };
    let whole = file(stored, true, 3);
    // The marks and counts take 44 bytes, the mark of the block 4; its second axis is that of all y.
    let at = 48 + 8 * (8 + 3);
    for (value, message) in [(1e-300, None), (f64::NAN, Some("node 4"))] {
        let mut bytes = whole.clone();
        bytes[at..at + 8].copy_from_slice(&f64::to_be_bytes(value));
        match (read(&plot3d::ANY, &bytes), message) {
            (Ok(mesh), None) => assert_eq!(mesh.points[3][1], value),
            (Err(error), Some(message)) => {
                assert_says(&error.message, &[message, "not finite"]);
                assert_eq!(error.position, Some(Position::Byte(at as u64)));
            }
            (read, _) => panic!("{value}: {:?}", read.map(|mesh| mesh.points)),
        }
    }
}

#[test]
fn blanking_is_told_and_the_format_is_not_written() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let stored = every_way()
        .into_iter()
        .find(|stored| stored.has_blanking)
        .unwrap();
    std::fs::write(at.join("grid.xyz"), file(stored, false, 3)).unwrap();
    let told = succeed(at, "convert grid.xyz grid.vtu").err;
    assert_says(&told, &["blanking is not kept"]);
    let run = azimesh(at, "convert grid.vtu new.p3d");
    assert_eq!(run.code, 2, "{run:?}");
    assert_says(&run.err, &["Plot3D", "is read, not written"]);
}
