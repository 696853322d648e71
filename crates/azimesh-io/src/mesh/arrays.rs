//! Data arrays of a mesh: at nodes, at cells, or field arrays.

use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Values of one array, in the type of the file. See [`DataArray`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[allow(missing_docs)] // the names say it
pub enum Values {
    I8(Vec<i8>),
    U8(Vec<u8>),
    I16(Vec<i16>),
    U16(Vec<u16>),
    I32(Vec<i32>),
    U32(Vec<u32>),
    I64(Vec<i64>),
    U64(Vec<u64>),
    F32(Vec<f32>),
    F64(Vec<f64>),
    Text(Vec<String>),
}

/// Runs `$body` with `$v` bound to the vector inside; text is left to `$text`.
macro_rules! with_numbers {
    ($values:expr, $v:ident => $body:expr, $t:ident => $text:expr) => {
        match $values {
            Values::I8($v) => $body,
            Values::U8($v) => $body,
            Values::I16($v) => $body,
            Values::U16($v) => $body,
            Values::I32($v) => $body,
            Values::U32($v) => $body,
            Values::I64($v) => $body,
            Values::U64($v) => $body,
            Values::F32($v) => $body,
            Values::F64($v) => $body,
            Values::Text($t) => $text,
        }
    };
}
pub(crate) use with_numbers;

/// A named array of tuples.
///
/// ```
/// use azimesh_io::{DataArray, Values};
///
/// let force = DataArray::tuples("force", 3, Values::F64(vec![0.0, 0.0, 1.0, 0.0, 0.0, 2.0]));
/// assert_eq!(force.n_tuples(), 2);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct DataArray {
    /// Name of the array.
    pub name: String,
    /// Values in one tuple; 1 for a scalar, 3 for a vector.
    pub n_components: usize,
    /// Names of the components, where the file gives them; otherwise empty.
    pub component_names: Vec<String>,
    /// The tuples, one after another.
    pub values: Values,
}

impl DataArray {
    /// A scalar array.
    pub fn scalar(name: impl Into<String>, values: Values) -> Self {
        Self::tuples(name, 1, values)
    }

    /// An array of `n_components` values a tuple.
    pub fn tuples(name: impl Into<String>, n_components: usize, values: Values) -> Self {
        Self {
            name: name.into(),
            n_components,
            component_names: Vec::new(),
            values,
        }
    }

    /// Number of tuples.
    pub fn n_tuples(&self) -> usize {
        self.values.len() / self.n_components.max(1)
    }

    /// The array with these tuples, in this order.
    pub fn select(&self, tuples: &[usize]) -> Self {
        Self {
            component_names: self.component_names.clone(),
            ..Self::tuples(
                &*self.name,
                self.n_components,
                self.values.select(self.n_components, tuples),
            )
        }
    }
}

/// Gives arrays these of their tuples, in this order.
pub fn select_tuples(arrays: &mut [DataArray], tuples: &[usize]) {
    for array in arrays {
        array.values = array.values.select(array.n_components, tuples);
    }
}

/// Appends these of their tuples to arrays.
pub(crate) fn append_tuples(arrays: &mut [DataArray], tuples: &[usize]) {
    for array in arrays {
        let values = array.values.select(array.n_components, tuples);
        array.values.append(&values);
    }
}

impl Values {
    /// The values as floats; `None` for text.
    pub fn to_f64(&self) -> Option<Vec<f64>> {
        #[allow(clippy::unnecessary_cast)] // one arm for every type of number
        let numbers =
            with_numbers!(self, v => Some(v.iter().map(|x| *x as f64).collect()), _text => None);
        numbers
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        with_numbers!(self, v => v.len(), t => t.len())
    }

    /// Returns whether there is no value.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The values as integers; `None` for text and for numbers with a fraction.
    pub fn to_integers(&self) -> Option<Vec<i64>> {
        Some(match self {
            Values::I8(v) => v.iter().map(|&x| x.into()).collect(),
            Values::U8(v) => v.iter().map(|&x| x.into()).collect(),
            Values::I16(v) => v.iter().map(|&x| x.into()).collect(),
            Values::U16(v) => v.iter().map(|&x| x.into()).collect(),
            Values::I32(v) => v.iter().map(|&x| x.into()).collect(),
            Values::U32(v) => v.iter().map(|&x| x.into()).collect(),
            Values::I64(v) => v.clone(),
            Values::U64(v) => return v.iter().map(|&x| i64::try_from(x).ok()).collect(),
            Values::F32(v) => return v.iter().map(|&x| whole(x.into())).collect(),
            Values::F64(v) => return v.iter().map(|&x| whole(x)).collect(),
            Values::Text(_) => return None,
        })
    }

    /// Returns whether all values are integers.
    pub fn is_integer(&self) -> bool {
        match self {
            Values::Text(_) => false,
            Values::F32(v) => v.iter().all(|&x| whole(x.into()).is_some()),
            Values::F64(v) => v.iter().all(|&x| whole(x).is_some()),
            Values::U64(v) => v.iter().all(|&x| i64::try_from(x).is_ok()),
            _ => true,
        }
    }

