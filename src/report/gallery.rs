//! What the page shows of the meshes themselves: the bodies and a cut at every step that is read, some of them as
//! still pictures, and how the quality of the worst step is distributed beside that of the reference mesh.

use super::choose;
use super::cut::{Cut, Flat};
use super::embed::embedded;
use super::folder::Sequence;
use super::meshes::Meshes;
use super::pack::Pose;
use super::plot::{Bars, Plot};
use super::sample;
use super::scene::Scene;
use super::slice::Slice;
use super::stills::stills;
use super::surface::{Corner, landmarks};
use super::view::View;
use crate::record::MotionRecord;
use azimesh_core::diagnostic::short;
use azimesh_core::error::{Error, Result};
use azimesh_io::formats::ReadOptions;
use azimesh_io::mesh::Mesh;
use azimesh_quality::{Reference, scaled_jacobians};

/// Bars of the histogram.
const BARS: usize = 40;
/// Polygons and dots of the cuts: of all together, and of one of them at most and at least.
const SHAPES: usize = 240_000;
const MOST_SHAPES: usize = 6000;
const LEAST_SHAPES: usize = 2000;

/// Pictures of a sequence.
#[derive(Default)]
pub struct Gallery {
    /// Scaled Jacobians of the worst step and of the reference.
    pub histogram: Option<Plot>,
    /// Rows of the steps that can be seen, ascending.
    pub rows: Vec<usize>,
    /// The cut at each of them, compressed; one SVG element a line.
    pub cuts: String,
    /// The cut that is seen before any script has run.
    pub first_cut: String,
    /// The bodies at each of them, in space.
    pub scene: Option<Scene>,
    /// Still pictures: the reference mesh, then steps.
    pub pictures: Vec<Picture>,
    /// Where the cuts are.
    pub sentence: String,
}

/// Still pictures of one step.
pub struct Picture {
    /// The row of its step; `None` for the reference mesh.
    pub row: Option<usize>,
    /// Which step it is.
    pub caption: String,
    /// Its frame in space: -1 for the reference mesh.
    pub frame: Option<isize>,
    /// The cut.
    pub cut: String,
}

/// Reads the meshes one after another; what cannot be read becomes a note.
pub fn gallery(sequence: &mut Sequence, options: &ReadOptions) -> Gallery {
    if sequence.table.len() == 0 {
        return Gallery::default();
    }
    let mut notes = Vec::new();
    let gallery = draw(&Meshes::new(sequence, options), sequence, &mut notes);
    sequence.notes.append(&mut notes);
    gallery.unwrap_or_else(|error| {
        sequence.notes.push(format!("No mesh is shown: {error}."));
        Gallery::default()
    })
}

fn draw(meshes: &Meshes<'_>, sequence: &Sequence, notes: &mut Vec<String>) -> Result<Gallery> {
    let (before, is_original) = before(meshes, sequence, notes)?;
    let rows = choose::frames(&sequence.table, before.points.len());
    let mut studio = Studio::new(before, sequence, rows.len());
    let mut film = Film::default();
    let rest = is_original.then(|| studio.frame(None, "The reference mesh", 0.0));
    let worst = choose::worst(&sequence.table);
    let mut unread = Vec::new();
    for row in rows {
        let caption = caption(sequence, row, Some(row) == worst);
        let mesh = meshes.at(row).and_then(|mesh| studio.check(mesh));
        match mesh {
            Err(error) => unread.push((row, error)),
            Ok(mesh) => {
                if Some(row) == worst {
                    let name = format!("worst step, {}", sequence.table.step(row));
                    film.counted.push((name, studio.scaled_jacobians(&mesh)));
                }
                let frame = studio.frame(Some(&mesh), &caption, sequence.azimuth(row));
                film.add(row, frame);
            }
        }
    }
    note_unread(&unread, sequence, notes);
    if is_original {
        let quality = studio.scaled_jacobians(&studio.before);
        film.counted.push(("reference mesh".to_owned(), quality));
    }
    Ok(studio.hang(film, rest, sequence))
}

/// A sentence on the meshes that cannot be read; of many of them with the first reason.
fn note_unread(unread: &[(usize, Error)], sequence: &Sequence, notes: &mut Vec<String>) {
    let Some((row, error)) = unread.first() else {
        return;
    };
    let step = sequence.table.step(*row);
    notes.push(match unread.len() {
        1 => format!("The mesh of step {step} is not shown: {error}."),
        n => format!("The meshes of {n} steps are not shown; that of step {step}: {error}."),
    });
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
    let mesh = meshes.at(row)?;
    notes.push(format!(
        "The reference mesh is not shown: {error}. Cells are judged against step {}, which has moved least.",
        sequence.table.step(row)
    ));
    Ok((mesh, false))
}

/// What is seen of one mesh.
struct Frame {
    cut: String,
    pose: Pose,
}

/// What is seen of all of them.
#[derive(Default)]
struct Film {
    rows: Vec<usize>,
    frames: Vec<Frame>,
    counted: Vec<(String, Vec<f64>)>,
}

impl Film {
    fn add(&mut self, row: usize, frame: Frame) {
        self.rows.push(row);
        self.frames.push(frame);
    }
}

/// What all pictures have in common.
struct Studio {
    view: View,
    before: Mesh,
    motion: Option<MotionRecord>,
    landmarks: Vec<Corner>,
    scene: Option<Scene>,
    shapes: usize,
}

