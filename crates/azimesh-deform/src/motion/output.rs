//! `[output]`: options of the files that are written.

use super::places::Places;
use super::reader::Entry;
use azimesh_core::error::Result;
use azimesh_io::formats::{self, Compression, Encoding, Precision, WriteOptions};

const OUTPUT: &[&str] = &[
    "format",
    "precision",
    "quality",
    "displacement",
    "velocity",
    "encoding",
    "compression",
    "on_inverted",
    "surface",
    "title",
    "length_unit",
];

/// Characters of a title and of a unit, at most.
const TITLE: usize = 200;
const UNIT: usize = 20;

/// How much quality is computed at each step.
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

/// What happens when a step has inverted cells.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{OnInverted, Schedule, Steps};
///
/// let schedule = Schedule::new(Steps::azimuths_deg([0.0, 90.0])).on_inverted(OnInverted::Stop);
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum OnInverted {
    /// Warn and go on; the exit code is 1.
    Warn,
    /// Stop there.
    Stop,
    /// Take the step again in 2, 4, 8 substeps, then in 8 with `wendland-c0`; warn where that does not help.
    Substeps,
    /// As `Substeps`, then move nodes near cells that are still inverted until these are valid, together with the steps
    /// around it; warn where that does not help. What a schedule does that says nothing.
    Repair,
}

/// Files of the moving surfaces beside the meshes, for solvers that move the volume themselves.
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

/// `[output]`: what is written.
#[derive(Debug, Clone, PartialEq)]
pub struct OutputOptions {
    /// Name of a writable format.
    pub format: String,
    /// Whether it was given, and not left to be chosen.
    pub format_given: bool,
    /// Precision of coordinates.
    pub precision: Precision,
    /// How much quality is computed.
    pub quality: QualityOutput,
    /// Whether the displacement is added as a point array.
    pub displacement: bool,
    /// Whether node velocities are added as a point array.
    pub velocity: bool,
    /// How numbers are stored.
    pub encoding: Encoding,
    /// Compression of binary data.
    pub compression: Compression,
    /// What happens when a step has inverted cells.
    pub on_inverted: OnInverted,
    /// Files of the moving surfaces.
    pub surface: SurfaceOutput,
    /// Title of the report; the name of the mesh without one.
    pub title: Option<String>,
    /// What the mesh unit is called.
    pub length_unit: Option<String>,
}

impl Default for OutputOptions {
    fn default() -> Self {
        Self {
            format: "vtu".into(),
            format_given: false,
            precision: Precision::F64,
            quality: QualityOutput::Summary,
            displacement: false,
            velocity: false,
            encoding: Encoding::Raw,
            compression: Compression::None,
            on_inverted: OnInverted::Repair,
            surface: SurfaceOutput::None,
            title: None,
            length_unit: None,
        }
    }
}

impl OutputOptions {
    /// How meshes are written.
    pub fn write_options(&self) -> WriteOptions {
        WriteOptions {
            encoding: self.encoding,
            compression: self.compression,
            precision: self.precision,
            tag_names: true,
            pieces: None,
        }
    }

    /// Whether coordinates are written in 32 bits.
    pub fn rounds(&self) -> Result<bool> {
        Ok(formats::by_name(&self.format)?.rounds(self.precision))
    }

    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = entry.section("[output]", OUTPUT)?;
        let mut options = Self::default();
        let names = formats::written().map(|format| format.name);
        let known: Vec<(&str, &str)> = names.map(|name| (name, name)).collect();
        let format = |entry: &Entry<'_>| Ok(entry.choice(&known)?.to_owned());
        section.set("format", &mut options.format, format)?;
        options.format_given = section.get("format").is_some();
        let known = Precision::ALL.map(|(name, value, _)| (name, value));
        section.set("precision", &mut options.precision, |entry| {
            entry.choice(&known)
        })?;
        let known = [
            ("summary", QualityOutput::Summary),
            ("cells", QualityOutput::Cells),
            ("none", QualityOutput::None),
        ];
        section.set("quality", &mut options.quality, |entry| {
            entry.choice(&known)
        })?;
        section.set("displacement", &mut options.displacement, Entry::boolean)?;
        section.set("velocity", &mut options.velocity, Entry::boolean)?;
        let known = Encoding::ALL.map(|(name, value, _)| (name, value));
        section.set("encoding", &mut options.encoding, |entry| {
            entry.choice(&known)
        })?;
        let known = Compression::ALL.map(|(name, value, _)| (name, value));
        section.set("compression", &mut options.compression, |entry| {
            entry.choice(&known)
        })?;
        let known = [
            ("warn", OnInverted::Warn),
            ("stop", OnInverted::Stop),
            ("substeps", OnInverted::Substeps),
            ("repair", OnInverted::Repair),
        ];
        section.set("on_inverted", &mut options.on_inverted, |entry| {
            entry.choice(&known)
        })?;
        let known = [("none", SurfaceOutput::None), ("su2", SurfaceOutput::Su2)];
        section.set("surface", &mut options.surface, |entry| {
            entry.choice(&known)
        })?;
        let text = |entry: &Entry<'_>| entry.string().map(|text| Some(text.to_owned()));
        section.set("title", &mut options.title, text)?;
        section.set("length_unit", &mut options.length_unit, text)?;
        Ok(options)
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
        let known = formats::by_name(&self.format).and_then(formats::to_write);
        let known = known.map(|_| ());
        known.map_err(|error| places.error("output.format", error.message))
    }
}
