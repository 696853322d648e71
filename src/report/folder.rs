//! The folder of a sequence: its record and its table, with the motion as columns.

use super::table::Table;
use crate::record::{
    BodyRecord, COLUMNS, EndRecord, RunRecord, file_name, in_shell, in_shell_all, parts_in,
};
use azimesh_core::error::{Error, Result};
use azimesh_core::{Note, note};
use azimesh_io::formats::{read_file, records_in};
use std::path::{Path, PathBuf};

/// Unit of lengths without another name.
const MESH_UNITS: &str = "mesh units";
/// Largest number of bodies whose motion is shown.
const BODIES: usize = 8;
/// Columns of the motion of a body, made from run.json: name, label, unit.
const OF_BODY: [(&str, &str, &str); 7] = [
    ("pitch_deg", "pitch", "degrees"),
    ("flap_deg", "flap", "degrees"),
    ("lag_deg", "lag", "degrees"),
    ("angle_deg", "angle", "degrees"),
    ("tip_x", "tip displacement along x", MESH_UNITS),
    ("tip_y", "tip displacement along y", MESH_UNITS),
    ("tip_z", "tip displacement along z", MESH_UNITS),
];

/// The records of a sequence in a folder.
pub struct Sequence {
    /// The folder of the records.
    pub folder: PathBuf,
    /// The folder that was passed to the run.
    output: PathBuf,
    /// The run, or the first part of it.
    pub record: RunRecord,
    /// The finished steps. Motions of bodies are columns `body/pitch_deg` and so on.
    pub table: Table,
    /// Sentences on missing data.
    pub notes: Vec<Note>,
}

impl Sequence {
    /// Reads records and tables; no mesh.
    pub fn read(folder: &Path) -> Result<Self> {
        if folder.is_file() {
            return Err(Error::input(
                "this is a file; give the folder that `azimesh deform -o` has made",
            )
            .file(folder));
        }
        std::fs::read_dir(folder).map_err(|error| Error::io(folder, &error))?;
        // In a case the records of a run have a folder of their own.
        let output = folder.to_path_buf();
        let records = records_in(folder);
        let folder = records.as_deref().unwrap_or(folder);
        let tables = whole_or_parts(folder, "steps", "csv");
        let records = whole_or_parts(folder, "run", "json");
        if tables.is_empty() && records.is_empty() {
            return Err(Error::input(
                "holds neither steps.csv nor run.json, so it is not the folder of a sequence; give one that \
                 `azimesh deform -o` has made",
            )
            .file(folder));
        }
        let mut sequence = Self {
            folder: folder.to_path_buf(),
            output,
            record: RunRecord::default(),
            table: Table::read(&tables)?,
            notes: Vec::new(),
        };
        sequence.take_records(&records)?;
        sequence.add_motion();
        sequence.note_what_is_missing();
        Ok(sequence)
    }

    /// The first record; it also gets the seconds of further parts, and the errors of incomplete or wrong parts.
    fn take_records(&mut self, paths: &[PathBuf]) -> Result<()> {
        for (at, path) in paths.iter().enumerate() {
            let record = read(path)?;
            if at == 0 {
                self.record = record;
                continue;
            }
            let is_complete = record.is_complete();
            if let Some(end) = record.end {
                let all = self.record.end.get_or_insert_default();
                add_new(&mut all.diagnostics, end.diagnostics);
                add_new(&mut all.skipped_steps, end.skipped_steps);
                add_new(&mut all.failures, end.failures);
                all.error = all.error.take().or(end.error);
            }
            if let Some(seconds) = record.seconds {
                let all = self.record.seconds.get_or_insert_default();
                *all = all.plus(seconds);
            }
            if !is_complete {
                self.record.outcome = record.outcome;
            }
        }
        if paths.len() > 1 {
            self.record.arguments = self.record.arguments_of_all_steps();
            self.notes.push(note!(
                "parts_of_sequence",
                "The sequence is in {} parts; inputs, options and base points are those of the first, and times are \
                 added up.",
                paths.len()
            ));
        }
        Ok(())
    }

