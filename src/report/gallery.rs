//! Pictures of the meshes: the bodies and a cut at every step that is read, some of them as still pictures, and a histogram
//! of the quality at the worst step and in the reference mesh.

use super::cut::Cut;
use super::folder::Sequence;
use super::meshes::Meshes;
use super::plot::{Plot, evenly};
use super::scene::{Corner, Pose, Scene, landmarks};
use super::slice::Slice;
use super::stills::stills;
use super::view::View;
use crate::record::MotionRecord;
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, add, scale};
use azimesh_core::numbers::short;
use azimesh_core::{Note, note};
use azimesh_io::formats::ReadOptions;
use azimesh_io::mesh::Mesh;
use azimesh_quality::{Reference, scaled_jacobians};
use serde_json::{Value, json};

/// Largest and smallest number of steps whose meshes are read, and the number of nodes of all meshes between the two.
const FRAMES: usize = 120;
const FEWEST: usize = 9;
const NODES: usize = 60_000_000;
/// Bars of the histogram.
const BARS: usize = 40;
/// Cells whose distance from the plane is a smaller part of the window are cut too.
const MARGIN: f64 = 1e-3;

/// Pictures of a sequence. Picture 0 is the reference mesh, or empty; the others are steps.
#[derive(Default)]
pub struct Gallery {
    /// Scaled Jacobians of the worst step and of the reference.
    pub histogram: Option<Plot>,
    /// Rows of the steps that have a picture, ascending.
    pub rows: Vec<usize>,
    /// The cut of every picture, for the script.
    pub cut: Value,
    /// The bodies of each picture, in space.
    pub scene: Option<Scene>,
    /// Still pictures with their captions.
    pub stills: Vec<(usize, String)>,
    /// The place of the cuts.
    pub sentence: String,
}

/// Reads the meshes one after another; an unreadable mesh becomes a note.
pub fn gallery(sequence: &mut Sequence, options: &ReadOptions) -> Gallery {
    if sequence.table.len() == 0 {
        return Gallery::default();
    }
    let mut notes = Vec::new();
    let gallery = draw(sequence, options, &mut notes);
    sequence.notes.append(&mut notes);
    gallery.unwrap_or_else(|error| {
        let note = note!("no_mesh_shown", "No mesh is shown: {error}.");
        sequence.notes.push(note);
        Gallery::default()
    })
}

fn draw(sequence: &Sequence, options: &ReadOptions, notes: &mut Vec<Note>) -> Result<Gallery> {
    let meshes = Meshes::new(sequence, options);
    let (before, is_original) = before(&meshes, sequence, notes)?;
    let reference = Reference::new(&before);
    let worst = sequence.table.worst();
    let rows = frames(sequence, worst, before.points.len());
    let caption = |row: usize| caption(sequence, row, Some(row) == worst);
    let motion = sequence.record.motion.as_ref();
    let view = View::new(&before, motion);
    let found = cut_cells(&view, &before, &meshes, sequence, &rows);
    let mut studio = FrameRenderer::new(&before, sequence, view, found, rows.len());
    let rest = scaled_jacobians(&before, &before.points, &reference);
    studio.add(&before, &rest, 0.0, "The reference mesh");
    let (mut shown, mut counted, mut unread) = (Vec::new(), Vec::new(), Vec::new());
    for row in rows {
        let mesh = match meshes.at(row).and_then(|mesh| check(mesh, &before)) {
            Ok(mesh) => mesh,
            Err(error) => {
                unread.push((row, error));
                continue;
            }
        };
        let quality = scaled_jacobians(&mesh, &mesh.points, &reference);
        studio.add(&mesh, &quality, sequence.azimuth(row), &caption(row));
        shown.push(row);
        if Some(row) == worst {
            counted.push((format!("worst step, {}", sequence.table.step(row)), quality));
        }
    }
    if let Some((row, error)) = unread.first() {
        let step = sequence.table.step(*row);
        notes.push(match unread.len() {
            1 => note!(
                "mesh_not_shown",
                "The mesh of step {step} is not shown: {error}."
            ),
            n => note!(
                "meshes_not_shown",
                "The meshes of {n} steps are not shown. Step {step}: {error}."
            ),
        });
    }
    let first = usize::from(!is_original);
    if is_original {
        counted.push(("reference mesh".to_owned(), rest));
    }
    let place = shown.iter().position(|&row| Some(row) == worst);
    let chosen = stills(&studio.poses[first..], place.map(|place| place + 1 - first));
    let caption_of = |picture: usize| match picture {
        0 => "Reference mesh".to_owned(),
        _ => caption(shown[picture - 1]),
    };
    let (cut, cells) = studio.slice.data(&studio.view, studio.unit)?;
    Ok(Gallery {
        histogram: histogram(&counted),
        stills: chosen
            .into_iter()
            .map(|at| (at + first, caption_of(at + first)))
            .collect(),
        rows: shown,
        cut,
        sentence: format!("{} {cells}", studio.view.sentence),
        scene: studio.scene,
    })
}

