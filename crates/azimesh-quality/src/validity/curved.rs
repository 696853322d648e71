//! Curved cells: the Jacobian of the map of a cell of any order, in Bernstein form.
//!
//! A cell is a product of simplices: an interval for each axis of a hexahedron, a triangle and an interval for a wedge. Its map is a
//! polynomial with control points `b`,
//!
//! ```text
//! x(s) = sum_a b_a B_a(s),    B_a of degree p on each simplex
//! ```
//!
//! The derivatives of `x` have differences of control points as coefficients, and the coefficients of a product are the convolution of
//! the coefficients of its factors, each times its multinomial. So the coefficients of `det dx/ds` follow without sampling. The
//! determinant is between the least and the largest of them, and equals them at the corners; bisection brings both together.
//!
//! A pyramid is the product of three intervals `(u, v, w)` with `x = u (1 - w)`, `y = v (1 - w)`: its functions [2] are polynomials in
//! these, and the derivatives by `u` and `v` have a factor `1 - w` that is dropped.
//!
//! Sources: [1] A. Johnen, J.-F. Remacle, C. Geuzaine, Geometrical validity of curvilinear finite elements, Journal of
//! Computational Physics 233, 2013. [2] M. Bergot, G. Cohen, M. Durufle, Higher-order finite elements for hybrid meshes using new nodal
//! pyramidal elements, Journal of Scientific Computing 42, 2010.

use super::Proof;
use azimesh_core::geometry::vector::{Vector, cross, dot, norm, scale, sub};
use azimesh_io::mesh::CellKind::{self, *};
use azimesh_io::mesh::lagrange;

/// The highest order that is checked.
const MAX_ORDER: usize = 10;
/// Bisections of each edge at most, and parts of a cell at most.
const DEPTH: usize = 6;
const MAX_PARTS: usize = 4096;
/// Rounding of a coefficient, as a part of the product of the largest derivatives.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// Exponents of the reference coordinates.
type Exponents = [usize; 3];

/// Coordinates of each simplex of a product.
type Simplices = &'static [&'static [usize]];

const TRIANGLE: Simplices = &[&[0, 1]];
const SQUARE: Simplices = &[&[0], &[1]];
const TETRAHEDRON: Simplices = &[&[0, 1, 2]];
const CUBE: Simplices = &[&[0], &[1], &[2]];
const PRISM: Simplices = &[&[0, 1], &[2]];

/// Polynomials on a product of simplices, of one degree on each.
#[derive(Debug, Clone)]
struct Space {
    simplices: Simplices,
    degrees: Vec<usize>,
    exponents: Vec<Exponents>,
    /// The multinomial of each Bernstein polynomial.
    multinomials: Vec<f64>,
}

impl Space {
    fn new(simplices: Simplices, degrees: Vec<usize>) -> Self {
        let mut exponents = vec![[0; 3]];
        for (simplex, &degree) in simplices.iter().zip(&degrees) {
            for &axis in *simplex {
                exponents = exponents
                    .iter()
                    .flat_map(|from| {
                        let used: usize = simplex.iter().map(|&axis| from[axis]).sum();
                        (0..=degree - used).map(move |i| {
                            let mut to = *from;
                            to[axis] = i;
                            to
                        })
                    })
                    .collect();
            }
        }
        let multinomial = |a: &Exponents| {
            let of = |(simplex, &degree): (&&[usize], &usize)| {
                let mut left = degree;
                let mut product = 1.0;
                for &axis in *simplex {
                    product *= binomial(left, a[axis]);
                    left -= a[axis];
                }
                product
            };
            simplices.iter().zip(&degrees).map(of).product()
        };
        let multinomials = exponents.iter().map(multinomial).collect();
        Self {
            simplices,
            degrees,
            exponents,
            multinomials,
        }
    }

    /// The place of each polynomial in an array with these strides.
    fn places(&self, strides: [usize; 3]) -> Vec<usize> {
        let place = |a: &Exponents| (0..3).map(|axis| a[axis] * strides[axis]).sum();
        self.exponents.iter().map(place).collect()
    }

