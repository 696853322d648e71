//! Arrays compared by name, value by value at nodes and cells that belong together.

use super::super::arrays::with_numbers;
use super::super::{DataArray, Mesh, Values};
use super::Tolerance;
use super::partners::{Partners, in_chunks};
use azimesh_core::error::counted;
use azimesh_core::numbers::short;
use std::collections::BTreeMap;
use std::ops::Range;

/// A sentence for each array that differs: of `pairs`, the first are nodes, the second cells. Arrays
/// of different lengths differ where all is `in_order`.
pub fn compare(
    a: &Mesh,
    b: &Mesh,
    pairs: [&Partners; 2],
    in_order: bool,
    tolerance: Tolerance,
) -> Vec<String> {
    let whole = Partners::InOrder(usize::MAX);
    let places = [
        ("point", &a.point_arrays, &b.point_arrays, pairs[0]),
        ("cell", &a.cell_arrays, &b.cell_arrays, pairs[1]),
        ("field", &a.field_arrays, &b.field_arrays, &whole),
    ];
    let mut found = Vec::new();
    for (place, ours, theirs, partners) in places {
        let same_length = in_order || place == "field";
        let [of_ours, of_theirs] = [ours, theirs].map(|arrays| by_name(arrays));
        for array in ours {
            let name = &array.name;
            let what = match of_theirs.get(&**name) {
                None => Some("is only in the first mesh".to_owned()),
                Some(other) if same_length && !same_shape(array, other) => {
                    Some(different_shape(array, other))
                }
                Some(other) => difference(array, other, partners, tolerance),
            };
            found.extend(what.map(|what| format!("{place} array \"{name}\" {what}")));
        }
        for array in theirs {
            if !of_ours.contains_key(&*array.name) {
                let name = &array.name;
                found.push(format!(
                    "{place} array \"{name}\" is only in the second mesh"
                ));
            }
        }
    }
    found
}

fn by_name(arrays: &[DataArray]) -> BTreeMap<&str, &DataArray> {
    let named = arrays.iter().map(|array| (&*array.name, array));
    named.collect()
}

fn same_shape(a: &DataArray, b: &DataArray) -> bool {
    (a.n_components, a.values.len()) == (b.n_components, b.values.len())
}

fn different_shape(a: &DataArray, b: &DataArray) -> String {
    let shape = |x: &DataArray| format!("{} of {}", counted(x.n_tuples(), "tuple"), x.n_components);
    format!("has {} and {}", shape(a), shape(b))
}

/// The difference between two arrays of one name. The type of number may differ, its value not.
fn difference(
    a: &DataArray,
    b: &DataArray,
    partners: &Partners,
    tolerance: Tolerance,
) -> Option<String> {
    if a.n_components != b.n_components {
        return Some(different_shape(a, b));
    }
    if partners.is_in_order() && a.values == b.values {
        return None;
    }
    let pairs = Pairs {
        partners,
        n_tuples: a.n_tuples(),
        n_components: a.n_components,
    };
    match (&a.values, &b.values) {
        (Values::Text(x), Values::Text(y)) => text_difference(x, y, &pairs),
        (Values::Text(_), _) | (_, Values::Text(_)) => {
            Some("is text in one and numbers in the other".to_owned())
        }
        (x, y) => number_difference(x, y, &pairs, tolerance),
    }
}

/// The values of two arrays that belong together.
struct Pairs<'a> {
    partners: &'a Partners,
    n_tuples: usize,
    n_components: usize,
}

impl Pairs<'_> {
    /// Places of values, in the first and the second, of a range of tuples.
    fn of(&self, tuples: Range<usize>) -> impl Iterator<Item = [usize; 2]> {
        let n = self.n_components;
        tuples
            .filter_map(|tuple| Some([tuple, self.partners.of(tuple)?]))
            .flat_map(move |[i, j]| (0..n).map(move |k| [i * n + k, j * n + k]))
    }
}

fn text_difference(x: &[String], y: &[String], pairs: &Pairs) -> Option<String> {
    let [i, j] = pairs.of(0..pairs.n_tuples).find(|&[i, j]| x[i] != y[j])?;
    let tuple = i / pairs.n_components.max(1);
    Some(format!("has \"{}\" and \"{}\" at {tuple}", x[i], y[j]))
}