    fn add_motion(&mut self) {
        let steps: Vec<usize> = (0..self.table.len())
            .map(|row| self.table.step(row))
            .collect();
        let Some(motion) = &self.record.motion else {
            return;
        };
        for body in motion.bodies.iter().take(BODIES) {
            for (key, values) in courses(body) {
                let column = format!("{}/{key}", body.name);
                let values: Vec<_> = steps
                    .iter()
                    .map(|&step| values.get(step).copied())
                    .collect();
                self.table.add(&column, &values);
            }
        }
        if motion.bodies.len() > BODIES {
            self.notes.push(note!(
                "bodies_not_shown",
                "The motion of the first {BODIES} of {} bodies is shown.",
                motion.bodies.len()
            ));
        }
    }

    fn note_what_is_missing(&mut self) {
        let n = self.table.len();
        if self.record.outcome.is_empty() {
            self.notes.push(note!(
                "no_record",
                "There is no run.json: inputs, options, base points and times are not known."
            ));
        }
        match self.record.steps {
            Some(all) if n < all => self.notes.push(
                note!(
                    "steps_left",
                    "Finished steps: {n} of the {all} of the schedule."
                )
                .with("finished", n)
                .with("steps", all),
            ),
            None if n == 0 => self.notes.push(note!("no_step", "No step is finished.")),
            _ => {}
        }
    }

    /// Returns the label and the unit of a column. `body/pitch_deg` is a column of that body; an unknown column keeps its
    /// name. Volumes have their unit from the dimension of the mesh, and are areas in a plane.
    pub fn label(&self, column: &str) -> (String, String) {
        let (body, key) = column.rsplit_once('/').unwrap_or(("", column));
        let of_step = COLUMNS.iter().map(|of| (of.name, of.label, of.unit));
        let known = of_step.chain(OF_BODY).find(|(name, _, _)| *name == key);
        let (name, unit) = match (column, self.record.dimension) {
            ("min_volume", Some(2)) => ("smallest area", "mesh units²"),
            ("min_volume", Some(3)) => ("smallest volume", "mesh units³"),
            _ => known.map_or((key, ""), |(_, label, unit)| (label, unit)),
        };
        let of = if body.is_empty() {
            String::new()
        } else {
            format!("{body}: ")
        };
        (of + name, unit.replace(MESH_UNITS, self.length_unit()))
    }

    /// Returns the name of the mesh unit in the schedule.
    pub fn length_unit(&self) -> &str {
        self.record.length_unit.as_deref().unwrap_or(MESH_UNITS)
    }

    /// Returns the command that makes these meshes: the original one, or an equivalent one if a program called the library.
    /// `None` if the record names no mesh or no schedule.
    pub fn command(&self) -> Option<String> {
        if !self.record.arguments.is_empty() {
            return Some(in_shell_all(&self.record.arguments));
        }
        let inputs = &self.record.inputs;
        let file_of = |what: &str| Some(&inputs.iter().find(|input| input.what == what)?.file);
        file_of("mesh").and(file_of("schedule"))?;
        let options = &self.record.options;
        let given = [
            ("--base", file_of("base")),
            ("--format", options.format.as_ref()),
            ("--tag-array", options.tag_array.as_ref()),
        ];
        let given = given
            .into_iter()
            .filter_map(|(option, value)| Some((option, value?)));
        let conditions = self.record.fail_on.iter().map(|value| ("--fail-on", value));
        let mut command = self.record.command(&self.output);
        for (option, value) in given.chain(conditions) {
            command += &format!(" {option} {}", in_shell(value));
        }
        Some(command)
    }

    /// The title that the schedule gives, or the name of the case.
    pub fn title(&self) -> String {
        self.record.title.clone().unwrap_or_else(|| self.case())
    }

    /// Name of a column with its unit.
    pub fn with_unit(&self, column: &str) -> String {
        match self.label(column) {
            (name, unit) if unit.is_empty() => name,
            (name, unit) => format!("{name}, {unit}"),
        }
    }