    /// The largest exponent of each coordinate.
    fn largest(&self) -> Exponents {
        let mut largest = [0; 3];
        for (simplex, &degree) in self.simplices.iter().zip(&self.degrees) {
            simplex.iter().for_each(|&axis| largest[axis] = degree);
        }
        largest
    }

    /// The values of all polynomials at a point.
    fn values(&self, at: [f64; 3]) -> Vec<f64> {
        let value = |(a, multinomial): (&Exponents, &f64)| {
            let of = |(simplex, &degree): (&&[usize], &usize)| {
                let used: usize = simplex.iter().map(|&axis| a[axis]).sum();
                let sum: f64 = simplex.iter().map(|&axis| at[axis]).sum();
                let powers = simplex.iter().map(|&axis| at[axis].powi(a[axis] as i32));
                powers.product::<f64>() * (1.0 - sum).powi((degree - used) as i32)
            };
            multinomial
                * self
                    .simplices
                    .iter()
                    .zip(&self.degrees)
                    .map(of)
                    .product::<f64>()
        };
        self.exponents
            .iter()
            .zip(&self.multinomials)
            .map(value)
            .collect()
    }
}

fn binomial(n: usize, k: usize) -> f64 {
    (0..k).fold(1.0, |c, i| c * (n - i) as f64 / (i + 1) as f64)
}

/// A derivative of the map: coefficients as differences of two control points, in scaled form.
#[derive(Debug)]
struct Derivative {
    /// Control points to subtract, the factor, and the place in the determinant.
    terms: Vec<(usize, usize, f64, usize)>,
}

/// The map of one kind of cell with one number of nodes.
#[derive(Debug)]
pub struct CurvedMap {
    n_nodes: usize,
    /// Control points of the nodes, row by row.
    control: Vec<f64>,
    derivatives: Vec<Derivative>,
    /// Places of the cross product of the first two derivatives.
    crossed: Vec<usize>,
    determinant: Space,
    /// Places of the coefficients of the determinant, and the size of the array.
    places: Vec<usize>,
    n_places: usize,
    corners: Vec<usize>,
    /// For each edge of a simplex the lines of coefficients along it.
    lines: Vec<Vec<Vec<usize>>>,
    rounding: f64,
}

impl CurvedMap {
    /// The map of cells with more nodes than corners; `None` for kinds and orders that are not checked.
    pub fn new(kind: CellKind, n_nodes: usize) -> Option<Self> {
        let cell = Nodes::of(kind, n_nodes)?;
        let map = Space::new(cell.simplices, cell.degrees.clone());
        let is_pyramid = kind.linear() == Pyramid;
        let dimension = usize::from(kind.dimension());
        let spaces: Vec<Space> = (0..dimension)
            .map(|axis| {
                let owns = |simplex: &&[usize]| simplex.contains(&axis);
                let degrees = cell.simplices.iter().zip(&cell.degrees);
                let lowered = degrees.map(|(simplex, degree)| degree - usize::from(owns(simplex)));
                let mut degrees: Vec<usize> = lowered.collect();
                if is_pyramid && axis < 2 {
                    degrees[2] -= 1;
                }
                Space::new(cell.simplices, degrees)
            })
            .collect();
        let sum = |n: usize| {
            let of = |i: usize| spaces[..n].iter().map(|space| space.degrees[i]).sum();
            Space::new(cell.simplices, (0..cell.simplices.len()).map(of).collect())
        };
        let determinant = sum(dimension);
        let size = determinant.largest().map(|largest| largest + 1);
        let strides = [1, size[0], size[0] * size[1]];
        let index = |a: Exponents| map.exponents.iter().position(|b| *b == a);
        let mut derivatives = Vec::new();
        for (axis, space) in spaces.iter().enumerate() {
            let owner = cell
                .simplices
                .iter()
                .position(|simplex| simplex.contains(&axis))?;
            let degree = cell.degrees[owner] as f64;
            let places = space.places(strides);
            let mut terms = Vec::new();
            for (i, a) in space.exponents.iter().enumerate() {
                let mut next = *a;
                next[axis] += 1;
                // A pyramid's scaled coefficients stay, where the factor `1 - w` is dropped.
                let scaled = if is_pyramid && axis < 2 {
                    let at = cell.degrees[2];
                    space.multinomials[i] / binomial(at - 1, a[2]) * binomial(at, a[2])
                } else {
                    space.multinomials[i]
                };
                terms.push((index(next)?, index(*a)?, degree * scaled, places[i]));
            }
            derivatives.push(Derivative { terms });
        }
        let corners =
            (0..determinant.exponents.len()).filter(|&i| determinant.multinomials[i] == 1.0);
        let is_corner = |a: &Exponents| {
            let pairs = determinant.simplices.iter().zip(&determinant.degrees);
            pairs.into_iter().all(|(simplex, &degree)| {
                simplex.iter().all(|&axis| a[axis] == 0)
                    || simplex.iter().any(|&axis| a[axis] == degree)
            })
        };
        let corners = corners
            .filter(|&i| is_corner(&determinant.exponents[i]))
            .collect();
        let sums = cell
            .control
            .chunks(n_nodes)
            .map(|row| row.iter().map(|x| x.abs()).sum::<f64>());
        let rounding = sums.fold(1.0, f64::max);
        Some(Self {
            n_nodes,
            control: cell.control,
            derivatives,
            crossed: if dimension == 3 {
                sum(2).places(strides)
            } else {
                Vec::new()
            },
            places: determinant.places(strides),
            n_places: size.iter().product(),
            corners,
            lines: lines(&determinant),
            rounding: ROUNDING * rounding,
            determinant,
        })
    }

