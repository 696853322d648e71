//! A small mesh for tests, written in every way that OpenFOAM's files have: two hexahedra side by side and a pyramid on
//! the second.

use flate2::{Compression, write::GzEncoder};
use std::fs;
use std::io::Write;
use std::path::Path;

/// Names, types and faces of the patches.
pub(super) const PATCHES: [(&str, &str, std::ops::Range<usize>); 4] = [
    ("left", "wall", 2..3),
    ("bottom", "symmetryPlane", 3..5),
    ("none", "cyclic", 5..5),
    ("far", "patch", 5..15),
];

/// Encoding of files.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub is_binary: bool,
    pub label: usize,
    pub scalar: usize,
    pub is_big_endian: bool,
    pub is_compact: bool,
    pub arch: Option<&'static str>,
    pub is_packed: bool,
}

/// As text.
pub(super) const ASCII: Way = Way {
    is_binary: false,
    label: 4,
    scalar: 8,
    is_big_endian: false,
    is_compact: false,
    arch: None,
    is_packed: false,
};

/// As OpenFOAM writes binary files by default.
pub(super) const BINARY: Way = Way {
    is_binary: true,
    is_compact: true,
    arch: Some("LSB;label=32;scalar=64"),
    ..ASCII
};

/// The lists of a mesh.
#[derive(Clone)]
pub(super) struct Small {
    pub points: Vec<[f64; 3]>,
    pub faces: Vec<Vec<i64>>,
    pub owner: Vec<i64>,
    pub neighbour: Vec<i64>,
    /// Name, further entries, start and number of faces.
    pub patches: Vec<(String, String, usize, usize)>,
    /// The cells of the zone `top`.
    pub zone: Vec<i64>,
}

/// The mesh.
pub(super) fn small() -> Small {
    let mut points = Vec::new();
    for k in 0..2 {
        for j in 0..2 {
            points.extend((0..3).map(|i| [f64::from(i), f64::from(j), f64::from(k)]));
        }
    }
    points.push([1.5, 0.5, 2.0]);
    let faces: [(&[i64], i64); 15] = [
        (&[1, 4, 10, 7], 0),
        (&[7, 8, 11, 10], 1),
        (&[0, 6, 9, 3], 0),
        (&[0, 3, 4, 1], 0),
        (&[1, 4, 5, 2], 1),
        (&[0, 1, 7, 6], 0),
        (&[3, 9, 10, 4], 0),
        (&[6, 7, 10, 9], 0),
        (&[1, 2, 8, 7], 1),
        (&[4, 10, 11, 5], 1),
        (&[2, 5, 11, 8], 1),
        (&[7, 8, 12], 2),
        (&[8, 11, 12], 2),
        (&[11, 10, 12], 2),
        (&[10, 7, 12], 2),
    ];
    let patches = PATCHES.map(|(name, kind, faces)| {
        (
            name.to_owned(),
            format!("type {kind};"),
            faces.start,
            faces.len(),
        )
    });
    Small {
        points,
        owner: faces.iter().map(|(_, owner)| *owner).collect(),
        faces: faces.iter().map(|(nodes, _)| nodes.to_vec()).collect(),
        neighbour: vec![1, 2],
        patches: patches.to_vec(),
        zone: vec![1, 2],
    }
}

impl Way {
    pub fn label(&self, value: i64) -> Vec<u8> {
        let mut bytes = value.to_le_bytes()[..self.label].to_vec();
        if self.is_big_endian {
            bytes.reverse();
        }
        bytes
    }

    fn scalar(&self, value: f64) -> Vec<u8> {
        let mut bytes = match self.scalar {
            4 => (value as f32).to_le_bytes().to_vec(),
            _ => value.to_le_bytes().to_vec(),
        };
        if self.is_big_endian {
            bytes.reverse();
        }
        bytes
    }

    /// The header of a file.
    pub fn header(&self, class: &str) -> String {
        let format = if self.is_binary { "binary" } else { "ascii" };
        let arch = self
            .arch
            .map_or(String::new(), |arch| format!("arch \"{arch}\";"));
        format!(
            "/* banner */\nFoamFile\n{{\n version 2.0;\n format {format};\n class {class}; {arch}\n object x;\n}}\n// * * //\n"
        )
    }

    pub fn labels(&self, values: &[i64]) -> Vec<u8> {
        if !self.is_binary {
            let words: Vec<String> = values.iter().map(i64::to_string).collect();
            return format!("{}\n(\n{}\n)\n", values.len(), words.join("\n")).into_bytes();
        }
        // An empty binary list has no brackets.
        if values.is_empty() {
            return b"0\n\n".to_vec();
        }
        let bytes: Vec<u8> = values.iter().flat_map(|value| self.label(*value)).collect();
        [format!("{}\n(", values.len()).as_bytes(), &bytes, b")\n"].concat()
    }

    fn points(&self, points: &[[f64; 3]]) -> Vec<u8> {
        let mut file = format!("{}\n(", points.len()).into_bytes();
        for point in points {
            if self.is_binary {
                file.extend(point.iter().flat_map(|x| self.scalar(*x)))
            } else {
                file.extend(format!("\n({:?} {:?} {:?})", point[0], point[1], point[2]).bytes())
            }
        }
        file.extend(b")\n");
        file
    }

