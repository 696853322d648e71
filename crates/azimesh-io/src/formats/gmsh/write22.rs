//! Writing MSH 2.2. A cell in several groups is written once for each.

use super::super::WriteOptions;
use super::super::records::{push_integer, write_all, write_records};
use super::content::MshContent;
use super::sink::{Sink, push_point, push_point_binary};
use super::write_data;
use crate::formats::Notes;
use crate::mesh::MeshView;
use azimesh_core::error::{Error, Result};
use std::io::Write;

/// Writes the mesh; returns a note for each thing that is left out.
pub(super) fn write(mesh: &MeshView, out: &mut dyn Write, options: &WriteOptions) -> Result<Notes> {
    let plan = MshContent::new(mesh, i32::MAX.into(), 1)?;
    let copies = |entity: usize| plan.entities[entity].physicals.len().max(1);
    let blocks = plan.blocks.iter();
    let n_elements: usize = blocks.map(|b| b.cells.len() * copies(b.entity)).sum();
    let numbers = Numbers::new(&plan);
    let highest = numbers.highest(&plan).max(n_elements);
    if highest.max(mesh.points.len()) > i32::MAX as usize {
        return Err(Error::input(format!(
            "there are {} nodes and element numbers up to {highest}; MSH 2.2 holds numbers up to {}, MSH 4.1 larger ones",
            mesh.points.len(),
            i32::MAX
        )));
    }
    let mut sink = Sink::new(out, options);
    sink.header("2.2")?;
    let mut notes = Notes::default();
    notes.extend(sink.physical_names(mesh, &plan)?);
    write_nodes(mesh, &plan, &mut sink)?;
    sink.line(&format!("$Elements\n{n_elements}"))?;
    write_elements(mesh, &plan, &numbers, &mut sink)?;
    sink.end_binary()?;
    sink.line("$EndElements")?;
    let number = |cell| numbers.of(cell, 0);
    notes.extend(write_data::write(mesh, &plan, number, &mut sink)?);
    write_data::note_left_out(mesh, options, &mut notes);
    Ok(notes)
}

fn write_nodes(mesh: &MeshView, plan: &MshContent, sink: &mut Sink) -> Result<()> {
    let n = mesh.points.len();
    sink.line(&format!("$Nodes\n{n}"))?;
    let text = sink.text;
    write_records(sink.out, n, &|range, buffer| {
        for i in range {
            if text {
                push_integer(buffer, plan.node_tag(i as u32));
                buffer.push(b' ');
                push_point(buffer, &mesh.points[i]);
            } else {
                let tag = plan.node_tag(i as u32) as i32;
                buffer.extend_from_slice(&tag.to_le_bytes());
                push_point_binary(buffer, &mesh.points[i]);
            }
        }
    })?;
    sink.end_binary()?;
    sink.line("$EndNodes")
}

/// Numbers of the elements: those that the cells came with, and higher ones for a cell's copies; or
/// counted in the order of the file.
struct Numbers<'a> {
    own: Option<&'a [i64]>,
    /// First cell, number of its element, and number of its next copy, for each block. Copies of a
    /// block follow one another.
    blocks: Vec<[usize; 3]>,
    /// Cells of each block.
    lengths: Vec<usize>,
}

impl<'a> Numbers<'a> {
    fn new(plan: &'a MshContent) -> Self {
        let own = plan.cell_numbers.as_deref();
        let highest = own.and_then(|own| own.iter().max()).map(|n| *n as usize);
        let mut next = highest.map_or(1, |highest| highest + 1);
        let mut blocks = Vec::new();
        for block in &plan.blocks {
            let n = block.cells.len();
            let copies = plan.entities[block.entity].physicals.len().max(1);
            match own {
                Some(_) => {
                    blocks.push([block.cells.start, 0, next]);
                    next += n * (copies - 1);
                }
                None => {
                    blocks.push([block.cells.start, next, next + n]);
                    next += n * copies;
                }
            }
        }
        let lengths = plan.blocks.iter().map(|block| block.cells.len()).collect();
        Self {
            own,
            blocks,
            lengths,
        }
    }

    /// The highest number used.
    fn highest(&self, plan: &MshContent) -> usize {
        let own = self
            .own
            .and_then(|own| own.iter().max())
            .map_or(0, |n| *n as usize);
        let last = self.blocks.last().zip(plan.blocks.last());
        let counted = last.map_or(0, |([_, _, copies], block)| {
            let n = plan.entities[block.entity].physicals.len().max(1) - 1;
            copies + n * block.cells.len() - 1
        });
        own.max(counted)
    }

    /// Number of a cell's element, or of its copy from 1 on.
    fn of(&self, cell: usize, copy: usize) -> u64 {
        let block = self.blocks.partition_point(|[first, ..]| *first <= cell) - 1;
        let [first, element, copies] = self.blocks[block];
        match (copy, self.own) {
            (0, Some(own)) => own[cell] as u64,
            (0, None) => (element + cell - first) as u64,
            _ => (copies + (copy - 1) * self.lengths[block] + cell - first) as u64,
        }
    }
}

fn write_elements(
    mesh: &MeshView,
    plan: &MshContent,
    numbers: &Numbers,
    sink: &mut Sink,
) -> Result<()> {
    for block in &plan.blocks {
        let entity = &plan.entities[block.entity];
        let (type_number, of) = &plan.types[block.of];
        let physicals = match &entity.physicals[..] {
            [] => &[0],
            numbers => numbers,
        };
        for (copy, physical) in physicals.iter().enumerate() {
            if !sink.text {
                let header = [*type_number, block.cells.len() as i32, 2];
                let bytes: Vec<u8> = header.iter().flat_map(|int| int.to_le_bytes()).collect();
                write_all(sink.out, &bytes)?;
            }
            for run in mesh.cells.runs_in(block.cells.clone()) {
                // Text has type and number of tags on each line, binary once in the header.
                let front = if sink.text { 5 } else { 3 };
                let first = numbers.of(run.first_cell, copy);
                let own = numbers.own.filter(|_| copy == 0);
                sink.integers(run.n_cells(), front + run.n_nodes, 4, |i, values| {
                    values[0] = match own {
                        Some(own) => own[run.first_cell + i] as u64,
                        None => first + i as u64,
                    };
                    if front == 5 {
                        values[1] = *type_number as u64;
                        values[2] = 2;
                    }
                    values[front - 2] = *physical as u64;
                    values[front - 1] = entity.tag as u64;
                    let cell = &run.connectivity[i * run.n_nodes..(i + 1) * run.n_nodes];
                    for (j, tag) in values[front..].iter_mut().enumerate() {
                        *tag = plan.node_tag(cell[of.vtk(j)]);
                    }
                })?;
            }
        }
    }
    Ok(())
}
