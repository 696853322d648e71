//! `$NodeData` and `$ElementData`: values at nodes and elements, as arrays of the mesh.

use super::super::names::{Places, text_of};
use super::super::tokens::{Lines, Tokens, shown};
use super::super::{Notes, ReadOptions};
use super::index::Index;
use super::stream::{Binary, Stream};
use crate::mesh::{DataArray, Mesh, Values};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;

/// More components than any field has.
pub(super) const MOST_COMPONENTS: usize = 100;

#[derive(Debug)]
pub(super) struct Data<'a> {
    /// `false` for values of elements.
    at_nodes: bool,
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
    /// Reads a section, if it is one of data: a name, a time, three integers or more (step, components,
    /// number of values), each list after its length, then the values. Only the values are binary.
    pub fn read(
        section: &[u8],
        stream: &mut Stream<'a>,
        notes: &mut Notes,
    ) -> Result<Option<Self>> {
        let at_nodes = match section {
            b"NodeData" => true,
            b"ElementData" => false,
            _ => return Ok(None),
        };
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
                let bytes = stream.take(n_rows, 4 + 8 * n_components, "the values")?;
                Rows::Binary(binary, bytes)
            }
            None => Rows::Text(stream.text.take_lines(n_rows, "the values")?),
        };
        Ok(Some(Self {
            at_nodes,
            name,
            time,
            n_components,
            rows,
        }))
    }

    /// Puts the values where they belong; returns how many belong to nothing in the mesh.
    fn fill(&self, index: &Index, values: &mut [f64]) -> Result<usize> {
        let n = self.n_components;
        let mut n_lost = 0;
        self.for_each_row(|tag, row| match index.get(tag) {
            Some(i) => {
                let place = values[i as usize * n..][..n].iter_mut();
                place.zip(row).for_each(|(to, value)| *to = value);
            }
            None => n_lost += 1,
        })?;
        Ok(n_lost)
    }

    /// Checks if a value differs from one that the array has already.
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

    /// Passes the tag and the values of each row to `put`.
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
fn value(line: &mut Tokens) -> Result<f64> {
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
        let key = (one.at_nodes, &*one.name);
        places.entry(key, &mut arrays, Vec::new).push(one);
    }
    arrays
}

/// Adds the arrays of the step in `options`, by default the last. Elements without tags count from 1.
pub(super) fn add(
    data: &[Data],
    (nodes, elements): (&Index, Option<&[i64]>),
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
    for mut all in by_array(data) {
        all.retain(|data| data.time <= until || times.is_empty());
        let Some(time) = all.iter().map(|data| data.time).max_by(f64::total_cmp) else {
            continue;
        };
        all.retain(|data| data.time == time);
        let (index, n, added) = match &elements {
            _ if all[0].at_nodes => (nodes, mesh.points.len(), &mut mesh.point_arrays),
            Ok(index) => (index, mesh.cells.len(), &mut mesh.cell_arrays),
            Err(error) => {
                let name = &all[0].name;
                notes.push(note!(
                    "data_without_elements",
                    "data \"{name}\" of elements are not kept: {error}"
                ));
                continue;
            }
        };
        added.extend(arrays(&all, index, n, notes)?);
    }
    Ok(())
}

/// The time up to which data are read: the time of the step, or no limit.
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

/// The array of the sections of one name and time; the parts of a partitioned mesh each have one.
/// Sections that contradict one another are several arrays.
fn arrays(data: &[&Data], index: &Index, n: usize, notes: &mut Notes) -> Result<Vec<DataArray>> {
    let Data {
        name, n_components, ..
    } = data[0];
    let (n_components, what) = (*n_components, items(data[0].at_nodes));
    if data.iter().any(|data| data.n_components != n_components) {
        notes.push(note!(
            "components_differ",
            "data \"{name}\" of {what} have different numbers of components and are not kept"
        ));
        return Ok(Vec::new());
    }
    let mut arrays: Vec<Vec<f64>> = Vec::new();
    let mut n_lost = 0;
    for data in data {
        let mut at = 0;
        while at < arrays.len() && data.contradicts(index, &arrays[at])? {
            at += 1;
        }
        if at == arrays.len() {
            arrays.push(vec![f64::NAN; n * n_components]);
        }
        n_lost += data.fill(index, &mut arrays[at])?;
    }
    notes.count(n_lost, |n| {
        let n = counted(n, "value");
        note!(
            "values_elsewhere",
            "\"{name}\" has {n} for {what} that are not in the mesh"
        )
    });
    let array = |values| DataArray::tuples(name.clone(), n_components, Values::F64(values));
    Ok(arrays.into_iter().map(array).collect())
}

fn items(at_nodes: bool) -> &'static str {
    if at_nodes { "nodes" } else { "elements" }
}

/// Notes where data have no value at nodes or elements of the mesh.
pub(super) fn note_missing(mesh: &Mesh, notes: &mut Notes) {
    let of_nodes = mesh.point_arrays.iter().map(|array| (array, true));
    let of_elements = mesh.cell_arrays.iter().map(|array| (array, false));
    for (array, at_nodes) in of_nodes.chain(of_elements) {
        let Values::F64(values) = &array.values else {
            continue;
        };
        let rows = values.chunks_exact(array.n_components);
        let of = rows.len();
        let missing = rows.filter(|row| row.iter().all(|value| value.is_nan()));
        notes.count(missing.count(), |n| {
            let (name, what) = (&array.name, items(at_nodes));
            note!(
                "values_missing",
                "\"{name}\" has no value at {n} of {of} {what}, where it is NaN"
            )
        });
    }
}
