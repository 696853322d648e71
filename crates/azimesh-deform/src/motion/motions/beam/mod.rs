//! `[body.beam]`: a blade that bends: translations and rotations of its sections over azimuth and span.

mod coverage;
mod lifting;
pub(super) mod sections;
mod slopes;

use super::cyclic::Hinges;
use super::link::Link;
use super::naming::{self, NamedColumns};
use super::table::COLUMNS as SIX;
use super::{At, BodyMotion, Clock, Cyclic, MapScope, OnMesh, ResolvedMotion, TableSource};
use crate::motion::body::Body;
use crate::motion::keys::{Kind, boolean, choice, keys, string};
use crate::motion::rotor::RotorAxes;
use crate::motion::setters::setters;
use crate::motion::table::{
    Column, ColumnNames, Interpolation, Naming, RotationForm, SpanHistory, Table, Unit,
};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::{Vector, distance, dot, sub};
use azimesh_core::{Note, note};
use coverage::check_span;
use lifting::{BladeEdges, LiftingLine};
use sections::Sections;
use serde::{Deserialize, Serialize};
use slopes::check_slopes;
use std::sync::Arc;

/// Elastic motion of a blade from a structural code: translations and rotations of its sections about a
/// lifting line, with the cyclic motion of the body as its pitch, flap and lag (eq. 2 and 3 of the method).
///
/// Columns of the table, in any order: `azimuth_deg` (or `azimuth_rad`, `time_s`, `step`) unless it holds for
/// all steps; `station`, the distance from the hub along the span; `dx`, `dy`, `dz` in mesh units;
/// `rot_x_deg`, `rot_y_deg`, `rot_z_deg` (or `_rad`), all in the axes of the blade. What is left out is 0.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Beam, Body, Table};
///
/// let columns = ["station", "dx", "dy", "dz", "rot_x_deg", "rot_y_deg", "rot_z_deg"];
/// let bent = [[0.0; 7], [2.0, 0.0, 0.0, 0.1, -1.5, 0.0, 0.0]];
/// let blade = Body::new("blade", ["blade"]).beam(Beam::new(Table::from_rows(columns, bent)));
/// ```
#[derive(Debug, Clone)]
pub struct Beam {
    table: TableSource,
    /// Table of the points about which sections turn; the quarter chord of the mesh when `None`.
    lifting_line: Option<TableSource>,
    /// Interpolation between azimuths; along the span it is linear.
    interpolation: Interpolation,
    /// True if the table may cover less than nine tenths of the blade.
    hold_ends: bool,
    rotation: Option<RotationForm>,
    naming: Naming,
}

impl Beam {
    /// Creates a beam whose sections turn about the quarter chord of the mesh; linear between rows.
    pub fn new(table: impl Into<TableSource>) -> Self {
        Self {
            table: table.into(),
            lifting_line: None,
            interpolation: Interpolation::Linear,
            hold_ends: false,
            rotation: None,
            naming: Naming::default(),
        }
    }
}

setters! { Beam {
    /// Sets the line about which sections turn: a table of `station, x, y, z`, points in the axes of the blade from the hub,
    /// in mesh units.
    lifting_line(table: impl Into<TableSource>) |self| self.lifting_line = Some(table.into());
    /// Sets the form of its rotations, which are about the axes of the blade.
    rotation(form: RotationForm) |self| self.rotation = Some(form);
    /// Interpolates between azimuths with a cubic spline, which is periodic if the table is.
    cubic() |self| self.interpolation = Interpolation::Cubic;
    /// Maps a column's name here to its name in the file: `column("dx", "u1")`. Columns of other names are ignored.
    column(name: impl Into<String>, in_file: impl Into<String>) |self| self.naming.columns.insert(name.into(), in_file.into());
    /// Sets the unit of a column, by its name here: `unit("station", "radius")` for fractions of the radius, `unit("dx", "mm")`,
    /// `unit("rot_x_deg", "rad")`, or a factor.
    unit(name: impl Into<String>, unit: impl Into<Unit>) |self| self.naming.units.insert(name.into(), unit.into());
    /// Allows a table that covers less than nine tenths of the blade: the values of its first and last station hold
    /// past them.
    hold_ends() |self| self.hold_ends = true;
} }

