//! A moving body: its tags and its motions, read from `[[body]]` or made in memory.

use super::motions::{
    AxisRotation, Beam, BodyMotion, Cyclic, Displacements, MOTIONS, Modes, Rigid, SurfaceMotion,
    TableMotion, Translation,
};
use super::names::{Pattern, list};
use super::places::Places;
use super::reader::{AngleUnit, Entry};
use super::setters::setters;
use super::steps::Step;
use azimesh_core::error::Result;
use std::any::Any;
use std::sync::Arc;

/// A moving body. Its motions act in the order modes and surface displacements, rigid motion, table, then beam
/// and cyclic motion as one; then those of its parent.
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
    /// Its name, of its own among the bodies.
    pub(super) name: String,
    /// Boundary tags that move with it.
    pub(super) tags: Vec<Pattern>,
    /// Azimuth of its blade when the rotor's is zero, in radians; that of its parent when `None`.
    pub(super) azimuth_offset: Option<f64>,
    /// The body it moves with, which stands before it.
    pub(super) parent: Option<String>,
    /// In the order in which they act.
    pub(super) motions: Vec<Arc<dyn BodyMotion>>,
    pub(super) places: Places,
}

setters! { Body {
    /// Pitch, flap and lag as harmonics of the azimuth.
    cyclic(cyclic: Cyclic) |self| self = self.with(cyclic);
    /// A rotation about an axis, before the translation.
    rotate(rotation: AxisRotation) |self| self = self.with_rigid(|rigid| rigid.rotate = Some(rotation));
    /// A translation.
    translate(translation: Translation) |self| self = self.with_rigid(|rigid| rigid.translate = Some(translation));
    /// Rotation and translation grow from nothing at the first step to the whole at the last.
    ramp() |self| self = self.with_rigid(|rigid| rigid.ramp = true);
    /// Six degrees of freedom from a [`Table`](super::table::Table), or a [`TableMotion`] of one.
    table(table: impl Into<TableMotion>) |self| self = self.with(table.into());
    /// Bending from a structural code.
    beam(beam: Beam) |self| self = self.with(beam);
    /// Mode shapes times generalised coordinates.
    modes(modes: Modes) |self| self = self.with(modes);
    /// Displacements or positions of its nodes from another program.
    surface(surface: SurfaceMotion) |self| self = self.with(surface);
    /// Displacements by a function: for a step and the positions `(n, 3)` of all its nodes in the reference
    /// mesh it writes their displacements `(n, 3)`, which are zero before, all in mesh units. Nodes are in
    /// the order of the mesh. It is called once a step, when the mesh is known; its velocity is the difference of
    /// the neighbouring steps. Such a body has no twist and no children.
    displacements(function: impl Fn(&Step, &[[f64; 3]], &mut [[f64; 3]]) + Send + Sync + 'static) |self|
        self = self.with(Displacements { function: Arc::new(function), name: None });
    /// Displacements by a function, as [`displacements`](Self::displacements), with a name: a run of it can be
    /// resumed, for which the caller promises that a function of the same name gives the same displacements.
    displacements_named(name: impl Into<String>, function: impl Fn(&Step, &[[f64; 3]], &mut [[f64; 3]]) + Send + Sync + 'static) |self|
        self = self.with(Displacements { function: Arc::new(function), name: Some(name.into()) });
    /// The body that it moves with, one that is given to the schedule before it.
    parent(name: impl Into<String>) |self| self.parent = Some(name.into());
    /// Azimuth of its blade when the rotor's is zero, in degrees; that of its parent unless it is set, else 0.
    azimuth_offset_deg(azimuth: f64) |self| self.azimuth_offset = Some(azimuth.to_radians());
} }

impl Body {
    /// A body of these boundary tags; a tag may be a glob with `*` and `?`.
    pub fn new(name: impl Into<String>, tags: impl IntoIterator<Item = impl Into<String>>) -> Self {
        let name = name.into();
        let places = Places::of_item(format!("body \"{name}\""));
        Self {
            tags: Pattern::all(tags, &places, "tags"),
            name,
            azimuth_offset: None,
            parent: None,
            motions: Vec::new(),
            places,
        }
    }

    /// Adds a motion; it replaces one of the same type.
    fn with(mut self, motion: impl BodyMotion) -> Self {
        let sort = motion.type_id();
        self.motions.retain(|other| (**other).type_id() != sort);
        self.add(Arc::new(motion));
        self
    }

    fn with_rigid(self, change: impl FnOnce(&mut Rigid)) -> Self {
        let mut rigid = self.motion::<Rigid>().cloned().unwrap_or_default();
        change(&mut rigid);
        self.with(rigid)
    }

    fn add(&mut self, motion: Arc<dyn BodyMotion>) {
        self.motions.push(motion);
        self.motions.sort_by_key(|motion| motion.order());
    }

    /// Its motion of a type.
    pub(super) fn motion<M: BodyMotion>(&self) -> Option<&M> {
        let mut motions = self.motions.iter();
        motions.find_map(|motion| (&**motion as &dyn Any).downcast_ref())
    }

    /// Reads a body of a schedule.
    pub(super) fn read(entry: &Entry<'_>, unit: AngleUnit) -> Result<Self> {
        let mut keys = vec!["name", "tags", "azimuth_offset", "parent"];
        keys.extend(MOTIONS.iter().map(|known| known.key));
        let section = entry.section("[[body]]", &keys)?;
        let name = section.require("name", "name = \"blade\"")?.string()?;
        let mut body = Self::new(name, [""; 0]);
        body.places = section.places();
        body.places.add(String::new(), section.line);
        body.tags = section
            .require("tags", "tags = [\"blade\"]")?
            .patterns("name the tags of the body")?;
        body.parent = section
            .optional("parent", Entry::string)?
            .map(str::to_owned);
        body.azimuth_offset = section.optional("azimuth_offset", |entry| entry.angle(unit))?;
        for known in MOTIONS {
            if let Some(motion) = section.optional(known.key, |entry| (known.read)(entry, unit))? {
                body.add(motion);
            }
        }
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
        places.check(
            !self.tags.is_empty(),
            "tags",
            "empty",
            "the tags of the body",
        )?;
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
        if self.motions.is_empty() && self.parent.is_none() {
            let message = format!(
                "body \"{name}\" has no motion; give it [body.cyclic], [body.rigid] or another one, or list its tags \
                 as `fixed`"
            );
            return Err(places.error("", message));
        }
        self.motions
            .iter()
            .try_for_each(|motion| motion.check(self))
    }

    /// Whether it is a beam.
    pub(super) fn bends(&self) -> bool {
        self.motion::<Beam>().is_some()
    }

    /// Whether its motions need the azimuth of a step.
    pub(super) fn has_harmonics(&self) -> bool {
        self.motions.iter().any(|motion| motion.has_harmonics())
    }
}