    /// Calls `visit(value, how often)` for each stretch of equal integers in `range`. Values that
    /// are no integers count as 0.
    pub fn for_each_stretch(&self, range: Range<usize>, mut visit: impl FnMut(i64, usize)) {
        macro_rules! stretches {
            ($v:expr, $integer:expr) => {
                for same in $v[range].chunk_by(|a, b| a == b) {
                    visit($integer(&same[0]), same.len());
                }
            };
        }
        match self {
            Values::I8(v) => stretches!(v, |&x: &i8| i64::from(x)),
            Values::U8(v) => stretches!(v, |&x: &u8| i64::from(x)),
            Values::I16(v) => stretches!(v, |&x: &i16| i64::from(x)),
            Values::U16(v) => stretches!(v, |&x: &u16| i64::from(x)),
            Values::I32(v) => stretches!(v, |&x: &i32| i64::from(x)),
            Values::U32(v) => stretches!(v, |&x: &u32| i64::from(x)),
            Values::I64(v) => stretches!(v, |&x: &i64| x),
            Values::U64(v) => stretches!(v, |&x: &u64| i64::try_from(x).unwrap_or(0)),
            Values::F32(v) => stretches!(v, |&x: &f32| whole(x.into()).unwrap_or(0)),
            Values::F64(v) => stretches!(v, |&x: &f64| whole(x).unwrap_or(0)),
            Values::Text(_) => visit(0, range.len()),
        }
    }

    /// The values of tuples `keep`, in that order.
    ///
    /// # Panics
    /// When a tuple is out of range.
    pub fn select(&self, n_components: usize, keep: &[usize]) -> Self {
        macro_rules! pick {
            ($($variant:ident),*) => {
                match self { $(Values::$variant(v) => Values::$variant(
                    keep.iter()
                        .flat_map(|&i| v[i * n_components..(i + 1) * n_components].iter().cloned())
                        .collect(),
                )),* }
            };
        }
        pick!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64, Text)
    }

    /// Name of the type of a value, as in Rust; `text` for text.
    pub fn type_name(&self) -> &'static str {
        match self {
            Values::I8(_) => "i8",
            Values::U8(_) => "u8",
            Values::I16(_) => "i16",
            Values::U16(_) => "u16",
            Values::I32(_) => "i32",
            Values::U32(_) => "u32",
            Values::I64(_) => "i64",
            Values::U64(_) => "u64",
            Values::F32(_) => "f32",
            Values::F64(_) => "f64",
            Values::Text(_) => "text",
        }
    }

    /// Smallest and largest value of each component, without NaN; `None` if all are NaN.
    /// Empty for text.
    #[allow(clippy::unnecessary_cast)] // one text for numbers of every type
    pub fn ranges(&self, n_components: usize) -> Vec<Option<[f64; 2]>> {
        let of = |component: usize| {
            with_numbers!(self, v => {
                let values = v.iter().skip(component).step_by(n_components);
                let numbers = values.map(|&x| x as f64).filter(|x| !x.is_nan());
                numbers.fold(None, |range: Option<[f64; 2]>, x| {
                    Some(range.map_or([x, x], |[low, high]| [low.min(x), high.max(x)]))
                })
            }, _text => None)
        };
        match self {
            Values::Text(_) => Vec::new(),
            _ => (0..n_components).map(of).collect(),
        }
    }

    /// Adds the values of another array of the same type at the end; `false` when it is of another.
    pub fn append(&mut self, other: &Self) -> bool {
        macro_rules! append {
            ($($variant:ident),*) => {
                match (self, other) {
                    $((Values::$variant(v), Values::$variant(more)) => v.extend_from_slice(more),)*
                    _ => return false,
                }
            };
        }
        append!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64, Text);
        true
    }

    /// Bytes held in memory.
    pub fn memory_bytes(&self) -> usize {
        with_numbers!(self, v => size_of_val(&v[..]), t => t.iter().map(|s| s.len() + 24).sum())
    }
}

fn whole(x: f64) -> Option<i64> {
    (x.fract() == 0.0 && x.abs() < 9e15).then_some(x as i64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stretches_of_equal_integers_cover_the_range() {
        let values = Values::F32(vec![9.0, 2.0, 2.0, -1.0, -1.0, -1.0, 9.0]);
        assert!(values.is_integer());
        let mut found = Vec::new();
        values.for_each_stretch(1..6, |value, n| found.push((value, n)));
        assert_eq!(found, [(2, 2), (-1, 3)]);
        assert!(!Values::F64(vec![0.5]).is_integer());
    }

    #[test]
    fn ranges_are_of_each_component_and_leave_out_nan() {
        let values = Values::F32(vec![1.0, f32::NAN, -2.0, f32::NAN]);
        assert_eq!(values.ranges(2), [Some([-2.0, 1.0]), None]);
        assert!(Values::Text(vec!["a".into()]).ranges(1).is_empty());
    }
}
