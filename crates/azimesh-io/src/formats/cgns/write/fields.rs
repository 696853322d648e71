//! Arrays of the mesh as a whole, as user-defined data of the base: numbers as they are, strings one
//! after another with a zero after each.

use super::super::{FIELD_ARRAYS, FULL_NAME};
use super::arrays::fits;
use super::draft::{DataType, Draft, NodeIndex};
use super::names::{Names, RULE};
use crate::formats::Notes;
use crate::formats::column::Data;
use crate::mesh::{DataArray, Values};
use azimesh_core::diagnostic::formats::ArrayWritten;

/// An array as it is written.
pub(super) struct Field {
    /// Name in the file.
    pub name: String,
    /// Full name, where that is too long for CGNS.
    pub full_name: Option<String>,
    pub kind: DataType,
    /// Sizes, the fastest index first.
    pub sizes: Vec<u64>,
    pub data: Data<'static>,
}

/// Adds the arrays to the base.
pub(super) fn add(draft: &mut Draft, base: NodeIndex, arrays: &[&DataArray], notes: &mut Notes) {
    let fields = fields(arrays, notes);
    if fields.is_empty() {
        return;
    }
    let parent = draft.group(base, FIELD_ARRAYS, "UserDefinedData_t");
    for field in fields {
        let name = (field.name.as_str(), "DataArray_t");
        let node = draft.data(parent, name, field.kind, &field.sizes, field.data);
        if let Some(full_name) = &field.full_name {
            draft.text(node, FULL_NAME, "Descriptor_t", full_name);
        }
    }
}

/// The arrays that CGNS can hold; a note for each other.
pub(super) fn fields(arrays: &[&DataArray], notes: &mut Notes) -> Vec<Field> {
    let mut fields = Vec::new();
    for array in arrays {
        if array.n_components == 0 || array.n_tuples() == 0 {
            let name = array.name.clone();
            notes.push(ArrayWritten::WithoutValues { name });
            continue;
        }
        if !fits(&array.values) {
            let name = array.name.clone();
            notes.push(ArrayWritten::IntegersTooLarge { name });
            continue;
        }
        let (kind, data) = data_of(&array.values);
        fields.push(Field {
            full_name: None,
            name: array.name.clone(),
            sizes: match (kind, &data) {
                (DataType::C1, Data::Bytes(bytes)) => vec![bytes.len() as u64],
                _ => vec![array.n_components as u64, array.n_tuples() as u64],
            },
            kind,
            data,
        });
    }
    let names: Vec<&str> = fields.iter().map(|field| field.name.as_str()).collect();
    let names = Names::default().give_all(&names);
    for (field, name) in fields.iter_mut().zip(names) {
        let full_name = std::mem::replace(&mut field.name, name);
        notes.extend(RULE.note("array", &full_name, &field.name));
        field.full_name = (field.name != full_name).then_some(full_name);
    }
    fields
}

fn data_of(values: &Values) -> (DataType, Data<'static>) {
    let kind = match values {
        Values::F64(v) => return (DataType::R8, Data::owned(v)),
        Values::F32(v) => return (DataType::R4, Data::owned(v)),
        Values::Text(lines) => {
            let ended = lines.iter().flat_map(|line| [line.as_bytes(), b"\0"]);
            let bytes: Vec<u8> = ended.flatten().copied().collect();
            return (DataType::C1, Data::Bytes(bytes.into()));
        }
        Values::U32(_) | Values::I64(_) | Values::U64(_) => DataType::I8,
        _ => DataType::I4,
    };
    let numbers = values.to_integers().expect("they fit");
    (kind, kind.data_of(&numbers))
}
