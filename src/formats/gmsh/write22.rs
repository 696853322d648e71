//! Writing MSH 2.2. A cell in several groups is written once for each.

use super::super::WriteOptions;
use super::super::records::{left_out, push_integer, write_all, write_records};
use super::kinds;
use super::written::{Plan, Sink, push_point, push_point_binary};
use crate::error::{Error, Result};
use crate::mesh::Mesh;
use std::io::Write;

/// Writes the mesh; returns a sentence for each thing that is left out.
pub(super) fn write(
    mesh: &Mesh,
    out: &mut dyn Write,
    options: &WriteOptions,
) -> Result<Vec<String>> {
    let plan = Plan::new(mesh)?;
    let copies = |entity: usize| plan.entities[entity].physicals.len().max(1);
    let blocks = plan.blocks.iter();
    let n_elements: usize = blocks.map(|b| b.cells.len() * copies(b.entity)).sum();
    if n_elements.max(mesh.points.len()) > i32::MAX as usize {
        return Err(Error::input(format!(
            "{} nodes and {n_elements} elements; MSH 2.2 holds at most {}, MSH 4.1 more",
            mesh.points.len(),
            i32::MAX
        )));
    }
    let mut sink = Sink::new(out, options);
    sink.header("2.2")?;
    let mut notes = sink.physical_names(mesh, &plan)?;
    write_nodes(mesh, &mut sink)?;
    sink.line(&format!("$Elements\n{n_elements}"))?;
    write_elements(mesh, &plan, &mut sink)?;
    sink.end_binary()?;
    sink.line("$EndElements")?;
    notes.extend(left_out("MSH", mesh, options));
    Ok(notes)
}

fn write_nodes(mesh: &Mesh, sink: &mut Sink) -> Result<()> {
    let n = mesh.points.len();
    sink.line(&format!("$Nodes\n{n}"))?;
    let text = sink.text;
    write_records(sink.out, n, |range, buffer| {
        for i in range {
            if text {
                push_integer(buffer, i as u64 + 1);
                buffer.push(b' ');
                push_point(buffer, &mesh.points[i]);
            } else {
                buffer.extend_from_slice(&(i as i32 + 1).to_le_bytes());
                push_point_binary(buffer, &mesh.points[i]);
            }
        }
    })?;
    sink.end_binary()?;
    sink.line("$EndNodes")
}

fn write_elements(mesh: &Mesh, plan: &Plan, sink: &mut Sink) -> Result<()> {
    let mut n_written = 0;
    for block in &plan.blocks {
        let entity = &plan.entities[block.entity];
        let order = kinds::order(block.kind);
        let physicals = match &entity.physicals[..] {
            [] => &[0],
            numbers => numbers,
        };
        for physical in physicals {
            if !sink.text {
                let header = [block.number, block.cells.len() as i32, 2];
                let bytes: Vec<u8> = header.iter().flat_map(|int| int.to_le_bytes()).collect();
                write_all(sink.out, &bytes)?;
            }
            for run in mesh.cells.runs_in(block.cells.clone()) {
                // Text has type and number of tags on each line, binary once in the header.
                let front = if sink.text { 5 } else { 3 };
                sink.integers(run.n_cells(), front + run.n_nodes, 4, |i, values| {
                    values[0] = (n_written + i) as u64 + 1;
                    if front == 5 {
                        values[1] = block.number as u64;
                        values[2] = 2;
                    }
                    values[front - 2] = *physical as u64;
                    values[front - 1] = entity.tag as u64;
                    let cell = &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes];
                    kinds::to_gmsh(order, cell, &mut values[front..]);
                })?;
                n_written += run.n_cells();
            }
        }
    }
    Ok(())
}
