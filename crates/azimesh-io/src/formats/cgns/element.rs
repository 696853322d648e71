//! CGNS's element types: their numbers and names, the cell kinds they are, the order of their nodes.

use super::lattice::vtk_from_cgns;
use crate::mesh::CellKind;
use azimesh_core::parallel::for_blocks;

/// Number of the type of sections whose elements name their own type.
pub(super) const MIXED: i64 = 20;
/// Number of the type of polygons.
pub(super) const NGON_N: i64 = 22;
/// Number of the type of polyhedra.
pub(super) const NFACE_N: i64 = 23;

/// An element type with a fixed number of nodes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct ElementType {
    /// CGNS's number.
    pub number: i64,
    /// CGNS's name.
    pub name: &'static str,
    /// Nodes in the file.
    pub n_nodes: usize,
    /// The cell it becomes: of its corners alone for an element that VTK does not have.
    pub kind: CellKind,
    form: Form,
}

/// Correspondence of the nodes of an element and of the cell.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    /// As in VTK.
    Same,
    /// Node `i` of the cell is node `order[i]` of the element.
    Permuted(&'static [u8]),
    /// A complete element of third or fourth order.
    Lattice(u16),
    /// Nodes on the edges (and faces) only, of third or fourth order: VTK has no such cell.
    Incomplete,
}

use CellKind::*;
use Form::{Incomplete, Lattice, Permuted, Same};

const HEXA_20: [u8; 20] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15,
];
const HEXA_27: [u8; 27] = [
    0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 16, 17, 18, 19, 12, 13, 14, 15, 24, 22, 21, 23, 20, 25,
    26,
];
const PENTA_15: [u8; 15] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11];
const PENTA_18: [u8; 18] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 12, 13, 14, 9, 10, 11, 15, 16, 17];

const fn element(
    number: i64,
    name: &'static str,
    n_nodes: usize,
    kind: CellKind,
    form: Form,
) -> ElementType {
    ElementType {
        number,
        name,
        n_nodes,
        kind,
        form,
    }
}

/// Every type with a fixed number of nodes.
static TYPES: &[ElementType] = &[
    element(2, "NODE", 1, Vertex, Same),
    element(3, "BAR_2", 2, Line, Same),
    element(4, "BAR_3", 3, Line3, Same),
    element(5, "TRI_3", 3, Triangle, Same),
    element(6, "TRI_6", 6, Triangle6, Same),
    element(7, "QUAD_4", 4, Quadrilateral, Same),
    element(8, "QUAD_8", 8, Quadrilateral8, Same),
    element(9, "QUAD_9", 9, Quadrilateral9, Same),
    element(10, "TETRA_4", 4, Tetrahedron, Same),
    element(11, "TETRA_10", 10, Tetrahedron10, Same),
    element(12, "PYRA_5", 5, Pyramid, Same),
    element(13, "PYRA_14", 14, LagrangePyramid, Same),
    element(14, "PENTA_6", 6, Wedge, Same),
    element(15, "PENTA_15", 15, Wedge15, Permuted(&PENTA_15)),
    element(16, "PENTA_18", 18, Wedge18, Permuted(&PENTA_18)),
    element(17, "HEXA_8", 8, Hexahedron, Same),
    element(18, "HEXA_20", 20, Hexahedron20, Permuted(&HEXA_20)),
    element(19, "HEXA_27", 27, Hexahedron27, Permuted(&HEXA_27)),
    element(21, "PYRA_13", 13, Pyramid13, Same),
    element(24, "BAR_4", 4, LagrangeCurve, Same),
    element(25, "TRI_9", 9, Triangle, Incomplete),
    element(26, "TRI_10", 10, LagrangeTriangle, Same),
    element(27, "QUAD_12", 12, Quadrilateral, Incomplete),
    element(28, "QUAD_16", 16, LagrangeQuadrilateral, Lattice(3)),
    element(29, "TETRA_16", 16, Tetrahedron, Incomplete),
    element(30, "TETRA_20", 20, LagrangeTetrahedron, Lattice(3)),
    element(31, "PYRA_21", 21, Pyramid, Incomplete),
    element(32, "PYRA_29", 29, Pyramid, Incomplete),
    element(33, "PYRA_30", 30, LagrangePyramid, Lattice(3)),
    element(34, "PENTA_24", 24, Wedge, Incomplete),
    element(35, "PENTA_38", 38, Wedge, Incomplete),
    element(36, "PENTA_40", 40, LagrangeWedge, Lattice(3)),
    element(37, "HEXA_32", 32, Hexahedron, Incomplete),
    element(38, "HEXA_56", 56, Hexahedron, Incomplete),
    element(39, "HEXA_64", 64, LagrangeHexahedron, Lattice(3)),
    element(40, "BAR_5", 5, LagrangeCurve, Same),
    element(41, "TRI_12", 12, Triangle, Incomplete),
    element(42, "TRI_15", 15, LagrangeTriangle, Same),
    element(43, "QUAD_P4_16", 16, Quadrilateral, Incomplete),
    element(44, "QUAD_25", 25, LagrangeQuadrilateral, Lattice(4)),
    element(45, "TETRA_22", 22, Tetrahedron, Incomplete),
    element(46, "TETRA_34", 34, Tetrahedron, Incomplete),
    element(47, "TETRA_35", 35, LagrangeTetrahedron, Lattice(4)),
    element(48, "PYRA_P4_29", 29, Pyramid, Incomplete),
    element(49, "PYRA_50", 50, Pyramid, Incomplete),
    element(50, "PYRA_55", 55, LagrangePyramid, Lattice(4)),
    element(51, "PENTA_33", 33, Wedge, Incomplete),
    element(52, "PENTA_66", 66, Wedge, Incomplete),
    element(53, "PENTA_75", 75, LagrangeWedge, Lattice(4)),
    element(54, "HEXA_44", 44, Hexahedron, Incomplete),
    element(55, "HEXA_98", 98, Hexahedron, Incomplete),
    element(56, "HEXA_125", 125, LagrangeHexahedron, Lattice(4)),
];

