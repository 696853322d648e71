//! What is written of a mesh: the datasets, and notes on what they leave out.

use super::super::hdf5::{Data, Element, Sink};
use super::super::vtk::arrays::{Sections, VtkArrays};
use super::super::vtk::content::{Content, ContentPart, owned};
use super::super::vtk::number::Element as VtkElement;
use super::faces::{self, FaceCounts, Index};
use crate::formats::Notes;
use crate::formats::names::{Rule, decoded};
use crate::mesh::{DataArray, Listing, MeshView, NodesOfCells};
use azimesh_core::diagnostic::formats::ArrayWritten;
use azimesh_core::error::Result;
use azimesh_core::parallel::collect;

/// Indices converted at a time.
const CHUNK: usize = 1 << 19;

/// One dataset.
pub(super) struct Block<'a> {
    /// The group in that of the grid; empty for the grid itself.
    pub group: &'static str,
    pub name: String,
    pub element: Element,
    pub n_rows: u64,
    pub n_components: u64,
    pub data: Data<'a>,
}

/// The arrays of a mesh, and the numbers that say how long they are.
pub(super) struct Blocks<'a> {
    /// Node coordinates.
    pub points: Block<'a>,
    /// Datasets of the cells: connectivity, offsets, types, faces.
    pub cells: Vec<Block<'a>>,
    /// `PointData`, `CellData` and `FieldData`.
    pub arrays: Vec<Block<'a>>,
    /// Names and values of the datasets of one number a part.
    pub counts: Vec<(&'static str, u64)>,
    pub notes: Notes,
}

impl Block<'_> {
    pub fn shape(&self) -> Vec<u64> {
        shape(self.n_rows, self.n_components)
    }
}

/// A shape that has a second index only where there are components.
pub(super) fn shape(n_rows: u64, n_components: u64) -> Vec<u64> {
    match n_components {
        1 => vec![n_rows],
        n => vec![n_rows, n],
    }
}

impl<'a> Blocks<'a> {
    pub fn new(mesh: &'a MeshView<'a>, plan: &'a VtkArrays<'a>) -> Self {
        let Sections {
            fields,
            point_data,
            cell_data,
            mut points,
            cells,
        } = plan.sections();
        let mut notes = plan.notes.clone();
        notes.extend(unwritten_components(mesh));
        let mut arrays = Vec::new();
        for (group, contents) in [
            ("PointData", point_data),
            ("CellData", cell_data),
            ("FieldData", fields),
        ] {
            for content in contents {
                if content.element == VtkElement::String && group != "FieldData" {
                    // VTK reads text in field data only; elsewhere it makes VTK refuse all arrays.
                    notes.push(ArrayWritten::TextLeftOut {
                        format: "VTKHDF",
                        name: content.name.to_owned(),
                    });
                } else {
                    arrays.push(array(group, content.name.to_owned(), content));
                }
            }
        }
        let mut counts = vec![
            ("NumberOfPoints", mesh.points.len() as u64),
            ("NumberOfCells", plan.n_cells() as u64),
        ];
        let points = points
            .pop()
            .expect("a plan has coordinates, perhaps of no node");
        Self {
            points: array("", "Points".into(), points),
            cells: cell_blocks(mesh, plan, cells, &mut counts),
            arrays,
            counts,
            notes,
        }
    }
}

/// Names of datasets: those of the arrays, but for what HDF5 does not allow.
pub(super) const NAMES: Rule = Rule {
    longest: usize::MAX,
    fit: |name, _| match name {
        "" | "." => "_".to_owned(),
        name => name.replace(['/', '\0'], "_"),
    },
    why: "names in HDF5 have no slash",
};

fn unwritten_components(mesh: &MeshView) -> impl Iterator<Item = ArrayWritten> {
    let named = |array: &&DataArray| !array.component_names.is_empty();
    let names = mesh.arrays().filter(named).map(|array| array.name.clone());
    names.map(|name| ArrayWritten::ComponentNames { name })
}

fn array<'a>(group: &'static str, name: String, content: Content<'a>) -> Block<'a> {
    let (n_rows, n_components) = (content.n_tuples as u64, content.n_components as u64);
    let element = element(content.element);
    let data = match (element, content.apart()) {
        (_, Some(numbers)) => Data::Apart(numbers.clone()),
        (Element::String, _) => Data::Strings(strings(&content).into()),
        _ => Data::Stream(Box::new(move |sink| content.for_each(sink))),
    };
    Block {
        group,
        name,
        element,
        n_rows,
        n_components,
        data,
    }
}

fn element(element: VtkElement) -> Element {
    match element {
        VtkElement::Int8 => Element::I8,
        VtkElement::UInt8 => Element::U8,
        VtkElement::Int16 => Element::I16,
        VtkElement::UInt16 => Element::U16,
        VtkElement::Int32 => Element::I32,
        VtkElement::UInt32 => Element::U32,
        VtkElement::Int64 => Element::I64,
        VtkElement::UInt64 => Element::U64,
        VtkElement::Float32 => Element::F32,
        VtkElement::Float64 => Element::F64,
        VtkElement::String => Element::String,
    }
}

/// Strings, each ended by a zero in the content's bytes.
fn strings(content: &Content) -> Vec<String> {
    let mut bytes = Vec::with_capacity(content.n_bytes);
    let gathered = content.for_each(&mut |some| {
        bytes.extend_from_slice(some);
        Ok(())
    });
    gathered.expect("gathering in memory does not fail");
    let words = bytes.split(|byte| *byte == 0);
    let n = content.n_tuples * content.n_components;
    words
        .take(n)
        .map(|word| decoded(word).into_owned())
        .collect()
}

