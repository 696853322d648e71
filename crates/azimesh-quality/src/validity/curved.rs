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

mod face;
mod samples;

pub use face::FaceTerms;
pub use samples::Samples;

use super::Proof;
use azimesh_core::geometry::vector::{Vector, add, cross, distance, dot, scale, sub};
use azimesh_io::mesh::CellKind::{self, *};
use azimesh_io::mesh::lagrange;
use std::cell::RefCell;
use std::sync::{Arc, OnceLock};

/// The highest order that is checked.
const MAX_ORDER: usize = 10;
/// Bisections of each edge at most, and parts of a cell at most.
const DEPTH: usize = 6;
const MAX_PARTS: usize = 4096;
/// Rounding of a sum, as a part of the sum of its largest terms.
const ROUNDING: f64 = 16.0 * f64::EPSILON;
/// Gap between the bounds of the least Jacobian, as a part of it.
const RELATIVE: f64 = 1e-3;
/// Largest difference of derivatives that are the same but for rounding.
const AFFINE: f64 = 1e-12;

/// Exponents of the reference coordinates.
type Exponents = [usize; 3];

/// Coordinates of each simplex of a product.
type Simplices = &'static [&'static [usize]];

const INTERVAL: Simplices = &[&[0]];
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

/// A derivative of the map by one coordinate.
#[derive(Debug)]
struct Derivative {
    space: Space,
    /// For each coefficient the control points to subtract, and the factor; none for the normal of a plane cell.
    terms: Vec<(usize, usize, f64)>,
    /// The multinomial of each coefficient, and its place in the determinant.
    places: Vec<(f64, usize)>,
}

/// The map of one kind of cell with one number of nodes.
#[derive(Debug)]
pub struct CurvedMap {
    kind: CellKind,
    n_nodes: usize,
    order: usize,
    /// Few and many.
    samples: [OnceLock<Arc<Samples>>; 2],
    /// Nodes and their shares of each control point.
    control: Vec<Vec<(usize, f64)>>,
    derivatives: [Derivative; 3],
    /// Places of the cross product of the first two derivatives.
    crossed: Vec<usize>,
    determinant: Space,
    /// Places of the coefficients of the determinant, and the size of the array.
    places: Vec<usize>,
    n_places: usize,
    corners: Vec<usize>,
    /// For each edge of a simplex the lines of coefficients along it.
    lines: Vec<Vec<Vec<usize>>>,
    /// Largest factors of a node in the coefficients of each derivative.
    factors: [f64; 3],
    /// Volume of the reference cell.
    volume: f64,
    /// The scaled Jacobian of the ideal cell is 1 with this factor.
    ideal: f64,
    /// The polynomials of each derivative at the points where the scaled Jacobian is sampled.
    lattice: Vec<[Vec<f64>; 3]>,
}

/// Arrays for one cell, kept for the next.
#[derive(Debug, Default)]
struct Workspace {
    /// Largest distance of a node from the first one.
    extent: f64,
    control: Vec<Vector>,
    /// Coefficients of the derivatives.
    slopes: [Vec<Vector>; 3],
    normals: Vec<Vector>,
    products: Vec<f64>,
    /// Coefficients of the determinant.
    coefficients: Vec<f64>,
}

thread_local! {
    static WORKSPACE: RefCell<Workspace> = RefCell::default();
}

