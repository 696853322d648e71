//! Small netCDF files of the classic formats, written for tests of readers.

/// Values of a variable.
pub enum Numbers {
    Text(Vec<u8>),
    I32(Vec<i32>),
    I64(Vec<i64>),
    F32(Vec<f32>),
    F64(Vec<f64>),
}

/// A file: dimensions, then variables. A dimension of length 0 is that of the records.
pub struct NetCdf {
    /// 1, 2 or 5.
    version: u8,
    n_records: usize,
    dimensions: Vec<(String, usize)>,
    variables: Vec<Variable>,
}

struct Variable {
    name: String,
    dimensions: Vec<usize>,
    element_type: Option<String>,
    numbers: Numbers,
}

impl Numbers {
    fn number(&self) -> u32 {
        match self {
            Self::Text(_) => 2,
            Self::I32(_) => 4,
            Self::F32(_) => 5,
            Self::F64(_) => 6,
            Self::I64(_) => 10,
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Self::Text(text) => text.clone(),
            Self::I32(v) => v.iter().flat_map(|x| x.to_be_bytes()).collect(),
            Self::I64(v) => v.iter().flat_map(|x| x.to_be_bytes()).collect(),
            Self::F32(v) => v.iter().flat_map(|x| x.to_be_bytes()).collect(),
            Self::F64(v) => v.iter().flat_map(|x| x.to_be_bytes()).collect(),
        }
    }
}

/// Names, each filled up to `length`.
pub fn text(length: usize, lines: &[&str]) -> Numbers {
    let mut text = Vec::new();
    for (i, line) in lines.iter().enumerate() {
        text.resize(i * length, 0);
        text.extend(line.bytes());
    }
    text.resize(lines.len() * length, 0);
    Numbers::Text(text)
}

impl NetCdf {
    pub fn new(version: u8, n_records: usize, dimensions: &[(&str, usize)]) -> Self {
        let dimensions = dimensions.iter().map(|(name, n)| ((*name).to_owned(), *n));
        Self {
            version,
            n_records,
            dimensions: dimensions.collect(),
            variables: Vec::new(),
        }
    }

    /// Which of the classic formats it is.
    pub fn version(&self) -> u8 {
        self.version
    }

    /// Another length of a dimension.
    pub fn resize(&mut self, dimension: &str, n: usize) {
        let found = self
            .dimensions
            .iter_mut()
            .find(|(name, _)| name == dimension);
        found.expect(dimension).1 = n;
    }

    /// Other values of a variable.
    pub fn replace(&mut self, name: &str, numbers: Numbers) {
        let found = self
            .variables
            .iter_mut()
            .find(|variable| variable.name == name);
        found.expect(name).numbers = numbers;
    }

    /// Takes a variable away.
    pub fn remove(&mut self, name: &str) {
        self.variables.retain(|variable| variable.name != name);
    }

    /// Adds a variable; its values are those of all records.
    pub fn add(&mut self, name: &str, dimensions: &[&str], numbers: Numbers) {
        let find = |wanted: &&str| self.dimensions.iter().position(|(name, _)| name == wanted);
        let dimensions = dimensions.iter().map(|name| find(name).expect(name));
        self.variables.push(Variable {
            name: name.to_owned(),
            dimensions: dimensions.collect(),
            element_type: None,
            numbers,
        });
    }

    /// Adds a variable of nodes with the type of its elements.
    pub fn connect(&mut self, name: &str, dimensions: &[&str], of: &str, numbers: Numbers) {
        self.add(name, dimensions, numbers);
        self.variables.last_mut().unwrap().element_type = Some(of.to_owned());
    }

    /// The file.
    pub fn bytes(&self) -> Vec<u8> {
        let length = self.header(&vec![0; self.variables.len()]).len();
        let (starts, body) = self.body(length);
        [self.header(&starts), body].concat()
    }

    fn is_of_records(&self, variable: &Variable) -> bool {
        let first = variable.dimensions.first();
        first.is_some_and(|first| self.dimensions[*first].1 == 0)
    }

    /// Where each variable starts, and the values.
    fn body(&self, first: usize) -> (Vec<usize>, Vec<u8>) {
        let mut starts = vec![0; self.variables.len()];
        let mut body = Vec::new();
        let (of_records, fixed): (Vec<usize>, Vec<usize>) =
            (0..starts.len()).partition(|i| self.is_of_records(&self.variables[*i]));
        for i in fixed {
            starts[i] = first + body.len();
            body.extend(self.variables[i].numbers.bytes());
            pad(&mut body);
        }
        for record in 0..self.n_records {
            for &i in &of_records {
                if record == 0 {
                    starts[i] = first + body.len();
                }
                let bytes = self.variables[i].numbers.bytes();
                let row = bytes.len() / self.n_records;
                body.extend(&bytes[record * row..(record + 1) * row]);
                if of_records.len() > 1 {
                    pad(&mut body);
                }
            }
        }
        (starts, body)
    }

    fn header(&self, starts: &[usize]) -> Vec<u8> {
        let mut out = b"CDF".to_vec();
        out.push(self.version);
        self.count(&mut out, self.n_records);
        self.list(&mut out, 10, self.dimensions.len());
        for (name, n) in &self.dimensions {
            self.name(&mut out, name);
            self.count(&mut out, *n);
        }
        self.list(&mut out, 0, 0);
        self.list(&mut out, 11, self.variables.len());
        for (variable, start) in self.variables.iter().zip(starts) {
            self.name(&mut out, &variable.name);
            self.count(&mut out, variable.dimensions.len());
            for dimension in &variable.dimensions {
                self.count(&mut out, *dimension);
            }
            match &variable.element_type {
                Some(text) => {
                    self.list(&mut out, 12, 1);
                    self.name(&mut out, "elem_type");
                    out.extend(2_u32.to_be_bytes());
                    self.name(&mut out, text);
                }
                None => self.list(&mut out, 0, 0),
            }
            out.extend(variable.numbers.number().to_be_bytes());
            self.count(&mut out, 0);
            match self.version {
                1 => out.extend((*start as u32).to_be_bytes()),
                _ => out.extend((*start as u64).to_be_bytes()),
            }
        }
        out
    }

    fn count(&self, out: &mut Vec<u8>, n: usize) {
        match self.version {
            5 => out.extend((n as u64).to_be_bytes()),
            _ => out.extend((n as u32).to_be_bytes()),
        }
    }

    fn list(&self, out: &mut Vec<u8>, tag: u32, n: usize) {
        out.extend(tag.to_be_bytes());
        self.count(out, n);
    }

    fn name(&self, out: &mut Vec<u8>, name: &str) {
        self.count(out, name.len());
        out.extend(name.bytes());
        pad(out);
    }
}

fn pad(bytes: &mut Vec<u8>) {
    bytes.resize(bytes.len().next_multiple_of(4), 0);
}
