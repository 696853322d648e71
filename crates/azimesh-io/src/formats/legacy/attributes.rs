//! Arrays of nodes, cells and the whole in a legacy file, in each of the ways it has for them.

use super::super::tokens::shown;
use super::super::vtk::number::Element;
use super::cursor::{Cursor, decoded};
use super::values::{self, Type};
use crate::formats::Notes;
use crate::mesh::{DataArray, Values};
use azimesh_core::error::{Error, Result, counted};
use azimesh_core::note;

/// Arrays of one kind.
pub(super) struct Section<'m> {
    /// "point", "cell" or "field".
    pub what: &'static str,
    /// Tuples that each array must have; any number in field data.
    pub n_tuples: Option<usize>,
    /// The arrays that were found.
    pub arrays: &'m mut Vec<DataArray>,
}

impl Section<'_> {
    /// Reads the arrays after an attribute's keyword; `false` when it is none.
    pub fn attribute(
        &mut self,
        keyword: &str,
        cursor: &mut Cursor,
        notes: &mut Notes,
    ) -> Result<bool> {
        match keyword {
            "scalars" => self.scalars(cursor, notes)?,
            "vectors" | "normals" => self.named(cursor, Some(3), notes)?,
            "tensors" => self.named(cursor, Some(9), notes)?,
            "tensors6" => self.named(cursor, Some(6), notes)?,
            "global_ids" | "pedigree_ids" | "edge_flags" | "edge_flag" => {
                self.named(cursor, Some(1), notes)?
            }
            "texture_coordinates" => self.named(cursor, None, notes)?,
            "color_scalars" => self.colors(cursor, notes)?,
            "lookup_table" => lookup_table(cursor, notes)?,
            "field" => self.field(cursor, notes)?,
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn named(
        &mut self,
        cursor: &mut Cursor,
        n_components: Option<usize>,
        notes: &mut Notes,
    ) -> Result<()> {
        let name = cursor.name(notes)?;
        let count = || cursor.count("a number of components");
        let n_components = n_components.map_or_else(count, Ok)?;
        let kind = Type::read(cursor)?;
        self.array(cursor, (name, n_components, kind), notes)
    }

    /// `SCALARS name type [components]`, and on a separate line their lookup table.
    fn scalars(&mut self, cursor: &mut Cursor, notes: &mut Notes) -> Result<()> {
        let name = cursor.name(notes)?;
        let kind = Type::read(cursor)?;
        let mut n_components = 1;
        if !cursor.clone().line().trim_ascii().is_empty() {
            n_components = cursor.count("a number of components")?;
        }
        if cursor.peek().as_deref() == Some("lookup_table") {
            cursor.keyword();
            cursor.need("the name of a lookup table")?;
        }
        self.array(cursor, (name, n_components, kind), notes)
    }

    /// Colours: bytes, or as text numbers from 0 to 1.
    fn colors(&mut self, cursor: &mut Cursor, notes: &mut Notes) -> Result<()> {
        let name = cursor.name(notes)?;
        let n_components = cursor.count("a number of components")?;
        if cursor.binary {
            let kind = Type::Number(Element::UInt8);
            return self.array(cursor, (name, n_components, kind), notes);
        }
        let n = self.n_values(cursor, n_components)?;
        let colors = values::numbers::<f32>(cursor, Element::Float32, n)?;
        let byte = |color: f32| (255.0 * color + 0.5) as u8;
        let bytes = Values::U8(colors.into_iter().map(byte).collect());
        self.push(name, n_components, bytes);
        Ok(())
    }

    fn n_values(&self, cursor: &Cursor, n_components: usize) -> Result<usize> {
        let n = self.n_tuples.unwrap_or(0).checked_mul(n_components);
        n.filter(|_| n_components > 0)
            .ok_or_else(|| cursor.error(format!("an array cannot have {n_components} components")))
    }

    fn array(
        &mut self,
        cursor: &mut Cursor,
        (name, n_components, kind): (String, usize, Type),
        notes: &mut Notes,
    ) -> Result<()> {
        let n = self.n_values(cursor, n_components)?;
        let values = values_of(cursor, &name, kind, n, notes)?;
        self.push(name, n_components, values);
        Ok(())
    }

    fn push(&mut self, name: String, n_components: usize, values: Values) {
        let array = DataArray::tuples(name, n_components, values);
        self.arrays.push(array);
    }

    /// `FIELD name n`, then for each array `name components tuples type` and its values.
    fn field(&mut self, cursor: &mut Cursor, notes: &mut Notes) -> Result<()> {
        cursor.need("the name of a field")?;
        let n_arrays = cursor.count("a number of arrays")?;
        for _ in 0..n_arrays {
            while cursor.peek().as_deref() == Some("metadata") {
                cursor.keyword();
                metadata(cursor, self.arrays.last_mut(), notes);
            }
            let word = cursor.need("the name of an array")?;
            if word == b"NULL_ARRAY" {
                continue;
            }
            let name = decoded(word, notes);
            let n_components = cursor.count("a number of components")?;
            let n_tuples = cursor.count("a number of tuples")?;
            let kind = Type::read(cursor)?;
            let n = n_components.checked_mul(n_tuples).ok_or_else(|| {
                cursor.error(format!("an array has {n_tuples} tuples of {n_components} components, which is out of range"))
            })?;
            let values = values_of(cursor, &name, kind, n, notes)?;
            let fits = self.n_tuples.is_none_or(|expected| expected == n_tuples);
            if fits && n_components > 0 {
                self.push(name, n_components, values);
            } else {
                let what = self.what;
                notes.push(note!(
                    "array_misfit",
                    "the {what} array \"{name}\" is left out: it has {} of {} for {}",
                    counted(n_tuples, "tuple"),
                    counted(n_components, "component"),
                    counted(self.n_tuples.unwrap_or(0), what)
                ));
            }
        }
        Ok(())
    }
}

/// Reads `n` values of an array, which errors name.
fn values_of(
    cursor: &mut Cursor,
    name: &str,
    kind: Type,
    n: usize,
    notes: &mut Notes,
) -> Result<Values> {
    values::read(cursor, kind, n, notes).map_err(|error| Error {
        message: format!("array \"{name}\": {}", error.message),
        ..error
    })
}

fn lookup_table(cursor: &mut Cursor, notes: &mut Notes) -> Result<()> {
    let name = decoded(cursor.need("the name of a lookup table")?, notes);
    let n = cursor.count("the size of a lookup table")?;
    let element = cursor.by_encoding(Element::UInt8, Element::Float32);
    let too_large = || cursor.error("the size of a lookup table is out of range");
    let n = n.checked_mul(4).ok_or_else(too_large)?;
    values::read(cursor, Type::Number(element), n, notes)?;
    notes.push(note!(
        "name_not_kept",
        "the lookup table \"{name}\" is not kept"
    ));
    Ok(())
}

/// Lines up to a blank one: names of the components of the array before, and information that VTK
/// works out again.
pub(super) fn metadata(cursor: &mut Cursor, array: Option<&mut DataArray>, notes: &mut Notes) {
    const KNOWN: [&[u8]; 2] = [b"L2_NORM_RANGE", b"L2_NORM_FINITE_RANGE"];
    cursor.line();
    let n_names = array.as_ref().map_or(0, |array| array.n_components);
    let mut names = Vec::new();
    loop {
        let line = cursor.line().trim_ascii();
        if line.is_empty() {
            break;
        }
        if line == b"COMPONENT_NAMES" {
            names.clear();
            while names.len() < n_names && !cursor.rest().is_empty() {
                names.push(decoded(cursor.line().trim_ascii(), notes));
            }
        } else if let Some(name) = line.strip_prefix(b"NAME ") {
            let name = name.split(u8::is_ascii_whitespace).next().unwrap_or(name);
            if !KNOWN.contains(&name) {
                let shown = shown(name);
                notes.push(note!("information", "the information {shown} is not kept"));
            }
        }
    }
    if let Some(array) = array {
        array.component_names = names;
    }
}