/// Chooses the rows whose meshes are read, ascending: all, or of a long sequence or a large mesh some evenly and the worst.
fn frames(sequence: &Sequence, worst: Option<usize>, n_nodes: usize) -> Vec<usize> {
    let most = (NODES / n_nodes.max(1)).clamp(FEWEST, FRAMES);
    let mut rows = evenly(sequence.table.len(), most);
    rows.extend(worst);
    rows.sort_unstable();
    rows.dedup();
    rows
}

/// Reads the reference mesh, or the step that has moved least; whether it is the former.
fn before(meshes: &Meshes<'_>, sequence: &Sequence, notes: &mut Vec<Note>) -> Result<(Mesh, bool)> {
    let error = match meshes.reference() {
        Ok(mesh) => return Ok((mesh, true)),
        Err(error) => error,
    };
    let row = sequence.table.least_displaced();
    let mesh = meshes.at(row)?;
    notes.push(note!(
        "no_reference_shown",
        "The reference mesh is not shown: {error}. Cells are compared with step {}, which has moved least.",
        sequence.table.step(row)
    ));
    Ok((mesh, false))
}

fn check(mesh: Mesh, before: &Mesh) -> Result<Mesh> {
    let (n, wanted) = (mesh.cells.len(), before.cells.len());
    if n == wanted {
        return Ok(mesh);
    }
    Err(Error::input(format!(
        "it has {n} cells, and the reference mesh has {wanted}"
    )))
}

/// Lists the cells that the plane cuts in the reference mesh or at a step. Only in 3D are these not all the same.
fn cut_cells(
    view: &View,
    before: &Mesh,
    meshes: &Meshes<'_>,
    sequence: &Sequence,
    rows: &[usize],
) -> Vec<usize> {
    let margin = MARGIN * view.window(&[]).half[0];
    let mut is_cut = vec![false; before.cells.len()];
    let mut add = |mesh: &Mesh, plane| {
        let cells = Cut::new(mesh, plane).cells(margin);
        cells.into_iter().for_each(|cell| is_cut[cell] = true);
    };
    add(before, view.plane);
    for &row in rows.iter().filter(|_| before.dimension() == 3) {
        if let Ok(mesh) = meshes.at(row).and_then(|mesh| check(mesh, before)) {
            let motion = sequence.record.motion.as_ref();
            add(&mesh, view.plane(motion, sequence.azimuth(row)));
        }
    }
    let cells = is_cut.iter().enumerate().filter(|(_, is_cut)| **is_cut);
    cells.map(|(cell, _)| cell).collect()
}

/// The settings of all pictures, and the pictures so far.
struct FrameRenderer<'a> {
    view: View,
    motion: Option<&'a MotionRecord>,
    unit: &'a str,
    landmarks: Vec<Corner>,
    scene: Option<Scene>,
    slice: Slice,
    poses: Vec<Pose>,
}

impl<'a> FrameRenderer<'a> {
    fn new(
        before: &Mesh,
        sequence: &'a Sequence,
        view: View,
        found: Vec<usize>,
        n_frames: usize,
    ) -> Self {
        let motion = sequence.record.motion.as_ref();
        let bodies = motion.map_or(&[][..], |motion| &motion.bodies);
        Self {
            slice: Slice::new(before, &view, bodies, found),
            view,
            motion,
            unit: sequence.length_unit(),
            landmarks: landmarks(before, bodies),
            scene: Scene::new(before, motion, n_frames),
            poses: Vec::new(),
        }
    }