impl CurvedMap {
    /// The map of a kind of cell with so many nodes; `None` for kinds and orders that are not checked.
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
        let crossed = sum(2).places(strides);
        for (axis, space) in spaces.into_iter().enumerate() {
            let owner = cell
                .simplices
                .iter()
                .position(|simplex| simplex.contains(&axis))?;
            let degree = cell.degrees[owner] as f64;
            let mut terms = Vec::new();
            for a in &space.exponents {
                let mut next = *a;
                next[axis] += 1;
                // Scaled coefficients stay where the factor `1 - w` of a pyramid is dropped.
                let dropped = if is_pyramid && axis < 2 {
                    let at = cell.degrees[2];
                    binomial(at, a[2]) / binomial(at - 1, a[2])
                } else {
                    1.0
                };
                terms.push((index(next)?, index(*a)?, degree * dropped));
            }
            let places = space.places(strides);
            let multinomials = space.multinomials.iter().copied();
            derivatives.push(Derivative {
                terms,
                places: multinomials.zip(places).collect(),
                space,
            });
        }
        if dimension == 2 {
            derivatives.push(Derivative {
                space: Space::new(&[], Vec::new()),
                terms: Vec::new(),
                places: vec![(1.0, 0)],
            });
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
        let most = sums.fold(1.0, f64::max);
        let factors = std::array::from_fn(|axis: usize| {
            let terms = derivatives[axis].terms.iter();
            2.0 * most * terms.fold(0.0, |most: f64, term| most.max(term.2.abs()))
        });
        let control = cell.control.chunks(n_nodes).map(|row| {
            let shares = row.iter().copied().enumerate();
            shares.filter(|(_, share)| *share != 0.0).collect()
        });
        let (volume, ideal) = match kind.linear() {
            Triangle => (1.0 / 2.0, 2.0 / 3f64.sqrt()),
            Tetrahedron => (1.0 / 6.0, 2f64.sqrt()),
            Wedge => (1.0 / 2.0, 2.0 / 3f64.sqrt()),
            Pyramid => (1.0 / 3.0, 2f64.sqrt()),
            _ => (1.0, 1.0),
        };
        let degrees: Vec<usize> = cell.degrees.iter().map(|degree| 2 * degree).collect();
        let sample = |a: &Exponents| {
            let mut at = [0.0; 3];
            for (simplex, &degree) in cell.simplices.iter().zip(&degrees) {
                for &axis in *simplex {
                    at[axis] = a[axis] as f64 / degree as f64;
                }
            }
            std::array::from_fn(|axis: usize| derivatives[axis].space.values(at))
        };
        let lattice = Space::new(cell.simplices, degrees.clone()).exponents;
        Some(Self {
            kind,
            n_nodes,
            order: cell.degrees.iter().copied().fold(1, usize::max),
            samples: Default::default(),
            control: control.collect(),
            lattice: lattice.iter().map(sample).collect(),
            derivatives: derivatives.try_into().ok()?,
            crossed,
            places: determinant.places(strides),
            n_places: size.iter().product(),
            corners,
            lines: lines(&determinant),
            factors,
            volume,
            ideal,
            determinant,
        })
    }

    /// Proves or refutes a cell whose positive orientation is `sign`.
    pub fn prove(&self, nodes: &[u32], points: &[Vector], sign: i8) -> Proof {
        WORKSPACE.with_borrow_mut(|work| {
            self.slopes(nodes, points, work);
            let bound = self.coefficients(sign, work);
            self.decide(&work.coefficients, bound)
        })
    }

    /// The least Jacobian of a cell whose positive orientation is `sign`, and its least scaled Jacobian:
    ///
    /// ```text
    /// jacobian = min over s of det(dx/ds) |S| / |V|,    S the reference cell
    /// scaled   = min over s of c det(dx/ds) / product over the simplices of the lengths of its edges
    /// ```
    ///
    /// `V`, the `volume`, is that of the cell with straight edges; `dx/ds` maps the edges of a simplex, and the largest product of
    /// those that meet at one of its corners counts. The first is a lower bound, at most 1/1000 of the value below it. The second is the
    /// least of a sample at the nodes of a lattice of twice the order; at most 0 if the first is.
    pub fn least(&self, nodes: &[u32], points: &[Vector], sign: i8, volume: f64) -> [f64; 2] {
        WORKSPACE.with_borrow_mut(|work| {
            self.slopes(nodes, points, work);
            let samples = if is_affine(&work.slopes) {
                &self.lattice[..1]
            } else {
                &self.lattice
            };
            let mut scaled = f64::INFINITY;
            let mut jacobian = f64::INFINITY;
            for weights in samples {
                let slope = |axis: usize| {
                    let pairs = weights[axis].iter().zip(&work.slopes[axis]);
                    pairs.fold([0.0; 3], |sum, (weight, slope)| {
                        add(sum, scale(*slope, *weight))
                    })
                };
                let axes: [Vector; 3] = std::array::from_fn(slope);
                let determinant = f64::from(sign) * dot(cross(axes[0], axes[1]), axes[2]);
                let lengths = |simplex: &&[usize]| largest_product(simplex, &axes);
                let simplices = self.determinant.simplices.iter();
                let product = simplices.map(lengths).product::<f64>().sqrt();
                let value = if product > 0.0 {
                    self.ideal * determinant / product
                } else {
                    determinant
                };
                scaled = scaled.min(value);
                jacobian = jacobian.min(determinant);
            }
            if samples.len() > 1 {
                self.coefficients(sign, work);
                let [low, high] =
                    self.bounds(&work.coefficients, 1e-6 * volume.abs() / self.volume);
                jacobian = low;
                if high <= 0.0 {
                    scaled = scaled.min(0.0);
                }
            }
            let size = volume.abs() / self.volume;
            let jacobian = if size > 0.0 {
                jacobian / size
            } else {
                f64::NAN
            };
            [jacobian, scaled]
        })
    }

