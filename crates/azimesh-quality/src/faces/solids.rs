//! Solid cells with fixed faces: where the corners of their faces are, and their centres side by side.

use super::block::CentreColumns;
use super::geometry::{self, Centre, Face};
use crate::block::{BLOCK, Columns};
use azimesh_core::geometry::vector::Vector;
use multiversion::multiversion;

/// A kind of solid cell with `N` corners and `F` faces.
pub(super) trait Solid<const N: usize, const F: usize> {
    /// Corners of each face, as in `CellKind::faces`.
    const SIDES: [&'static [usize]; F];

    /// Must be free of branches, or the loop over cells stays scalar.
    fn centre(corner: impl Fn(usize) -> Vector) -> Centre;
}

pub(super) struct Tetrahedron;

impl Solid<4, 4> for Tetrahedron {
    const SIDES: [&'static [usize]; 4] = [&[0, 1, 3], &[1, 2, 3], &[2, 0, 3], &[0, 2, 1]];

    #[inline(always)]
    fn centre(corner: impl Fn(usize) -> Vector) -> Centre {
        geometry::solid_simplex([corner(0), corner(1), corner(2), corner(3)])
    }
}

#[inline(always)]
fn tri(corner: &impl Fn(usize) -> Vector, nodes: [usize; 3]) -> Face {
    geometry::triangle(corner(nodes[0]), corner(nodes[1]), corner(nodes[2]))
}

#[inline(always)]
fn quad(corner: &impl Fn(usize) -> Vector, nodes: [usize; 4]) -> Face {
    geometry::polygon(4, |i| corner(nodes[i]))
}

macro_rules! solids {
    ($($name:ident $n:literal $f:literal: $($face:ident $nodes:expr),+;)*) => {
        $(
            pub(super) struct $name;

            impl Solid<$n, $f> for $name {
                const SIDES: [&'static [usize]; $f] = [$(&$nodes),+];

                #[inline(always)]
                fn centre(corner: impl Fn(usize) -> Vector) -> Centre {
                    geometry::cell(&[$($face(&corner, $nodes)),+], 3)
                }
            }
        )*
    };
}

solids! {
    Hexahedron 8 6: quad [0, 4, 7, 3], quad [1, 2, 6, 5], quad [0, 1, 5, 4], quad [3, 7, 6, 2], quad [0, 3, 2, 1],
        quad [4, 5, 6, 7];
    Wedge 6 5: tri [0, 2, 1], tri [3, 4, 5], quad [0, 1, 4, 3], quad [1, 2, 5, 4], quad [2, 0, 3, 5];
    Pyramid 5 5: quad [0, 3, 2, 1], tri [0, 1, 4], tri [1, 2, 4], tri [2, 3, 4], tri [3, 0, 4];
}

/// Centres of the cells of a block.
#[multiversion(targets(
    "x86_64+avx512f+avx512dq+avx512vl+avx2+fma",
    "x86_64+avx2+fma",
    "aarch64+neon"
))]
pub(super) fn centres<S: Solid<N, F>, const N: usize, const F: usize>(
    at: &Columns<N>,
    found: &mut CentreColumns,
) {
    for i in 0..BLOCK {
        let centre = S::centre(|k| [at[k][0][i], at[k][1][i], at[k][2][i]]);
        found[0][i] = centre.at[0];
        found[1][i] = centre.at[1];
        found[2][i] = centre.at[2];
        found[3][i] = centre.volume;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_io::mesh::CellKind;

    #[test]
    fn the_faces_are_those_of_the_kinds() {
        let check = |kind: CellKind, sides: &[&[usize]]| {
            let faces = kind
                .faces()
                .iter()
                .map(|face| face.iter().map(|&k| usize::from(k)));
            let faces: Vec<Vec<usize>> = faces.map(Iterator::collect).collect();
            assert_eq!(sides, faces, "{kind:?}");
        };
        check(CellKind::Tetrahedron, &Tetrahedron::SIDES);
        check(CellKind::Pyramid, &Pyramid::SIDES);
        check(CellKind::Wedge, &Wedge::SIDES);
        check(CellKind::Hexahedron, &Hexahedron::SIDES);
    }
}
