//! Options, meshes and displacements that a morph refuses.

use super::*;
use azimesh_core::error::{Error, ErrorKind};

fn refused(mesh: Mesh, options: MorphOptions) -> Error {
    let error = Morph::new(mesh, options).expect_err("it is refused");
    assert_eq!(error.kind, ErrorKind::Input, "{error}");
    error
}

#[test]
fn what_is_wrong_with_the_options_is_told() {
    let good = || options("airfoil", &["farfield"], &[]);
    let cases: Vec<(MorphOptions, &str)> = vec![
        (
            options("wing", &[], &[]),
            "\"wing\" is not in the mesh; it has: airfoil, farfield",
        ),
        (
            MorphOptions {
                moving: Nodes::default(),
                ..good()
            },
            "`moving` has no nodes",
        ),
        (
            MorphOptions {
                fixed: vec![0, 99_999].into(),
                ..good()
            },
            "has node 99999, but the mesh has",
        ),
        (
            MorphOptions {
                fixed: vec![7, 7].into(),
                ..good()
            },
            "`fixed` has node 7 twice",
        ),
        (
            MorphOptions {
                max_points: 0,
                ..good()
            },
            "`max_points` is 0",
        ),
        (
            MorphOptions {
                tolerance: f64::NAN,
                ..good()
            },
            "`tolerance` is NaN",
        ),
        (
            MorphOptions {
                support_radius: Some(-1.0),
                ..good()
            },
            "`support_radius` is -1",
        ),
        (
            MorphOptions {
                samples: vec![vec![[1.0; 3]]],
                ..good()
            },
            "sample 0: found 1 displacement for ",
        ),
    ];
    for (options, wanted) in cases {
        let error = refused(read("naca0012.vtu"), options);
        assert!(error.message.contains(wanted), "{error}");
    }
}

#[test]
fn a_node_in_two_lists_is_refused_and_tags_that_meet_are_not() {
    let mesh = read("wing_on_plane.vtu");
    let wing = mesh.tag_nodes("wing").expect("it is there");
    let plane = mesh.tag_nodes("symmetry").expect("it is there");
    let both = MorphOptions {
        moving: wing.into(),
        fixed: plane.into(),
        ..MorphOptions::default()
    };
    let error = refused(mesh.clone(), both);
    assert!(
        error.message.contains("is in `moving` and in `fixed`"),
        "{error}"
    );
    let met = options("wing", &["symmetry", "farfield"], &[]);
    let morph = Morph::new(mesh.clone(), met).expect("the wing's foot moves");
    assert_eq!(morph.moving(), mesh.tag_nodes("wing").expect("it is there"));
}

#[test]
fn sliding_on_curved_walls_is_refused() {
    let error = refused(
        read("body_in_duct.vtu"),
        options("body", &["inlet", "outlet"], &["wall"]),
    );
    assert!(error.message.contains("curved boundary"), "{error}");
}

#[test]
fn nodes_that_slide_need_faces_of_nodes_that_slide() {
    let mesh = read("wing_on_plane.vtu");
    let plane = mesh.tag_nodes("symmetry").expect("it is there");
    let inside = vec![mesh.points.len() as u32 - 1];
    let slide = |nodes: Vec<u32>| MorphOptions {
        slide: nodes.into(),
        ..options("wing", &["farfield"], &[])
    };
    let error = refused(mesh.clone(), slide([plane.clone(), inside].concat()));
    assert!(error.message.contains("cannot slide"), "{error}");
    let by_list = Morph::new(mesh.clone(), slide(plane)).expect("the plane's faces are found");
    let by_tag = options("wing", &["farfield"], &["symmetry"]);
    let by_tag = Morph::new(mesh, by_tag).expect("it is good");
    let d = rough(&by_tag, 1);
    let [a, b] = [by_list, by_tag].map(|morph| morph.points(&d).expect("it is good"));
    assert_eq!(a, b);
}

#[test]
fn a_mesh_made_in_memory_is_checked() {
    let mut mesh = torn();
    mesh.cells.push(CellKind::Triangle, &[0, 1, 77]);
    let moving = || MorphOptions {
        moving: vec![0].into(),
        ..MorphOptions::default()
    };
    assert!(refused(mesh, moving()).message.contains("has node 77"));
    let mut mesh = torn();
    mesh.points[3][1] = f64::INFINITY;
    assert!(refused(mesh, moving()).message.contains("node 3 is at"));
}

#[test]
fn wrong_displacements_and_derivatives_are_told() {
    let morph = Morph::new(read("naca0012.vtu"), options("airfoil", &["farfield"], &[]));
    let morph = morph.expect("it is good");
    let n = morph.moving().len();
    let told = |d: &[Vector]| morph.points(d).expect_err("it is refused").to_string();
    assert!(told(&[[0.0; 3]]).contains(&format!("1 displacement for {n} nodes")));
    let with = |d: Vector| {
        let mut all = vec![[0.0; 3]; n];
        all[4] = d;
        all
    };
    let node = format!("node {} has ", morph.moving()[4]);
    assert!(told(&with([0.0, f64::NAN, 0.0])).contains(&node));
    assert!(told(&with([0.0, 0.0, 0.1])).contains("leaves the plane"));
    let mut g = vec![[0.0; 3]; morph.mesh().points.len()];
    assert!(morph.pull_back(&g[1..]).is_err());
    g[9][2] = f64::INFINITY;
    let error = morph.pull_back(&g).expect_err("it is refused");
    assert!(
        error.message.contains("node 9 has the derivative"),
        "{error}"
    );
}
