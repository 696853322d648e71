//! A moving body: its tags and its motions, read from `[[body]]` or made in memory.

use super::keys::{Holds, Keys, Kind, angle, keys, patterns, string, table};
use super::motions::{
    AxisRotation, Beam, BodyMotion, Cyclic, Displacements, Modes, Rigid, SurfaceMotion,
    TableMotion, Translation, order,
};
use super::names::{Pattern, list};
use super::places::Places;
use super::ramp::Ramp;
use super::reader::Entry;
use super::setters::setters;
use super::steps::Step;
use azimesh_core::error::Result;
use std::any::Any;
use std::sync::Arc;

/// A moving body. Its motions act in this order: modes and surface displacements, rigid motion, table, then beam
/// and cyclic motion together. The motions of its parent follow.
///
/// ```
/// # use azimesh_deform as azimesh;
/// use azimesh::{AxisRotation, Body, Cyclic};
///
/// let wing = Body::new("wing", ["wing", "wing_tip_*"]).cyclic(Cyclic::new().pitch_deg(1, 5.0, 0.0));
/// let hinge = AxisRotation::new([0.0, 0.0, 1.0]).origin([0.75, 0.0, 0.0]);
/// let flap = Body::new("flap", ["flap"]).rotate(hinge.angle_deg(10.0)).parent("wing");
///
/// // Any other motion is a function of all nodes of the body.
/// let tail = Body::new("tail", ["tail"]).displacements(|step, places, displacements| {
///     let swing = 0.1 * step.azimuth_deg().unwrap_or(0.0).to_radians().sin();
///     for (x, d) in places.iter().zip(displacements) {
///         d[1] = swing * x[0] * x[0];
///     }
/// });
/// ```
#[derive(Debug, Clone)]
pub struct Body {
    /// Its name, unique among the bodies.
    pub(super) name: String,
    /// Boundary tags that move with it.
    pub(super) tags: Vec<Pattern>,
    /// Boundary tags that the mesh may lack.
    pub(super) optional_tags: Vec<Pattern>,
    /// Zones that move rigidly with it; it has these or tags.
    pub(super) zones: Vec<Pattern>,
    /// Its rotor; the parent's rotor, or the only one, when `None`.
    pub(super) rotor: Option<String>,
    /// Azimuth of its blade at rotor azimuth zero, in radians; the parent's offset when `None`.
    pub(super) azimuth_offset: Option<f64>,
    /// The body it moves with, which is declared earlier.
    pub(super) parent: Option<String>,
    /// Smooth start of its motions.
    pub(super) ramp: Option<Ramp>,
    /// Sorted by the order in which they act.
    pub(super) motions: Vec<Arc<dyn BodyMotion>>,
    pub(super) places: Places,
}

