//! Arrays put together from pieces: values of parts of a mesh, and scalars that are the components of vectors.

use crate::mesh::{DataArray, Values};
use std::mem::discriminant;
use std::ops::Range;

/// Values of the nodes or cells in some ranges, in order.
pub(super) struct Piece {
    pub at: Vec<Range<usize>>,
    pub values: Values,
}

/// Joins pieces to an array of `n` values, floating-point numbers where the types differ. Missing values are NaN, or zero
/// in an array of integers.
pub(super) fn joined(mut pieces: Vec<Piece>, n: usize) -> Values {
    if let [Piece { at, values }] = &mut pieces[..]
        && at.len() == 1
        && at[0] == (0..n)
    {
        return std::mem::replace(values, Values::U8(Vec::new()));
    }
    let is_first = |piece: &Piece| discriminant(&piece.values) == discriminant(&pieces[0].values);
    let one_type = pieces.iter().all(is_first);
    macro_rules! placed {
        ($variant:ident, $nothing:expr) => {{
            let mut all = vec![$nothing; n];
            for piece in &pieces {
                let Values::$variant(values) = &piece.values else {
                    unreachable!("all pieces are of one type");
                };
                place(&mut all, &piece.at, values);
            }
            Values::$variant(all)
        }};
    }
    match &pieces[0].values {
        Values::I32(_) if one_type => placed!(I32, 0),
        Values::I64(_) if one_type => placed!(I64, 0),
        Values::F32(_) if one_type => placed!(F32, f32::NAN),
        _ => {
            for piece in &mut pieces {
                if !matches!(piece.values, Values::F64(_)) {
                    piece.values = Values::F64(piece.values.to_f64().unwrap_or_default());
                }
            }
            placed!(F64, f64::NAN)
        }
    }
}

fn place<T: Copy>(all: &mut [T], at: &[Range<usize>], values: &[T]) {
    let mut rest = values;
    for range in at {
        let n = range.len().min(rest.len());
        let (head, tail) = rest.split_at(n);
        all[range.start..range.start + n].copy_from_slice(head);
        rest = tail;
    }
}

/// Makes three scalars of one type an array of vectors where `names` gives for the first one the name of the vector and
/// the names of the two others.
pub(super) fn with_vectors(
    scalars: Vec<DataArray>,
    names: impl Fn(&str) -> Option<(String, [String; 2])>,
) -> Vec<DataArray> {
    let mut scalars: Vec<Option<DataArray>> = scalars.into_iter().map(Some).collect();
    let mut arrays = Vec::new();
    for i in 0..scalars.len() {
        let Some(first) = scalars[i].take() else {
            continue;
        };
        let kind = discriminant(&first.values);
        let find = |name: &String| {
            let is_it =
                |other: &DataArray| other.name == *name && discriminant(&other.values) == kind;
            scalars
                .iter()
                .position(|other| other.as_ref().is_some_and(is_it))
        };
        let others =
            names(&first.name).and_then(|(name, [y, z])| Some((name, [find(&y)?, find(&z)?])));
        arrays.push(match others {
            None => first,
            Some((name, others)) => {
                let [y, z] = others.map(|i| scalars[i].take().expect("it was just found"));
                DataArray::tuples(name, 3, interleaved(&first.values, &y.values, &z.values))
            }
        });
    }
    arrays
}

fn interleaved(x: &Values, y: &Values, z: &Values) -> Values {
    macro_rules! interleaved {
        ($($variant:ident),*) => {
            match (x, y, z) {
                $((Values::$variant(x), Values::$variant(y), Values::$variant(z)) => {
                    let triples = x.iter().zip(y).zip(z);
                    Values::$variant(triples.flat_map(|((&x, &y), &z)| [x, y, z]).collect())
                })*
                _ => unreachable!("the three are of one type"),
            }
        };
    }
    interleaved!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64)
}
