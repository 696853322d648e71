//! Kinds of cells by meshio's names.

use azimesh::CellKind;

const NAMES: [(CellKind, &str); 24] = [
    (CellKind::Quadrilateral, "quad"),
    (CellKind::Tetrahedron, "tetra"),
    (CellKind::PentagonalPrism, "penta_prism"),
    (CellKind::HexagonalPrism, "hexa_prism"),
    (CellKind::Quadrilateral8, "quad8"),
    (CellKind::Tetrahedron10, "tetra10"),
    (CellKind::Quadrilateral9, "quad9"),
    (CellKind::QuadraticLinearQuadrilateral, "quad6"),
    (CellKind::QuadraticLinearWedge, "wedge12"),
    (CellKind::CubicLine, "line4"),
    (CellKind::LagrangeCurve, "VTK_LAGRANGE_CURVE"),
    (CellKind::LagrangeTriangle, "VTK_LAGRANGE_TRIANGLE"),
    (
        CellKind::LagrangeQuadrilateral,
        "VTK_LAGRANGE_QUADRILATERAL",
    ),
    (CellKind::LagrangeTetrahedron, "VTK_LAGRANGE_TETRAHEDRON"),
    (CellKind::LagrangeHexahedron, "VTK_LAGRANGE_HEXAHEDRON"),
    (CellKind::LagrangeWedge, "VTK_LAGRANGE_WEDGE"),
    (CellKind::LagrangePyramid, "VTK_LAGRANGE_PYRAMID"),
    (CellKind::BezierCurve, "VTK_BEZIER_CURVE"),
    (CellKind::BezierTriangle, "VTK_BEZIER_TRIANGLE"),
    (CellKind::BezierQuadrilateral, "VTK_BEZIER_QUADRILATERAL"),
    (CellKind::BezierTetrahedron, "VTK_BEZIER_TETRAHEDRON"),
    (CellKind::BezierHexahedron, "VTK_BEZIER_HEXAHEDRON"),
    (CellKind::BezierWedge, "VTK_BEZIER_WEDGE"),
    (CellKind::BezierPyramid, "VTK_BEZIER_PYRAMID"),
];

/// meshio's name of a kind; the library's own where meshio has the same or none.
pub fn name(kind: CellKind) -> &'static str {
    let other = NAMES.iter().find(|(known, _)| *known == kind);
    other.map_or(kind.name(), |(_, name)| name)
}

/// The kind of a name; digits after it count nodes where a kind may have any number of them.
pub fn kind(wanted: &str) -> Option<CellKind> {
    let of = |wanted: &str| CellKind::ALL.into_iter().find(|kind| name(*kind) == wanted);
    of(wanted).or_else(|| {
        let bare = wanted.trim_end_matches(|c: char| c.is_ascii_digit());
        of(bare).filter(|kind| kind.n_nodes().is_none())
    })
}