impl ElementType {
    /// The type with this number; `None` for MIXED, NGON_n, NFACE_n and unknown ones.
    pub fn from_number(number: i64) -> Option<Self> {
        TYPES.iter().copied().find(|t| t.number == number)
    }

    /// The type with this number in a file of this CGNS version: before 3, those above all others are polygons.
    pub fn in_version(number: i64, version: f64) -> Option<Self> {
        let n_nodes = number.checked_sub(21).and_then(|n| usize::try_from(n).ok());
        match n_nodes.filter(|n| version < 2.995 && *n >= 3) {
            Some(n_nodes) => Some(element(number, "polygon", n_nodes, Polygon, Same)),
            None => Self::from_number(number),
        }
    }

    /// The type that holds a cell with all its nodes.
    pub fn of(kind: CellKind, n_nodes: usize) -> Option<Self> {
        let kind = match kind {
            CellKind::CubicLine => LagrangeCurve,
            kind => kind,
        };
        let holds = |t: &ElementType| t.kind == kind && t.n_nodes == n_nodes && t.is_kept();
        TYPES.iter().copied().find(holds)
    }

    /// Tests if the cell keeps every node of the element.
    pub fn is_kept(self) -> bool {
        self.form != Incomplete
    }

    /// Position in the element of each node of the cell; `None` where they are the same.
    pub fn vtk_from_cgns(self) -> Option<Vec<usize>> {
        match self.form {
            Same | Incomplete => None,
            Permuted(order) => Some(order.iter().map(|&i| i.into()).collect()),
            Lattice(order) => Some(vtk_from_cgns(self.kind, order)),
        }
    }

    /// Position in the cell of each node of the element; `None` where they are the same.
    pub fn cgns_from_vtk(self) -> Option<Vec<usize>> {
        let order = self.vtk_from_cgns()?;
        let mut inverse = vec![0; order.len()];
        for (to, &from) in order.iter().enumerate() {
            inverse[from] = to;
        }
        Some(inverse)
    }
}

/// Current meaning of an element type number in a file of this CGNS version: in 3.0 the pyramid of
/// 13 nodes stood among the others.
pub(super) fn current_number(number: i64, version: f64) -> i64 {
    match number {
        13 if is_3_0(version) => 21,
        14..=21 if is_3_0(version) => number - 1,
        _ => number,
    }
}

fn is_3_0(version: f64) -> bool {
    (2.995..3.095).contains(&version)
}

/// Puts the nodes of consecutive elements into another order: node `i` becomes what was node
/// `order[i]`.
pub(in crate::formats) fn permute(connectivity: &mut [u32], order: &[usize]) {
    let n = order.len();
    for_blocks(connectivity, n * 4096, &|_, elements| {
        let mut before = vec![0; n];
        for element in elements.chunks_exact_mut(n) {
            before.copy_from_slice(element);
            for (node, &from) in element.iter_mut().zip(order) {
                *node = before[from];
            }
        }
    });
}

/// Name of any element type, for messages.
pub(super) fn type_name(number: i64) -> String {
    match number {
        MIXED => "MIXED".to_owned(),
        NGON_N => "NGON_n".to_owned(),
        NFACE_N => "NFACE_n".to_owned(),
        _ => ElementType::from_number(number)
            .map_or_else(|| format!("type {number}"), |t| t.name.to_owned()),
    }
}

