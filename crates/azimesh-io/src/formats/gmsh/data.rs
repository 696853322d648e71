//! `$NodeData` and `$ElementData`: values at nodes and elements, as arrays of the mesh.

use super::super::lexer::{Fields, Lines, shown};
use super::super::names::{Places, text_of};
use super::super::{Notes, ReadOptions};
use super::index::Index;
use super::stream::{Binary, Stream};
use crate::mesh::{DataArray, Mesh, Values};
use azimesh_core::diagnostic::formats::ArrayRead;
use azimesh_core::error::{Error, Result};

/// More components than any field has.
pub(super) const MOST_COMPONENTS: usize = 100;

/// The items that values belong to.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum DataOwner {
    Nodes,
    Elements,
}

impl DataOwner {
    /// The kind of the section with this name.
    pub fn of(section: &[u8]) -> Option<Self> {
        match section {
            b"NodeData" => Some(Self::Nodes),
            b"ElementData" => Some(Self::Elements),
            _ => None,
        }
    }

    fn items(self) -> &'static str {
        match self {
            Self::Nodes => "nodes",
            Self::Elements => "elements",
        }
    }
}

/// A section of data.
#[derive(Debug)]
pub(super) struct Data<'a> {
    kind: DataOwner,
    name: String,
    time: f64,
    n_components: usize,
    rows: Rows<'a>,
}

/// A tag and values each.
#[derive(Debug)]
enum Rows<'a> {
    Text(Lines<'a>),
    Binary(Binary, &'a [u8]),
}

impl<'a> Data<'a> {
    /// Reads a section: a name, a time, three integers or more (step, components, number of values),
    /// each list after its length, then the values. All but the values is text in binary files too.
    pub fn read(stream: &mut Stream<'a>, kind: DataOwner, notes: &mut Notes) -> Result<Self> {
        let mut name = String::new();
        for i in 0..length(stream, "the number of string tags")? {
            let line = stream.text.line();
            let line = line.ok_or_else(|| stream.error("the file ends within string tags"))?;
            if i == 0 {
                let text = line.rest();
                let bare = text.strip_prefix(b"\"").and_then(|t| t.strip_suffix(b"\""));
                name = text_of(bare.unwrap_or(text), notes);
            }
        }
        let mut time = 0.0;
        for i in 0..length(stream, "the number of real tags")? {
            let value = stream.word("a real tag")?.real("a real tag")?;
            time = if i == 0 { value } else { time };
        }
        let mut integers = [0, 1, 0];
        let n_integers = length(stream, "the number of integer tags")?;
        for i in 0..n_integers {
            let value = stream.word("an integer tag")?.integer("an integer tag")?;
            if let Some(known) = integers.get_mut(i) {
                *known = value;
            }
        }
        let [_, n_components, n_rows] = integers.map(|value| usize::try_from(value).ok());
        let n_components = n_components.filter(|n| (1..=MOST_COMPONENTS).contains(n));
        let (Some(n_components), Some(n_rows), 3..) = (n_components, n_rows, n_integers) else {
            return Err(stream.error(format!(
                "data \"{name}\" have the integer tags {integers:?}; they must have a time step, a number of components from 1 to {MOST_COMPONENTS}, and a number of values"
            )));
        };
        let rows = match stream.binary {
            Some(binary) => {
                stream.pass_line_end();
                Rows::Binary(
                    binary,
                    stream.take(n_rows, 4 + 8 * n_components, "the values")?,
                )
            }
            None => Rows::Text(stream.lines(n_rows, "the values")?),
        };
        Ok(Self {
            kind,
            name,
            time,
            n_components,
            rows,
        })
    }

    /// Puts the values where they belong; returns how many belong to nothing in the mesh.
    fn fill(&self, index: &Index, values: &mut [f64]) -> Result<usize> {
        let n = self.n_components;
        let mut n_lost = 0;
        self.for_each_row(|tag, row| match index.get(tag) {
            Some(i) => {
                let place = &mut values[i as usize * n..][..n];
                place
                    .iter_mut()
                    .zip(row)
                    .for_each(|(to, value)| *to = value);
            }
            None => n_lost += 1,
        })?;
        Ok(n_lost)
    }

    /// Whether it has another value at some place than the array has already.
    fn contradicts(&self, index: &Index, values: &[f64]) -> Result<bool> {
        let n = self.n_components;
        let mut is_other = false;
        self.for_each_row(|tag, row| {
            if let Some(i) = index.get(tag) {
                let place = &values[i as usize * n..][..n];
                let is_set = place.iter().any(|value| !value.is_nan());
                let mut both = place.iter().zip(row);
                is_other |= is_set && both.any(|(a, b)| a.to_bits() != b.to_bits());
            }
        })?;
        Ok(is_other)
    }

    /// Hands the tag and the values of each row to `put`.
    fn for_each_row(&self, mut put: impl FnMut(i64, &mut dyn Iterator<Item = f64>)) -> Result<()> {
        let n = self.n_components;
        match &self.rows {
            Rows::Binary(binary, bytes) => {
                for row in bytes.chunks_exact(4 + 8 * n) {
                    let mut reals = row[4..].chunks_exact(8).map(|bytes| binary.real(bytes));
                    put(binary.int(&row[..4]).into(), &mut reals);
                }
            }
            Rows::Text(lines) => {
                let parts = lines.parse(|line, (tags, values): &mut (Vec<i64>, Vec<f64>)| {
                    tags.push(line.integer("a tag of a value")?);
                    for _ in 0..n {
                        values.push(value(line)?);
                    }
                    line.end("a value")
                })?;
                for (tags, values) in parts {
                    for (tag, row) in tags.iter().zip(values.chunks_exact(n)) {
                        put(*tag, &mut row.iter().copied());
                    }
                }
            }
        }
        Ok(())
    }
}

/// The length of a list of tags.
fn length(stream: &mut Stream, what: &str) -> Result<usize> {
    stream.word(what)?.narrow(what)
}

/// A value, which may be infinite or no number, unlike a coordinate.
fn value(line: &mut Fields) -> Result<f64> {
    let word = line.word().unwrap_or_default();
    fast_float2::parse(word).map_err(|_| {
        let found = shown(word);
        line.error(format!("expected a number as a value, found {found}"))
    })
}

/// The times that some array is given for more than once, ascending; empty where there is no such
/// array.
pub(super) fn times(data: &[Data]) -> Vec<f64> {
    let several = |one: &Vec<&Data>| one.iter().any(|data| data.time != one[0].time);
    let changing = by_array(data).into_iter().filter(several).flatten();
    let mut times: Vec<f64> = changing.map(|data| data.time).collect();
    times.sort_by(f64::total_cmp);
    times.dedup();
    times
}

/// The sections of each array, in the order in which the file has the first.
fn by_array<'d, 'a>(data: &'d [Data<'a>]) -> Vec<Vec<&'d Data<'a>>> {
    let mut places = Places::default();
    let mut arrays = Vec::new();
    for one in data {
        let key = (one.kind, &*one.name);
        places.entry(key, &mut arrays, Vec::new).push(one);
    }
    arrays
}

