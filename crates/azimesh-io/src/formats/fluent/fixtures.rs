//! Small meshes as Fluent stores them, written by the tests: text, binary, HDF5.

use crate::formats::column::Data;
use crate::formats::hdf5::{Element, Tree};
use std::fmt::Write;

/// A file: numbers count from 1, as in it.
#[derive(Clone)]
pub(super) struct Small {
    pub dimension: usize,
    pub points: Vec<[f64; 3]>,
    pub faces: Vec<Zone>,
    /// Zone, first and last cell, type.
    pub cells: Vec<[u32; 4]>,
    /// Zone, type and name.
    pub names: Vec<(u32, &'static str, &'static str)>,
    /// Further sections of text.
    pub more: String,
}

/// A zone of faces.
#[derive(Clone)]
pub(super) struct Zone {
    pub zone: u32,
    pub kind: u32,
    /// Nodes and two cells.
    pub faces: Vec<(Vec<u32>, [u32; 2])>,
}

/// Encoding of numbers.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Stored {
    pub is_double: bool,
    pub is_big_endian: bool,
}

/// A zone of these faces, one after another the nodes and the two cells.
pub(super) fn zone(zone: u32, kind: u32, faces: &[(&[u32], [u32; 2])]) -> Zone {
    let faces = faces.iter().map(|(nodes, cells)| (nodes.to_vec(), *cells));
    Zone {
        zone,
        kind,
        faces: faces.collect(),
    }
}

/// A cube, and a pyramid on it.
pub(super) fn house() -> Small {
    let (x, y, z) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]);
    let sum = |a: [f64; 3], b: [f64; 3]| [a[0] + b[0], a[1] + b[1], a[2] + b[2]];
    let floor = [[0.0; 3], x, sum(x, y), y];
    Small {
        dimension: 3,
        points: floor
            .into_iter()
            .chain(floor.map(|point| sum(point, z)))
            .chain([[0.5, 0.5, 1.5]])
            .collect(),
        faces: vec![
            // The cells are on the side that the right-hand rule points to, then on the other.
            zone(10, 2, &[(&[5, 6, 7, 8], [2, 1])]),
            zone(
                3,
                10,
                &[
                    (&[5, 6, 2, 1], [1, 0]),
                    (&[2, 3, 7, 6], [0, 1]),
                    (&[7, 8, 4, 3], [1, 0]),
                    (&[8, 5, 1, 4], [1, 0]),
                ],
            ),
            zone(4, 3, &[(&[1, 2, 3, 4], [1, 0])]),
            zone(
                17,
                7,
                &[
                    (&[6, 5, 9], [2, 0]),
                    (&[7, 6, 9], [2, 0]),
                    (&[7, 8, 9], [0, 2]),
                    (&[5, 8, 9], [2, 0]),
                ],
            ),
        ],
        cells: vec![[1, 1, 1, 1], [2, 2, 2, 1]],
        names: vec![
            (1, "fluid", "room"),
            (2, "solid", "roof"),
            (3, "velocity-inlet", "sides"),
            (4, "wall", "floor"),
            (17, "symmetry", "tiles"),
            (10, "interior", "default-interior"),
        ],
        more: String::new(),
    }
}

/// A square next to one that was divided into a lower and an upper half.
pub(super) fn refined() -> Small {
    Small {
        dimension: 2,
        points: [
            [0.0, 0.0],
            [1.0, 0.0],
            [1.0, 1.0],
            [0.0, 1.0],
            [2.0, 0.0],
            [2.0, 1.0],
            [1.0, 0.5],
            [2.0, 0.5],
        ]
        .map(|[x, y]| [x, y, 0.0])
        .to_vec(),
        faces: vec![
            zone(5, 31, &[(&[2, 3], [1, 2]), (&[5, 6], [2, 0])]),
            zone(
                6,
                2,
                &[(&[2, 7], [1, 3]), (&[3, 7], [4, 1]), (&[7, 8], [4, 3])],
            ),
            zone(
                7,
                3,
                &[
                    (&[1, 2], [1, 0]),
                    (&[4, 3], [0, 1]),
                    (&[4, 1], [1, 0]),
                    (&[2, 5], [3, 0]),
                    (&[5, 8], [3, 0]),
                    (&[8, 6], [4, 0]),
                    (&[6, 3], [4, 0]),
                ],
            ),
        ],
        cells: vec![[1, 1, 1, 1], [2, 2, 2, 32], [1, 3, 4, 1]],
        names: vec![(1, "fluid", "air"), (7, "wall", "box")],
        more: "(58 (2 2 1 1)(\n2 3 4))\n(59 (1 2 5 6)(\n2 3 4\n2 a b))\n".to_owned(),
    }
}