impl Studio {
    fn new(before: Mesh, sequence: &Sequence, n_frames: usize) -> Self {
        let motion = sequence.record.motion.as_ref();
        let bodies = motion.map_or(&[][..], |motion| &motion.bodies);
        Self {
            view: View::new(&before, motion),
            landmarks: landmarks(&before, bodies),
            scene: Scene::new(&before, motion, n_frames),
            shapes: (SHAPES / n_frames.max(1)).clamp(LEAST_SHAPES, MOST_SHAPES),
            motion: motion.cloned(),
            before,
        }
    }

    fn check(&self, mesh: Mesh) -> Result<Mesh> {
        let n = self.before.cells.len();
        match mesh.cells.len() == n {
            true => Ok(mesh),
            false => Err(Error::input(format!(
                "it has {} cells, and the reference mesh has {n}",
                mesh.cells.len(),
            ))),
        }
    }

    /// The scaled Jacobian of every cell.
    fn scaled_jacobians(&self, mesh: &Mesh) -> Vec<f64> {
        scaled_jacobians(mesh, &mesh.points, &Reference::new(&self.before))
    }

    /// What is seen of the mesh of a step, or of the reference mesh.
    fn frame(&mut self, mesh: Option<&Mesh>, caption: &str, azimuth_deg: f64) -> Frame {
        if let (Some(scene), Some(mesh)) = (&mut self.scene, mesh) {
            scene.add(mesh, azimuth_deg);
        }
        let mesh = mesh.unwrap_or(&self.before);
        let carry = self
            .motion
            .as_ref()
            .map(|motion| motion.carry(azimuth_deg).inverse());
        let place = |corner: &Corner| {
            let x = corner.place(mesh);
            carry.map_or(x, |carry| carry.apply(x)).map(|x| x as f32)
        };
        Frame {
            pose: self.landmarks.iter().map(place).collect(),
            cut: self.cut(mesh, azimuth_deg, caption),
        }
    }

    /// The cut through a mesh.
    fn cut(&self, mesh: &Mesh, azimuth_deg: f64, name: &str) -> String {
        let cut = Cut::new(mesh, self.view.plane(self.motion.as_ref(), azimuth_deg));
        let outline: Vec<[Flat; 2]> = cut.outline(&self.view.tags);
        let window = self.view.window(&outline);
        let pieces = cut.pieces(&window);
        let cells: Vec<usize> = pieces.iter().map(|piece| piece.cell).collect();
        let quality = sample::scaled_jacobians(&cells, mesh, &self.before);
        let worst = quality
            .iter()
            .copied()
            .filter(|q| !q.is_nan())
            .reduce(f64::min);
        let worst = worst.map_or_else(String::new, |q| {
            format!(", smallest scaled Jacobian {}", short(q))
        });
        let slice = Slice {
            pieces: &pieces,
            most: self.shapes,
            quality: &quality,
            outline: &outline,
            before: &self.view.outline,
            window,
        };
        let in_words = format!("{name}: {} cells in view{worst}.", pieces.len());
        slice.svg(&in_words)
    }

    /// Chooses the still pictures.
    fn hang(self, film: Film, rest: Option<Frame>, sequence: &Sequence) -> Gallery {
        let worst = choose::worst(&sequence.table);
        let (cuts, poses): (Vec<String>, Vec<Pose>) = film
            .frames
            .into_iter()
            .map(|frame| (frame.cut, frame.pose))
            .unzip();
        let place = worst.and_then(|worst| film.rows.iter().position(|&row| row == worst));
        let chosen = stills(rest.as_ref().map(|rest| &rest.pose), &poses, place);
        let is_solid = self.scene.is_some();
        let rest = rest.map(|rest| Picture {
            row: None,
            frame: is_solid.then_some(-1),
            caption: "Reference mesh".to_owned(),
            cut: rest.cut,
        });
        let steps = chosen.into_iter().map(|frame| {
            let row = film.rows[frame];
            let caption = caption(sequence, row, Some(row) == worst);
            Picture {
                row: Some(row),
                frame: is_solid.then_some(frame as isize),
                caption,
                cut: cuts[frame].clone(),
            }
        });
        Gallery {
            histogram: histogram(&film.counted),
            pictures: rest.into_iter().chain(steps).collect(),
            first_cut: cuts.first().cloned().unwrap_or_default(),
            cuts: embedded(cuts.join("\n").as_bytes()),
            rows: film.rows,
            sentence: self.view.sentence,
            scene: self.scene,
        }
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
    let bars: Vec<Bars> = sets
        .iter()
        .map(|(name, values)| (name.clone(), shares(values, low, width)))
        .collect();
    let heights = bars.iter().flat_map(|(_, bars)| bars);
    let least = heights.filter_map(|bar| bar.1).reduce(f64::min)?;
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

/// Left edge and percentage of each bar; no height where there is no cell.
fn shares(values: &[f64], low: f64, width: f64) -> Vec<(f64, Option<f64>)> {
    let mut counts = [0u64; BARS];
    for value in values {
        let bar = ((value - low) / width).max(0.0) as usize;
        counts[bar.min(BARS - 1)] += 1;
    }
    let all = values.len() as f64;
    let bars = counts.into_iter().enumerate();
    bars.map(|(bar, count)| {
        let height = (count > 0).then(|| 100.0 * count as f64 / all);
        (low + bar as f64 * width, height)
    })
    .collect()
}
