//! `[body.table]`: six degrees of freedom over azimuth, time or step.

use super::clock::StepHistory;
use super::link::{Link, RigidLink};
use super::naming;
use super::{
    At, BodyMotion, FromSchedule, OnMesh, ResolvedMotion, Rotation, TableSource, read_interpolation,
};
use crate::motion::body::Body;
use crate::motion::reader::{AngleUnit, Entry};
use crate::motion::setters::setters;
use crate::motion::table::{Column, Columns, History, Interpolation, Naming, Table};
use azimesh_core::diagnostic::Diagnostic;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, scale};
use std::sync::Arc;

/// Axes that a body in the plane cannot be moved along or turned about, as columns.
const OUT_OF_PLANE: [usize; 3] = [2, 3, 4];
const COLUMNS: [&str; 6] = ["dx", "dy", "dz", "rot_x", "rot_y", "rot_z"];

/// Six degrees of freedom from a [`Table`]: rotations about x, y, then z through an origin, then a
/// translation, interpolated between rows.
///
/// Columns, in any order: one of `azimuth_deg`, `azimuth_rad`, `time_s` and `step`; `dx`, `dy`, `dz` in
/// mesh units; `rot_x_deg`, `rot_y_deg`, `rot_z_deg` (or `_rad`). What is left out is 0.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Table, TableMotion};
///
/// let table = Table::from_rows(["time_s", "rot_z_deg"], [[0.0, 0.0], [0.5, 8.0], [1.0, 0.0]]);
/// let motion = TableMotion::new(table).origin([0.25, 0.0, 0.0]).cubic();
/// let airfoil = Body::new("airfoil", ["airfoil"]).table(motion);
/// ```
#[derive(Debug, Clone)]
pub struct TableMotion {
    table: TableSource,
    origin: Vector,
    interpolation: Interpolation,
    naming: Naming,
}

/// What `columns` and `units` may name.
const NAMED: [&str; 13] = [
    "azimuth_deg",
    "azimuth_rad",
    "time_s",
    "step",
    "dx",
    "dy",
    "dz",
    "rot_x_deg",
    "rot_x_rad",
    "rot_y_deg",
    "rot_y_rad",
    "rot_z_deg",
    "rot_z_rad",
];

impl TableMotion {
    /// A table that turns about the origin, linear between rows.
    pub fn new(table: impl Into<TableSource>) -> Self {
        Self {
            table: table.into(),
            origin: [0.0; 3],
            interpolation: Interpolation::Linear,
            naming: Naming::default(),
        }
    }
}

setters! { TableMotion {
    /// What it turns about, in mesh units.
    origin(origin: Vector) |self| self.origin = origin;
    /// What the file calls a column, by its name here: `column("dx", "u1")`. Columns of other names are passed over.
    column(name: impl Into<String>, in_file: impl Into<String>) |self| self.naming.columns.insert(name.into(), in_file.into());
    /// The unit of a column, by its name here: `unit("dx", "mm")`, `unit("rot_x_deg", "rad")`.
    unit(name: impl Into<String>, unit: impl Into<String>) |self| self.naming.units.insert(name.into(), unit.into());
    /// A cubic spline between rows, periodic where the table is.
    cubic() |self| self.interpolation = Interpolation::Cubic;
} }

impl From<Table> for TableMotion {
    fn from(table: Table) -> Self {
        Self::new(table)
    }
}

impl FromSchedule for TableMotion {
    const KEY: &'static str = "table";

    fn read(entry: &Entry<'_>, _: AngleUnit) -> Result<Self> {
        let section = entry.section(
            "[body.table]",
            &["file", "origin", "interpolation", "columns", "units"],
        )?;
        let mut motion = Self::new(section.require("file", "file = \"motion.csv\"")?.string()?);
        section.set("origin", &mut motion.origin, Entry::numbers)?;
        motion.interpolation = read_interpolation(&section, "interpolation")?;
        motion.naming = naming::read(&section, &NAMED)?;
        Ok(motion)
    }
}