    fn faces(&self, faces: &[Vec<i64>]) -> Vec<u8> {
        if self.is_compact {
            let mut starts = vec![0];
            for face in faces {
                starts.push(starts[starts.len() - 1] + face.len() as i64);
            }
            return [self.labels(&starts), self.labels(&faces.concat())].concat();
        }
        let mut file = format!("{}\n(\n", faces.len()).into_bytes();
        for face in faces {
            file.extend(if self.is_binary {
                self.labels(face)
            } else {
                self.labels(face)
                    .iter()
                    .map(|byte| if *byte == b'\n' { b' ' } else { *byte })
                    .collect()
            });
        }
        file.extend(b")\n");
        file
    }

    /// Content of each file of a mesh, by its name.
    pub fn files(&self, mesh: &Small) -> Vec<(&'static str, Vec<u8>)> {
        let class = if self.is_compact {
            "faceCompactList"
        } else {
            "faceList"
        };
        let with = |class: &str, body: Vec<u8>| {
            [
                self.header(class).into_bytes(),
                body,
                b"\n// **** //\n".to_vec(),
            ]
            .concat()
        };
        let patches = mesh.patches.iter().map(|(name, entries, start, n)| {
            format!("{name}\n{{\n {entries}\n nFaces {n};\n startFace {start};\n}}\n")
        });
        let patches = format!(
            "{}\n(\n{})\n",
            mesh.patches.len(),
            patches.collect::<String>()
        );
        let zone = [
            &b"1\n(\ntop\n{\n type cellZone;\ncellLabels List<label> "[..],
            &self.labels(&mesh.zone),
            b";\n}\n)\n",
        ];
        vec![
            ("points", with("vectorField", self.points(&mesh.points))),
            ("faces", with(class, self.faces(&mesh.faces))),
            ("owner", with("labelList", self.labels(&mesh.owner))),
            ("neighbour", with("labelList", self.labels(&mesh.neighbour))),
            ("boundary", with("polyBoundaryMesh", patches.into_bytes())),
            ("cellZones", with("regIOobject", zone.concat())),
        ]
    }

    /// Writes files to a folder.
    pub fn write(&self, folder: &Path, files: &[(&str, Vec<u8>)]) {
        fs::create_dir_all(folder).expect("a folder");
        for (name, bytes) in files {
            if self.is_packed {
                let file = fs::File::create(folder.join(format!("{name}.gz"))).expect("a file");
                let mut file = GzEncoder::new(file, Compression::fast());
                file.write_all(bytes).expect("it is written");
                file.finish().expect("it is written");
            } else {
                fs::write(folder.join(name), bytes).expect("a file")
            }
        }
    }
}

impl Small {
    /// Writes the mesh as the only one of a case.
    pub fn write(&self, case: &Path, way: Way) {
        way.write(&case.join("constant/polyMesh"), &way.files(self));
    }

    /// The piece of some cells, with its numbers in the whole: points, faces (from 1 on) and cells.
    pub fn piece(&self, cells: &[i64], number: usize, other: usize) -> (Self, [Vec<i64>; 3]) {
        let has = |cell: i64| cells.contains(&cell);
        let local = |cell: i64| cells.iter().position(|own| *own == cell).expect("own") as i64;
        let n_internal = self.neighbour.len();
        let inner = |face: &usize| {
            *face < n_internal && has(self.owner[*face]) && has(self.neighbour[*face])
        };
        let shared = |face: &usize| {
            *face < n_internal && has(self.owner[*face]) != has(self.neighbour[*face])
        };
        let mut order: Vec<usize> = (0..self.owner.len()).filter(inner).collect();
        let neighbour = order
            .iter()
            .map(|face| local(self.neighbour[*face]))
            .collect();
        let mut patches = Vec::new();
        for (name, entries, start, n) in &self.patches {
            let first = order.len();
            order.extend((*start..start + n).filter(|face| has(self.owner[*face])));
            patches.push((name.clone(), entries.clone(), first, order.len() - first));
        }
        let first = order.len();
        order.extend((0..n_internal).filter(shared));
        let entries = format!("type processor; myProcNo {number}; neighbProcNo {other};");
        let name = format!("procBoundary{number}to{other}");
        patches.push((name, entries, first, order.len() - first));
        let is_turned = |face: usize| !has(self.owner[face]);
        let mut points: Vec<i64> = order
            .iter()
            .flat_map(|face| self.faces[*face].clone())
            .collect();
        points.sort_unstable();
        points.dedup();
        let node = |node: &i64| points.binary_search(node).expect("a node") as i64;
        let faces = order.iter().map(|face| {
            let mut nodes: Vec<i64> = self.faces[*face].iter().map(node).collect();
            if is_turned(*face) {
                nodes[1..].reverse();
            }
            nodes
        });
        let owner = order.iter().map(|face| {
            if is_turned(*face) {
                local(self.neighbour[*face])
            } else {
                local(self.owner[*face])
            }
        });
        let piece = Self {
            points: points
                .iter()
                .map(|point| self.points[*point as usize])
                .collect(),
            faces: faces.collect(),
            owner: owner.collect(),
            neighbour,
            patches,
            zone: self
                .zone
                .iter()
                .filter(|cell| has(**cell))
                .map(|cell| local(*cell))
                .collect(),
        };
        let numbers = order
            .iter()
            .map(|face| (*face as i64 + 1) * if is_turned(*face) { -1 } else { 1 });
        let numbers = numbers.collect();
        (piece, [points, numbers, cells.to_vec()])
    }
}