keys! { impl Beam "[body.beam]" = Self::new(""), {
    /// columns `azimuth_deg` (or `time_s`, `step`), `station`, and any of `dx`, `dy`, `dz`, `rot_x_deg`, `rot_y_deg`, `rot_z_deg`; missing ones are 0. Rows in any order. Without the first column it is valid at every step
    table => table, string::<TableSource>(), needed "table = \"beam.csv\"";
    /// centres of rotation of the sections: a quarter of the chord behind the leading edge (the end of a section towards `e_y`, in a clockwise rotor the other end; the middle of a blunt end), measured in the mesh at the stations of the table and continued straight through the rounded ends of the blade (a tenth of the chord); or a table `station,x,y,z` of points along the blade's axes from the hub. Beyond its ends it is parallel to the span
    lifting_line => lifting_line, LINE, default "quarter_chord";
    /// between azimuths; between stations it is linear
    interpolation => interpolation, choice::<Interpolation>(), default "linear";
    /// allows a table that covers less than nine tenths of the blade
    hold_ends => hold_ends, boolean(), default false;
    /// how [rotations](#rotations-in-a-table) are written, about the axes of the blade
    rotation => rotation, choice::<RotationForm>(), or "`\"euler_zyx\"`";
    /// [names in the file](#names-and-units-of-columns)
    columns => naming.columns, naming::columns::<Self>(), or "none";
    /// [units in the file](#names-and-units-of-columns)
    units => naming.units, naming::units::<Self>(), or "none";
} }

const LINE: Kind<Option<TableSource>> = Kind {
    words: "string",
    read: |entry| {
        let line = Some(entry.string()?).filter(|line| *line != "quarter_chord");
        Ok(line.map(TableSource::from))
    },
    schema: string::<String>().schema,
};

impl NamedColumns for Beam {
    const COLUMNS: &'static str = "azimuth_deg azimuth_rad time_s step station dx dy dz rot_x_deg rot_x_rad \
                                   rot_y_deg rot_y_rad rot_z_deg rot_z_rad quat_w quat_x quat_y quat_z wm_x wm_y wm_z \
                                   rot_1_deg rot_1_rad rot_2_deg rot_2_rad rot_3_deg rot_3_rad";
}

impl BodyMotion for Beam {
    fn files(&self) -> Vec<&TableSource> {
        [&self.table]
            .into_iter()
            .chain(&self.lifting_line)
            .collect()
    }

    fn check(&self, body: &Body) -> Result<()> {
        naming::check::<Self>(&self.naming, body, "beam")?;
        naming::check_rotation(&self.naming, self.rotation, body, "beam")?;
        match body.motion::<Cyclic>() {
            Some(cyclic) if cyclic.pitch_axis != [0.0; 2] => Err(body.places.error(
                "beam",
                format!(
                    "body \"{}\" has both `pitch_axis` and a beam, whose sections pitch about its lifting line; leave \
                     `pitch_axis` out",
                    body.name
                ),
            )),
            _ => Ok(()),
        }
    }

    /// Reads the table and the lifting line; there must be values at every step.
    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let body = &on.body.name;
        if on.in_plane() {
            let message = format!(
                "body \"{body}\" is a beam, which needs a 3D mesh; in 2D a table or modes bend it"
            );
            return Err(on.error("beam", message));
        }
        let (table, line) = (self.table.read(on, "beam")?, self.read_line(on)?);
        let edges = BladeEdges::of(on);
        let [low, high] = edges.span();
        let radius = low.abs().max(high.abs());
        let naming = self.naming.with_units_of(&table, &Self::names())?;
        let names = naming::resolve(&naming, on, Some(radius), "beam")?;
        let rotation = naming::rotation_of(&table, self.rotation, on, "beam")?;
        let (span, others) = read_span(&table, names.clone(), rotation, self.interpolation)?;
        let note = on.clock.check(span.history(), on, "beam")?;
        let mut notes = check_span(&span, &table, body, edges.span(), self.hold_ends)?;
        notes.extend(note);
        notes.extend(naming::notes(&naming, &names, &others, &table, body));
        let told = check_slopes(&span, &table, (&self.naming, rotation), body);
        told.into_iter().for_each(|note| on.warn(note));
        let (line, name) = match line {
            Some(line) => (
                LiftingLine::from_table(&line, body, edges.span())?,
                "lifting line",
            ),
            None => {
                let line = LiftingLine::quarter_chord(&edges, span.stations(), body);
                let line = line.map_err(|error| error.at(on.body.places.of("beam")));
                (line?, "quarter chord")
            }
        };
        let [from, to] = line.ends().map(|[x, y, z]| on.blade.point(x, y, z));
        let digits = (4.0 - distance(from, to).log10().floor()).clamp(0.0, 17.0) as usize;
        notes.push(note!(
            "beam_line",
            "body \"{body}\": its {name} goes from {} to {}, with the leading edge towards {}",
            rounded(from, digits),
            rounded(to, digits),
            rounded(on.blade.leading_edge(), 3)
        ));
        if let Some(beside) = line.beside(body, &edges.bounds()) {
            on.warn(beside);
        }
        Ok(Arc::new(BendingBlade {
            offset: Clock::offset(span.history(), on),
            span,
            rotation,
            line,
            notes,
            blade: on.blade,
            hinges: Hinges::of(on)?,
        }))
    }
}