    /// Returns the result of the run; empty while it is under way.
    pub fn end(&self) -> EndRecord {
        self.record.end.clone().unwrap_or_default()
    }

    /// Returns the state of the run in a word or two.
    pub fn state(&self) -> &str {
        match self.record.outcome.as_str() {
            "" => "not known",
            "running" => "not finished",
            outcome if self.record.is_finished() => outcome,
            _ => "stopped",
        }
    }

    /// Returns the bodies' motions, if the record has them.
    pub fn bodies(&self) -> &[BodyRecord] {
        let motion = self.record.motion.as_ref();
        motion.map_or(&[], |motion| {
            &motion.bodies[..motion.bodies.len().min(BODIES)]
        })
    }

    /// Azimuth of a row in degrees.
    pub fn azimuth(&self, row: usize) -> f64 {
        self.table.text(row, "azimuth_deg").parse().unwrap_or(0.0)
    }

    /// Returns the column of the horizontal axes: the azimuth where it grows from step to step, else the time, else
    /// the number of the step.
    pub fn abscissa(&self) -> &'static str {
        let grows = |column: &&str| {
            let values = self.table.numbers(column);
            let pairs = values.windows(2);
            self.table.has(column) && pairs.into_iter().all(|pair| pair[0] < pair[1])
        };
        let columns = ["azimuth_deg", "time_s"];
        columns.into_iter().find(grows).unwrap_or("step")
    }

    /// Returns the name of the mesh without its endings.
    pub fn case(&self) -> String {
        let input = self.record.inputs.first().map_or("", |mesh| &mesh.file);
        let name = Path::new(input).file_name().unwrap_or_default();
        match azimesh_io::formats::case_name(&name.to_string_lossy()) {
            "" | "-" => "sequence".to_owned(),
            case => case.to_owned(),
        }
    }
}

/// Reads a run.json.
fn read(path: &Path) -> Result<RunRecord> {
    let bytes = read_file(path);
    let bytes = bytes.map_err(|error| Error::io(path, &error))?;
    RunRecord::parse(&bytes).map_err(|error| error.file(path))
}

/// Adds what is not there yet.
fn add_new<T: PartialEq>(to: &mut Vec<T>, items: Vec<T>) {
    for item in items {
        if !to.contains(&item) {
            to.push(item);
        }
    }
}

/// Lists the known values of a body over the steps of the schedule; angles that are always zero are left out.
fn courses(body: &BodyRecord) -> Vec<(&'static str, Vec<f64>)> {
    // The outermost point along the span of the rotor may be one that stays, as at the root of a wing.
    let has_tip = body.tip_displacement.iter().flatten().any(|x| *x != 0.0);
    let tips = body.tip_displacement.iter().filter(|_| has_tip);
    let tip = |axis: usize| tips.clone().map(|tip| tip[axis]).collect();
    let angles = [
        ("pitch_deg", body.pitch_deg.clone()),
        ("flap_deg", body.flap_deg.clone()),
        ("lag_deg", body.lag_deg.clone()),
        ("angle_deg", body.angle_deg.clone()),
    ];
    let angles = angles
        .into_iter()
        .filter(|(_, values)| values.iter().any(|x| *x != 0.0));
    let lengths = [
        ("tip_x", tip(0)),
        ("tip_y", tip(1)),
        ("tip_z", tip(2)),
        ("max_displacement", body.max_displacement.clone()),
    ];
    let all = angles.chain(lengths);
    all.filter(|(_, values): &(_, Vec<f64>)| !values.is_empty())
        .collect()
}

/// Lists the file of a whole sequence, or the files of its parts.
fn whole_or_parts(folder: &Path, stem: &str, extension: &str) -> Vec<PathBuf> {
    let whole = folder.join(file_name(stem, None, extension));
    if whole.is_file() {
        return vec![whole];
    }
    let parts = parts_in(folder, stem, extension).unwrap_or_default();
    parts.into_iter().map(|(_, path)| path).collect()
}