impl Small {
    /// As text. Zones of faces of one size say so where `says_size`.
    pub fn text(&self, says_size: bool) -> String {
        let mut text = String::from("(0 \"a small mesh (of tests)\")\n");
        let mut line = |part: String| text.push_str(&part);
        line(format!(
            "(2 {})\n(10 (0 1 {:x} 0))\n",
            self.dimension,
            self.points.len()
        ));
        line(format!(
            "(10 (1 1 {:x} 1 {})(\n",
            self.points.len(),
            self.dimension
        ));
        for point in &self.points {
            let words: Vec<String> = point[..self.dimension].iter().map(f64::to_string).collect();
            line(format!("{}\n", words.join(" ")));
        }
        line("))\n".to_owned());
        line(format!("(12 (0 1 {:x} 0))\n", self.n_cells()));
        for [zone, first, last, kind] in &self.cells {
            line(format!(
                "(12 ({zone:x} {first:x} {last:x} {kind:x} 0)(\n4 4))\n"
            ));
        }
        line(format!("(13 (0 1 {:x} 0))\n", self.n_faces()));
        let mut first = 1;
        for zone in &self.faces {
            let size = if says_size { zone.size() } else { 0 };
            let last = first + zone.faces.len() - 1;
            line(format!(
                "(13({:x} {first:x} {last:x} {:x} {size})(\n",
                zone.zone, zone.kind
            ));
            first = last + 1;
            for (nodes, cells) in &zone.faces {
                let count = (size == 0).then_some(nodes.len() as u32);
                let words = count.iter().chain(nodes).chain(cells);
                let words: Vec<String> = words.map(|n| format!("{n:x}")).collect();
                line(format!("{}\n", words.join(" ")));
            }
            line("))\n".to_owned());
        }
        line(self.names_text());
        line(self.more.clone());
        text
    }

    fn names_text(&self) -> String {
        let mut text = String::new();
        for (zone, kind, name) in &self.names {
            let _ = writeln!(
                text,
                "(39 ({zone} {kind} {name} 1)(\n (a . \"(\")\n (b? #f)))"
            );
        }
        text
    }

    /// In binary sections.
    pub fn binary(&self, stored: Stored, says_size: bool) -> Vec<u8> {
        let base = if stored.is_double { 3000 } else { 2000 };
        let machine = if stored.is_big_endian { "23" } else { "60" };
        let mut file = format!(
            "(4 ({machine} 0 0 1 2 4 4 4 8 8 8 4))\n(2 {})\n",
            self.dimension
        )
        .into_bytes();
        let section = |file: &mut Vec<u8>, header: String, body: Option<Vec<u8>>| {
            let index = base + header[..2].parse::<u32>().unwrap_or(0);
            file.extend(format!("({index} {}", &header[3..]).bytes());
            if let Some(body) = body {
                file.extend(b"\n(");
                file.extend(body);
                file.extend(b")");
            }
            file.extend(format!("\nEnd of Binary Section   {index})\n").bytes());
        };
        let coordinates = self
            .points
            .iter()
            .flat_map(|point| &point[..self.dimension]);
        let body = coordinates.flat_map(|x| {
            if stored.is_double {
                ordered(&x.to_le_bytes(), stored)
            } else {
                ordered(&(*x as f32).to_le_bytes(), stored)
            }
        });
        let header = format!("10 (1 1 {:x} 1 {})", self.points.len(), self.dimension);
        section(&mut file, header, Some(body.collect()));
        for [zone, first, last, kind] in &self.cells {
            section(
                &mut file,
                format!("12 ({zone:x} {first:x} {last:x} {kind:x} 4)"),
                None,
            );
        }
        let mut first = 1;
        for zone in &self.faces {
            let size = if says_size { zone.size() } else { 0 };
            let last = first + zone.faces.len() - 1;
            let header = format!(
                "13 ({:x} {first:x} {last:x} {:x} {size})",
                zone.zone, zone.kind
            );
            first = last + 1;
            let numbers = zone.faces.iter().flat_map(|(nodes, cells)| {
                let count = (size == 0).then_some(nodes.len() as u32);
                count.into_iter().chain(nodes.iter().copied()).chain(*cells)
            });
            let body = numbers.flat_map(|n| ordered(&n.to_le_bytes(), stored));
            section(&mut file, header, Some(body.collect()));
        }
        file.extend(self.names_text().bytes());
        file.extend(self.more.bytes());
        file
    }

