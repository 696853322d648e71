//! Writing MSH 4.1. All nodes stand in one block of the entity of highest dimension.

use super::super::WriteOptions;
use super::super::records::{left_out, push_real, write_all, write_records};
use super::kinds;
use super::written::{Block, Entity, Plan, Sink, push_point, push_point_binary};
use crate::error::Result;
use crate::mesh::Mesh;
use rayon::prelude::*;
use std::io::Write;

/// Writes the mesh; returns a sentence for each thing that is left out.
pub(super) fn write(
    mesh: &Mesh,
    out: &mut dyn Write,
    options: &WriteOptions,
) -> Result<Vec<String>> {
    let mut plan = Plan::new(mesh)?;
    if plan.entities.is_empty() {
        plan.entities.push(Entity {
            dimension: 3,
            tag: 1,
            physicals: Vec::new(),
        });
    }
    let mut sink = Sink::new(out, options);
    sink.header("4.1")?;
    let mut notes = sink.physical_names(mesh, &plan)?;
    write_entities(mesh, &plan, &mut sink)?;
    write_nodes(mesh, &plan, &mut sink)?;
    write_elements(mesh, &plan, &mut sink)?;
    notes.extend(left_out("MSH", mesh, options));
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

fn write_entities(mesh: &Mesh, plan: &Plan, sink: &mut Sink) -> Result<()> {
    let of = |dimension: u8| {
        let entities = plan.entities.iter().enumerate();
        entities.filter(move |(_, entity)| entity.dimension == dimension)
    };
    sink.line("$Entities")?;
    let counts: Vec<usize> = (0..4).map(|dimension| of(dimension).count()).collect();
    sink.ints_sizes(&[], &counts)?;
    for (i, entity) in (0..4).flat_map(of) {
        let [low, high] = bounds(mesh, plan, i);
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

/// Smallest and largest coordinates of an entity's cells; of all nodes where it has none.
fn bounds(mesh: &Mesh, plan: &Plan, entity: usize) -> [[f64; 3]; 2] {
    let blocks = plan.blocks.iter().filter(|block| block.entity == entity);
    let boxes = blocks.map(|block| {
        let runs = mesh.cells.runs_in(block.cells.clone());
        runs.fold(NOWHERE, |all, run| {
            let chunks = run.connectivity.par_chunks(1 << 16);
            let of_chunk = |nodes: &[u32]| {
                let points = nodes.iter().map(|node| mesh.points[*node as usize]);
                points.fold(NOWHERE, |all, point| joined(all, [point, point]))
            };
            let boxes: Vec<_> = chunks.map(of_chunk).collect();
            boxes.into_iter().fold(all, joined)
        })
    });
    let all = boxes.fold(NOWHERE, joined);
    if all == NOWHERE {
        return mesh.bounds().unwrap_or([[0.0; 3]; 2]);
    }
    all
}

const NOWHERE: [[f64; 3]; 2] = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];

fn joined([low, high]: [[f64; 3]; 2], [l, h]: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    [
        std::array::from_fn(|i| low[i].min(l[i])),
        std::array::from_fn(|i| high[i].max(h[i])),
    ]
}

fn write_nodes(mesh: &Mesh, plan: &Plan, sink: &mut Sink) -> Result<()> {
    let n = mesh.points.len();
    sink.line("$Nodes")?;
    sink.ints_sizes(&[], &[1, n, n.min(1), n])?;
    let home = plan.entities.iter().max_by_key(|entity| {
        // The first of the highest dimension.
        (entity.dimension, std::cmp::Reverse(entity.tag))
    });
    let home = home.expect("there is one entity at least");
    sink.ints_sizes(&[home.dimension.into(), home.tag, 0], &[n])?;
    sink.integers(n, 1, 8, |i, tag| tag[0] = i as u64 + 1)?;
    let push = if sink.text {
        push_point
    } else {
        push_point_binary
    };
    write_records(sink.out, n, |range, buffer| {
        for point in &mesh.points[range] {
            push(buffer, point);
        }
    })?;
    sink.end_binary()?;
    sink.line("$EndNodes")
}

fn write_elements(mesh: &Mesh, plan: &Plan, sink: &mut Sink) -> Result<()> {
    let n = mesh.cells.len();
    sink.line("$Elements")?;
    sink.ints_sizes(&[], &[plan.blocks.len(), n, n.min(1), n])?;
    for block in &plan.blocks {
        let Block {
            kind,
            number,
            cells,
            entity,
        } = block;
        let entity = &plan.entities[*entity];
        let order = kinds::order(*kind);
        let header = [entity.dimension.into(), entity.tag, *number];
        sink.ints_sizes(&header, &[cells.len()])?;
        for run in mesh.cells.runs_in(cells.clone()) {
            sink.integers(run.n_cells(), 1 + run.n_nodes, 8, |i, values| {
                values[0] = (run.first_cell + i) as u64 + 1;
                let cell = &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes];
                kinds::to_gmsh(order, cell, &mut values[1..]);
            })?;
        }
    }
    sink.end_binary()?;
    sink.line("$EndElements")
}