    /// Proves or refutes a cell whose positive orientation is `sign`.
    pub fn prove(&self, nodes: &[u32], points: &[Vector], sign: i8) -> Proof {
        let (mut coefficients, size) = self.coefficients(nodes, points);
        coefficients.iter_mut().for_each(|c| *c *= f64::from(sign));
        self.decide(coefficients, self.rounding * size)
    }

    /// The least value of the determinant at the corners, and its least coefficient.
    #[cfg(test)]
    pub fn range(&self, nodes: &[u32], points: &[Vector]) -> (f64, f64) {
        let (coefficients, _) = self.coefficients(nodes, points);
        let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
        (
            least(&mut self.corners.iter().map(|&i| coefficients[i])),
            least(&mut coefficients.iter().copied()),
        )
    }

    /// The coefficients of the determinant, and the product of the largest derivatives.
    fn coefficients(&self, nodes: &[u32], points: &[Vector]) -> (Vec<f64>, f64) {
        let origin = points[nodes[0] as usize];
        let at = |i: usize| sub(points[nodes[i] as usize], origin);
        let nodes: Vec<Vector> = (0..self.n_nodes).map(at).collect();
        let point = |row: &[f64]| {
            let pairs = row.iter().zip(&nodes).filter(|(share, _)| **share != 0.0);
            pairs.fold([0.0; 3], |sum: Vector, (share, x)| {
                std::array::from_fn(|k| sum[k] + share * x[k])
            })
        };
        let control: Vec<Vector> = self.control.chunks(self.n_nodes).map(point).collect();
        let mut size = 1.0;
        let derivatives: Vec<Vec<(Vector, usize)>> = self
            .derivatives
            .iter()
            .map(|derivative| {
                let mut largest = 0.0f64;
                let terms = derivative.terms.iter().map(|&(next, this, factor, place)| {
                    let difference = scale(sub(control[next], control[this]), factor);
                    largest = largest.max(norm(difference));
                    (difference, place)
                });
                let terms = terms.collect();
                size *= largest;
                terms
            })
            .collect();
        let mut all = vec![0.0; self.n_places];
        if let [x, y] = &derivatives[..] {
            for (a, i) in x {
                for (b, j) in y {
                    all[i + j] += a[0] * b[1] - a[1] * b[0];
                }
            }
        } else if let [x, y, z] = &derivatives[..] {
            let mut normals = vec![[0.0; 3]; self.n_places];
            for (a, i) in x {
                for (b, j) in y {
                    let normal = cross(*a, *b);
                    (0..3).for_each(|k| normals[i + j][k] += normal[k]);
                }
            }
            for &i in &self.crossed {
                for (c, j) in z {
                    all[i + j] += dot(normals[i], *c);
                }
            }
        }
        let pairs = self.places.iter().zip(&self.determinant.multinomials);
        (
            pairs
                .map(|(&place, multinomial)| all[place] / multinomial)
                .collect(),
            size,
        )
    }

