//! The cells at a plane at every frame: the data of `cut.js`, in which the browser cuts and draws them.
//!
//! Coordinates are those of the plane: to the right, upward, and in 3D along the normal. A position is the one in the reference mesh
//! and a few modes of the motion, so that further frames need few bytes.

use super::cut::{Cut, Flat, Plane};
use super::html::{count, packed, packed_numbers};
use super::scene::Corner;
use super::view::View;
use crate::record::BodyRecord;
use azimesh_core::error::Result;
use azimesh_core::geometry::curve;
use azimesh_core::geometry::vector::{Vector, sub};
use azimesh_core::numbers::short;
use azimesh_io::mesh::sides::for_each_side;
use azimesh_io::mesh::{CellRef, Mesh};
use azimesh_rbf::modes::{Form, Modes};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Largest number of cells: of more, those nearest to the bodies are kept.
const CELLS: usize = 50_000;
/// Accuracy of positions in half widths of the window, and the number of modes from which on it is less.
const ACCURACY: f64 = 1e-4;
const MODES: usize = 16;
/// Colours from 0 to 1.
const COLOURS: u8 = 16;

/// Returns the class of the style sheet for a quality: 0 for NaN, from 1 for a good cell to 16 for a bad one, 17 for an
/// inverted one. A worse cell is drawn over a better one.
pub fn colour(quality: f64) -> u8 {
    if quality.is_nan() {
        0
    } else if quality <= 0.0 {
        COLOURS + 1
    } else {
        COLOURS - ((quality * f64::from(COLOURS)) as u8).min(COLOURS - 1)
    }
}

/// The sides of a cell in nodes of its own; one side of a cell that is drawn as it is.
type Shape = Vec<Vec<u32>>;

/// Cells, or the faces of a boundary: the shape of each, and their vertices.
#[derive(Debug, Default)]
struct Group {
    name: String,
    is_body: bool,
    shapes: Vec<u32>,
    nodes: Vec<u32>,
}

/// Cells and boundaries at a plane, and their state at each frame. The first frame is the reference mesh.
pub struct Slice {
    cells: Vec<usize>,
    n_found: usize,
    is_solid: bool,
    vertices: Vec<Corner>,
    rest: Vec<Vector>,
    shapes: BTreeMap<Shape, u32>,
    groups: Vec<Group>,
    /// Displacements of the vertices.
    moved: Vec<Vec<[f32; 3]>>,
    /// Colours of the cells, as changes since the frame before.
    colours: Vec<u8>,
    last_colours: Vec<u8>,
    frames: Vec<Value>,
}

impl Slice {
    /// Prepares the slice of these cells of the reference mesh: those that are cut at some frame.
    pub fn new(mesh: &Mesh, view: &View, bodies: &[BodyRecord], found: Vec<usize>) -> Self {
        let n_found = found.len();
        let cells = nearest(mesh, view, bodies, found);
        let mut corners = BTreeMap::new();
        for &cell in &cells {
            for (place, &node) in mesh.cells.get(cell).nodes.iter().enumerate() {
                corners.entry(node).or_insert(Corner::new(cell, place));
            }
        }
        let corners: Vec<(u32, Corner)> = corners.into_iter().collect();
        let points = corners.iter().map(|(_, corner)| corner.position(mesh));
        let order = curve::order(&points.collect::<Vec<_>>());
        let mut index = vec![u32::MAX; mesh.points.len()];
        for (at, &vertex) in (0..).zip(&order) {
            index[corners[vertex as usize].0 as usize] = at;
        }
        let vertices = order.iter().map(|&vertex| corners[vertex as usize].1);
        let vertices: Vec<Corner> = vertices.collect();
        let mut slice = Self {
            rest: vertices
                .iter()
                .map(|x| view.plane.place(x.position(mesh)))
                .collect(),
            last_colours: vec![0; cells.len()],
            is_solid: mesh.dimension() == 3,
            n_found,
            cells,
            vertices,
            shapes: BTreeMap::new(),
            groups: Vec::new(),
            moved: Vec::new(),
            colours: Vec::new(),
            frames: Vec::new(),
        };
        let cells = slice.cells.clone();
        slice.add_group(mesh, "cells", false, &index, cells.into_iter());
        for body in bodies {
            let tags = mesh
                .boundary_tags()
                .filter(|tag| body.tags.contains(&tag.name));
            let faces = tags.flat_map(|tag| tag.cells.iter());
            slice.add_group(mesh, &body.name, true, &index, faces);
        }
        let is_free = |name: &String| !bodies.iter().any(|body| body.tags.contains(name));
        let others = mesh.boundary_tags().filter(|tag| is_free(&tag.name));
        let faces = others.flat_map(|tag| tag.cells.iter());
        slice.add_group(mesh, "other boundaries", false, &index, faces);
        slice
    }

