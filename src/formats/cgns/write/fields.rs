//! Arrays of the mesh as a whole, as user-defined data of the base: numbers as they are, strings one
//! after another with a zero after each.

use super::super::{FIELD_ARRAYS, FULL_NAME};
use super::arrays::{fits, too_large};
use super::draft::{Draft, Kind, Place};
use super::names::Names;
use crate::mesh::{DataArray, Values};

/// Adds the arrays to the base.
pub(super) fn add(draft: &mut Draft, base: Place, arrays: &[DataArray], notes: &mut Vec<String>) {
    let is_written = |array: &&DataArray| {
        let name = &array.name;
        if array.n_components == 0 || array.n_tuples() == 0 {
            notes.push(format!(
                "field array \"{name}\" is not written: it has no values"
            ));
        } else if !fits(&array.values) {
            notes.push(too_large(name));
        } else {
            return true;
        }
        false
    };
    let written: Vec<&DataArray> = arrays.iter().filter(is_written).collect();
    if written.is_empty() {
        return;
    }
    let parent = draft.group(base, FIELD_ARRAYS, "UserDefinedData_t");
    let mut names = Names::default();
    for array in written {
        let name = names.give(&array.name);
        let (kind, bytes) = bytes_of(&array.values);
        let sizes = match kind {
            Kind::C1 => vec![bytes.len() as u64],
            _ => vec![array.n_components as u64, array.n_tuples() as u64],
        };
        let node = draft.bytes(parent, (&name, "DataArray_t"), kind, &sizes, bytes);
        if name != array.name {
            draft.text(node, FULL_NAME, "Descriptor_t", &array.name);
        }
    }
}

fn bytes_of(values: &Values) -> (Kind, Vec<u8>) {
    match values {
        Values::F64(v) => (Kind::R8, bytemuck::cast_slice(v).to_vec()),
        Values::F32(v) => (Kind::R4, bytemuck::cast_slice(v).to_vec()),
        Values::Text(lines) => {
            let ended = lines.iter().flat_map(|line| [line.as_bytes(), b"\0"]);
            (Kind::C1, ended.flatten().copied().collect())
        }
        Values::U32(_) | Values::I64(_) | Values::U64(_) => integers(Kind::I8, values),
        _ => integers(Kind::I4, values),
    }
}

fn integers(kind: Kind, values: &Values) -> (Kind, Vec<u8>) {
    let numbers = values.to_integers().expect("they fit");
    (kind, kind.bytes_of(&numbers))
}