    /// Bisects until every part is positive or a corner is negative.
    fn decide(&self, coefficients: Vec<f64>, bound: f64) -> Proof {
        if coefficients.iter().any(|c| c.is_nan()) {
            return Proof::Inside;
        }
        let mut parts = vec![(coefficients, 0)];
        let mut n_parts = 0;
        let mut worst = Proof::Valid;
        while let Some((c, depth)) = parts.pop() {
            if c.iter().all(|c| *c > bound) {
                continue;
            }
            let least = self
                .corners
                .iter()
                .map(|&i| c[i])
                .fold(f64::INFINITY, f64::min);
            if least < -bound {
                return Proof::Inside;
            }
            n_parts += 1;
            if least <= bound || depth == DEPTH * self.lines.len() || n_parts == MAX_PARTS {
                worst = Proof::Unproven;
                if n_parts == MAX_PARTS {
                    return worst;
                }
                continue;
            }
            let lines = &self.lines[depth % self.lines.len()];
            parts.extend(halves(&c, lines).map(|half| (half, depth + 1)));
        }
        worst
    }
}

/// The coefficients on the two halves of a part, bisected along the lines of coefficients of an edge.
fn halves(c: &[f64], lines: &[Vec<usize>]) -> [Vec<f64>; 2] {
    let mut both = [c.to_vec(), c.to_vec()];
    let mut row = Vec::new();
    for line in lines {
        row.clear();
        row.extend(line.iter().map(|&i| c[i]));
        let n = row.len();
        // De Casteljau: the first values of each level are one half, the last values the other.
        for level in 0..n {
            both[0][line[level]] = row[0];
            both[1][line[n - 1 - level]] = row[n - 1 - level];
            for i in 0..n - 1 - level {
                row[i] = 0.5 * (row[i] + row[i + 1]);
            }
        }
    }
    both
}

/// For each edge of each simplex, the lines of coefficients from its first to its second corner.
fn lines(space: &Space) -> Vec<Vec<Vec<usize>>> {
    let index = |a: &Exponents| space.exponents.iter().position(|b| b == a);
    let mut all = Vec::new();
    for (simplex, &degree) in space.simplices.iter().zip(&space.degrees) {
        // `None` is the corner at the origin of the simplex.
        let corners: Vec<Option<usize>> = std::iter::once(None)
            .chain(simplex.iter().copied().map(Some))
            .collect();
        let of = |a: &Exponents, corner: Option<usize>| match corner {
            Some(axis) => a[axis],
            None => degree - simplex.iter().map(|&axis| a[axis]).sum::<usize>(),
        };
        for (i, &from) in corners.iter().enumerate() {
            for &to in &corners[i + 1..] {
                let starts = space.exponents.iter().filter(|a| of(a, to) == 0);
                let line = |start: &Exponents| {
                    let mut at = *start;
                    let mut line = Vec::new();
                    for step in 0..=of(start, from) {
                        line.extend(index(&at));
                        if step < of(start, from) {
                            if let Some(axis) = from {
                                at[axis] -= 1;
                            }
                            if let Some(axis) = to {
                                at[axis] += 1;
                            }
                        }
                    }
                    line
                };
                all.push(starts.map(line).collect());
            }
        }
    }
    all
}

/// The product of simplices that a cell is, and its control points from its nodes.
struct Nodes {
    simplices: Simplices,
    degrees: Vec<usize>,
    control: Vec<f64>,
}

