//! `[body.cyclic]`: pitch, flap and lag as harmonics of the azimuth, and from a table.

use super::link::{Link, RigidLink};
use super::naming::{self, ColumnValues, NamedColumns, NamedTable};
use super::series::{ANGLES, Series};
use super::{At, BodyMotion, OnMesh, ResolvedMotion, Rotation, TableSource};
use crate::motion::body::Body;
use crate::motion::keys::{angle, choice, keys, number, numbers, string};
use crate::motion::rotor::RotorAxes;
use crate::motion::setters::setters;
use crate::motion::steps::Step;
use crate::motion::table::{Interpolation, Naming, Unit};
use azimesh_core::error::{Error, Result};
use azimesh_core::geometry::vector::Vector;
use azimesh_core::{Note, note};
use std::f64::consts::TAU;
use std::sync::Arc;

/// Cyclic motion of a blade (eq. 11 of the method): pitch, flap and lag as harmonics of the azimuth
/// `psi` of the blade,
///
/// ```text
/// pitch(psi) = collective + sum over m of [ A_m sin(m psi + phase) + B_m cos(m psi + phase) ]
/// ```
///
/// and likewise `flap` about its coning angle, and `lag`. Angles of a [`table`](Self::table) are added.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{Body, Cyclic};
///
/// let cyclic = Cyclic::new()
///     .collective_deg(10.04)
///     .pitch_deg(1, -7.65, -0.96) // -7.65 sin psi - 0.96 cos psi
///     .coning_deg(2.6)
///     .flap_hinge(0.2);
/// let blade = Body::new("blade", ["blade"]).cyclic(cyclic);
/// ```
#[derive(Debug, Clone, Default)]
pub struct Cyclic {
    /// Collective and harmonics of the pitch angle.
    pub(in crate::motion) pitch: Series,
    /// Coning and harmonics of the flap angle.
    pub(in crate::motion) flap: Series,
    /// Harmonics of the lag angle.
    pub(in crate::motion) lag: Series,
    /// Added to every harmonic's argument, in radians.
    pub(in crate::motion) phase: f64,
    /// Chordwise and shaftwise offset of the pitch axis at the hub, in mesh units.
    pub(in crate::motion) pitch_axis: [f64; 2],
    /// Spanwise offset of the flap and lag hinge, in mesh units.
    pub(in crate::motion) flap_hinge: f64,
    /// Angles that are added.
    table: Option<TableSource>,
    interpolation: Interpolation,
    naming: Naming,
}

impl Cyclic {
    /// Creates a motion with zero angles at every azimuth.
    pub fn new() -> Self {
        Self::default()
    }

    fn series(&self) -> [(&'static str, &Series); 3] {
        [
            ("pitch", &self.pitch),
            ("flap", &self.flap),
            ("lag", &self.lag),
        ]
    }
}

setters! { Cyclic {
    /// Sets the mean of the pitch angle, in degrees.
    collective_deg(angle: f64) |self| self.pitch.mean = angle.to_radians();
    /// Sets harmonic `m` of the pitch angle, from 1: `sin` and `cos` in degrees.
    pitch_deg(m: usize, sin: f64, cos: f64) |self| self.pitch.set_deg(m, sin, cos);
    /// Sets the mean of the flap angle, in degrees.
    coning_deg(angle: f64) |self| self.flap.mean = angle.to_radians();
    /// Sets harmonic `m` of the flap angle, from 1: `sin` and `cos` in degrees.
    flap_deg(m: usize, sin: f64, cos: f64) |self| self.flap.set_deg(m, sin, cos);
    /// Sets harmonic `m` of the lag angle, from 1: `sin` and `cos` in degrees.
    lag_deg(m: usize, sin: f64, cos: f64) |self| self.lag.set_deg(m, sin, cos);
    /// Sets the phase added to the argument of every harmonic, in degrees.
    phase_deg(phase: f64) |self| self.phase = phase.to_radians();
    /// Sets the offset of the pitch axis from the hub, chordwise and shaftwise, in mesh units. The axis is parallel to the span.
    pitch_axis(chordwise: f64, shaftwise: f64) |self| self.pitch_axis = [chordwise, shaftwise];
    /// Sets the spanwise distance of the flap and lag hinge from the hub, in mesh units.
    flap_hinge(spanwise: f64) |self| self.flap_hinge = spanwise;
    /// Adds angles from a table of `azimuth_deg` (or `azimuth_rad`, `time_s`, `step`) and any of `pitch_deg`, `flap_deg`,
    /// `lag_deg` (or `_rad`); missing columns are 0.
    table(table: impl Into<TableSource>) |self| self.table = Some(table.into());
    /// Maps a column's name here to its name in the file: `column("pitch_deg", "theta")`. Columns of other names are
    /// ignored.
    column(name: impl Into<String>, in_file: impl Into<String>) |self| self.naming.columns.insert(name.into(), in_file.into());
    /// Sets the unit of a column, by its name here: `unit("pitch_deg", "rad")`, or a factor.
    unit(name: impl Into<String>, unit: impl Into<Unit>) |self| self.naming.units.insert(name.into(), unit.into());
    /// Interpolates the table with a cubic spline, which is periodic if the table is.
    cubic() |self| self.interpolation = Interpolation::Cubic;
} }

keys! { impl Cyclic "[body.cyclic]" = Self::new(), {
    /// mean pitch
    collective => pitch.mean, angle(), default 0;
    /// harmonics 1, 2, ...; a missing `sin` or `cos` is 0
    pitch => pitch.harmonics, ANGLES, default [];
    /// mean flap
    coning => flap.mean, angle(), default 0;
    /// harmonics of flap
    flap => flap.harmonics, ANGLES, default [];
    /// harmonics of lag
    lag => lag.harmonics, ANGLES, default [];
    /// added in every harmonic
    phase => phase, angle(), default 0;
    /// offset of the pitch axis from the hub along `e_y` (towards the leading edge; in a clockwise rotor the trailing edge) and `e_z`
    pitch_axis => pitch_axis, numbers::<2>("2 lengths"), default [0, 0];
    /// `h`, the offset of the flap and lag hinge along the span
    flap_hinge => flap_hinge, number("length"), default 0;
    /// a table of `pitch_deg`, `flap_deg` and `lag_deg` over `azimuth_deg`, `time_s` or `step`, added to the series; missing columns are 0, and `_rad` is understood. It has the signs of `[rotor]`, and no `phase`
    table => table, string::<TableSource>(), or "none";
    /// between rows of the table
    interpolation => interpolation, choice::<Interpolation>(), default "linear", with table;
    /// [names in the file](#names-and-units-of-columns)
    columns => naming.columns, naming::columns::<Self>(), or "none", with table;
    /// [units in the file](#names-and-units-of-columns)
    units => naming.units, naming::units::<Self>(), or "none", with table;
} }

impl NamedColumns for Cyclic {
    const COLUMNS: &'static str =
        "azimuth_deg azimuth_rad time_s step pitch_deg pitch_rad flap_deg flap_rad lag_deg lag_rad";
}

impl BodyMotion for Cyclic {
    fn has_harmonics(&self) -> bool {
        let mut series = self.series().into_iter();
        series.any(|(_, series)| !series.harmonics.is_empty())
    }