impl Beam {
    fn read_line(&self, on: &OnMesh<'_>) -> Result<Option<Arc<Table>>> {
        let line = self.lifting_line.as_ref();
        let told = |error: Error| match error.path {
            Some(_) => error,
            None => Error {
                message: format!(
                    "{}; `lifting_line` is \"quarter_chord\" or a table  station,x,y,z",
                    error.message
                ),
                ..error
            },
        };
        line.map(|line| line.read(on, "beam").map_err(told))
            .transpose()
    }
}

/// Six values at every station and azimuth, and the line that sections turn about.
#[derive(Debug)]
struct BendingBlade {
    span: SpanHistory,
    rotation: RotationForm,
    line: LiftingLine,
    blade: RotorAxes,
    offset: f64,
    hinges: Option<Hinges>,
    notes: Vec<Note>,
}

impl ResolvedMotion for BendingBlade {
    fn is_of_blade(&self) -> bool {
        true
    }

    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let promise = "the table was checked at every step";
        let key = self.span.history().key();
        let place = Clock::place(key, at.step, self.offset).expect(promise);
        let hinges = self.hinges.as_ref().map(|hinges| hinges.rotations(at));
        Some(Link::Sections(Box::new(Sections::new(
            (self.span.at(place).expect(promise), self.rotation),
            (&self.line, self.blade),
            at.part,
            at.clock.rate_in(self.span.history(), at.step),
            hinges,
        ))))
    }

    fn map_scope(&self) -> MapScope {
        MapScope::Sections
    }

    fn centre_line(&self, points: &[Vector]) -> Option<CentreLine> {
        let stations = points
            .iter()
            .map(|x| dot(sub(*x, self.blade.hub), self.blade.e_x));
        let span = stations.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], r| {
            [low.min(r), high.max(r)]
        });
        Some(CentreLine {
            line: self.line.clone(),
            blade: self.blade,
            // A body that shares all of its nodes with others has no node of its own.
            span: if span[0] <= span[1] { span } else { [0.0; 2] },
        })
    }

    fn notes(&self) -> &[Note] {
        &self.notes
    }
}

/// The lifting line of a blade in the reference mesh, its ends held.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct CentreLine {
    line: LiftingLine,
    blade: RotorAxes,
    span: [f64; 2],
}

impl CentreLine {
    /// Returns the point of the line at the station of `x`.
    pub fn at(&self, x: Vector) -> Vector {
        let station = dot(sub(x, self.blade.hub), self.blade.e_x);
        let [x, y, z] = self.line.at(station.clamp(self.span[0], self.span[1]));
        self.blade.point(x, y, z)
    }
}

/// Reads the table; also returns its unused columns. Missing columns are 0.
fn read_span(
    table: &Arc<Table>,
    names: ColumnNames,
    rotation: RotationForm,
    interpolation: Interpolation,
) -> Result<(SpanHistory, Vec<String>)> {
    let mut columns = table.columns_as(names)?;
    let key = columns.optional_key()?;
    let station = columns.require("station")?;
    let mut six: Vec<Option<Column>> = Vec::new();
    six.extend(SIX[..3].iter().map(|name| columns.optional(name)));
    let turns = rotation.pick(&mut columns)?;
    let others = columns.done()?;
    let (table, turns) = rotation.vectors(Arc::clone(table), &turns, false)?;
    six.extend(turns);
    if six.iter().all(Option::is_none) {
        let names = rotation.columns().join(", ");
        let message = format!("the table has none of the columns dx, dy, dz, {names}");
        return Err(table.header_error(message));
    }
    let span = SpanHistory::from_table(&table, key, station, &six, interpolation)?;
    Ok((span, others))
}

/// Formats a position with this many decimals; a value that rounds to zero has no sign.
fn rounded(x: Vector, digits: usize) -> String {
    let least = 0.5 * 0.1_f64.powi(digits as i32);
    let numbers = x.map(|x| format!("{:.digits$}", if x.abs() < least { 0.0 } else { x }));
    format!("[{}]", numbers.join(", "))
}