impl Nodes {
    fn of(kind: CellKind, n_nodes: usize) -> Option<Self> {
        let simplices = match kind.linear() {
            Triangle => TRIANGLE,
            Quadrilateral => SQUARE,
            Tetrahedron => TETRAHEDRON,
            Hexahedron | Pyramid => CUBE,
            Wedge => PRISM,
            _ => return None,
        };
        let full = match kind.linear() {
            Triangle => LagrangeTriangle,
            Quadrilateral => LagrangeQuadrilateral,
            Tetrahedron => LagrangeTetrahedron,
            Hexahedron => LagrangeHexahedron,
            Pyramid => LagrangePyramid,
            _ => LagrangeWedge,
        };
        let second = |kind| lagrange::lattice(kind, 2);
        // The positions of the nodes of the complete cell, its degrees, and its nodes from the nodes of the cell.
        let (places, degrees, nodes) = match kind {
            Triangle6 | Quadrilateral9 | Tetrahedron10 | Hexahedron27 | Wedge18 => {
                (second(full), vec![2; simplices.len()], None)
            }
            Quadrilateral8 | Hexahedron20 | Wedge15 | Pyramid13 => (
                second(full),
                vec![2; simplices.len()],
                Some(serendipity(kind, full)),
            ),
            Triangle7 => (lagrange::lattice(full, 3), vec![3], Some(bubble())),
            QuadraticLinearQuadrilateral => {
                let places = vec![
                    [0, 0, 0],
                    [2, 0, 0],
                    [2, 1, 0],
                    [0, 1, 0],
                    [1, 0, 0],
                    [1, 1, 0],
                ];
                (places, vec![2, 1], None)
            }
            QuadraticLinearWedge => {
                let base = [[0, 0, 0], [2, 0, 0], [0, 2, 0]];
                let middle = [[1, 0, 0], [1, 1, 0], [0, 1, 0]];
                let up = |[i, j, _]: [u16; 3]| [i, j, 1];
                let places = [base, base.map(up), middle, middle.map(up)].concat();
                (places, vec![2, 1], None)
            }
            LagrangeTriangle
            | LagrangeQuadrilateral
            | LagrangeTetrahedron
            | LagrangeHexahedron
            | LagrangeWedge
            | LagrangePyramid
            | BezierTriangle
            | BezierQuadrilateral
            | BezierTetrahedron
            | BezierHexahedron
            | BezierWedge => {
                let order = lagrange::order(kind, n_nodes)
                    .filter(|order| (2..=MAX_ORDER).contains(order))?;
                (
                    lagrange::lattice(kind, order),
                    vec![order; simplices.len()],
                    None,
                )
            }
            _ => return None,
        };
        let space = Space::new(simplices, degrees.clone());
        let n_full = places.len();
        let is_bezier = matches!(
            kind,
            BezierTriangle
                | BezierQuadrilateral
                | BezierTetrahedron
                | BezierHexahedron
                | BezierWedge
        );
        let steps = |places: &[lagrange::LatticePoint]| -> Vec<Exponents> {
            places.iter().map(|place| place.map(usize::from)).collect()
        };
        let control = if kind.linear() == Pyramid {
            let order = degrees[0];
            let n = order as f64;
            let basis = Bergot { order };
            let at_nodes: Vec<f64> = steps(&places)
                .iter()
                .flat_map(|[i, j, k]| {
                    let width = (order - k) as f64;
                    let across = |i: usize| if width > 0.0 { i as f64 / width } else { 0.0 };
                    basis.values([across(*i), across(*j), *k as f64 / n])
                })
                .collect();
            let to_basis = inverse(&at_nodes, n_full)?;
            let at = |a: &Exponents| basis.values(a.map(|i| i as f64 / n));
            let at_places: Vec<f64> = space.exponents.iter().flat_map(at).collect();
            let full = product(&at_places, &to_basis, n_full);
            product(&to_control(&space)?, &full, space.exponents.len())
        } else {
            let order: Vec<usize> = steps(&places)
                .iter()
                .map(|place| space.exponents.iter().position(|a| a == place))
                .collect::<Option<_>>()?;
            let n = space.exponents.len();
            if n != n_full {
                return None;
            }
            let shares = if is_bezier {
                let mut unit = vec![0.0; n * n];
                (0..n).for_each(|i| unit[i * n + i] = 1.0);
                unit
            } else {
                to_control(&space)?
            };
            let mut control = vec![0.0; n * n];
            for row in 0..n {
                for (node, &place) in order.iter().enumerate() {
                    control[row * n + node] = shares[row * n + place];
                }
            }
            control
        };
        let control = match nodes {
            Some(nodes) => product(&control, &nodes, n_full),
            None => control,
        };
        (control.len() == n_nodes * space.exponents.len()).then_some(Self {
            simplices,
            degrees,
            control,
        })
    }
}

