//! `[body.table]`: six degrees of freedom over azimuth, time or step.

use super::link::{Link, RigidLink};
use super::naming::{self, ColumnValues, NamedColumns, NamedTable};
use super::{At, BodyMotion, OnMesh, ResolvedMotion, Rotation, TableSource};
use crate::motion::body::Body;
use crate::motion::keys::{choice, keys, numbers, string};
use crate::motion::setters::setters;
use crate::motion::table::{Interpolation, Naming, RotationForm, Table, Unit};
use azimesh_core::Note;
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, scale};
use std::sync::Arc;

/// Columns that would move a plane body out of its plane.
const OUT_OF_PLANE: [usize; 3] = [2, 3, 4];
/// Translations and rotations.
pub(super) const COLUMNS: [&str; 6] = ["dx", "dy", "dz", "rot_x", "rot_y", "rot_z"];

/// Six degrees of freedom from a [`Table`]: rotations about x, y, then z through an origin (or in another
/// [form](RotationForm)), then a translation, interpolated between rows.
///
/// Columns, in any order: one of `azimuth_deg`, `azimuth_rad`, `time_s` and `step`; `dx`, `dy`, `dz` in
/// mesh units; `rot_x_deg`, `rot_y_deg`, `rot_z_deg` (or `_rad`). Missing columns are 0.
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
    rotation: Option<RotationForm>,
    naming: Naming,
}

impl TableMotion {
    /// Creates a motion by a table that turns about the origin; linear between rows.
    pub fn new(table: impl Into<TableSource>) -> Self {
        Self {
            table: table.into(),
            origin: [0.0; 3],
            interpolation: Interpolation::Linear,
            rotation: None,
            naming: Naming::default(),
        }
    }
}

setters! { TableMotion {
    /// Sets the centre of rotation, in mesh units.
    origin(origin: Vector) |self| self.origin = origin;
    /// Maps a column's name here to its name in the file: `column("dx", "u1")`; `"-u1"` changes the sign. Columns of other
    /// names are ignored.
    column(name: impl Into<String>, in_file: impl Into<String>) |self| self.naming.columns.insert(name.into(), in_file.into());
    /// Sets the unit of a column, by its name here: `unit("dx", "mm")`, `unit("rot_x_deg", "rad")`, or a factor.
    unit(name: impl Into<String>, unit: impl Into<Unit>) |self| self.naming.units.insert(name.into(), unit.into());
    /// Sets the form of its rotations.
    rotation(form: RotationForm) |self| self.rotation = Some(form);
    /// Interpolates between rows with a cubic spline, which is periodic if the table is.
    cubic() |self| self.interpolation = Interpolation::Cubic;
} }

impl From<Table> for TableMotion {
    fn from(table: Table) -> Self {
        Self::new(table)
    }
}

keys! { impl TableMotion "[body.table]" = Self::new(""), {
    /// a table; the path is relative to the schedule
    file => table, string::<TableSource>(), needed "file = \"motion.csv\"";
    /// centre of rotation
    origin => origin, numbers::<3>("3 lengths"), default [0, 0, 0];
    /// between rows
    interpolation => interpolation, choice::<Interpolation>(), default "linear";
    /// how [rotations](#rotations-in-a-table) are written
    rotation => rotation, choice::<RotationForm>(), or "`\"euler_zyx\"`";
    /// [names in the file](#names-and-units-of-columns)
    columns => naming.columns, naming::columns::<Self>(), or "none";
    /// [units in the file](#names-and-units-of-columns)
    units => naming.units, naming::units::<Self>(), or "none";
} }

impl NamedColumns for TableMotion {
    const COLUMNS: &'static str = "azimuth_deg azimuth_rad time_s step dx dy dz rot_x_deg rot_x_rad \
                                   rot_y_deg rot_y_rad rot_z_deg rot_z_rad quat_w quat_x quat_y quat_z wm_x wm_y wm_z \
                                   rot_1_deg rot_1_rad rot_2_deg rot_2_rad rot_3_deg rot_3_rad";
}

impl BodyMotion for TableMotion {
    fn files(&self) -> Vec<&TableSource> {
        vec![&self.table]
    }

    fn check(&self, body: &Body) -> Result<()> {
        naming::check::<Self>(&self.naming, body, "table")?;
        naming::check_rotation(&self.naming, self.rotation, body, "table")?;
        body.places.finite("table.origin", &self.origin)
    }

    /// Reads the table; it must have values at every step.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let table = NamedTable {
            table: &self.table,
            interpolation: self.interpolation,
            naming: &self.naming,
            rotation: self.rotation,
            known: Self::names(),
            key: "table",
            place: "table",
        };
        let refused = |i: usize, name: &str| {
            (on.in_plane() && OUT_OF_PLANE.contains(&i)).then(|| {
                let name = name.trim_end_matches("_deg");
                format!(
                    "`{name}` is not 0, so body \"{}\" would leave the plane of the 2D mesh; use only dx, dy and rotations about z",
                    on.body.name
                )
            })
        };
        Ok(Arc::new(SixDegrees {
            values: ColumnValues::read(&table, COLUMNS, on, refused)?,
            origin: self.origin,
        }))
    }
}

/// A table of `dx, dy, dz, rot_x, rot_y, rot_z`.
#[derive(Debug)]
struct SixDegrees {
    values: ColumnValues<6>,
    origin: Vector,
}

impl ResolvedMotion for SixDegrees {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let [dx, dy, dz, values @ ..] = self.values.at(at.step);
        let [x_rate, y_rate, z_rate, rates @ ..] = self.values.rates(at);
        let turns = |axis: &usize| self.values.has(3 + axis);
        let rotation = |axis: usize| {
            let direction = std::array::from_fn(|i| f64::from(u8::from(i == axis)));
            Rotation::about(direction, self.origin, [values[axis], rates[axis]])
        };
        let rotations: Vec<Rotation> = match self.values.rotation.order() {
            Some(order) => order.into_iter().filter(turns).map(rotation).collect(),
            None if (0..3).any(|axis| turns(&axis)) => {
                vec![Rotation::by([values, rates], self.origin)]
            }
            None => Vec::new(),
        };
        let rotations = rotations.into_iter().map(|rotation| rotation.part(at.part));
        Some(Link::Rigid(RigidLink {
            rotations: rotations.collect(),
            translation: Some([scale([dx, dy, dz], at.part), [x_rate, y_rate, z_rate]]),
        }))
    }

    fn centre(&self) -> Option<Vector> {
        let turns = (3..6).any(|column| self.values.has(column));
        turns.then_some(self.origin)
    }

    fn notes(&self) -> &[Note] {
        &self.values.notes
    }
}
