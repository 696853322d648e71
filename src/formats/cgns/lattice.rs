//! Where the nodes of complete elements of third and fourth order lie: in CGNS's order and in VTK's.
//!
//! Both orders list corners, edges, faces, inside, but walk along them differently. A node is named
//! by its place on the lattice of the reference element, with whole coordinates from 0 to the order;
//! an element is put from one order into the other by places. VTK has no pyramid of these orders;
//! it keeps the order of CGNS.

/// Shape of an element that has nodes on a lattice.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Shape {
    Quadrilateral,
    Tetrahedron,
    Hexahedron,
    Wedge,
    Pyramid,
}

type Place = [i32; 3];

/// For each node in VTK's order, its position in CGNS's order.
pub(super) fn vtk_from_cgns(shape: Shape, order: u8) -> Vec<usize> {
    let cgns = cgns_places(shape, order.into());
    if shape == Shape::Pyramid {
        return (0..n_pyramid_nodes(order.into())).collect();
    }
    let position = |place: &Place| cgns.iter().position(|p| p == place);
    vtk_places(shape, order.into())
        .iter()
        .map(|place| position(place).expect("both orders list the same places"))
        .collect()
}

fn n_pyramid_nodes(order: usize) -> usize {
    (1..=order + 1).map(|n| n * n).sum()
}

/// A list of places that grows edge by edge and face by face.
struct Walk {
    order: i32,
    places: Vec<Place>,
}

impl Walk {
    fn new(order: i32, corners: &[Place]) -> Self {
        let scaled = corners.iter().map(|c| c.map(|x| x * order));
        Self {
            order,
            places: scaled.collect(),
        }
    }

    fn corner(&self, i: usize) -> Place {
        self.places[i]
    }

    /// Nodes between two corners, from the first to the second.
    fn edges(&mut self, edges: &[[usize; 2]]) {
        for &[a, b] in edges {
            let (a, b) = (self.corner(a), self.corner(b));
            let unit = step(a, b, self.order);
            self.places
                .extend((1..self.order).map(|i| ahead(a, unit, i)));
        }
    }

    /// Nodes inside a triangle: a triangle of third order less, its corners first.
    fn triangle(&mut self, [a, b, c]: [Place; 3]) {
        let (u, v) = (step(a, b, self.order), step(a, c, self.order));
        let n = self.order - 3;
        if n < 0 {
            return;
        }
        let first = ahead(ahead(a, u, 1), v, 1);
        let corners = [first, ahead(first, u, n), ahead(first, v, n)];
        match n {
            0 => self.places.push(first),
            _ => self.places.extend(corners),
        }
        debug_assert!(n < 2, "orders three and four only");
    }

    /// Nodes inside a quadrilateral as CGNS lists them: round the rim of what is inside, then the
    /// middle.
    fn spiral(&mut self, [a, b, c, d]: [Place; 4]) {
        let n = self.order;
        let (u, v) = (step(a, b, n), step(a, d, n));
        let first = ahead(ahead(a, u, 1), v, 1);
        let side = n - 2;
        let rim = [
            first,
            ahead(first, u, side),
            ahead(ahead(first, u, side), v, side),
            ahead(first, v, side),
        ];
        debug_assert_eq!(ahead(ahead(a, u, n), v, n), c);
        for i in 0..4 {
            let (from, to) = (rim[i], rim[(i + 1) % 4]);
            let unit = step(from, to, side);
            self.places.extend((0..side).map(|k| ahead(from, unit, k)));
        }
        if n == 4 {
            self.places.push(ahead(ahead(a, u, 2), v, 2));
        }
    }

    /// Nodes inside a quadrilateral row by row, along its first edge fastest.
    fn rows(&mut self, [a, b, _, d]: [Place; 4]) {
        let (u, v) = (step(a, b, self.order), step(a, d, self.order));
        for j in 1..self.order {
            let row = ahead(a, v, j);
            self.places
                .extend((1..self.order).map(|i| ahead(row, u, i)));
        }
    }

    fn corners<const N: usize>(&self, of: [usize; N]) -> [Place; N] {
        of.map(|i| self.corner(i))
    }

    /// The corners of a face, carried up by `k` layers.
    fn raised<const N: usize>(&self, of: [usize; N], k: i32) -> [Place; N] {
        self.corners(of).map(|[x, y, z]| [x, y, z + k])
    }
}

fn step(a: Place, b: Place, n: i32) -> Place {
    std::array::from_fn(|i| (b[i] - a[i]) / n)
}

fn ahead(a: Place, unit: Place, n: i32) -> Place {
    std::array::from_fn(|i| a[i] + n * unit[i])
}

const QUADRILATERAL: [Place; 4] = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]];
const TETRAHEDRON: [Place; 4] = [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]];
const WEDGE: [Place; 6] = [
    [0, 0, 0],
    [1, 0, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [0, 1, 1],
];
const HEXAHEDRON: [Place; 8] = [
    [0, 0, 0],
    [1, 0, 0],
    [1, 1, 0],
    [0, 1, 0],
    [0, 0, 1],
    [1, 0, 1],
    [1, 1, 1],
    [0, 1, 1],
];

fn corners_of(shape: Shape) -> &'static [Place] {
    match shape {
        Shape::Quadrilateral => &QUADRILATERAL,
        Shape::Tetrahedron => &TETRAHEDRON,
        Shape::Wedge => &WEDGE,
        Shape::Hexahedron => &HEXAHEDRON,
        Shape::Pyramid => &[],
    }
}

