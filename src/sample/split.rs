//! Cutting quadrilaterals into triangles and wedges into tetrahedra, so that neighbours agree.

/// Tetrahedra of a wedge.
pub const WEDGE_TETRAHEDRA: usize = 3;

/// Two triangles for each quadrilateral, cut from its lowest node.
pub fn triangles(quads: &[[u32; 4]]) -> Vec<[u32; 3]> {
    quads
        .iter()
        .flat_map(|quad| {
            let lowest = (0..4).min_by_key(|&i| quad[i]).expect("there are four");
            let [a, b, c, d] = std::array::from_fn(|i| quad[(lowest + i) % 4]);
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// The tetrahedra of the wedge between two triangles that turn towards `high`. Each side is cut
/// from its lowest node, which must be in `low`, so that wedges with a common side agree.
pub fn tetrahedra(low: [u32; 3], high: [u32; 3]) -> [[u32; 4]; WEDGE_TETRAHEDRA] {
    let first = (0..3).min_by_key(|&i| low[i]).expect("there are three");
    let [a, b, c] = std::array::from_fn(|i| low[(first + i) % 3]);
    let [d, e, f] = std::array::from_fn(|i| high[(first + i) % 3]);
    if b < c {
        [[a, b, c, f], [a, b, f, e], [a, e, f, d]]
    } else {
        [[a, b, c, e], [a, e, c, f], [a, e, f, d]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use azimesh_core::geometry::vector::{Vector, cross, dot, sub};

    #[test]
    fn the_tetrahedra_fill_the_wedge_whatever_its_numbers() {
        let corners: [Vector; 3] = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        for low in [
            [0, 1, 2],
            [0, 2, 1],
            [1, 0, 2],
            [2, 0, 1],
            [1, 2, 0],
            [2, 1, 0],
        ] {
            let at = |node: u32| {
                let i = low
                    .iter()
                    .position(|&n| n == node % 3)
                    .expect("it is a corner");
                [corners[i][0], corners[i][1], f64::from(node / 3)]
            };
            for tetrahedron in tetrahedra(low, low.map(|node| node + 3)) {
                let [a, b, c, d] = tetrahedron.map(at);
                let volume = dot(cross(sub(b, a), sub(c, a)), sub(d, a)) / 6.0;
                assert!(
                    (volume - 1.0 / 6.0).abs() < 1e-12,
                    "{low:?} {tetrahedron:?}"
                );
            }
        }
    }
}