/// Names of all element types.
pub(super) fn names() -> impl Iterator<Item = &'static str> {
    let fixed = TYPES.iter().map(|t| t.name).filter(|name| *name != "NODE");
    fixed.chain(["MIXED", "NGON_N", "NFACE_N"])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn order_of(number: i64) -> Vec<usize> {
        let element = ElementType::from_number(number).expect("it is a known type");
        element.vtk_from_cgns().expect("the orders differ")
    }

    /// Corner pairs and faces as the standard (SIDS 3.3.3) numbers the nodes of HEXA_27 from 1, and
    /// as VTK documents for its triquadratic hexahedron.
    #[test]
    fn nodes_of_a_hexahedron_lie_between_the_same_corners() {
        let cgns: [&[usize]; 19] = [
            &[1, 2],
            &[2, 3],
            &[3, 4],
            &[4, 1],
            &[1, 5],
            &[2, 6],
            &[3, 7],
            &[4, 8],
            &[5, 6],
            &[6, 7],
            &[7, 8],
            &[8, 5],
            &[1, 4, 3, 2],
            &[1, 2, 6, 5],
            &[2, 3, 7, 6],
            &[3, 4, 8, 7],
            &[1, 5, 8, 4],
            &[5, 6, 7, 8],
            &[1, 2, 3, 4, 5, 6, 7, 8],
        ];
        let order = order_of(19);
        let kind = CellKind::Hexahedron27;
        let edges = kind.edges().iter().map(|edge| edge.to_vec());
        let faces = kind.faces().iter().map(|face| face.to_vec());
        for (vtk, corners) in edges.chain(faces).enumerate() {
            let mut expected: Vec<usize> = corners.iter().map(|&c| usize::from(c) + 1).collect();
            let mut found = cgns[order[8 + vtk] - 8].to_vec();
            expected.sort_unstable();
            found.sort_unstable();
            assert_eq!(found, expected, "node {}", 8 + vtk);
        }
        assert_eq!(order[26], 26);
        assert_eq!(order_of(18), order[..20]);
    }

    #[test]
    fn vertical_edges_of_a_wedge_come_before_those_of_its_top_in_the_file() {
        let order = order_of(16);
        assert_eq!(order[9..15], [12, 13, 14, 9, 10, 11]);
        assert_eq!(order_of(15), order[..15]);
    }

    /// Nodes of HEXA_64 on one face and edge as the standard's figure has them (from 1): edge 3-4 has
    /// 13 and 14 from 3 to 4, the bottom has 33 to 36 round its rim.
    #[test]
    fn cubic_hexahedra_go_round_in_the_file_and_along_the_axes_in_vtk() {
        let order = order_of(39);
        assert_eq!(order[8..16], [8, 9, 10, 11, 13, 12, 15, 14]);
        // VTK's faces: x low, x high, y low, y high, z low at 48.
        assert_eq!(order[48..52], [32, 33, 35, 34]);
        let mut all = order.clone();
        all.sort_unstable();
        assert!(all.into_iter().eq(0..64));
    }

    #[test]
    fn pyramids_of_second_order_have_the_same_nodes_in_both() {
        assert!(
            vtk_from_cgns(CellKind::LagrangePyramid, 2)
                .into_iter()
                .eq(0..14)
        );
    }

    #[test]
    fn orders_there_and_back_cancel() {
        for element in TYPES {
            let (Some(there), Some(back)) = (element.vtk_from_cgns(), element.cgns_from_vtk())
            else {
                continue;
            };
            assert_eq!(there.len(), element.n_nodes, "{}", element.name);
            assert!(
                (0..there.len()).all(|i| back[there[i]] == i),
                "{}",
                element.name
            );
        }
    }

    #[test]
    fn a_cell_finds_the_type_that_holds_all_its_nodes() {
        let name = |kind, n| ElementType::of(kind, n).map(|element| element.name);
        assert_eq!(name(CellKind::Hexahedron, 8), Some("HEXA_8"));
        assert_eq!(name(CellKind::LagrangeHexahedron, 64), Some("HEXA_64"));
        assert_eq!(name(CellKind::LagrangeTriangle, 15), Some("TRI_15"));
        assert_eq!(name(CellKind::LagrangeTriangle, 21), None);
        assert_eq!(name(CellKind::Triangle7, 7), None);
    }

    #[test]
    fn types_of_3_0_are_those_of_today() {
        assert_eq!(current_number(18, 3.0), 17);
        assert_eq!(current_number(13, 3.0), 21);
        assert_eq!(current_number(17, 3.1), 17);
        assert_eq!(current_number(7, 3.0), 7);
        let old = ElementType::in_version(26, 2.5).expect("it is a polygon");
        assert_eq!((old.kind, old.n_nodes), (Polygon, 5));
        let new = ElementType::in_version(26, 3.1).expect("it is a triangle");
        assert_eq!(new.name, "TRI_10");
    }
}
