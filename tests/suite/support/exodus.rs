//! A small Exodus file: a tetrahedron, a wedge, a polyhedron and a bar with side sets, node sets and results.

use super::netcdf::{NetCdf, Numbers, text};

/// The small mesh in netCDF's version 1, 2 or 5; with the names that Exodus had before version 4 in the first.
pub fn small(version: u8) -> Vec<u8> {
    file(version).bytes()
}

/// The file of [`small`].
pub fn file(version: u8) -> NetCdf {
    let mut file = NetCdf::new(version, 2, DIMENSIONS);
    nodes(&mut file, version);
    blocks(&mut file);
    sets(&mut file);
    results(&mut file, version);
    file
}

const DIMENSIONS: &[(&str, usize)] = &[
    ("len_string", 33),
    ("time_step", 0),
    ("num_dim", 3),
    ("num_nodes", 16),
    ("num_elem", 5),
    ("num_el_blk", 5),
    ("num_fa_blk", 1),
    ("num_side_sets", 3),
    ("num_node_sets", 1),
    ("num_el_in_blk1", 1),
    ("num_nod_per_el1", 4),
    ("num_el_in_blk2", 1),
    ("num_nod_per_el2", 6),
    ("num_el_in_blk4", 1),
    ("num_fac_per_el4", 4),
    ("num_el_in_blk5", 2),
    ("num_nod_per_el5", 3),
    ("num_fa_in_blk1", 4),
    ("num_nod_per_fa1", 12),
    ("num_side_ss1", 2),
    ("num_side_ss2", 2),
    ("num_nod_ns1", 3),
    ("num_nod_var", 4),
    ("num_elem_var", 1),
    ("num_glo_var", 2),
];

fn nodes(file: &mut NetCdf, version: u8) {
    let axes: [Vec<f64>; 3] = [
        (0..16).map(f64::from).collect(),
        vec![0.5; 16],
        (0..16).map(|i| -f64::from(i * i)).collect(),
    ];
    match version {
        1 => file.add(
            "coord",
            &["num_dim", "num_nodes"],
            Numbers::F64(axes.concat()),
        ),
        _ => {
            for (name, axis) in ["coordx", "coordy", "coordz"].iter().zip(axes) {
                file.add(name, &["num_nodes"], Numbers::F64(axis));
            }
        }
    }
    let ids = (0..16).map(|i| 100 + i).collect();
    file.add("node_num_map", &["num_nodes"], Numbers::I32(ids));
    file.add(
        "elem_num_map",
        &["num_elem"],
        Numbers::I32(vec![1, 2, 3, 4, 5]),
    );
}

fn blocks(file: &mut NetCdf) {
    file.add(
        "eb_prop1",
        &["num_el_blk"],
        Numbers::I32(vec![10, 20, 30, 40, 50]),
    );
    let names = text(33, &["air", "", "nothing", "cells", "skin"]);
    file.add("eb_names", &["num_el_blk", "len_string"], names);
    let nodes = Numbers::I32(vec![1, 2, 3, 4]);
    file.connect(
        "connect1",
        &["num_el_in_blk1", "num_nod_per_el1"],
        "TETRA",
        nodes,
    );
    let nodes = Numbers::I64(vec![1, 2, 3, 4, 5, 6]);
    if file_is_wide(file) {
        file.connect(
            "connect2",
            &["num_el_in_blk2", "num_nod_per_el2"],
            "WEDGE6",
            nodes,
        )
    } else {
        let nodes = Numbers::I32(vec![1, 2, 3, 4, 5, 6]);
        file.connect(
            "connect2",
            &["num_el_in_blk2", "num_nod_per_el2"],
            "WEDGE6",
            nodes,
        );
    }
    let faces = Numbers::I32(vec![1, 2, 3, 4]);
    file.connect("facconn4", &["num_fac_per_el4"], "nfaced", faces);
    file.add("ebepecnt4", &["num_el_in_blk4"], Numbers::I32(vec![4]));
    let nodes = Numbers::I32(vec![6, 7, 8, 6, 7, 9, 7, 8, 9, 6, 8, 9]);
    file.connect("fbconn1", &["num_nod_per_fa1"], "nsided", nodes);
    file.add("fbepecnt1", &["num_fa_in_blk1"], Numbers::I32(vec![3; 4]));
    let nodes = Numbers::I32(vec![10, 11, 12, 11, 12, 13]);
    file.connect(
        "connect5",
        &["num_el_in_blk5", "num_nod_per_el5"],
        "SHELL3",
        nodes,
    );
}

fn file_is_wide(file: &NetCdf) -> bool {
    file.version() == 5
}

fn sets(file: &mut NetCdf) {
    file.add("ss_prop1", &["num_side_sets"], Numbers::I32(vec![7, 8, 9]));
    let names = text(33, &["upper wall", "", "never"]);
    file.add("ss_names", &["num_side_sets", "len_string"], names);
    file.add("elem_ss1", &["num_side_ss1"], Numbers::I32(vec![1, 2]));
    file.add("side_ss1", &["num_side_ss1"], Numbers::I32(vec![4, 1]));
    file.add("elem_ss2", &["num_side_ss2"], Numbers::I32(vec![3, 4]));
    file.add("side_ss2", &["num_side_ss2"], Numbers::I32(vec![2, 1]));
    file.add("ns_prop1", &["num_node_sets"], Numbers::I32(vec![3]));
    file.add("node_ns1", &["num_nod_ns1"], Numbers::I32(vec![1, 2, 3]));
}

fn results(file: &mut NetCdf, version: u8) {
    file.add("time_whole", &["time_step"], Numbers::F64(vec![0.25, 0.5]));
    let names = text(33, &["displ_x", "displ_y", "displ_z", "p"]);
    file.add("name_nod_var", &["num_nod_var", "len_string"], names);
    let values = |variable: usize, time: usize| {
        (0..16).map(move |i| (100 * time + 10 * variable) as f64 + f64::from(i) / 16.0)
    };
    if version == 1 {
        let all = (0..2)
            .flat_map(|time| (0..4).flat_map(move |i| values(i, time)))
            .collect();
        let dimensions = ["time_step", "num_nod_var", "num_nodes"];
        file.add("vals_nod_var", &dimensions, Numbers::F64(all));
    } else {
        for i in 0..4 {
            let all = (0..2).flat_map(|time| values(i, time)).collect();
            let name = format!("vals_nod_var{}", i + 1);
            file.add(&name, &["time_step", "num_nodes"], Numbers::F64(all));
        }
    }
    file.add(
        "name_elem_var",
        &["num_elem_var", "len_string"],
        text(33, &["stress"]),
    );
    file.add(
        "vals_elem_var1eb1",
        &["time_step", "num_el_in_blk1"],
        Numbers::F32(vec![1.0, 2.0]),
    );
    let of_shells = Numbers::F32(vec![3.0, 4.0, 5.0, 6.0]);
    file.add(
        "vals_elem_var1eb5",
        &["time_step", "num_el_in_blk5"],
        of_shells,
    );
    file.add(
        "name_glo_var",
        &["num_glo_var", "len_string"],
        text(33, &["mass", "energy"]),
    );
    let values = Numbers::F64(vec![1.0, 2.0, 3.0, 4.0]);
    file.add("vals_glo_var", &["time_step", "num_glo_var"], values);
}