/// Control points from values at the lattice of a space, row by row.
fn to_control(space: &Space) -> Option<Vec<f64>> {
    // A product of the matrices of the simplices: each is inverted alone.
    let n = space.exponents.len();
    let mut all = vec![1.0; n * n];
    for (simplex, &degree) in space.simplices.iter().zip(&space.degrees) {
        let own = Space::new(
            match simplex.len() {
                1 => &[&[0]],
                2 => TRIANGLE,
                _ => TETRAHEDRON,
            },
            vec![degree],
        );
        let m = own.exponents.len();
        let at = |a: &Exponents| own.values(a.map(|i| i as f64 / degree as f64));
        let inverted = inverse(&own.exponents.iter().flat_map(at).collect::<Vec<_>>(), m)?;
        let index = |a: &Exponents| {
            let mut part = [0; 3];
            for (to, &axis) in part.iter_mut().zip(*simplex) {
                *to = a[axis];
            }
            own.exponents.iter().position(|b| *b == part)
        };
        let places: Vec<usize> = space.exponents.iter().map(index).collect::<Option<_>>()?;
        for (row, &i) in places.iter().enumerate() {
            for (column, &j) in places.iter().enumerate() {
                all[row * n + column] *= inverted[i * m + j];
            }
        }
    }
    Some(all)
}

/// The nodes of a complete cell of second order from a cell without nodes in faces and inside.
fn serendipity(kind: CellKind, full: CellKind) -> Vec<f64> {
    let places = lagrange::lattice(full, 2);
    let n = kind.n_nodes().unwrap_or_default();
    let mut rows = vec![0.0; places.len() * n];
    for node in 0..n {
        rows[node * n + node] = 1.0;
    }
    for (missing, place) in places.iter().enumerate().skip(n) {
        // A face: its four corners and four edges are in its plane. The middle of a hexahedron: all corners and edges.
        let is_inside = *place == [1, 1, 1] && full == LagrangeHexahedron;
        let faces = kind.faces().iter().filter(|face| face.len() == 4);
        let corners: Vec<usize> = if is_inside || full == LagrangeQuadrilateral {
            (0..kind.n_corners(n)).collect()
        } else {
            let is_centre = |face: &&&[u8]| {
                let sum = |axis: usize| {
                    face.iter()
                        .map(|&i| places[usize::from(i)][axis])
                        .sum::<u16>()
                };
                (0..3).all(|axis| sum(axis) == 4 * place[axis])
            };
            let face = faces.clone().find(is_centre);
            face.map(|face| face.iter().map(|&i| usize::from(i)).collect())
                .unwrap_or_default()
        };
        for &corner in &corners {
            rows[missing * n + corner] = -0.25;
        }
        for (edge, ends) in kind.edges().iter().enumerate() {
            let is_own = ends.iter().all(|&end| corners.contains(&usize::from(end)));
            let node = kind.n_corners(n) + edge;
            if is_own {
                rows[missing * n + node] = if is_inside { 0.25 } else { 0.5 };
            }
        }
    }
    rows
}

