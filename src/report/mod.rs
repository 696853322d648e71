//! One HTML page of a sequence: motion, accuracy, quality and time of every step.
//!
//! ```text
//! folder ── Sequence::read ──> run.json, steps.csv ── charts ──────────────> figures ─┐
//!               │                                                                     ├── page
//!               └── a few meshes ── gallery: histogram, cuts coloured by quality ─────┘
//! ```
//!
//! Owns the page and the cuts of a mesh on it. Other modules define steps, the quality of cells and mesh formats. uPlot
//! draws the charts and three.js the bodies, in the browser.

mod charts;
mod cut;
mod folder;
mod gallery;
mod html;
mod meshes;
mod page;
mod plot;
mod scene;
mod section;
mod slice;
mod stills;
mod summary;
mod table;
#[cfg(test)]
mod tests;
mod view;

use azimesh_core::Note;
use azimesh_core::error::Result;
use azimesh_io::formats::ReadOptions;
use std::path::Path;

/// A page, and notes on data that is not on it.
#[derive(Debug, Clone)]
pub struct Page {
    /// The page; the same bytes for the same folder.
    pub html: String,
    /// Number of finished steps that it shows.
    pub n_steps: usize,
    /// Sentences on missing data; they are also on the page.
    pub notes: Vec<Note>,
}

/// Builds the page of the sequence in a folder, finished or not.
///
/// Reads `run.json` and `steps.csv`, or the files of its parts, and the meshes of at most 121 steps; of a large mesh fewer.
///
/// # Errors
/// If the folder holds no sequence, or its records cannot be read. A missing mesh is a note.
pub fn page(folder: &Path, options: &ReadOptions) -> Result<Page> {
    let mut sequence = folder::Sequence::read(folder)?;
    let gallery = gallery::gallery(&mut sequence, options);
    let html = page::html(&sequence, &gallery);
    Ok(Page {
        html,
        n_steps: sequence.table.len(),
        notes: sequence.notes,
    })
}
