//! Small Plot3D grids of 16 nodes, stored in every way.

/// How a grid is stored.
#[derive(Debug, Clone, Copy)]
pub struct Stored {
    /// Bytes of a coordinate, `None` for text.
    pub real: Option<usize>,
    pub is_big_endian: bool,
    pub has_records: bool,
    pub has_blanking: bool,
}

/// Text without blanking.
pub const TEXT: Stored = Stored {
    real: None,
    is_big_endian: false,
    has_records: false,
    has_blanking: false,
};

/// The neutral map of the two blocks in space.
pub const NEUTRAL: &str = "\
# === neutral map === \\
  2 \\
\\
  1  2 2 2
  2  2 2 2
# Type  B1 F1 S1 E1 S2 E2  B2 F2 S1 E1 S2 E2 Swap
'one-to-one'    1 4 1 2 1 2   2 3 1 2 1 2  false
'viscous_solid' 1 1 1 2 1 2
'viscous_solid' 2 1 1 2 1 2
'farfield'      1 2 1 2 1 2
farfield        2 2 1 2 1 2
'symmetry_y'    1 5 1 2 1 2
'symmetry_y'    2 5 1 2 1 2
'symmetry_y'    1 6 1 2 1 2
'symmetry_y'    2 6 1 2 1 2
'inflow'        1 3 1 2 1 2
'outflow'       2 4 1 2 1 2 \\
";

/// Every way in which a grid can be stored.
pub fn every_way() -> Vec<Stored> {
    let mut ways = Vec::new();
    for has_blanking in [false, true] {
        for is_big_endian in [false, true] {
            for has_records in [false, true] {
                for real in [4, 8] {
                    ways.push(Stored {
                        real: Some(real),
                        is_big_endian,
                        has_records,
                        has_blanking,
                    });
                }
            }
        }
        ways.push(Stored {
            real: None,
            is_big_endian: false,
            has_records: false,
            has_blanking,
        });
    }
    ways
}

/// Blocks, of 16 nodes together.
pub fn blocks(is_multi: bool, n_axes: usize) -> &'static [[usize; 3]] {
    match (is_multi, n_axes) {
        (true, 3) => &[[2, 2, 2], [2, 2, 2]],
        (true, _) => &[[2, 3, 1], [5, 2, 1]],
        (false, 3) => &[[4, 2, 2]],
        (false, _) => &[[4, 4, 1]],
    }
}

/// The node of a block; the second block lies beside the first along the first axis, and shares a side with it.
pub fn node(block: usize, [i, j, k]: [usize; 3], sizes: &[[usize; 3]]) -> [f64; 3] {
    let before: usize = sizes[..block].iter().map(|size| size[0] - 1).sum();
    [(before + i) as f64 + 0.25, j as f64, 0.5 * k as f64]
}

/// The nodes of all blocks in the order of the file.
pub fn nodes(sizes: &[[usize; 3]]) -> Vec<Vec<[f64; 3]>> {
    let of_block = |(block, size): (usize, &[usize; 3])| {
        let mut nodes = Vec::new();
        for k in 0..size[2] {
            for j in 0..size[1] {
                nodes.extend((0..size[0]).map(|i| node(block, [i, j, k], sizes)));
            }
        }
        nodes
    };
    sizes.iter().enumerate().map(of_block).collect()
}

/// The file of these blocks.
pub fn file(stored: Stored, is_multi: bool, n_axes: usize) -> Vec<u8> {
    let sizes = blocks(is_multi, n_axes);
    let mut file = Writer {
        stored,
        bytes: Vec::new(),
    };
    if is_multi {
        file.integers(&[sizes.len()]);
    }
    let counts: Vec<usize> = sizes
        .iter()
        .flat_map(|size| size[..n_axes].to_vec())
        .collect();
    file.integers(&counts);
    for nodes in nodes(sizes) {
        file.block(&nodes, n_axes);
    }
    file.bytes
}

struct Writer {
    stored: Stored,
    bytes: Vec<u8>,
}

impl Writer {
    fn integer(&self, n: usize) -> [u8; 4] {
        if self.stored.is_big_endian {
            (n as i32).to_be_bytes()
        } else {
            (n as i32).to_le_bytes()
        }
    }

    fn record(&mut self, content: &[u8]) {
        let mark = self.integer(content.len());
        let marks = if self.stored.has_records {
            &mark[..]
        } else {
            &[]
        };
        self.bytes.extend([marks, content, marks].concat());
    }

    fn integers(&mut self, numbers: &[usize]) {
        match self.stored.real {
            None => {
                let words: Vec<String> = numbers.iter().map(usize::to_string).collect();
                self.bytes.extend(format!(" {}\n", words.join(" ")).bytes());
            }
            Some(_) => {
                let content: Vec<u8> = numbers.iter().flat_map(|n| self.integer(*n)).collect();
                self.record(&content);
            }
        }
    }

    fn block(&mut self, nodes: &[[f64; 3]], n_axes: usize) {
        let reals = (0..n_axes).flat_map(|axis| nodes.iter().map(move |node| node[axis]));
        let flags = if self.stored.has_blanking {
            nodes.len()
        } else {
            0
        };
        let Some(real) = self.stored.real else {
            let words = reals.map(|x| format!("{x:.3}"));
            let words: Vec<String> = words
                .chain((0..flags).map(|i| i.min(1).to_string()))
                .collect();
            words.chunks(5).for_each(|line| {
                self.bytes
                    .extend(format!("  {}\n", line.join("  ")).bytes());
            });
            return;
        };
        let is_big_endian = self.stored.is_big_endian;
        let bytes = |x: f64| match (real, is_big_endian) {
            (4, true) => (x as f32).to_be_bytes().to_vec(),
            (4, false) => (x as f32).to_le_bytes().to_vec(),
            (_, true) => x.to_be_bytes().to_vec(),
            (_, false) => x.to_le_bytes().to_vec(),
        };
        let mut content: Vec<u8> = reals.flat_map(bytes).collect();
        content.extend((0..flags).flat_map(|i| self.integer(i.min(1))));
        self.record(&content);
    }
}
