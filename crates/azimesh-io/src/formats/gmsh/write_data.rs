//! Writing arrays as `$NodeData` and `$ElementData`, and notes on arrays that MSH does not hold.

use super::super::names::Given;
use super::super::records::{push_integer, push_real, write_records};
use super::super::vtk::chunk::Chunk;
use super::super::{Notes, WriteOptions};
use super::content::MshContent;
use super::data::MOST_COMPONENTS;
use super::sink::{ARRAY, Sink};
use crate::mesh::{DataArray, MeshView, Values};
use azimesh_core::diagnostic::formats::ArrayWritten;
use azimesh_core::error::Result;

/// The format in a sentence.
const MSH: &str = "MSH";

/// Writes arrays of numbers as 64-bit reals; `number` gives the tag of a cell's element. Returns a
/// note for each thing that is not as it was.
pub(super) fn write(
    mesh: &MeshView,
    plan: &MshContent,
    number: impl Fn(usize) -> u64 + Sync,
    sink: &mut Sink,
) -> Result<Notes> {
    let [point, cell] = plan.data(mesh);
    let mut notes = Notes::default();
    for (array, name) in named(point) {
        let tag = |node: usize| plan.node_tag(node as u32);
        write_array("NodeData", (array, &name), tag, sink, &mut notes)?;
    }
    for (array, name) in named(cell) {
        write_array("ElementData", (array, &name), &number, sink, &mut notes)?;
    }
    Ok(notes)
}

/// Arrays with the names that they have in the file.
fn named(arrays: Vec<&DataArray>) -> impl Iterator<Item = (&DataArray, String)> {
    let names: Vec<&str> = arrays.iter().map(|array| array.name.as_str()).collect();
    let names = Given::default().give_all(&names, &ARRAY);
    arrays.into_iter().zip(names)
}

fn write_array(
    section: &str,
    (array, name): (&DataArray, &str),
    tag: impl Fn(usize) -> u64 + Sync,
    sink: &mut Sink,
    notes: &mut Notes,
) -> Result<()> {
    let Some(values) = Chunk::of(&array.values) else {
        let name = array.name.clone();
        notes.push(ArrayWritten::TextLeftOut { format: MSH, name });
        return Ok(());
    };
    if array.n_components > MOST_COMPONENTS {
        notes.push(ArrayWritten::TooManyComponents {
            name: array.name.clone(),
            n: array.n_components,
            most: MOST_COMPONENTS,
        });
        return Ok(());
    }
    notes.extend(ARRAY.note("array", &array.name, name));
    if !all_are_exact(&array.values) {
        let name = array.name.clone();
        notes.push(ArrayWritten::IntegersRounded { name });
    }
    let n = array.n_components;
    let rows = match &array.values {
        Values::F32(values) => rows_of_numbers(values, n),
        Values::F64(values) => rows_of_numbers(values, n),
        _ => (0..array.n_tuples() as u32).collect(),
    };
    sink.line(&format!(
        "${section}\n1\n\"{name}\"\n1\n0.0\n3\n0\n{n}\n{}",
        rows.len()
    ))?;
    let text = sink.text;
    write_records(sink.out, rows.len(), &|range, buffer| {
        let mut own = vec![0.0; n];
        for &row in &rows[range] {
            let row = row as usize;
            values.part(row * n..(row + 1) * n).few_reals(&mut own);
            if text {
                push_integer(buffer, tag(row));
                for value in &own {
                    buffer.push(b' ');
                    push_real(buffer, *value);
                }
                buffer.push(b'\n');
            } else {
                buffer.extend_from_slice(&(tag(row) as i32).to_le_bytes());
                buffer.extend(own.iter().flat_map(|value| value.to_le_bytes()));
            }
        }
    })?;
    sink.end_binary()?;
    sink.line(&format!("$End{section}"))
}

/// Rows with a number in them: those that are NaN throughout have no value in the file.
#[allow(clippy::eq_op)] // only NaN differs from itself
fn rows_of_numbers<T: PartialEq>(values: &[T], n_components: usize) -> Vec<u32> {
    let rows = (0..).zip(values.chunks_exact(n_components));
    let numbers = rows.filter(|(_, row)| row.iter().any(|value| value == value));
    numbers.map(|(row, _)| row).collect()
}

fn all_are_exact(values: &Values) -> bool {
    const LARGEST: i64 = 1 << 53;
    match values {
        Values::I64(v) => v.iter().all(|x| (-LARGEST..=LARGEST).contains(x)),
        Values::U64(v) => v.iter().all(|x| *x <= LARGEST as u64),
        _ => true,
    }
}

/// A note for each array and option that MSH has no place for.
pub(super) fn note_left_out(mesh: &MeshView, options: &WriteOptions, notes: &mut Notes) {
    let (format, what) = (MSH, "field");
    let names = mesh.field_arrays.iter().map(|array| array.name.clone());
    notes.list(names.collect(), |names| ArrayWritten::LeftOut {
        format,
        what,
        names,
    });
    notes.conditions_left_out(format, mesh);
    notes.in_64_bits(format, options);
}
