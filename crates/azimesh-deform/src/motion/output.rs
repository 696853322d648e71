//! `[output]`: options of the files that are written.

use super::keys::{Kind, boolean, choice, keys, names, positive, string};
use super::places::Places;
use azimesh_core::error::Result;
use azimesh_io::formats::{self, Compression, Encoding, Precision, WriteOptions};
use serde_json::json;

/// Largest number of characters of a title or a unit.
const TITLE: usize = 200;
const UNIT: usize = 20;

/// Amount of quality output per step.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{QualityOutput, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0])).quality(QualityOutput::Cells);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum QualityOutput {
    /// A row of steps.csv.
    Summary,
    /// The row, and cell arrays in the mesh.
    Cells,
    /// Nothing.
    None,
}

/// Reaction to inverted cells.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{OnInverted, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0])).on_inverted(OnInverted::Stop);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnInverted {
    /// Warn and continue; the exit code is 1.
    Warn,
    /// Stop.
    Stop,
    /// Repeat the step in 2, 4, 8 substeps, then in 8 with `wendland-c0`; warn if that does not help.
    Substeps,
    /// As `Substeps`, then move nodes near cells that are still inverted until these are valid, together with the
    /// neighbouring steps; warn if that does not help. The default of a schedule.
    Repair,
}

/// Files of the moving surfaces, for solvers that move the volume themselves.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Schedule, Steps, SurfaceOutput};
///
/// let schedule = Schedule::new(Steps::times_s([0.0, 0.01, 0.02])).surface(SurfaceOutput::Su2);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum SurfaceOutput {
    /// No such files.
    None,
    /// A file for each iteration of SU2's unsteady `EXTERNAL` motion.
    Su2,
}

names! {
    QualityOutput { "summary" => Summary, "cells" => Cells, "none" => None }
    OnInverted { "warn" => Warn, "stop" => Stop, "substeps" => Substeps, "repair" => Repair }
    SurfaceOutput { "none" => None, "su2" => Su2 }
}

fn writable() -> Vec<&'static str> {
    formats::written().map(|format| format.name).collect()
}

/// Name of a writable format.
const FORMAT: Kind<String> = Kind {
    words: "name of a writable format",
    read: |entry| {
        let known: Vec<_> = writable().into_iter().map(|name| (name, name)).collect();
        Ok(entry.choice(&known)?.to_owned())
    },
    schema: || json!({ "enum": writable() }),
};

keys! {
    /// `[output]`: what is written.
    #[derive(Debug, Clone, PartialEq)]
    pub struct OutputOptions "[output]" {
        /// any of the [formats](formats.md): `"vtu"`, `"msh"`, `"su2"`, ...; `"vtkhdf"` (ParaView 5.12 or later) and
        /// `"cgns"` hold the whole sequence in one file
        pub format: Option<String>, FORMAT, or "`\"vtu\"`; `\"openfoam\"` if the mesh is a case";
        /// of coordinates, in the formats of VTK and CGNS; `"f32"` is refused where it would change a first-cell height by more
        /// than 1%
        pub precision: Precision, choice::<Precision>(), default "f64";
        /// columns of [steps.csv](outputs.md#stepscsv); these and cell arrays; nothing
        pub quality: QualityOutput, choice::<QualityOutput>(), default "summary";
        /// adds the displacement as a point array, in formats that hold arrays; in an OpenFOAM case as
        /// `<time>/wantedDisplacement`
        pub displacement: bool, boolean(), default false;
        /// adds node velocities as the point array `Velocity`, in mesh units per second, in formats that hold arrays.
        /// [Velocities](#velocities)
        pub velocity: bool, boolean(), default false;
        /// of numbers in VTU files
        pub encoding: Encoding, choice::<Encoding>(), default "raw";
        /// of binary data in VTU files
        pub compression: Compression, choice::<Compression>(), default "none";
        /// at a step with inverted cells: [repair](batches.md#inverted-cells) it; `"warn"`: continue and exit with 1;
        /// `"stop"`: stop (`--keep-going` skips the step); `"substeps"`: compute it again in substeps only, not with
        /// `velocity`, nor with `interpolate = "twist"` on a beam. No effect with `quality = "none"`
        pub on_inverted: OnInverted, choice::<OnInverted>(), default "repair";
        /// scaled Jacobian, at most 1: cells below it are [improved](batches.md#cells-of-low-quality), with neighbours, towards their
        /// shape and size in the reference mesh. Needs `on_inverted = "repair"` and `quality`
        pub improve: Option<f64>, positive("scaled Jacobian"), or "none";
        /// `"su2"` adds a file of the moving surfaces per step for [SU2](tasks/su2.md). The mesh is a `.su2` file, or
        /// `format` is `"su2"`; steps are evenly spaced
        pub surface: SurfaceOutput, choice::<SurfaceOutput>(), default "none";
        /// false leaves boundary faces and their tags out of `"vtu"` and `"vtkhdf"`: the volume cells alone, with all nodes.
        /// [Slices](formats.md#slices-in-paraview)
        pub boundary_faces: bool, boolean(), default true;
        /// title of the [report](report.md)
        pub title: Option<String>, string::<String>(), or "the mesh's name";
        /// name of the mesh unit, such as `"m"` or `"mm"`, for the [report](report.md) and for [tables in other
        /// units](#names-and-units-of-columns)
        pub length_unit: Option<String>, string::<String>(), or "none";
    }
}

impl OutputOptions {
    /// Name of the format that meshes are written in.
    pub fn format(&self) -> &str {
        self.format.as_deref().unwrap_or("vtu")
    }

    /// Options for writing meshes.
    pub fn write_options(&self) -> WriteOptions {
        WriteOptions {
            encoding: self.encoding,
            compression: self.compression,
            precision: self.precision,
            tag_names: true,
            pieces: None,
        }
    }

    /// Returns whether coordinates are written in 32 bits.
    pub fn rounds(&self) -> Result<bool> {
        Ok(formats::by_name(self.format())?.rounds(self.precision))
    }

    /// Refuses a format that cannot be written, and labels that are empty or too long for one line.
    pub(super) fn check(&self, places: &Places) -> Result<()> {
        for (key, label, most) in [
            ("output.title", &self.title, TITLE),
            ("output.length_unit", &self.length_unit, UNIT),
        ] {
            let Some(label) = label else { continue };
            let n = label.chars().count();
            if label.trim().is_empty() || n > most || label.contains(char::is_control) {
                let message =
                    format!("should be one line of 1 to {most} characters, found {label:?}");
                return Err(places.error(key, message));
            }
        }
        let alone = self.on_inverted != OnInverted::Repair || self.quality == QualityOutput::None;
        if let Some(wanted) = self.improve.filter(|q| *q > 1.0 || *q <= 0.0 || alone) {
            let message = match alone {
                true => "needs `on_inverted` = \"repair\" and a `quality` other than \"none\""
                    .to_owned(),
                false => format!("should be greater than 0 and at most 1, found {wanted}"),
            };
            return Err(places.error("output.improve", message));
        }
        if !self.boundary_faces && !["vtu", "vtkhdf"].contains(&self.format()) {
            let message = format!(
                "boundary_faces = false is for the formats \"vtu\" and \"vtkhdf\"; this one is \"{}\"",
                self.format()
            );
            return Err(places.error("output.boundary_faces", message));
        }
        let known = formats::by_name(self.format()).and_then(formats::to_write);
        let known = known.map(|_| ());
        known.map_err(|error| places.error("output.format", error.message))
    }
}