    /// In HDF5, as `.cas.h5` files have it.
    pub fn hdf5(&self) -> Vec<u8> {
        let mut tree = Tree::new();
        let meshes = tree.group(Tree::ROOT, "meshes");
        let mesh = tree.group(meshes, "1");
        tree.number_attribute(mesh, "dimension", &[self.dimension as i32], false);
        tree.number_attribute(mesh, "nodeCount", &[self.points.len() as u64], false);
        let nodes = tree.group(mesh, "nodes");
        let coords = tree.group(nodes, "coords");
        let coordinates = self
            .points
            .iter()
            .flat_map(|point| &point[..self.dimension]);
        let bytes: Vec<u8> = coordinates.flat_map(|x| x.to_le_bytes()).collect();
        let shape = [self.points.len() as u64, self.dimension as u64];
        let one = tree.dataset(
            coords,
            "1",
            Element::Float64,
            &shape,
            Data::Bytes(bytes.into()),
        );
        ids(&mut tree, one, 1, self.points.len());
        let cells = tree.group(mesh, "cells");
        let zones = tree.group(cells, "zoneTopology");
        let column = |i: usize| -> Vec<u32> { self.cells.iter().map(|zone| zone[i]).collect() };
        for (name, i) in [("id", 0), ("minId", 1), ("maxId", 2), ("zoneType", 3)] {
            tree.numbers(zones, name, &column(i));
        }
        self.hdf5_faces(&mut tree, mesh);
        let settings = tree.group(Tree::ROOT, "settings");
        let text = vec![self.names_text()];
        tree.dataset(
            settings,
            "Thread Variables",
            Element::String,
            &[1],
            Data::Text(text.into()),
        );
        let mut bytes = Vec::new();
        tree.write(&mut bytes).expect("it is in memory");
        bytes
    }

    fn hdf5_faces(&self, tree: &mut Tree, mesh: crate::formats::hdf5::Id) {
        let faces = tree.group(mesh, "faces");
        let zones = tree.group(faces, "zoneTopology");
        let mut topology: [Vec<u32>; 4] = Default::default();
        let mut first = 1;
        for zone in &self.faces {
            let n = zone.faces.len() as u32;
            for (list, value) in
                topology
                    .iter_mut()
                    .zip([zone.zone, first, first + n - 1, zone.kind])
            {
                list.push(value);
            }
            first += n;
        }
        for (name, list) in ["id", "minId", "maxId", "zoneType"]
            .into_iter()
            .zip(&topology)
        {
            tree.numbers(zones, name, list);
        }
        let all: Vec<_> = self.faces.iter().flat_map(|zone| &zone.faces).collect();
        let nodes = tree.group(faces, "nodes");
        let one = tree.group(nodes, "1");
        ids(tree, one, 1, all.len());
        let counts: Vec<i32> = all.iter().map(|(nodes, _)| nodes.len() as i32).collect();
        tree.numbers(one, "nnodes", &counts);
        let list: Vec<u32> = all.iter().flat_map(|(nodes, _)| nodes.clone()).collect();
        tree.numbers(one, "nodes", &list);
        for (side, name) in ["c0", "c1"].into_iter().enumerate() {
            let group = tree.group(faces, name);
            // In two sections, as Fluent has them for parts of the faces.
            let half = all.len() / 2;
            for (part, name) in [(0..half, "1"), (half..all.len(), "2")] {
                let list: Vec<u32> = all[part.clone()]
                    .iter()
                    .map(|(_, cells)| cells[side])
                    .collect();
                let dataset = {
                    let bytes: Vec<u8> = list.iter().flat_map(|n| n.to_le_bytes()).collect();
                    let n = list.len() as u64;
                    tree.dataset(
                        group,
                        name,
                        Element::UInt32,
                        &[n],
                        Data::Bytes(bytes.into()),
                    )
                };
                ids(tree, dataset, part.start + 1, part.end);
            }
        }
    }

    fn n_cells(&self) -> u32 {
        self.cells.iter().map(|zone| zone[2]).max().unwrap_or(0)
    }

    fn n_faces(&self) -> usize {
        self.faces.iter().map(|zone| zone.faces.len()).sum()
    }
}

impl Zone {
    /// Nodes of all faces; 0 where they differ.
    fn size(&self) -> usize {
        let first = self.faces[0].0.len();
        let is_one = self.faces.iter().all(|(nodes, _)| nodes.len() == first);
        if is_one { first } else { 0 }
    }
}

fn ids(tree: &mut Tree, of: crate::formats::hdf5::Id, first: usize, last: usize) {
    tree.number_attribute(of, "minId", &[first as u64], false);
    tree.number_attribute(of, "maxId", &[last as u64], false);
}

fn ordered(bytes: &[u8], stored: Stored) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if stored.is_big_endian {
        bytes.reverse();
    }
    bytes
}