    /// Adds the pictures of a mesh.
    fn add(&mut self, mesh: &Mesh, quality: &[f64], azimuth_deg: f64, caption: &str) {
        let worst = least(quality.iter().copied().enumerate());
        let worst = worst.map(|(cell, quality)| (cell, quality, centre(mesh, cell)));
        if let Some(scene) = &mut self.scene {
            scene.add(mesh, quality, worst.map(|(_, _, at)| at), azimuth_deg);
        }
        let back = self
            .motion
            .map(|motion| motion.carry(azimuth_deg).inverse());
        let place = |corner: &Corner| {
            let x = corner.position(mesh);
            back.map_or(x, |back| back.apply(x)).map(|x| x as f32)
        };
        self.poses.push(self.landmarks.iter().map(place).collect());
        let frame = self.cut(mesh, quality, worst, azimuth_deg, caption);
        let plane = self.view.plane(self.motion, azimuth_deg);
        self.slice.add(mesh, &plane, quality, frame);
    }

    /// Describes the cut; the worst cell of the mesh, and the worst one in the first view, are marked.
    fn cut(
        &self,
        mesh: &Mesh,
        quality: &[f64],
        worst: Option<(usize, f64, Vector)>,
        azimuth_deg: f64,
        caption: &str,
    ) -> Value {
        let plane = self.view.plane(self.motion, azimuth_deg);
        let cut = Cut::new(mesh, plane);
        let outline = cut.outline(&self.view.tags);
        let window = self.view.window(&outline);
        let pieces = cut.pieces(&window);
        let mut words = format!("{caption}: {} cells in the first view", pieces.len());
        let mut marks = Vec::new();
        let in_view = least(pieces.iter().map(|piece| quality[piece.cell]).enumerate());
        if let Some((at, quality)) = in_view {
            let (cell, quality) = (pieces[at].cell, short(quality));
            words += &format!(", smallest scaled Jacobian {quality}");
            if worst.is_none_or(|(worst, ..)| worst != cell) {
                marks.push((
                    window.nearest(pieces[at].centre()),
                    format!("Worst cell in the first view, {cell}: scaled Jacobian {quality}"),
                ));
            }
        }
        if let Some((cell, quality, x)) = worst {
            let (quality, unit) = (short(quality), self.unit);
            let place = x.map(short)[..usize::from(mesh.space_dimension())].join(", ");
            let off = match plane.height(x).abs() {
                off if mesh.dimension() == 3 => format!(", {} {unit} from the plane", short(off)),
                _ => String::new(),
            };
            words += &format!("; the worst cell of the mesh has {quality}, at ({place}){off}");
            marks.push((
                plane.flat(x),
                format!(
                    "Worst cell of the mesh, {cell}: scaled Jacobian {quality}, at ({place}){off}"
                ),
            ));
        }
        marks.retain(|(at, _)| window.holds(&[*at]));
        json!({"words": words + ".", "centre": window.centre, "marks": marks})
    }
}

/// Returns the index and the value of the smallest value that is known.
fn least(values: impl Iterator<Item = (usize, f64)>) -> Option<(usize, f64)> {
    let known = values.filter(|(_, value)| !value.is_nan());
    known.min_by(|a, b| a.1.total_cmp(&b.1))
}

fn centre(mesh: &Mesh, cell: usize) -> Vector {
    let nodes = mesh.cells.get(cell).nodes;
    let sum = nodes
        .iter()
        .fold([0.0; 3], |sum, &node| add(sum, mesh.points[node as usize]));
    scale(sum, 1.0 / nodes.len() as f64)
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

/// Draws the shares of the cells over the scaled Jacobian.
fn histogram(counted: &[(String, Vec<f64>)]) -> Option<Plot> {
    let is_inverted = counted
        .iter()
        .flat_map(|(_, values)| values)
        .any(|q| *q < 0.0);
    let low = if is_inverted { -1.0 } else { 0.0 };
    let bars = counted
        .iter()
        .map(|(name, values)| (name.clone(), shares(values, low)));
    let bars: Vec<_> = bars
        .filter(|(_, bars)| bars.iter().any(|bar| bar.1.is_some()))
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

/// Returns the left edge and the percentage of each bar; no height where there is no cell.
fn shares(values: &[f64], low: f64) -> Vec<(f64, Option<f64>)> {
    let width = (1.0 - low) / BARS as f64;
    let mut counts = [0u64; BARS];
    for value in values.iter().filter(|q| !q.is_nan()) {
        counts[(((value - low) / width).max(0.0) as usize).min(BARS - 1)] += 1;
    }
    let all = counts.iter().sum::<u64>() as f64;
    let bar = |(at, count)| {
        (
            low + f64::from(at) * width,
            (count > 0).then(|| 100.0 * count as f64 / all),
        )
    };
    (0u32..).zip(counts).map(bar).collect()
}
