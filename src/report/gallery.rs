//! What the page shows of the meshes themselves: cuts at some of the steps, and how the quality of the
//! worst step is distributed beside that of the reference mesh.

use super::choose;
use super::cut::{Cut, Flat};
use super::folder::Sequence;
use super::meshes::Meshes;
use super::plot::Plot;
use super::slice::Slice;
use super::view::View;
use crate::diagnostic::short;
use crate::error::{Error, Result};
use crate::formats::ReadOptions;
use crate::mesh::Mesh;
use crate::quality::{Reference, per_cell};
use crate::record::MotionRecord;

/// Bars of the histogram.
const BARS: usize = 40;

/// Pictures of a sequence.
#[derive(Debug, Default)]
pub struct Gallery {
    /// Scaled Jacobians of the worst step and of the reference.
    pub histogram: Option<Plot>,
    /// Cuts: the reference mesh, then steps.
    pub pictures: Vec<Picture>,
    /// Where the cuts are.
    pub sentence: String,
}

/// One cut.
#[derive(Debug)]
pub struct Picture {
    /// The row of its step; `None` for the reference mesh.
    pub row: Option<usize>,
    /// Which step it is.
    pub caption: String,
    /// The picture.
    pub svg: String,
}

/// Reads the meshes one after another; what cannot be read becomes a note.
pub fn gallery(sequence: &mut Sequence, options: &ReadOptions) -> Gallery {
    let rows = choose::drawn(&sequence.table);
    if rows.is_empty() {
        return Gallery::default();
    }
    let mut notes = Vec::new();
    let gallery = draw(&Meshes::new(sequence, options), sequence, &rows, &mut notes);
    sequence.notes.append(&mut notes);
    gallery
}

fn draw(
    meshes: &Meshes<'_>,
    sequence: &Sequence,
    rows: &[usize],
    notes: &mut Vec<String>,
) -> Gallery {
    let (before, is_original) = match before(meshes, sequence, notes) {
        Ok(found) => found,
        Err(error) => {
            notes.push(format!("No mesh is shown: {error}."));
            return Gallery::default();
        }
    };
    let motion = sequence.record.motion.as_ref();
    let reference = Reference::new(&before);
    let studio = Studio {
        view: View::new(&before, motion),
        n_cells: before.cells.len(),
        reference,
        motion,
    };
    let worst = choose::worst(&sequence.table);
    let mut gallery = Gallery {
        sentence: studio.view.sentence.clone(),
        ..Gallery::default()
    };
    let mut counted = Vec::new();
    if is_original {
        let (svg, quality) = studio.picture(&before, 0.0, "The reference mesh");
        gallery.pictures.push(Picture {
            row: None,
            caption: "Reference mesh".to_owned(),
            svg,
        });
        counted.push(("reference mesh".to_owned(), quality));
    }
    drop(before);
    for &row in rows {
        let is_worst = Some(row) == worst;
        match studio.step(meshes, sequence, row, is_worst) {
            Ok((picture, quality)) => {
                if is_worst {
                    let step = sequence.table.step(row);
                    counted.insert(0, (format!("worst step, {step}"), quality));
                }
                gallery.pictures.push(picture);
            }
            Err(error) => {
                let step = sequence.table.step(row);
                notes.push(format!("The mesh of step {step} is not shown: {error}."));
            }
        }
    }
    gallery.histogram = histogram(&counted);
    gallery
}

/// The reference mesh, or the step that has moved least; whether it is the former.
fn before(
    meshes: &Meshes<'_>,
    sequence: &Sequence,
    notes: &mut Vec<String>,
) -> Result<(Mesh, bool)> {
    let error = match meshes.reference() {
        Ok(mesh) => return Ok((mesh, true)),
        Err(error) => error,
    };
    let row = choose::calmest(&sequence.table);
    let row = row.ok_or_else(|| Error::input("no step is finished"))?;
    notes.push(format!(
        "The reference mesh is not shown: {error}. Cells are judged against step {}, which has moved least.",
        sequence.table.step(row)
    ));
    Ok((meshes.at(row)?, false))
}

/// What all pictures have in common.
struct Studio<'a> {
    view: View,
    n_cells: usize,
    reference: Reference,
    motion: Option<&'a MotionRecord>,
}

