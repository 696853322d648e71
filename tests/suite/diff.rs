//! `azimesh diff` from outside: what regression tests in shell scripts rely on.

use crate::support::sequence::testdata;
use crate::support::{airfoil, assert_says, azimesh, json, rewrite, succeed};

const SQUARE: &str = "NDIME= 2\nNELEM= 2\n5 0 1 2 0\n5 0 2 3 1\nNPOIN= 4\n0 0 0\n1 0 1\n1 1 2\n\
0 1 3\nNMARK= 2\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n3 0 1\n3 1 2\nMARKER_TAG= far\nMARKER_ELEMS= 2\n\
3 2 3\n3 3 0\n";
/// The same with other numbers: nodes 0 1 2 3 are called 2 0 3 1.
const RENUMBERED: &str = "NDIME= 2\nNELEM= 2\n5 3 1 2 0\n5 2 0 3 1\nNPOIN= 4\n1 0 0\n0 1 1\n0 0 2\n\
1 1 3\nNMARK= 2\nMARKER_TAG= far\nMARKER_ELEMS= 2\n3 1 2\n3 3 1\nMARKER_TAG= wall\nMARKER_ELEMS= 2\n\
3 2 0\n3 0 3\n";

fn folder(other: &str) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("a.su2"), SQUARE).unwrap();
    std::fs::write(folder.path().join("b.su2"), other).unwrap();
    folder
}

#[test]
fn one_line_tells_a_moved_node_a_swapped_tag_and_a_reordered_cell() {
    for (what, old, new, line) in [
        (
            "node",
            "1 1 2\n",
            "1.000000001 1 2\n",
            "1 node differs: node 2, by 1",
        ),
        (
            "tag",
            "wall\nMARKER_ELEMS= 2\n3 0 1\n3 1 2",
            "wall\nMARKER_ELEMS= 2\n3 0 1\n3 2 3",
            "groups differ",
        ),
        (
            "cell",
            "5 0 1 2 0\n5 0 2 3 1",
            "5 0 2 3 0\n5 0 1 2 1",
            "different: 2 cells differ",
        ),
    ] {
        let mut changed = SQUARE.replace(old, new);
        if what == "tag" {
            changed = changed.replace("far\nMARKER_ELEMS= 2\n3 2 3", "far\nMARKER_ELEMS= 2\n3 1 2");
        }
        let folder = folder(&changed);
        let run = azimesh(folder.path(), "diff a.su2 b.su2");
        assert_eq!(
            (run.code, run.out.lines().count()),
            (1, 1),
            "{what}: {run:?}"
        );
        assert!(run.out.contains(line), "{what}: {run:?}");
        assert!(run.err.is_empty(), "{what}: {run:?}");
        let more = azimesh(folder.path(), "diff -v a.su2 b.su2").out;
        assert!(more.lines().count() > 1, "{what}: {more}");
    }
}

#[test]
fn tolerances_are_lengths_or_fractions_of_the_diagonal() {
    let folder = folder(&SQUARE.replace("1 1 2\n", "1.001 1 2\n"));
    for (options, code) in [
        (&["--tolerance", "0.0011"][..], 0),
        (&["--tolerance", "0.0009"], 1),
        (&["--tolerance", "0.0008", "--relative"], 0),
        (&["--tolerance", "0.0006", "--relative"], 1),
    ] {
        let args = [&["diff", "a.su2", "b.su2"], options].concat();
        let run = azimesh(folder.path(), &args);
        assert_eq!(run.code, code, "{options:?}: {run:?}");
    }
}

#[test]
fn a_renumbered_mesh_is_matched_by_position() {
    let folder = folder(RENUMBERED);
    assert_eq!(azimesh(folder.path(), "diff a.su2 b.su2").code, 1);
    let by_position = ["diff", "a.su2", "b.su2", "--match", "position"];
    let run = succeed(folder.path(), by_position);
    assert_eq!(run.out, "same: 4 nodes, 6 cells\n");
    let moved = RENUMBERED.replace("1 1 3\n", "1.000000001 1 3\n");
    std::fs::write(folder.path().join("b.su2"), moved).unwrap();
    let found = json(folder.path(), by_position);
    assert_eq!(found["same"], false);
    assert_eq!(found["moved_nodes"], 1);
    assert_eq!(found["first_moved"]["node"], 2);
    assert_eq!(found["first_moved"]["partner"], 3);
    let far = [&by_position[..], &["--match-tolerance", "1e-10"]].concat();
    let run = azimesh(folder.path(), &far);
    assert!(
        run.out
            .contains("1 node of the first mesh and 1 of the second have no partner"),
        "{run:?}"
    );
}

#[test]
fn sequences_are_compared_step_by_step() {
    let folder = airfoil();
    let path = folder.path();
    let few = [("step = 10.0", "step = 90.0")];
    rewrite(path, "n.toml", "few.toml", &few);
    succeed(path, "-q deform n.vtu few.toml -o out");
    succeed(path, "-q convert out/n.pvd all.vtkhdf");
    let run = succeed(path, "diff out all.vtkhdf");
    assert!(run.out.starts_with("same: 5 steps, "), "{run:?}");
    let moved = "-q convert out/n_0002.vtu out/n_0003.vtu --force";
    succeed(path, moved);
    let run = azimesh(path, "diff out/n.pvd all.vtkhdf -v");
    assert_eq!(run.code, 1);
    assert_says(&run.out, &["different: ", "1 of 5 steps", "step 3"]);
    let found = json(path, "diff out all.vtkhdf");
    assert_eq!(found["steps"][3]["same"], false);
    assert_eq!(found["steps"][4]["same"], true);
    succeed(path, "-q convert out/n.pvd one.vtkhdf --step 0");
    let run = azimesh(path, "diff out n.vtu");
    assert_eq!(run.code, 2);
    assert_says(&run.err, &["sequence", "n.vtu", "one mesh"]);
    let run = azimesh(path, "diff . n.vtu");
    assert!(
        run.err.contains("several sequences") || run.err.contains("sequence"),
        "{run:?}"
    );
}

#[test]
fn polyhedra_that_a_format_gives_back_as_other_cells_are_explained() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path();
    let mesh = testdata("polyhedra_ascii.vtu").display().to_string();
    succeed(path, ["convert", &mesh, "case", "--format", "openfoam"]);
    let run = azimesh(path, ["diff", &mesh, "case", "--match", "position"]);
    assert_eq!(run.code, 1, "{run:?}");
    let told = "the first mesh has 613 cells as polyhedra or polygons more than the second";
    assert_says(&run.err, &[told, "OpenFOAM"]);
    let run = succeed(path, "diff case case");
    assert!(!run.err.contains("polyhedra"), "{}", run.err);
}