    /// The least value of the determinant at the corners, and its least coefficient.
    #[cfg(test)]
    pub fn range(&self, nodes: &[u32], points: &[Vector]) -> (f64, f64) {
        let mut work = Workspace::default();
        self.slopes(nodes, points, &mut work);
        self.coefficients(1, &mut work);
        let corners = self.corners.iter().map(|&i| work.coefficients[i]);
        (
            corners.fold(f64::INFINITY, f64::min),
            least(&work.coefficients),
        )
    }

    /// Computes the coefficients of the derivatives.
    fn slopes(&self, nodes: &[u32], points: &[Vector], work: &mut Workspace) {
        let origin = points[nodes[0] as usize];
        let point = |row: &Vec<(usize, f64)>| {
            row.iter().fold([0.0; 3], |sum, &(node, share)| {
                let x = sub(points[nodes[node] as usize], origin);
                add(sum, scale(x, share))
            })
        };
        let distances = nodes
            .iter()
            .map(|&node| distance(points[node as usize], origin));
        work.extent = distances.fold(0.0, f64::max);
        work.control.clear();
        work.control.extend(self.control.iter().map(point));
        for (derivative, slopes) in self.derivatives.iter().zip(&mut work.slopes) {
            let terms = derivative.terms.iter();
            let terms = terms.map(|&(next, this, factor)| {
                scale(sub(work.control[next], work.control[this]), factor)
            });
            slopes.clear();
            slopes.extend(terms);
            if slopes.is_empty() {
                slopes.push([0.0, 0.0, 1.0]);
            }
        }
    }

    /// Computes the coefficients of the determinant, times `sign`; returns a bound of their rounding.
    fn coefficients(&self, sign: i8, work: &mut Workspace) -> f64 {
        let zeros = |of: &mut Vec<f64>| {
            of.clear();
            of.resize(self.n_places, 0.0);
        };
        zeros(&mut work.products);
        work.normals.clear();
        work.normals.resize(self.n_places, [0.0; 3]);
        let [x, y, z] = [0, 1, 2].map(|axis| {
            let places = self.derivatives[axis].places.iter();
            let scaled = places.zip(&work.slopes[axis]);
            scaled.map(|(&(multinomial, place), slope)| (scale(*slope, multinomial), place))
        });
        for (a, i) in x {
            for (b, j) in y.clone() {
                let normal = &mut work.normals[i + j];
                *normal = add(*normal, cross(a, b));
            }
        }
        for (c, j) in z {
            for &i in &self.crossed {
                work.products[i + j] += dot(work.normals[i], c);
            }
        }
        let pairs = self.places.iter().zip(&self.determinant.multinomials);
        let sign = f64::from(sign);
        let values = pairs.map(|(&place, multinomial)| sign * work.products[place] / multinomial);
        work.coefficients.clear();
        work.coefficients.extend(values);
        let largest = |slopes: &Vec<Vector>| {
            let squares = slopes.iter().map(|slope| dot(*slope, *slope));
            squares.fold(0.0, f64::max).sqrt()
        };
        let [x, y, z] = std::array::from_fn(|axis: usize| largest(&work.slopes[axis]));
        let [a, b, c] = self.factors.map(|factor| factor * work.extent);
        ROUNDING * (x * y * z + a * y * z + x * b * z + x * y * c)
    }

    /// A lower bound of the least value of the determinant, and a value that it has.
    fn bounds(&self, coefficients: &[f64], tolerance: f64) -> [f64; 2] {
        let mut parts = vec![(coefficients.to_vec(), 0)];
        let mut n_parts = 0;
        let [mut low, mut high] = [f64::INFINITY; 2];
        while let Some((c, depth)) = parts.pop() {
            n_parts += 1;
            let corners = self.corners.iter().map(|&i| c[i]);
            high = corners.fold(high, f64::min);
            let own = least(&c);
            let is_far = own < high - RELATIVE * high.abs() - tolerance;
            if is_far && depth < DEPTH * self.lines.len() && n_parts < MAX_PARTS {
                parts.extend(self.halves(&c).map(|half| (half, depth + 1)));
            } else {
                low = low.min(own);
            }
        }
        [low, high]
    }

    /// The coefficients on the two halves of a part, bisected along the edge where they bend most; the half with the least one last.
    fn halves(&self, c: &[f64]) -> [Vec<f64>; 2] {
        let bend = |lines: &Vec<Vec<usize>>| {
            let of = |line: &Vec<usize>| {
                let bends = line.windows(3).map(|i| c[i[0]] - 2.0 * c[i[1]] + c[i[2]]);
                bends.fold(0.0, |most: f64, bend| most.max(bend.abs()))
            };
            lines.iter().map(of).fold(0.0, f64::max)
        };
        let bends = self.lines.iter().map(|lines| (bend(lines), lines));
        let most = bends.max_by(|a, b| a.0.total_cmp(&b.0));
        let mut both = most.map(|(_, lines)| halves(c, lines)).unwrap_or_default();
        if least(&both[0]) < least(&both[1]) {
            both.reverse();
        }
        both
    }