/// The nodes of a triangle of third order from the seven nodes of one of second order with a node inside.
fn bubble() -> Vec<f64> {
    let mut rows = Vec::new();
    for place in lagrange::lattice(LagrangeTriangle, 3) {
        if place[0] == 1 && place[1] == 1 {
            rows.extend([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
            continue;
        }
        let [s, t] = [f64::from(place[0]) / 3.0, f64::from(place[1]) / 3.0];
        let r = 1.0 - s - t;
        rows.extend([
            r * (2.0 * r - 1.0),
            s * (2.0 * s - 1.0),
            t * (2.0 * t - 1.0),
        ]);
        rows.extend([4.0 * r * s, 4.0 * s * t, 4.0 * t * r, 0.0]);
    }
    rows
}

/// The functions of a pyramid in `(u, v, w)`, orthogonal so that their matrix is well conditioned.
struct Bergot {
    order: usize,
}

impl Bergot {
    fn values(&self, [u, v, w]: [f64; 3]) -> Vec<f64> {
        let mut values = Vec::new();
        for i in 0..=self.order {
            for j in 0..=self.order {
                let most = i.max(j);
                for k in 0..=self.order - most {
                    let alpha = 2.0 * most as f64 + 2.0;
                    let along = jacobi(k, alpha, 2.0 * w - 1.0) * (1.0 - w).powi(most as i32);
                    values.push(
                        jacobi(i, 0.0, 2.0 * u - 1.0) * jacobi(j, 0.0, 2.0 * v - 1.0) * along,
                    );
                }
            }
        }
        values
    }
}

/// The Jacobi polynomial `P_n^(alpha, 0)`.
fn jacobi(n: usize, alpha: f64, x: f64) -> f64 {
    let mut last = 1.0;
    let mut this = 0.5 * (alpha + (alpha + 2.0) * x);
    if n == 0 {
        return last;
    }
    for k in 2..=n {
        let k = k as f64;
        let s = 2.0 * k + alpha;
        let a = 2.0 * k * (k + alpha) * (s - 2.0);
        let b = (s - 1.0) * (s * (s - 2.0) * x + alpha * alpha);
        let c = 2.0 * (k + alpha - 1.0) * (k - 1.0) * s;
        let next = (b * this - c * last) / a;
        last = this;
        this = next;
    }
    this
}

/// The product of a matrix with rows of `n` and one of `n` rows.
fn product(a: &[f64], b: &[f64], n: usize) -> Vec<f64> {
    let columns = b.len() / n;
    let mut all = vec![0.0; a.len() / n * columns];
    for (row, to) in a.chunks(n).zip(all.chunks_mut(columns)) {
        for (factor, from) in row.iter().zip(b.chunks(columns)) {
            to.iter_mut()
                .zip(from)
                .for_each(|(to, from)| *to += factor * from);
        }
    }
    all
}

/// The inverse of a matrix of `n` rows, with pivots; `None` where it is singular.
fn inverse(matrix: &[f64], n: usize) -> Option<Vec<f64>> {
    let mut a = matrix.to_vec();
    let mut b = vec![0.0; n * n];
    (0..n).for_each(|i| b[i * n + i] = 1.0);
    for column in 0..n {
        let size = |row: &usize| a[row * n + column].abs();
        let pivot = (column..n).max_by(|i, j| size(i).total_cmp(&size(j)))?;
        if size(&pivot) < 1e-12 {
            return None;
        }
        for k in 0..n {
            a.swap(column * n + k, pivot * n + k);
            b.swap(column * n + k, pivot * n + k);
        }
        let factor = 1.0 / a[column * n + column];
        for k in 0..n {
            a[column * n + k] *= factor;
            b[column * n + k] *= factor;
        }
        for row in (0..n).filter(|row| *row != column) {
            let factor = a[row * n + column];
            if factor != 0.0 {
                for k in 0..n {
                    a[row * n + k] -= factor * a[column * n + k];
                    b[row * n + k] -= factor * b[column * n + k];
                }
            }
        }
    }
    Some(b)
}

#[cfg(test)]
mod tests {
    use super::*;

    const KINDS: [(CellKind, CellKind); 16] = [
        (Triangle6, LagrangeTriangle),
        (Triangle7, LagrangeTriangle),
        (Quadrilateral8, LagrangeQuadrilateral),
        (Quadrilateral9, LagrangeQuadrilateral),
        (Tetrahedron10, LagrangeTetrahedron),
        (Hexahedron20, LagrangeHexahedron),
        (Hexahedron27, LagrangeHexahedron),
        (Wedge15, LagrangeWedge),
        (Wedge18, LagrangeWedge),
        (Pyramid13, LagrangePyramid),
        (LagrangeTriangle, LagrangeTriangle),
        (LagrangeQuadrilateral, LagrangeQuadrilateral),
        (LagrangeTetrahedron, LagrangeTetrahedron),
        (LagrangeHexahedron, LagrangeHexahedron),
        (LagrangeWedge, LagrangeWedge),
        (LagrangePyramid, LagrangePyramid),
    ];

    /// The nodes of a cell at the places of its lattice, mapped.
    fn cell(
        kind: CellKind,
        full: CellKind,
        order: usize,
        map: impl Fn(Vector) -> Vector,
    ) -> (Vec<u32>, Vec<Vector>) {
        let places = lagrange::lattice(full, order);
        let n = kind.n_nodes().unwrap_or(places.len());
        let mut at: Vec<Vector> = places
            .iter()
            .map(|p| p.map(|i| f64::from(i) / order as f64))
            .collect();
        if kind == Triangle7 {
            at.push([1.0 / 3.0, 1.0 / 3.0, 0.0]);
        }
        at.truncate(n);
        ((0..n as u32).collect(), at.into_iter().map(map).collect())
    }

    fn orders(kind: CellKind) -> std::ops::RangeInclusive<usize> {
        if kind.n_nodes().is_some() {
            2..=2
        } else {
            2..=4
        }
    }

    #[test]
    fn the_determinant_of_an_affine_map_is_the_same_everywhere() {
        let map = |[x, y, z]: Vector| [2.0 * x + 0.3 * y, y - 0.2 * x + 0.1 * z, z + 0.4 * x + 5.0];
        for (kind, full) in KINDS {
            let determinant = if kind.dimension() == 2 {
                2.06
            } else {
                2.0 * 1.0 + 0.06 - 0.04 * 2.0 - 0.3 * 0.0 + 0.012
            };
            for order in orders(kind) {
                let (nodes, points) = cell(kind, full, order, map);
                let curved = CurvedMap::new(kind, nodes.len()).expect("a map");
                let (corners, all) = curved.range(&nodes, &points);
                assert!(
                    (corners - all).abs() < 1e-9 * determinant,
                    "{kind:?} {order}: {corners} {all}"
                );
                assert_eq!(
                    curved.prove(&nodes, &points, 1),
                    Proof::Valid,
                    "{kind:?} {order}"
                );
                assert_eq!(
                    curved.prove(&nodes, &points, -1),
                    Proof::Inside,
                    "{kind:?} {order}"
                );
            }
        }
    }

    #[test]
    fn a_straight_cell_has_the_orientation_of_its_corners() {
        for (kind, full) in KINDS {
            for order in orders(kind) {
                let (nodes, points) = cell(kind, full, order, |x| x);
                let mut mesh = azimesh_io::Mesh {
                    points,
                    ..azimesh_io::Mesh::default()
                };
                mesh.cells.push(kind, &nodes);
                assert_eq!(
                    crate::flaws(&mesh),
                    crate::Flaws::default(),
                    "{kind:?} {order}"
                );
                let reference = crate::Reference::new(&mesh);
                assert!(
                    reference.is_valid(0) && reference.sign(0) == 1,
                    "{kind:?} {order}"
                );
            }
        }
    }

    #[test]
    fn a_map_that_folds_between_its_corners_is_found() {
        // dx/dx = 1 + a (3 x^2 - 3 x + ..): positive at the ends, negative in the middle for a large `a`.
        let folded = |a: f64| move |[x, y, z]: Vector| [x + a * x * (x - 0.5) * (x - 1.0), y, z];
        for (kind, full) in KINDS
            .into_iter()
            .filter(|(kind, _)| kind.n_nodes().is_none())
        {
            for (a, expected) in [(3.0, Proof::Valid), (5.0, Proof::Inside)] {
                let (nodes, points) = cell(kind, full, 3, folded(a));
                let curved = CurvedMap::new(kind, nodes.len()).expect("a map");
                assert_eq!(curved.prove(&nodes, &points, 1), expected, "{kind:?} {a}");
            }
        }
    }

    #[test]
    fn second_order_cells_fold_at_a_corner_where_a_node_is_past_a_quarter() {
        for (kind, full) in KINDS
            .into_iter()
            .filter(|(kind, _)| kind.n_nodes().is_some())
        {
            for (x, expected) in [(0.3, Proof::Valid), (0.2, Proof::Inside)] {
                let (nodes, mut points) = cell(kind, full, 2, |x| x);
                // The node in the middle of the first edge.
                let middle = kind.n_corners(nodes.len());
                assert_eq!(points[middle], [0.5, 0.0, 0.0], "{kind:?}");
                points[middle] = [x, 0.0, 0.0];
                let curved = CurvedMap::new(kind, nodes.len()).expect("a map");
                assert_eq!(curved.prove(&nodes, &points, 1), expected, "{kind:?} {x}");
            }
        }
    }
}