/// Values that differ.
#[derive(Default)]
struct Different {
    n: usize,
    n_compared: usize,
    first: Option<[usize; 2]>,
    /// Place in the first array, and by how much.
    most: Option<(usize, f64)>,
}

impl Different {
    fn joined(self, later: Self) -> Self {
        let most = match (self.most, later.most) {
            (Some(x), Some(y)) if y.1 > x.1 => Some(y),
            (x, y) => x.or(y),
        };
        Self {
            n: self.n + later.n,
            n_compared: self.n_compared + later.n_compared,
            first: self.first.or(later.first),
            most,
        }
    }
}

fn number_difference(
    x: &Values,
    y: &Values,
    pairs: &Pairs,
    tolerance: Tolerance,
) -> Option<String> {
    let largest = if tolerance.relative { largest(x) } else { 0.0 };
    let allowed = tolerance.absolute(largest);
    let distance = distances(x, y);
    let look = |tuples: Range<usize>| {
        let mut found = Different::default();
        for [i, j] in pairs.of(tuples) {
            found.n_compared += 1;
            let distance = distance(i, j);
            if distance > allowed {
                found.n += 1;
                found.first.get_or_insert([i, j]);
                if found.most.is_none_or(|(_, most)| distance > most) {
                    found.most = Some((i, distance));
                }
            }
        }
        found
    };
    let found = in_chunks(pairs.n_tuples, &look, Different::joined);
    let (Some([i, j]), Some((at, most))) = (found.first, found.most) else {
        return None;
    };
    let tuple = |i: usize| i / pairs.n_components.max(1);
    let furthest = match found.n {
        1 => String::new(),
        _ => format!(", most by {} at {}", short(most), tuple(at)),
    };
    Some(format!(
        "differs in {} of {} values, first at {}: {} and {}{furthest}",
        found.n,
        found.n_compared,
        tuple(i),
        shown(x, i),
        shown(y, j)
    ))
}

/// A function of two indices: the difference of the values there; 0 if both are NaN, infinite if one is.
/// Integers are compared as such, others as reals.
fn distances<'a>(x: &'a Values, y: &'a Values) -> Box<dyn Fn(usize, usize) -> f64 + Sync + 'a> {
    if let (Some(x), Some(y)) = (integers(x), integers(y)) {
        return Box::new(move |i, j| x(i).abs_diff(y(j)) as f64);
    }
    let (x, y) = (reals(x), reals(y));
    Box::new(move |i, j| {
        let (x, y) = (x(i), y(j));
        if x == y || (x.is_nan() && y.is_nan()) {
            0.0
        } else {
            Some((x - y).abs())
                .filter(|d| !d.is_nan())
                .unwrap_or(f64::INFINITY)
        }
    })
}

/// The values of an array of integers by index.
fn integers(values: &Values) -> Option<Box<dyn Fn(usize) -> i128 + Sync + '_>> {
    macro_rules! each {
        ($($variant:ident),*) => {
            match values {
                $(Values::$variant(v) => Some(Box::new(move |i| v[i].into())),)*
                Values::F32(_) | Values::F64(_) | Values::Text(_) => None,
            }
        };
    }
    each!(I8, U8, I16, U16, I32, U32, I64, U64)
}

/// The values of an array of numbers by index; text gives NaN.
#[allow(clippy::unnecessary_cast)] // one text for numbers of every type
fn reals(values: &Values) -> Box<dyn Fn(usize) -> f64 + Sync + '_> {
    with_numbers!(values, v => Box::new(move |i| v[i] as f64), _text => Box::new(|_| f64::NAN))
}

/// Largest finite magnitude.
fn largest(values: &Values) -> f64 {
    let value = reals(values);
    let look = |range: Range<usize>| {
        let sizes = range.map(|i| value(i).abs()).filter(|x| x.is_finite());
        sizes.fold(0.0, f64::max)
    };
    in_chunks(values.len(), &look, f64::max)
}

fn shown(values: &Values, i: usize) -> String {
    with_numbers!(values, v => v[i].to_string(), t => t[i].clone())
}