impl BodyMotion for TableMotion {
    fn order(&self) -> u8 {
        4
    }

    fn has_harmonics(&self) -> bool {
        false
    }

    fn files(&self) -> Vec<&str> {
        self.table.file().into_iter().collect()
    }

    fn check(&self, body: &Body) -> Result<()> {
        naming::check(&self.naming, &NAMED, body, "table")?;
        body.places.finite("table.origin", &self.origin)
    }

    /// Reads the table; it must have values at every step.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let table = self.table.read(on, "table")?;
        let names = naming::resolve(&self.naming, on, None, "table")?;
        let mut columns = table.columns_as(names.clone())?;
        let key = columns.require_key()?;
        let found = six(&mut columns)?;
        let others = columns.done()?;
        if found.iter().all(Option::is_none) {
            let message =
                "the table has none of the columns dx, dy, dz, rot_x_deg, rot_y_deg, rot_z_deg";
            return Err(table.header_error(message));
        }
        if on.in_plane() {
            check_plane(&table, &found, &on.body.name)?;
        }
        let present: Vec<Column> = found.iter().flatten().copied().collect();
        let mut next = 0..present.len();
        let history = History::from_table(&table, key, &present, self.interpolation)?;
        let history = StepHistory::new(history, on, "table")?;
        let mut notes = naming::notes(&self.naming, &names, &others, &table, &on.body.name);
        notes.extend(history.note.clone());
        Ok(Arc::new(SixDegrees {
            notes,
            history,
            columns: found.map(|column| column.and_then(|_| next.next())),
            origin: self.origin,
        }))
    }
}

/// A table of `dx, dy, dz, rot_x, rot_y, rot_z`.
#[derive(Debug)]
struct SixDegrees {
    history: StepHistory,
    /// Place of each of the six among the values; a column left out is 0.
    columns: [Option<usize>; 6],
    origin: Vector,
    notes: Vec<Diagnostic>,
}

impl ResolvedMotion for SixDegrees {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let values = self.history.values(at.step);
        let rates = self.history.rates(at);
        let of = |values: &[f64], i: usize| self.columns[i].map_or(0.0, |at| values[at]);
        let rotation = |axis: usize| Rotation {
            axis: std::array::from_fn(|i| f64::from(u8::from(i == axis))),
            origin: self.origin,
            angle: at.part * of(&values, 3 + axis),
            rate: of(&rates, 3 + axis),
        };
        let turning = (0..3).filter(|axis| self.columns[3 + axis].is_some());
        let by = std::array::from_fn(|i| of(&values, i));
        let rate = std::array::from_fn(|i| of(&rates, i));
        Some(Link::Rigid(RigidLink {
            rotations: turning.map(rotation).collect(),
            translation: Some([scale(by, at.part), rate]),
        }))
    }

    fn centre(&self) -> Option<Vector> {
        let turns = self.columns[3..].iter().any(Option::is_some);
        turns.then_some(self.origin)
    }

    fn notes(&self) -> &[Diagnostic] {
        &self.notes
    }
}

/// The six columns; those of a wrong name are refused when all are taken.
fn six(columns: &mut Columns<'_>) -> Result<[Option<Column>; 6]> {
    let mut found = [None; 6];
    for (i, name) in COLUMNS.iter().enumerate() {
        found[i] = match i {
            0..3 => columns.optional(name),
            _ => columns.optional_angle(name)?,
        };
    }
    Ok(found)
}

fn check_plane(table: &Table, columns: &[Option<Column>; 6], body: &str) -> Result<()> {
    for i in OUT_OF_PLANE {
        let Some(column) = columns[i] else { continue };
        if let Some(row) = (0..table.n_rows()).find(|&row| table.value(row, column) != 0.0) {
            let message = format!(
                "`{}` is not 0, so body \"{body}\" would leave the plane of the 2D mesh; use only dx, dy and \
                 rot_z_deg",
                COLUMNS[i]
            );
            return Err(table.error(row, message));
        }
    }
    Ok(())
}