    fn files(&self) -> Vec<&TableSource> {
        self.table.iter().collect()
    }

    fn check(&self, body: &Body) -> Result<()> {
        for (name, series) in self.series() {
            series.check(&body.places, &format!("cyclic.{name}"), name)?;
        }
        naming::check::<Self>(&self.naming, body, "cyclic")?;
        body.places.angle("cyclic.phase", self.phase)?;
        body.places.finite("cyclic.pitch_axis", &self.pitch_axis)?;
        body.places.finite("cyclic.flap_hinge", &[self.flap_hinge])
    }

    fn check_plane(&self, body: &Body, upright: bool) -> Result<()> {
        let (leaving, keys, why) = if upright {
            let why = "pitches or flaps, but the 2D mesh turns about a shaft along z; turn the body about [0, 0, 1] with \
                       [body.rigid]";
            let keys = [
                "cyclic.collective",
                "cyclic.pitch",
                "cyclic.coning",
                "cyclic.flap",
            ];
            ([&self.pitch, &self.flap], keys.to_vec(), why)
        } else {
            let why = "flaps or lags, which needs a 3D mesh; in 2D a cyclic motion is pitch alone";
            let keys = ["cyclic.coning", "cyclic.flap", "cyclic.lag"];
            ([&self.flap, &self.lag], keys.to_vec(), why)
        };
        if leaving.iter().all(|series| series.is_zero()) {
            return Ok(());
        }
        let message = format!("body \"{}\" {why}", body.name);
        Err(Error::input(message).at(body.places.first_of(&keys)))
    }

    fn resolve(&self, on: &OnMesh<'_>) -> Result<Arc<dyn ResolvedMotion>> {
        let hinges = self.hinges(on)?;
        let notes = hinges.table.as_ref().map(|table| table.notes.clone());
        if let Some(turns) = hinges.more_than_a_turn(&on.body.name) {
            on.warn(turns);
        }
        Ok(Arc::new(Blade {
            notes: notes.unwrap_or_default(),
            hinges,
            bends: on.body.bends(),
        }))
    }
}

impl Cyclic {
    fn hinges(&self, on: &OnMesh<'_>) -> Result<Hinges> {
        // Refuses angles about an axis in the plane of a 2D mesh.
        let (allowed, left) = if on.blade.is_upright() {
            (2, "lag_deg")
        } else {
            (0, "pitch_deg")
        };
        let refused = |i: usize, _: &str| {
            let body = &on.body.name;
            (on.blade.in_plane && i != allowed).then(|| {
                format!("body \"{body}\" would leave the plane of the 2D mesh; use only {left}")
            })
        };
        let read = |table: &TableSource| {
            let table = NamedTable {
                table,
                interpolation: self.interpolation,
                naming: &self.naming,
                rotation: None,
                known: Self::names(),
                key: "cyclic",
                place: "cyclic.table",
            };
            ColumnValues::read(&table, ["pitch", "flap", "lag"], on, refused)
        };
        Ok(Hinges {
            table: self.table.as_ref().map(read).transpose()?,
            cyclic: self.clone(),
            blade: on.blade,
            offset: on.offset,
        })
    }
}

/// The cyclic motion of a blade on a mesh.
#[derive(Debug)]
struct Blade {
    hinges: Hinges,
    /// True if the blade is a beam; a beam includes the hinge rotations.
    bends: bool,
    notes: Vec<Note>,
}

/// Pitch, flap and lag of a blade.
#[derive(Debug)]
pub(super) struct Hinges {
    cyclic: Cyclic,
    table: Option<ColumnValues<3>>,
    blade: RotorAxes,
    offset: f64,
}

impl Hinges {
    /// Returns the angles of the blade of a body, if it has a cyclic motion.
    pub fn of(on: &OnMesh<'_>) -> Result<Option<Self>> {
        let cyclic = on.body.motion::<Cyclic>();
        cyclic.map(|cyclic| cyclic.hinges(on)).transpose()
    }

