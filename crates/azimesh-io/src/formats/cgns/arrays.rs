//! Solution arrays of all zones, put together into arrays of the mesh.

use super::super::names::Places;
use crate::mesh::{DataArray, Values};
use std::ops::Range;

/// Pieces of arrays at nodes or at cells.
#[derive(Default)]
pub(super) struct Arrays {
    found: Vec<FoundArray>,
    places: Places<String>,
}

struct FoundArray {
    name: String,
    pieces: Vec<ArrayPiece>,
}

/// Values of some consecutive nodes, or of the cells in some ranges, in order.
struct ArrayPiece {
    zone: usize,
    at: Vec<Range<usize>>,
    values: Values,
}

impl Arrays {
    /// Adds the values that an array has in the given places of a zone. An array that the zone has
    /// already under this name gets the name of its solution too. Gives the name that it has then.
    pub fn add(
        &mut self,
        zone: usize,
        [solution, name]: [&str; 2],
        at: Vec<Range<usize>>,
        values: Values,
    ) -> String {
        let is_taken = |place: usize| {
            let pieces = &self.found[place].pieces;
            pieces.last().is_some_and(|piece| piece.zone == zone)
        };
        let mut full_name = name.to_owned();
        let mut count = 1;
        while self.places.get(&full_name).is_some_and(is_taken) {
            full_name = match count {
                1 => format!("{solution}/{name}"),
                _ => format!("{solution}/{name} {count}"),
            };
            count += 1;
        }
        let new = || FoundArray {
            name: full_name.clone(),
            pieces: Vec::new(),
        };
        let found = (self.places).entry(full_name.clone(), &mut self.found, new);
        found.pieces.push(ArrayPiece { zone, at, values });
        full_name
    }

    /// The arrays, each with `n` values. Where the file gives none there is no number, or zero in an
    /// array of integers. Three arrays named by axes become one of vectors.
    pub fn into_data_arrays(self, n: usize) -> Vec<DataArray> {
        let mut scalars: Vec<Option<DataArray>> = self
            .found
            .into_iter()
            .map(|found| Some(DataArray::scalar(found.name, joined(found.pieces, n))))
            .collect();
        let mut arrays = Vec::new();
        for i in 0..scalars.len() {
            let Some(first) = scalars[i].take() else {
                continue;
            };
            match other_axes(&first, &scalars, &self.places) {
                Some(others) => {
                    let [y, z] = others.map(|i| scalars[i].take().expect("it was just found"));
                    arrays.push(vector(&first, &y, &z));
                }
                None => arrays.push(first),
            }
        }
        arrays
    }
}

/// Where the arrays for the second and third axis are that belong to one for the first.
fn other_axes(
    first: &DataArray,
    scalars: &[Option<DataArray>],
    places: &Places<String>,
) -> Option<[usize; 2]> {
    let stem = first.name.strip_suffix('X')?;
    let same_type = std::mem::discriminant(&first.values);
    let find = |axis: char| {
        let place = places.get(&format!("{stem}{axis}"))?;
        let array = scalars[place].as_ref()?;
        (std::mem::discriminant(&array.values) == same_type).then_some(place)
    };
    (!stem.is_empty()).then_some([find('Y')?, find('Z')?])
}

fn vector(x: &DataArray, y: &DataArray, z: &DataArray) -> DataArray {
    macro_rules! interleaved {
        ($($variant:ident),*) => {
            match (&x.values, &y.values, &z.values) {
                $((Values::$variant(x), Values::$variant(y), Values::$variant(z)) => {
                    Values::$variant(
                        x.iter().zip(y).zip(z).flat_map(|((&x, &y), &z)| [x, y, z]).collect(),
                    )
                })*
                _ => unreachable!("the three are of one type"),
            }
        };
    }
    let values = interleaved!(I8, U8, I16, U16, I32, U32, I64, U64, F32, F64);
    let stem = x.name.strip_suffix('X').unwrap_or(&x.name);
    DataArray::tuples(stem, 3, values)
}

fn joined(mut pieces: Vec<ArrayPiece>, n: usize) -> Values {
    let covers = |piece: &ArrayPiece| piece.at.len() == 1 && piece.at[0] == (0..n);
    if let [piece] = &mut pieces[..]
        && covers(piece)
    {
        return std::mem::replace(&mut piece.values, Values::U8(Vec::new()));
    }
    let type_of = |piece: &ArrayPiece| std::mem::discriminant(&piece.values);
    let one_type = pieces
        .windows(2)
        .all(|two| type_of(&two[0]) == type_of(&two[1]));
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
            let mut all = vec![f64::NAN; n];
            for piece in &pieces {
                let values = piece.values.to_f64().unwrap_or_default();
                place(&mut all, &piece.at, &values);
            }
            Values::F64(all)
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