/// Places in the order of the standard (SIDS, conventions for unstructured elements): edges and
/// faces cyclic, the inside layer by layer.
fn cgns_places(shape: Shape, order: i32) -> Vec<Place> {
    let mut walk = Walk::new(order, corners_of(shape));
    match shape {
        Shape::Pyramid => {}
        Shape::Quadrilateral => {
            walk.edges(&[[0, 1], [1, 2], [2, 3], [3, 0]]);
            walk.spiral(walk.corners([0, 1, 2, 3]));
        }
        Shape::Tetrahedron => {
            walk.edges(&[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]);
            for face in [[0, 1, 2], [0, 1, 3], [1, 2, 3], [2, 0, 3]] {
                walk.triangle(walk.corners(face));
            }
            walk.places.extend((order == 4).then_some([1; 3]));
        }
        Shape::Wedge => cgns_wedge(&mut walk),
        Shape::Hexahedron => cgns_hexahedron(&mut walk),
    }
    walk.places
}

fn cgns_wedge(walk: &mut Walk) {
    walk.edges(&[[0, 1], [1, 2], [2, 0], [0, 3], [1, 4], [2, 5]]);
    walk.edges(&[[3, 4], [4, 5], [5, 3]]);
    walk.triangle(walk.corners([0, 1, 2]));
    for face in [[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]] {
        walk.spiral(walk.corners(face));
    }
    walk.triangle(walk.corners([3, 4, 5]));
    for k in 1..walk.order {
        walk.triangle(walk.raised([0, 1, 2], k));
    }
}

fn cgns_hexahedron(walk: &mut Walk) {
    walk.edges(&[[0, 1], [1, 2], [2, 3], [3, 0]]);
    walk.edges(&[[0, 4], [1, 5], [2, 6], [3, 7]]);
    walk.edges(&[[4, 5], [5, 6], [6, 7], [7, 4]]);
    let faces = [
        [0, 1, 2, 3],
        [0, 1, 5, 4],
        [1, 2, 6, 5],
        [2, 3, 7, 6],
        [3, 0, 4, 7],
        [4, 5, 6, 7],
    ];
    for face in faces {
        walk.spiral(walk.corners(face));
    }
    for k in 1..walk.order {
        walk.spiral(walk.raised([0, 1, 2, 3], k));
    }
}

/// Places in the order of VTK's Lagrange cells: edges and faces along the axes.
fn vtk_places(shape: Shape, order: i32) -> Vec<Place> {
    let mut walk = Walk::new(order, corners_of(shape));
    match shape {
        Shape::Pyramid => return Vec::new(),
        Shape::Quadrilateral => {
            walk.edges(&[[0, 1], [1, 2], [3, 2], [0, 3]]);
            walk.rows(walk.corners([0, 1, 2, 3]));
        }
        Shape::Tetrahedron => {
            walk.edges(&[[0, 1], [1, 2], [2, 0], [0, 3], [1, 3], [2, 3]]);
            for face in [[0, 1, 3], [2, 3, 1], [0, 3, 2], [0, 2, 1]] {
                walk.triangle(walk.corners(face));
            }
            walk.places.extend((order == 4).then_some([1; 3]));
        }
        Shape::Wedge => vtk_wedge(&mut walk),
        Shape::Hexahedron => vtk_hexahedron(&mut walk),
    }
    walk.places
}

fn vtk_wedge(walk: &mut Walk) {
    walk.edges(&[[0, 1], [1, 2], [2, 0], [3, 4], [4, 5], [5, 3]]);
    walk.edges(&[[0, 3], [1, 4], [2, 5]]);
    walk.triangle(walk.corners([0, 1, 2]));
    walk.triangle(walk.corners([3, 4, 5]));
    for face in [[0, 1, 4, 3], [1, 2, 5, 4], [2, 0, 3, 5]] {
        walk.rows(walk.corners(face));
    }
    for k in 1..walk.order {
        walk.triangle(walk.raised([0, 1, 2], k));
    }
}

fn vtk_hexahedron(walk: &mut Walk) {
    walk.edges(&[[0, 1], [1, 2], [3, 2], [0, 3]]);
    walk.edges(&[[4, 5], [5, 6], [7, 6], [4, 7]]);
    walk.edges(&[[0, 4], [1, 5], [2, 6], [3, 7]]);
    let faces = [
        [0, 3, 7, 4],
        [1, 2, 6, 5],
        [0, 1, 5, 4],
        [3, 2, 6, 7],
        [0, 1, 2, 3],
        [4, 5, 6, 7],
    ];
    for face in faces {
        walk.rows(walk.corners(face));
    }
    for k in 1..walk.order {
        walk.rows(walk.raised([0, 1, 2, 3], k));
    }
}