    /// Adds those cells all of whose nodes are vertices.
    fn add_group(
        &mut self,
        mesh: &Mesh,
        name: &str,
        is_body: bool,
        index: &[u32],
        cells: impl Iterator<Item = usize>,
    ) {
        let name = name.to_owned();
        let mut group = Group {
            name,
            is_body,
            ..Group::default()
        };
        for cell in cells {
            let cell = mesh.cells.get(cell);
            let mut nodes: Vec<u32> = Vec::new();
            let sides = sides(mesh, &cell).into_iter().map(|side| {
                let of = |node: u32| {
                    let node = index[node as usize];
                    nodes
                        .iter()
                        .position(|known| *known == node)
                        .unwrap_or_else(|| {
                            nodes.push(node);
                            nodes.len() - 1
                        }) as u32
                };
                side.into_iter().map(of).collect()
            });
            let shape: Shape = sides.collect();
            if nodes.contains(&u32::MAX) {
                continue;
            }
            let next = self.shapes.len() as u32;
            group.shapes.push(*self.shapes.entry(shape).or_insert(next));
            group.nodes.extend(nodes);
        }
        self.groups.push(group);
    }

    /// Adds a frame: the mesh, the plane in it, the quality of all its cells, and what else the script needs.
    pub fn add(&mut self, mesh: &Mesh, plane: &Plane, quality: &[f64], frame: Value) {
        let places = self
            .vertices
            .iter()
            .map(|vertex| plane.place(vertex.position(mesh)));
        let moved = places
            .zip(&self.rest)
            .map(|(x, rest)| sub(x, *rest).map(|x| x as f32));
        self.moved.push(moved.collect());
        for (&cell, last) in self.cells.iter().zip(&mut self.last_colours) {
            let now = colour(quality[cell]);
            self.colours.push(now.wrapping_sub(*last));
            *last = now;
        }
        self.frames.push(frame);
    }

    /// Factors the displacements; to a lower accuracy where that takes many modes.
    fn modes(&self, half: f64) -> Result<Modes> {
        let mut limit = ACCURACY * half;
        loop {
            let (n, frames) = (self.vertices.len(), self.moved.len());
            let modes =
                Modes::of_displacements(n, frames, limit, Form::Scalar, |frame, nodes, out| {
                    for (x, moved) in out.iter_mut().zip(&self.moved[frame][nodes]) {
                        *x = moved.map(f64::from);
                    }
                })?;
            if modes.n_modes <= MODES || limit > 0.1 * half {
                return Ok(modes);
            }
            limit *= 4.0;
        }
    }

    /// Writes the data of the script, and a sentence on the cells.
    pub fn data(&self, view: &View, unit: &str) -> Result<(Value, String)> {
        let window = view.window(&view.outline);
        let modes = self.modes(window.half[0])?;
        let [right, up] = window.centre;
        let n_axes = if self.is_solid { 3 } else { 2 };
        let rest = (0..n_axes).flat_map(|axis| {
            let from = [right, up, 0.0][axis];
            self.rest.iter().map(move |x| (x[axis] - from) as f32)
        });
        let values = (0..modes.n_modes).flat_map(|mode| {
            let of_mode = modes.values.iter().skip(mode).step_by(modes.n_modes);
            of_mode.map(|value| *value as f32)
        });
        let coefficients = modes.coefficients.iter().map(|value| *value as f32);
        let mut shapes: Vec<_> = self.shapes.iter().collect();
        shapes.sort_by_key(|(_, at)| **at);
        let groups = self.groups.iter().map(|group| {
            json!({
                "name": group.name, "body": group.is_body,
                "shapes": packed_numbers(group.shapes.iter().copied()), "nodes": packed_numbers(group.nodes.iter().copied()),
            })
        });
        let data = json!({
            "axes": view.axes, "centre": window.centre, "half": window.half[0], "vertices": self.rest.len(), "modes": modes.n_modes,
            "rest": packed_numbers(rest.map(f32::to_bits)), "values": packed_numbers(values.map(f32::to_bits)),
            "coefficients": packed_numbers(coefficients.map(f32::to_bits)),
            "shapes": shapes.iter().map(|(shape, _)| shape).collect::<Vec<_>>(),
            "groups": groups.collect::<Vec<_>>(), "colours": packed(&self.colours), "frames": self.frames,
        });
        let (n, all) = (count(self.cells.len()), count(self.n_found));
        let cut = if self.is_solid {
            "that the plane cuts at some step"
        } else {
            "of the mesh"
        };
        let which = if self.cells.len() < self.n_found {
            format!("Shown are the {n} cells nearest to the bodies, of {all} {cut}")
        } else {
            format!("Shown are all {n} cells {cut}")
        };
        let accuracy = format!("{:.1e}", modes.truncation)
            .parse()
            .map(short)
            .unwrap_or_default();
        Ok((
            data,
            format!("{which}; positions are accurate to {accuracy} {unit}."),
        ))
    }
}

