//! Writing MSH 4.1. All nodes stand in one block of the entity of highest dimension.

use super::super::WriteOptions;
use super::super::records::{push_real, write_all, write_records};
use super::content::{Entity, MshContent};
use super::sink::{Sink, push_point, push_point_binary};
use super::write_data;
use crate::formats::Notes;
use crate::mesh::MeshView;
use azimesh_core::error::Result;
use azimesh_core::parallel::map_blocks;
use std::io::Write;

/// Writes the mesh; returns a note for each thing that is left out.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Write, options: &WriteOptions) -> Result<Notes> {
    let mut plan = MshContent::new(mesh, i64::MAX, 0)?;
    let mut notes = Notes::default();
    notes.extend(plan.drop_large_numbers(mesh));
    if plan.entities.is_empty() {
        plan.entities.push(Entity {
            dimension: 3,
            tag: 1,
            physicals: Vec::new(),
        });
    }
    let mut sink = Sink::new(out, options);
    sink.header("4.1")?;
    notes.extend(sink.physical_names(mesh, &plan)?);
    write_entities(mesh, &plan, &mut sink)?;
    write_nodes(mesh, &plan, &mut sink)?;
    let number = |cell: usize| match &plan.cell_numbers {
        Some(numbers) => numbers[cell] as u64,
        None => cell as u64 + 1,
    };
    write_elements(mesh, &plan, number, &mut sink)?;
    notes.extend(write_data::write(mesh, &plan, number, &mut sink)?);
    write_data::note_left_out(mesh, options, &mut notes);
    Ok(notes)
}

impl Sink<'_> {
    /// Writes integers of 4 bytes and then of 8 bytes, as one line.
    fn ints_sizes(&mut self, ints: &[i32], sizes: &[usize]) -> Result<()> {
        if self.text {
            let ints = ints.iter().map(ToString::to_string);
            let sizes = sizes.iter().map(ToString::to_string);
            return self.line(&ints.chain(sizes).collect::<Vec<_>>().join(" "));
        }
        let mut bytes: Vec<u8> = ints.iter().flat_map(|int| int.to_le_bytes()).collect();
        for size in sizes {
            bytes.extend_from_slice(&(*size as u64).to_le_bytes());
        }
        write_all(self.out, &bytes)
    }
}

fn write_entities(mesh: &MeshView, plan: &MshContent, sink: &mut Sink) -> Result<()> {
    let of = |dimension: u8| {
        let entities = plan.entities.iter().enumerate();
        entities.filter(move |(_, entity)| entity.dimension == dimension)
    };
    sink.line("$Entities")?;
    let counts: Vec<usize> = (0..4).map(|dimension| of(dimension).count()).collect();
    sink.ints_sizes(&[], &counts)?;
    let bounds = bounds(mesh, plan);
    for (i, entity) in (0..4).flat_map(of) {
        let [low, high] = bounds[i];
        let place = match entity.dimension {
            0 => low.to_vec(),
            _ => [low, high].concat(),
        };
        write_entity(entity, &place, sink)?;
    }
    sink.end_binary()?;
    sink.line("$EndEntities")
}

/// Tag, position or box, physical groups, and no bounding entities.
fn write_entity(entity: &Entity, place: &[f64], sink: &mut Sink) -> Result<()> {
    let mut bytes = Vec::new();
    if sink.text {
        bytes.extend_from_slice(entity.tag.to_string().as_bytes());
        for x in place {
            bytes.push(b' ');
            push_real(&mut bytes, *x);
        }
        let mut end = format!(" {}", entity.physicals.len());
        for number in &entity.physicals {
            end.push_str(&format!(" {number}"));
        }
        if entity.dimension > 0 {
            end.push_str(" 0");
        }
        bytes.extend_from_slice(end.as_bytes());
        bytes.push(b'\n');
    } else {
        bytes.extend_from_slice(&entity.tag.to_le_bytes());
        for x in place {
            bytes.extend_from_slice(&x.to_le_bytes());
        }
        bytes.extend_from_slice(&(entity.physicals.len() as u64).to_le_bytes());
        for number in &entity.physicals {
            bytes.extend_from_slice(&number.to_le_bytes());
        }
        if entity.dimension > 0 {
            bytes.extend_from_slice(&0u64.to_le_bytes());
        }
    }
    write_all(sink.out, &bytes)
}