setters! { Body {
    /// Boundary tags that move with it if the mesh has them.
    optional_tags(tags: impl IntoIterator<Item = impl Into<String>>) |self|
        self.optional_tags.extend(Pattern::all(tags, &self.places, "optional_tags"));
    /// Zones whose nodes all move rigidly with it; it has no tags then.
    zones(zones: impl IntoIterator<Item = impl Into<String>>) |self| self.zones.extend(Pattern::all(zones, &self.places, "zones"));
    /// Pitch, flap and lag as harmonics of the azimuth.
    cyclic(cyclic: Cyclic) |self| self = self.with(cyclic);
    /// A rotation about an axis, before the translation.
    rotate(rotation: AxisRotation) |self| self = self.with_rigid(|rigid| rigid.rotate = Some(rotation));
    /// A translation.
    translate(translation: Translation) |self| self = self.with_rigid(|rigid| rigid.translate = Some(translation));
    /// Makes rotation and translation grow from zero at the first step to the full motion at the last.
    ramp() |self| self = self.with_rigid(|rigid| rigid.ramp = true);
    /// Six degrees of freedom from a [`Table`](super::table::Table), or a [`TableMotion`] of one.
    table(table: impl Into<TableMotion>) |self| self = self.with(table.into());
    /// Bending from a structural code.
    beam(beam: Beam) |self| self = self.with(beam);
    /// Mode shapes times generalised coordinates.
    modes(modes: Modes) |self| self = self.with(modes);
    /// Displacements or positions of its nodes from another program.
    surface(surface: SurfaceMotion) |self| self = self.with(surface);
    /// Displaces nodes by a function. For a step and the positions `(n, 3)` of all its nodes in the reference mesh, it
    /// writes their displacements `(n, 3)`, initially zero, all in mesh units. Nodes are in the order of the mesh. It is
    /// called once per step, when the mesh is known; velocities are differences of the neighbouring steps. Such a body
    /// has no twist and no children.
    displacements(function: impl Fn(&Step, &[[f64; 3]], &mut [[f64; 3]]) + Send + Sync + 'static) |self|
        self = self.with(Displacements { function: Arc::new(function), name: None });
    /// Displaces nodes by a named function, like [`displacements`](Self::displacements). Its runs can be resumed: the
    /// caller promises that functions of the same name give the same displacements.
    displacements_named(name: impl Into<String>, function: impl Fn(&Step, &[[f64; 3]], &mut [[f64; 3]]) + Send + Sync + 'static) |self|
        self = self.with(Displacements { function: Arc::new(function), name: Some(name.into()) });
    /// Makes all its motions start smoothly: from zero at the first step to the full motion after these seconds.
    ramp_seconds(seconds: f64) |self| self.ramp = Some(Ramp::of_seconds(seconds));
    /// Makes all its motions start smoothly: from zero at the first step to the full motion after this number of steps.
    ramp_steps(steps: usize) |self| self.ramp = Some(Ramp::of_steps(steps));
    /// Sets the body that it moves with, which must be added to the schedule before it.
    parent(name: impl Into<String>) |self| self.parent = Some(name.into());
    /// Sets its rotor, if the schedule has several.
    rotor(name: impl Into<String>) |self| self.rotor = Some(name.into());
    /// Azimuth of its blade at rotor azimuth zero, in degrees. The default is the parent's offset, or 0 without a parent.
    azimuth_offset_deg(azimuth: f64) |self| self.azimuth_offset = Some(azimuth.to_radians());
} }

type Motions = Vec<Arc<dyn BodyMotion>>;

impl Holds<Arc<dyn BodyMotion>> for Motions {
    fn hold(&mut self, motion: Arc<dyn BodyMotion>) {
        self.push(motion);
        self.sort_by_key(|motion| order(&**motion));
    }
}

/// A motion.
const fn motion<M: BodyMotion + Keys>() -> Kind<Arc<dyn BodyMotion>> {
    Kind {
        words: "a table, below",
        read: |entry| Ok(Arc::new(M::read(entry)?)),
        schema: M::schema,
    }
}

keys! { impl Body "[[body]]" = Self::new("", [""; 0]), {
    /// unique among the bodies
    name => name, string::<String>(), needed "name = \"blade\"";
    /// boundary tags that move with it; `*` stands for any characters, `?` for one
    tags => tags, patterns(), or "this or `zones`";
    /// tags (globs as in `tags`) that move with it if the mesh has them
    optional_tags => optional_tags, patterns(), or "none";
    /// zones (globs as in `tags`) whose nodes all [move rigidly](#zones-that-move-rigidly) with it
    zones => zones, patterns(), or "this or `tags`";
    /// name of its rotor, which gives its motions their axes and azimuth
    rotor => rotor, string::<String>(), or "that of its parent, or the only one";
    /// azimuth of this blade when the rotor's azimuth is zero; 90 for the second of four blades. [What it turns](#what-azimuth_offset-turns)
    azimuth_offset => azimuth_offset, angle(), or "0, or the offset of its parent";
    /// the body that it moves with, which must come earlier in the schedule
    parent => parent, string::<String>(), or "none";
    /// a smooth start of all its motions, below
    ramp => ramp, table::<Ramp>(), or "none";
    /// pitch, flap and lag as harmonics of the azimuth, or from a table
    cyclic => motions, motion::<Cyclic>(), or "none";
    /// a rotation, then a translation
    rigid => motions, motion::<Rigid>(), or "none";
    /// six degrees of freedom from a table
    table => motions, motion::<TableMotion>(), or "none";
    /// bending of a blade from a structural code
    beam => motions, motion::<Beam>(), or "none";
    /// mode shapes times coordinates
    modes => motions, motion::<Modes>(), or "none";
    /// displacements from another program
    surface => motions, motion::<SurfaceMotion>(), or "none";
} }

impl Body {
    /// Creates a body of these boundary tags; a tag may be a glob with `*` and `?`.
    pub fn new(name: impl Into<String>, tags: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let name = name.into();
        let places = Places::of_item(format!("body \"{name}\""));
        Self {
            tags: Pattern::all(tags, &places, "tags"),
            optional_tags: Vec::new(),
            zones: Vec::new(),
            name,
            rotor: None,
            azimuth_offset: None,
            parent: None,
            ramp: None,
            motions: Vec::new(),
            places,
        }
    }

    /// Adds a motion; it replaces one of the same type.
    fn with(mut self, motion: impl BodyMotion) -> Self {
        let sort = motion.type_id();
        self.motions.retain(|other| (**other).type_id() != sort);
        let motion: Arc<dyn BodyMotion> = Arc::new(motion);
        self.motions.hold(motion);
        self
    }

    fn with_rigid(self, change: impl FnOnce(&mut Rigid)) -> Self {
        let mut rigid = self.motion::<Rigid>().cloned().unwrap_or_default();
        change(&mut rigid);
        self.with(rigid)
    }

    /// Returns its motion of a type.
    pub(super) fn motion<M: BodyMotion>(&self) -> Option<&M> {
        let mut motions = self.motions.iter();
        motions.find_map(|motion| (&**motion as &dyn Any).downcast_ref())
    }

    /// Reads a body of a schedule.
    pub(super) fn read(entry: &Entry<'_>) -> Result<Self> {
        let section = Self::section(entry)?;
        let mut body = Self::empty();
        body.places = section.places();
        body.places.add(String::new(), section.line);
        body.set(&section)?;
        Ok(body)
    }

    /// Refuses a body that is incomplete or contradicts itself; `before` are the bodies before it in the schedule.
    pub(super) fn check(&self, before: &[Self]) -> Result<()> {
        let (name, places) = (&self.name, &self.places);
        places.check(!name.is_empty(), "name", "empty", "a name of its own")?;
        let is_there = |name: &String| before.iter().any(|body| body.name == *name);
        if is_there(name) {
            let message = format!("there are two bodies \"{name}\"; each needs a name of its own");
            return Err(places.error("name", message));
        }
        self.check_zones()?;
        if let Some(parent) = self.parent.as_ref().filter(|parent| !is_there(parent)) {
            let all = list(before.iter().map(|body| body.name.as_str()));
            let before = match before {
                [] => "no body is defined before it".to_owned(),
                _ => format!("defined before it: {all}"),
            };
            let message = format!(
                "`parent` = \"{parent}\" is not a body that is defined before its child; {before}"
            );
            return Err(places.error("parent", message));
        }
        places.angle("azimuth_offset", self.azimuth_offset.unwrap_or(0.0))?;
        if let Some(ramp) = &self.ramp {
            ramp.check(places)?;
        }
        self.motions
            .iter()
            .try_for_each(|motion| motion.check(self))
    }

    /// Refuses a body without a motion that does not turn with its rotor either.
    pub(super) fn check_moves(&self, turns: bool) -> Result<()> {
        if turns || !self.motions.is_empty() || self.parent.is_some() {
            return Ok(());
        }
        let message = format!(
            "body \"{}\" has no motion; give it [body.cyclic], [body.rigid] or another one, or list its tags \
             as `fixed`",
            self.name
        );
        Err(self.places.error("", message))
    }

    /// Refuses a body without tags or zones, or with both, and zones that would not stay rigid.
    fn check_zones(&self) -> Result<()> {
        let (name, places) = (&self.name, &self.places);
        let has_no_tags = self.tags.is_empty() && self.optional_tags.is_empty();
        match (has_no_tags, self.zones.is_empty()) {
            (true, true) => {
                let message = format!(
                    "body \"{name}\" has no `tags`; add for example  tags = [\"blade\"], or `zones` that move rigidly"
                );
                return Err(places.error("", message));
            }
            (false, false) => {
                let message = format!(
                    "body \"{name}\" has `tags` and `zones`; leave `tags` out, tags in its zones move with them, or make two bodies"
                );
                return Err(places.error("zones", message));
            }
            (false, true) => return Ok(()),
            (true, false) => {}
        }
        let is_rigid = |motion: &&Arc<dyn BodyMotion>| {
            let motion = &***motion as &dyn Any;
            motion.is::<Cyclic>() || motion.is::<Rigid>() || motion.is::<TableMotion>()
        };
        if self.motions.iter().all(|motion| is_rigid(&motion)) {
            return Ok(());
        }
        let message = format!(
            "body \"{name}\" moves its zones rigidly, which a beam, `modes`, `surface` or displacements do not; use [body.rigid], \
             [body.table] or [body.cyclic], or name its `tags` instead"
        );
        Err(places.error("zones", message))
    }

    /// Returns whether it is a beam.
    pub(super) fn bends(&self) -> bool {
        self.motion::<Beam>().is_some()
    }

    /// Returns whether its motions need the azimuth of a step.
    pub(super) fn has_harmonics(&self) -> bool {
        self.motions.iter().any(|motion| motion.has_harmonics())
    }
}