/// The datasets of the cells: both of a pair have indices of the same size, as VTK wants them.
fn cell_blocks<'a>(
    mesh: &'a MeshView<'a>,
    plan: &'a VtkArrays<'a>,
    contents: Vec<Content<'a>>,
    counts: &mut Vec<(&'static str, u64)>,
) -> Vec<Block<'a>> {
    let mut blocks = Vec::new();
    let mut n_entries = 0;
    for content in contents {
        match content.name {
            "connectivity" => {
                n_entries = content.n_tuples as u64;
                let wide = is_wide(n_entries.max(mesh.points.len() as u64));
                blocks.push(match wide {
                    false => Block {
                        element: Element::I32,
                        ..array("", "Connectivity".into(), content)
                    },
                    true => match mesh.nodes_apart(NodesOfCells::new(
                        0..mesh.cells.len(),
                        Listing::Vtk,
                        true,
                    )) {
                        Some(numbers) => Block {
                            data: Data::Apart(numbers),
                            element: Element::I64,
                            ..array("", "Connectivity".into(), content)
                        },
                        None => made("Connectivity", n_entries, true, move |sink| {
                            content
                                .for_each(&mut |bytes| widened(bytemuck::cast_slice(bytes), sink))
                        }),
                    },
                });
                blocks.push(offsets(mesh, plan, wide));
            }
            "types" => blocks.push(array("", "Types".into(), content)),
            _ => {}
        }
    }
    counts.push(("NumberOfConnectivityIds", n_entries));
    if mesh.cells.has_polyhedra() {
        blocks.extend(face_blocks(mesh, plan, counts));
    }
    blocks
}

/// The datasets of the faces of polyhedra.
fn face_blocks<'a>(
    mesh: &'a MeshView<'a>,
    plan: &VtkArrays,
    counts: &mut Vec<(&'static str, u64)>,
) -> [Block<'a>; 4] {
    let FaceCounts { faces, entries } = FaceCounts::of(mesh.cells);
    counts.push(("NumberOfFaces", faces));
    counts.push(("NumberOfFaceConnectivityIds", entries));
    counts.push(("NumberOfPolyhedronToFaceIds", faces));
    let cells = mesh.cells;
    let (n_cells, n_more) = (plan.n_cells() as u64, plan.repeated.len());
    let wide = is_wide(entries.max(mesh.points.len() as u64));
    let wide_faces = is_wide(faces);
    [
        made("FaceConnectivity", entries, wide, move |sink| match wide {
            false => faces::nodes::<i32>(cells, sink),
            true => faces::nodes::<i64>(cells, sink),
        }),
        made("FaceOffsets", faces + 1, wide, move |sink| match wide {
            false => faces::starts::<i32>(cells, sink),
            true => faces::starts::<i64>(cells, sink),
        }),
        made(
            "PolyhedronToFaces",
            faces,
            wide_faces,
            move |sink| match wide_faces {
                false => faces::numbers::<i32>(faces, sink),
                true => faces::numbers::<i64>(faces, sink),
            },
        ),
        made(
            "PolyhedronOffsets",
            n_cells + 1,
            wide_faces,
            move |sink| match wide_faces {
                false => faces::cell_starts::<i32>(cells, n_more, sink),
                true => faces::cell_starts::<i64>(cells, n_more, sink),
            },
        ),
    ]
}

fn is_wide(largest: u64) -> bool {
    i32::try_from(largest).is_err()
}

/// A dataset of indices.
fn made<'a>(
    name: &str,
    n_rows: u64,
    wide: bool,
    make: impl Fn(Sink) -> Result<()> + 'a,
) -> Block<'a> {
    Block {
        group: "",
        name: name.into(),
        element: if wide { Element::I64 } else { Element::I32 },
        n_rows,
        n_components: 1,
        data: Data::Stream(Box::new(make)),
    }
}

fn widened(nodes: &[u32], sink: Sink) -> Result<()> {
    for some in nodes.chunks(CHUNK) {
        let wide = collect(some.len(), |i| i64::from(some[i]));
        sink(bytemuck::cast_slice(&wide))?;
    }
    Ok(())
}

/// Where the nodes of each cell start, and where those of the last end.
fn offsets<'a>(mesh: &'a MeshView<'a>, plan: &VtkArrays, wide: bool) -> Block<'a> {
    let mut end = mesh.cells.connectivity().len() as u64;
    let ends: Vec<u64> = plan
        .repeated
        .iter()
        .map(|cell| {
            end += mesh.cells.get(*cell).nodes.len() as u64;
            end
        })
        .collect();
    let element = if wide {
        VtkElement::Int64
    } else {
        VtkElement::Int32
    };
    let parts = vec![
        integers(&[0], wide),
        ContentPart::Offsets(mesh.cells, element),
        integers(&ends, wide),
    ];
    let content = Content::scalar("Offsets", element, plan.n_cells() + 1, parts);
    array("", "Offsets".into(), content)
}

fn integers(values: &[u64], wide: bool) -> ContentPart<'static> {
    fn narrowed<T: Index>(values: &[u64]) -> ContentPart<'static> {
        owned(&values.iter().map(|x| T::from_u64(*x)).collect::<Vec<T>>())
    }
    match wide {
        false => narrowed::<i32>(values),
        true => narrowed::<i64>(values),
    }
}