/// Lists the sides of a solid, or the corners of a face or an edge as one side.
fn sides(mesh: &Mesh, cell: &CellRef<'_>) -> Vec<Vec<u32>> {
    if cell.kind.dimension() < 3 {
        return vec![cell.nodes[..cell.kind.n_corners(cell.nodes.len())].to_vec()];
    }
    let mut sides = Vec::new();
    for_each_side(&mesh.cells, cell, |_, side| sides.push(side.to_vec()));
    sides
}

/// Chooses the cells nearest to the outlines of the bodies, where there are too many.
fn nearest(mesh: &Mesh, view: &View, bodies: &[BodyRecord], cells: Vec<usize>) -> Vec<usize> {
    if cells.len() <= CELLS {
        return cells;
    }
    let cut = Cut::new(mesh, view.plane);
    let outlines = bodies.iter().map(|body| cut.outline(&body.tags));
    let boxes = outlines.filter_map(|outline| super::view::around(&outline));
    let mut boxes: Vec<(Flat, Flat)> = boxes.collect();
    if boxes.is_empty() {
        boxes.push((view.window(&[]).centre, [0.0; 2]));
    }
    let distance = |cell: usize| {
        let nodes = mesh.cells.get(cell).nodes;
        let n = nodes.len() as f64;
        let flat = nodes
            .iter()
            .map(|&node| view.plane.place(mesh.points[node as usize]));
        let centre = flat.fold([0.0; 2], |[x, y], at| [x + at[0] / n, y + at[1] / n]);
        let away = boxes.iter().map(|(middle, extent)| {
            let off =
                |axis: usize| ((centre[axis] - middle[axis]).abs() - 0.5 * extent[axis]).max(0.0);
            off(0).hypot(off(1))
        });
        away.fold(f64::INFINITY, f64::min)
    };
    let mut by_distance: Vec<(f64, usize)> = cells
        .into_iter()
        .map(|cell| (distance(cell), cell))
        .collect();
    by_distance.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    let mut cells: Vec<usize> = by_distance[..CELLS].iter().map(|(_, cell)| *cell).collect();
    cells.sort_unstable();
    cells
}

/// Draws the colours, dark to bright.
pub fn colour_bar(in_words: &str) -> String {
    let bars = (0..COLOURS).map(|at| {
        format!(
            "<path class=\"q{}\" d=\"M{} 0h20v12h-20z\"/>",
            COLOURS - at,
            20 * u32::from(at)
        )
    });
    let bars: String = bars.collect();
    format!("<svg viewBox=\"0 0 320 12\" role=\"img\" aria-label=\"{in_words}\">{bars}</svg>")
}