    /// Returns pitch, flap and lag at a step, without the signs of the rotor.
    fn angles(&self, step: &Step) -> [f64; 3] {
        let (cyclic, psi) = (&self.cyclic, step.azimuth + self.offset);
        let table = self.table.as_ref();
        let added = table.map_or([0.0; 3], |table| table.at(step));
        let series = cyclic.series();
        std::array::from_fn(|i| series[i].1.at(psi, cyclic.phase) + added[i])
    }

    /// Returns their rates, in radians per second.
    fn rates(&self, at: &At<'_>) -> [f64; 3] {
        let (cyclic, psi) = (&self.cyclic, at.step.azimuth + self.offset);
        let rate = at.step.azimuth_rate.unwrap_or(0.0);
        let table = self.table.as_ref();
        let added = table.map_or([0.0; 3], |table| table.rates(at));
        let series = cyclic.series();
        std::array::from_fn(|i| series[i].1.slope(psi, cyclic.phase) * rate + added[i])
    }

    /// Returns a note if pitch, flap or lag exceeds one turn, which is not plausible for a blade.
    fn more_than_a_turn(&self, body: &str) -> Option<Note> {
        let added = self.table.as_ref().map_or([0.0; 3], |table| table.bound);
        let sums = self.cyclic.series().into_iter().zip(added);
        let mut sums = sums.map(|((angle, series), added)| (angle, series.bound() + added));
        let (angle, sum) = sums.find(|(_, sum)| *sum > TAU)?;
        let sum_deg = sum.to_degrees();
        Some(note!(
            "more_than_a_turn",
            "body \"{body}\": mean and harmonics of its {angle} add up to {sum_deg:.0} degrees, more than a full \
             turn; check `angle_unit`"
        ))
    }

    /// Equations 2 and 3 of the method without a beam, in the blade's own frame at its azimuth `psi`:
    ///
    /// ```text
    /// x_r = Rx(pitch) (x - x_ref),                 x_ref = O + r e_x + pitch_axis
    /// x'  = O + h e_x + Rz(lag) Ry(-flap) (x_r + x_ref - O - h e_x)
    /// ```
    ///
    /// Its rotations, pitch first. The pitch axis is parallel to the span, so the pitch rotation needs no station `r`.
    pub fn rotations(&self, at: &At<'_>) -> [Rotation; 3] {
        let blade = &self.blade;
        let signs = &blade.signs;
        let hinge = blade.point(self.cyclic.flap_hinge, 0.0, 0.0);
        let (angles, rates) = (self.angles(at.step), self.rates(at));
        let rotation = |axis, origin, i: usize, sign: f64| {
            Rotation::about(axis, origin, [sign * angles[i], sign * rates[i]])
        };
        [
            rotation(blade.e_x, self.pitch_centre(), 0, signs.pitch),
            rotation(blade.e_y, hinge, 1, -signs.flap),
            rotation(blade.e_z, hinge, 2, signs.lag),
        ]
    }

    /// Returns the point of the pitch axis at the hub.
    fn pitch_centre(&self) -> Vector {
        let [chordwise, shaftwise] = self.cyclic.pitch_axis;
        self.blade.point(0.0, chordwise, shaftwise)
    }
}

impl ResolvedMotion for Blade {
    fn link(&self, at: &At<'_>) -> Option<Link<'_>> {
        let rotations = || {
            self.hinges
                .rotations(at)
                .map(|rotation| rotation.part(at.part))
        };
        (!self.bends).then(|| {
            Link::Rigid(RigidLink {
                rotations: rotations().to_vec(),
                translation: None,
            })
        })
    }

    fn centre(&self) -> Option<Vector> {
        Some(self.hinges.pitch_centre())
    }

    fn is_of_blade(&self) -> bool {
        true
    }

    fn cyclic_angles(&self, step: &Step) -> Option<[f64; 3]> {
        Some(self.hinges.angles(step))
    }

    fn notes(&self) -> &[Note] {
        &self.notes
    }
}