/// Smallest and largest coordinates of each entity's cells; of all nodes where it has none, or all
/// cells of the mesh's own dimension.
fn bounds(mesh: &MeshView, plan: &MshContent) -> Vec<[[f64; 3]; 2]> {
    let whole = mesh.bounds().unwrap_or([[0.0; 3]; 2]);
    let alone = |entity: &Entity| {
        let same = plan
            .entities
            .iter()
            .filter(|other| other.dimension == entity.dimension);
        entity.dimension == mesh.dimension() && same.count() == 1
    };
    let mut boxes = vec![NOWHERE; plan.entities.len()];
    for block in &plan.blocks {
        if alone(&plan.entities[block.entity]) {
            continue;
        }
        let known = &mut boxes[block.entity];
        for run in mesh.cells.runs_in(block.cells.clone()) {
            let parts = map_blocks(run.connectivity.len(), 1 << 16, &|entries| {
                let nodes = run.connectivity[entries].iter();
                let points = nodes.map(|node| mesh.points[*node as usize]);
                points.fold(NOWHERE, |all, point| joined(all, [point, point]))
            });
            *known = parts.into_iter().fold(*known, joined);
        }
    }
    let or_whole = |known| if known == NOWHERE { whole } else { known };
    boxes.into_iter().map(or_whole).collect()
}

const NOWHERE: [[f64; 3]; 2] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

fn joined([low, high]: [[f64; 3]; 2], [l, h]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    [
        std::array::from_fn(|i| low[i].min(l[i])),
        std::array::from_fn(|i| high[i].max(h[i])),
    ]
}

fn write_nodes(mesh: &MeshView, plan: &MshContent, sink: &mut Sink) -> Result<()> {
    let n = mesh.points.len();
    sink.line("$Nodes")?;
    let [lowest, highest] = plan.node_tags(n);
    sink.ints_sizes(&[], &[1, n, lowest, highest])?;
    let home = plan.entities.iter().max_by_key(|entity| {
        // The first of the highest dimension.
        (entity.dimension, std::cmp::Reverse(entity.tag))
    });
    let home = home.expect("there is one entity at least");
    sink.ints_sizes(&[home.dimension.into(), home.tag, 0], &[n])?;
    sink.integers(n, 1, 8, |i, tag| tag[0] = plan.node_tag(i as u32))?;
    let push = if sink.text {
        push_point
    } else {
        push_point_binary
    };
    write_records(sink.out, n, &|range, buffer| {
        for point in &mesh.points[range] {
            push(buffer, point);
        }
    })?;
    sink.end_binary()?;
    sink.line("$EndNodes")
}

fn write_elements(
    mesh: &MeshView,
    plan: &MshContent,
    number: impl Fn(usize) -> u64 + Sync,
    sink: &mut Sink,
) -> Result<()> {
    let n = mesh.cells.len();
    sink.line("$Elements")?;
    let [lowest, highest] = plan.cell_tags(n);
    sink.ints_sizes(&[], &[plan.blocks.len(), n, lowest, highest])?;
    for block in &plan.blocks {
        let entity = &plan.entities[block.entity];
        let (type_number, of) = &plan.types[block.of];
        let header = [entity.dimension.into(), entity.tag, *type_number];
        sink.ints_sizes(&header, &[block.cells.len()])?;
        for run in mesh.cells.runs_in(block.cells.clone()) {
            sink.integers(run.n_cells(), 1 + run.n_nodes, 8, |i, values| {
                values[0] = number(run.first_cell + i);
                let cell = &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes];
                for (j, tag) in values[1..].iter_mut().enumerate() {
                    *tag = plan.node_tag(cell[of.vtk(j)]);
                }
            })?;
        }
    }
    sink.end_binary()?;
    sink.line("$EndElements")
}