/// Draws the colours of the quality with their meaning.
pub fn colour_key() -> String {
    let chip = |class: u8, words: &str| {
        format!(
            "<span><svg class=\"chip\" viewBox=\"0 0 12 12\" aria-hidden=\"true\"><path class=\"q{class}\" d=\"M0 0h12v12h-12z\"/></svg> {words}</span>"
        )
    };
    format!(
        "<span>0</span>{}<span>1</span> <span>scaled Jacobian</span> {} {}",
        colour_bar("Colours from 0, dark, to 1, bright"),
        chip(COLOURS + 1, "inverted"),
        chip(0, "not defined for the cell")
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::record::MotionRecord;
    use azimesh_core::geometry::vector::distance;
    use std::path::Path;

    fn numbers(text: &Value) -> Vec<u32> {
        let packed = base64_simd::STANDARD.decode_to_vec(text.as_str().expect("a text"));
        let mut bytes = Vec::new();
        let packed = packed.expect("it is base64");
        let mut reader = flate2::read::ZlibDecoder::new(&packed[..]);
        std::io::Read::read_to_end(&mut reader, &mut bytes).expect("it is zlib");
        let n = bytes.len() / 4;
        let mut last = 0u32;
        let number = |i| u32::from_le_bytes(std::array::from_fn(|at| bytes[at * n + i]));
        let sums = (0..n).map(|i| {
            last = last.wrapping_add(number(i));
            last
        });
        sums.collect()
    }

    fn floats(text: &Value) -> Vec<f64> {
        let numbers = numbers(text).into_iter();
        numbers.map(|x| f64::from(f32::from_bits(x))).collect()
    }

    /// As `cut.js` does it.
    #[test]
    fn every_cell_of_a_plane_mesh_is_in_the_data_and_comes_back_to_its_place() {
        let mesh = Mesh::read(Path::new("testdata/naca0012.vtu")).expect("it is good");
        let body = BodyRecord {
            name: "foil".to_owned(),
            tags: vec!["airfoil".to_owned()],
            ..BodyRecord::default()
        };
        let motion = MotionRecord {
            bodies: vec![body],
            turn_axis: [0.0, 0.0, 1.0],
            ..MotionRecord::default()
        };
        let view = View::new(&mesh, Some(&motion));
        let found = Cut::new(&mesh, view.plane).cells(0.0);
        let n_cells = mesh.volume_runs().map(|run| run.n_cells()).sum::<usize>();
        let mut slice = Slice::new(&mesh, &view, &motion.bodies, found);
        let mut moved = vec![mesh.clone()];
        for frame in 1..6 {
            let mut mesh = mesh.clone();
            for x in &mut mesh.points {
                let [a, b, _] = *x;
                let shift = f64::from(frame) * 0.02;
                *x = [a + shift * (-b * b).exp(), b + shift * shift * a.sin(), 0.0];
            }
            moved.push(mesh);
        }
        for (mesh, at) in moved.iter().zip(1u32..) {
            let quality = vec![1.0 - 0.1 * f64::from(at); mesh.cells.len()];
            slice.add(mesh, &view.plane, &quality, Value::Null);
        }
        let (data, sentence) = slice.data(&view, "m").expect("it is finite");
        assert!(sentence.starts_with("Shown are all ") && sentence.contains("cells of the mesh"));
        let cells = &data["groups"][0];
        let (shapes, nodes) = (numbers(&cells["shapes"]), numbers(&cells["nodes"]));
        assert_eq!((shapes.len(), nodes.len()), (n_cells, 4 * n_cells));
        assert_eq!(data["shapes"][0], json!([[0, 1, 2, 3]]));
        let outline = numbers(&data["groups"][1]["shapes"]).len();
        let tag = mesh.boundary_tags().find(|tag| tag.name == "airfoil");
        assert_eq!(Some(outline), tag.map(|tag| tag.cells.iter().count()));
        let [rest, values, coefficients] =
            ["rest", "values", "coefficients"].map(|key| floats(&data[key]));
        let n = rest.len() / 2;
        let modes = values.len() / n;
        let centre = [0, 1].map(|axis| data["centre"][axis].as_f64().expect("a number"));
        for (frame, mesh) in moved.iter().enumerate() {
            for (vertex, corner) in slice.vertices.iter().enumerate() {
                let at = |axis: usize| {
                    let by_mode = (0..modes).map(|mode| {
                        values[mode * n + vertex] * coefficients[(frame * modes + mode) * 3 + axis]
                    });
                    centre[axis] + rest[axis * n + vertex] + by_mode.sum::<f64>()
                };
                let off = distance([at(0), at(1), 0.0], corner.position(mesh));
                assert!(off < 1.1 * ACCURACY * view.window(&[]).half[0], "{off}");
            }
        }
    }

    #[test]
    fn of_many_cells_those_nearest_to_the_body_are_kept() {
        let mut mesh = Mesh::read(Path::new("testdata/naca0012.vtu")).expect("it is good");
        let n = mesh.points.len() as u32;
        let far = [[50.0, 0.0, 0.0], [51.0, 0.0, 0.0], [51.0, 1.0, 0.0]];
        mesh.points.extend(far);
        let near = mesh.cells.len();
        for _ in 0..CELLS {
            mesh.cells
                .push(azimesh_io::mesh::CellKind::Triangle, &[n, n + 1, n + 2]);
        }
        let view = View::new(&mesh, None);
        let all = Cut::new(&mesh, view.plane).cells(0.0);
        let body = BodyRecord {
            tags: vec!["airfoil".to_owned()],
            ..BodyRecord::default()
        };
        let kept = nearest(&mesh, &view, &[body], all.clone());
        assert_eq!(kept.len(), CELLS);
        let is_near = |cells: &[usize]| cells.iter().filter(|cell| **cell < near).count();
        assert_eq!(is_near(&kept), is_near(&all), "those far away are left out");
    }
}