impl Studio<'_> {
    fn check(&self, mesh: Mesh) -> Result<Mesh> {
        match mesh.cells.len() == self.n_cells {
            true => Ok(mesh),
            false => Err(Error::input(format!(
                "it has {} cells, and the reference mesh has {}",
                mesh.cells.len(),
                self.n_cells
            ))),
        }
    }

    /// The picture of a row of steps.csv, and the scaled Jacobian of the cells of its mesh.
    fn step(
        &self,
        meshes: &Meshes<'_>,
        sequence: &Sequence,
        row: usize,
        is_worst: bool,
    ) -> Result<(Picture, Vec<f64>)> {
        let mesh = self.check(meshes.at(row)?)?;
        let caption = caption(sequence, row, is_worst);
        let (svg, quality) = self.picture(&mesh, sequence.azimuth(row), &caption);
        let row = Some(row);
        Ok((Picture { row, caption, svg }, quality))
    }

    /// The cut through a mesh, and the scaled Jacobian of its cells.
    fn picture(&self, mesh: &Mesh, azimuth_deg: f64, name: &str) -> (String, Vec<f64>) {
        let quality = per_cell(mesh, &mesh.points, &self.reference).scaled_jacobian;
        let cut = Cut::new(mesh, self.view.plane(self.motion, azimuth_deg));
        let outline: Vec<[Flat; 2]> = cut.outline(&self.view.tags);
        let window = self.view.window(&outline);
        let pieces = cut.pieces(&window);
        let seen = pieces.iter().map(|piece| quality[piece.cell]);
        let worst = seen.filter(|q| !q.is_nan()).reduce(f64::min);
        let worst = worst.map_or_else(String::new, |q| {
            format!(", smallest scaled Jacobian {}", short(q))
        });
        let slice = Slice {
            pieces: &pieces,
            quality: &quality,
            outline: &outline,
            before: &self.view.outline,
            window,
        };
        let in_words = format!("{name}: {} cells in view{worst}.", pieces.len());
        (slice.svg(&in_words), quality)
    }
}

fn caption(sequence: &Sequence, row: usize, is_worst: bool) -> String {
    let step = sequence.table.step(row);
    let place = match sequence.abscissa() {
        "azimuth_deg" => format!(", {}°", short(sequence.azimuth(row))),
        "time_s" => sequence.table.numbers("time_s")[row]
            .map_or(String::new(), |time| format!(", {} s", short(time))),
        _ => String::new(),
    };
    let worst = if is_worst { ", the worst" } else { "" };
    format!("Step {step}{place}{worst}")
}

/// Shares of the cells over the scaled Jacobian.
fn histogram(counted: &[(String, Vec<f64>)]) -> Option<Plot> {
    let known = |values: &[f64]| -> Vec<f64> {
        let known = values.iter().copied().filter(|q| !q.is_nan());
        known.collect()
    };
    let sets: Vec<(String, Vec<f64>)> = counted
        .iter()
        .map(|(name, values)| (name.clone(), known(values)))
        .filter(|(_, values)| !values.is_empty())
        .collect();
    let values = || sets.iter().flat_map(|(_, values)| values);
    let low = if values().any(|q| *q < 0.0) {
        -1.0
    } else {
        0.0
    };
    let width = (1.0 - low) / BARS as f64;
    let bars: Vec<(String, Vec<[f64; 3]>)> = sets
        .iter()
        .map(|(name, values)| (name.clone(), shares(values, low, width)))
        .collect();
    let least = bars
        .iter()
        .flat_map(|(_, bars)| bars)
        .map(|bar| bar[2])
        .reduce(f64::min)?;
    Some(Plot {
        title: "Scaled Jacobian of the cells".to_owned(),
        x: "scaled Jacobian".to_owned(),
        y: "cells, %".to_owned(),
        is_log: true,
        include: vec![0.5 * least],
        bars,
        ..Plot::default()
    })
}

/// Bars with a cell at least, in percent of all.
fn shares(values: &[f64], low: f64, width: f64) -> Vec<[f64; 3]> {
    let mut counts = [0u64; BARS];
    for value in values {
        let bar = ((value - low) / width).max(0.0) as usize;
        counts[bar.min(BARS - 1)] += 1;
    }
    let all = values.len() as f64;
    let bars = counts
        .into_iter()
        .enumerate()
        .filter(|(_, count)| *count > 0);
    bars.map(|(bar, count)| {
        let from = low + bar as f64 * width;
        [from, from + width, 100.0 * count as f64 / all]
    })
    .collect()
}