/// Adds the arrays of the step in `options`, by default the last.
pub(super) fn add(
    data: &[Data],
    nodes: &Index,
    elements: Option<&[i64]>,
    mesh: &mut Mesh,
    options: &ReadOptions,
    notes: &mut Notes,
) -> Result<()> {
    let times = times(data);
    let until = last_time(&times, options.step)?;
    let elements = match elements {
        None => Ok(Index::Consecutive {
            first: 1,
            n: mesh.cells.len() as u64,
        }),
        Some(numbers) => Index::new(numbers, "element"),
    };
    for all in by_array(data) {
        let one = all[0];
        let time = all
            .iter()
            .map(|data| data.time)
            .filter(|time| *time <= until || times.is_empty());
        let Some(time) = time.max_by(f64::total_cmp) else {
            continue;
        };
        let now: Vec<&Data> = all.into_iter().filter(|data| data.time == time).collect();
        let (index, n) = match (one.kind, &elements) {
            (DataOwner::Nodes, _) => (nodes, mesh.points.len()),
            (DataOwner::Elements, Ok(index)) => (index, mesh.cells.len()),
            (DataOwner::Elements, Err(error)) => {
                notes.push(ArrayRead::WithoutElements {
                    name: one.name.clone(),
                    error: error.to_string(),
                });
                continue;
            }
        };
        let arrays = arrays(&now, index, n, notes)?;
        match one.kind {
            DataOwner::Nodes => mesh.point_arrays.extend(arrays),
            DataOwner::Elements => mesh.cell_arrays.extend(arrays),
        }
    }
    Ok(())
}

/// The time up to which data are read: that of the step, or no limit.
fn last_time(times: &[f64], step: Option<usize>) -> Result<f64> {
    let Some(step) = step.filter(|_| !times.is_empty()) else {
        return Ok(f64::INFINITY);
    };
    times.get(step).copied().ok_or_else(|| {
        let last = times.len() - 1;
        Error::input(format!(
            "there is no step {step}: the data have steps 0 to {last}"
        ))
    })
}

/// The array of the sections of one name and time; the parts of a partitioned mesh each have one. Those
/// that contradict one another are several arrays.
fn arrays(data: &[&Data], index: &Index, n: usize, notes: &mut Notes) -> Result<Vec<DataArray>> {
    let first = data[0];
    let (name, what) = (&first.name, first.kind.items());
    if data
        .iter()
        .any(|data| data.n_components != first.n_components)
    {
        notes.push(ArrayRead::ComponentsDiffer {
            name: name.clone(),
            what,
        });
        return Ok(Vec::new());
    }
    let n_components = first.n_components;
    let mut arrays: Vec<Vec<f64>> = Vec::new();
    let mut n_lost = 0;
    for data in data {
        let mut fitting = None;
        for (at, values) in arrays.iter().enumerate() {
            if fitting.is_none() && !data.contradicts(index, values)? {
                fitting = Some(at);
            }
        }
        let at = fitting.unwrap_or_else(|| {
            arrays.push(vec![f64::NAN; n * n_components]);
            arrays.len() - 1
        });
        n_lost += data.fill(index, &mut arrays[at])?;
    }
    notes.count(n_lost, |n| ArrayRead::ValuesElsewhere {
        name: name.clone(),
        what,
        n,
    });
    let array = |values| DataArray::tuples(name.clone(), n_components, Values::F64(values));
    Ok(arrays.into_iter().map(array).collect())
}

/// Notes where data have no value at nodes or elements of the mesh.
pub(super) fn note_missing(mesh: &Mesh, notes: &mut Notes) {
    let of_nodes = mesh
        .point_arrays
        .iter()
        .map(|array| (array, DataOwner::Nodes));
    let of_elements = mesh
        .cell_arrays
        .iter()
        .map(|array| (array, DataOwner::Elements));
    for (array, kind) in of_nodes.chain(of_elements) {
        let Values::F64(values) = &array.values else {
            continue;
        };
        let rows = values.chunks_exact(array.n_components);
        let of = rows.len();
        let missing = rows.filter(|row| row.iter().all(|value| value.is_nan()));
        let missing = missing.count();
        notes.count(missing, |n| ArrayRead::ValuesMissing {
            name: array.name.clone(),
            what: kind.items(),
            n,
            of,
        });
    }
}