    /// Bisects until every part is positive or a corner is negative.
    fn decide(&self, coefficients: &[f64], bound: f64) -> Proof {
        if coefficients.iter().all(|c| *c > bound) {
            return Proof::Valid;
        }
        if coefficients.iter().any(|c| c.is_nan()) {
            return Proof::Inside;
        }
        let mut parts = vec![(coefficients.to_vec(), 0)];
        let mut n_parts = 0;
        let mut worst = Proof::Valid;
        while let Some((c, depth)) = parts.pop() {
            let lowest = least(&c);
            if lowest > bound {
                continue;
            }
            if self.corners.iter().any(|&i| c[i] < -bound) {
                return Proof::Inside;
            }
            n_parts += 1;
            if lowest >= -bound || depth == DEPTH * self.lines.len() {
                worst = Proof::Unproven;
            } else if n_parts == MAX_PARTS {
                return Proof::Unproven;
            } else {
                parts.extend(self.halves(&c).map(|half| (half, depth + 1)));
            }
        }
        worst
    }
}

/// The least of some coefficients.
fn least(coefficients: &[f64]) -> f64 {
    coefficients.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Returns whether the derivatives are the same everywhere.
fn is_affine(slopes: &[Vec<Vector>; 3]) -> bool {
    slopes.iter().all(|slopes| {
        let first = slopes[0];
        let off = |slope: &Vector| {
            let off = sub(*slope, first);
            dot(off, off) <= AFFINE * AFFINE * dot(first, first)
        };
        slopes.iter().all(off)
    })
}

/// The largest product of the squared lengths of the edges of a simplex at one of its corners; `axes` are its edges at the first.
fn largest_product(simplex: &[usize], axes: &[Vector; 3]) -> f64 {
    let square = |x: Vector| dot(x, x);
    let first: f64 = simplex.iter().map(|&i| square(axes[i])).product();
    if simplex.len() == 1 {
        return first;
    }
    let others = simplex.iter().map(|&i| {
        let to = |&j: &usize| match i == j {
            true => square(axes[i]),
            false => square(sub(axes[j], axes[i])),
        };
        simplex.iter().map(to).product()
    });
    others.fold(first, f64::max)
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
    /// Places of the nodes of the complete cell.
    places: Vec<Exponents>,
}

impl Nodes {
    fn of(kind: CellKind, n_nodes: usize) -> Option<Self> {
        let simplices = match kind.linear() {
            Line => INTERVAL,
            Triangle => TRIANGLE,
            Quadrilateral => SQUARE,
            Tetrahedron => TETRAHEDRON,
            Hexahedron | Pyramid => CUBE,
            Wedge => PRISM,
            _ => return None,
        };
        let full = match kind.linear() {
            Line => LagrangeCurve,
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
            Triangle | Quadrilateral | Tetrahedron | Hexahedron | Wedge | Pyramid => {
                (lagrange::lattice(full, 1), vec![1; simplices.len()], None)
            }
            Line3 | Triangle6 | Quadrilateral9 | Tetrahedron10 | Hexahedron27 | Wedge18 => {
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
            CubicLine => (lagrange::lattice(full, 3), vec![3], None),
            LagrangeCurve
            | LagrangeTriangle
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
            places: steps(&places),
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
                let volume = corners * curved.volume;
                let [jacobian, _] = curved.least(&nodes, &points, 1, volume);
                assert!(
                    (jacobian - 1.0).abs() < 1e-9,
                    "{kind:?} {order}: {jacobian}"
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
    fn the_least_jacobian_is_where_the_map_says() {
        // dx/dx = 1 + a (3 x^2 - 3 x + 1/2): least at 1/2, where it is 1 - a / 4.
        let map = |[x, y, z]: Vector| [x + 2.0 * x * (x - 0.5) * (x - 1.0), y, z];
        for (kind, full) in KINDS
            .into_iter()
            .filter(|(kind, _)| kind.n_nodes().is_none())
        {
            let (nodes, points) = cell(kind, full, 3, map);
            let curved = CurvedMap::new(kind, nodes.len()).expect("a map");
            let [jacobian, scaled] = curved.least(&nodes, &points, 1, curved.volume);
            assert!((0.499..0.500001).contains(&jacobian), "{kind:?} {jacobian}");
            assert!((-1.0..1.0).contains(&scaled), "{kind:?} {scaled}");
            let [mirrored, _] = curved.least(&nodes, &points, -1, curved.volume);
            assert!(mirrored < -1.0, "{kind:?} {mirrored}");
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
