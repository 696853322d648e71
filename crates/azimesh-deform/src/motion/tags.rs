//! The role of every boundary tag of a mesh, by the schedule.

use super::body::Body;
use super::boundaries::{Boundaries, Others};
use super::names::{Pattern, list};
use super::rotor::Frame;
use super::schedule::Schedule;
use super::surface::{Role, TagRole};
use super::zones::DeformingZone;
use azimesh_core::error::{Error, Position, Result, option};
use azimesh_core::{Note, note};
use azimesh_io::formats::openfoam::neighbour_patch;
use azimesh_io::mesh::{Boundary, EMPTY, Group};

/// A periodic pair on a mesh: the tags of its sides, as indices into
/// [`Surface::tags`](super::Surface::tags), ascending and at least one on each side.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PeriodicTags {
    /// Tags of the one side.
    pub a: Vec<usize>,
    /// Tags of the other side.
    pub b: Vec<usize>,
    /// Position in the schedule.
    pub(crate) place: Option<Position>,
}

/// Every boundary tag of a mesh, in file order, and the periodic pairs.
pub(super) struct TagRoles {
    pub tags: Vec<TagRole>,
    pub periodic: Vec<PeriodicTags>,
}

/// Statement of the schedule about a tag.
#[derive(Clone, Copy, PartialEq)]
enum Named {
    Role(Role),
    /// A side, 0 or 1, of the periodic pair of this index.
    Periodic(usize, u8),
    Free,
}

impl TagRoles {
    pub(super) fn find(
        tags: &[&Group],
        schedule: &Schedule,
        zone: Option<&DeformingZone>,
        boundary: &Boundary,
    ) -> Result<Self> {
        let (bodies, boundaries) = (&schedule.bodies, &schedule.boundaries);
        if tags.is_empty() {
            return Err(Error::input(format!(
                "the mesh has no boundary tags, so nothing says which nodes move; convert it with {} connected, which gives each part \
                 of its boundary a tag",
                option("tag-boundary")
            )));
        }
        if bodies.len() > usize::from(u16::MAX) {
            return Err(Error::input(format!(
                "at most {} bodies are possible",
                u16::MAX
            )));
        }
        let names: Vec<&str> = tags.iter().map(|tag| tag.name.as_str()).collect();
        let mut named = named_tags(&names, bodies, boundaries)?;
        let is_side = |i: usize| is_empty_side(boundary, tags[i]);
        check_sides(&names, &named, is_side)
            .map_err(|error| error.at(schedule.places.of("boundaries")))?;
        let unnamed: Vec<usize> = (0..tags.len())
            .filter(|&i| named[i].is_none() && !is_side(i) && touches(tags[i], zone, boundary))
            .collect();
        let others = match boundaries.others {
            Some(Others::Free) => None,
            Some(Others::Fixed) => Some(Named::Role(Role::Fixed)),
            Some(Others::Slide) => Some(Named::Role(Role::Sliding)),
            None if unnamed.is_empty() => None,
            // Nothing deforms.
            None if bodies.iter().all(|body| !body.zones.is_empty()) => {
                Some(Named::Role(Role::Fixed))
            }
            None => {
                let mut error = not_named(&names, &unnamed);
                error.message += &offers(boundary, tags, &unnamed);
                return Err(error.at(schedule.places.of("boundaries")));
            }
        };
        if boundaries.others == Some(Others::Free) {
            check_free(boundary, tags, &unnamed)
                .map_err(|error| error.at(schedule.places.of("boundaries.others")))?;
        }
        let free = (0..tags.len()).filter(|&i| named[i] == Some(Named::Free));
        check_free(boundary, tags, &free.collect::<Vec<usize>>())
            .map_err(|error| error.at(schedule.places.of("boundaries.free")))?;
        unnamed.iter().for_each(|&i| named[i] = others);
        check_wedges(tags, &named)
            .map_err(|error| error.at(schedule.places.of("boundaries.slide")))?;
        let role = |i: usize| match named[i] {
            Some(Named::Role(role)) => Some(role),
            Some(Named::Periodic(..) | Named::Free) | None => None,
        };
        let roles = (0..tags.len()).map(|i| TagRole {
            tag: names[i].to_owned(),
            role: role(i),
            periodic: matches!(named[i], Some(Named::Periodic(..))),
        });
        let roles: Vec<TagRole> = roles.collect();
        check_bodies(tags, &roles, schedule, zone, boundary)?;
        Ok(Self {
            tags: roles,
            periodic: periodic_tags(&named, boundaries),
        })
    }
}

/// Returns what the schedule says of each tag; `None` where it says nothing.
fn named_tags(
    names: &[&str],
    bodies: &[Body],
    boundaries: &Boundaries,
) -> Result<Vec<Option<Named>>> {
    let mut named: Vec<Option<Named>> = vec![None; names.len()];
    let required = all_named(bodies, boundaries).map(|(pattern, what)| {
        let found = pattern.find("tag", names)?;
        Ok((pattern, what, found))
    });
    let optional = optional_tags(bodies).map(|(pattern, what)| {
        let found = (0..names.len()).filter(|&i| pattern.matches(names[i]));
        Ok((pattern, what, found.collect()))
    });
    for named_here in required.chain(optional) {
        let (pattern, what, found): (&Pattern, Named, Vec<usize>) = named_here?;
        for tag in found {
            if let Some(before) = named[tag].replace(what)
                && before != what
            {
                let error = two_roles(names[tag], before, what, bodies);
                return Err(error.at(pattern.place.clone()));
            }
        }
    }
    Ok(named)
}

impl Schedule {
    /// A note for each of the `optional_tags` that no tag of the mesh matches.
    pub(crate) fn unmatched(&self, tags: &[TagRole]) -> impl Iterator<Item = Note> {
        let all = self.bodies.iter().flat_map(|body| {
            let patterns = body.optional_tags.iter();
            patterns.map(move |pattern| (body, pattern))
        });
        let unmatched =
            all.filter(|(_, pattern)| !tags.iter().any(|tag| pattern.matches(&tag.tag)));
        unmatched.map(|(body, pattern)| Note {
            position: pattern.place.clone(),
            ..note!(
                "no_optional_tag",
                "no tag of the mesh matches \"{}\" in `optional_tags` of body \"{}\"",
                pattern.text,
                body.name
            )
            .file(&self.path)
        })
    }
}

/// Tags of bodies that the mesh may lack.
fn optional_tags(bodies: &[Body]) -> impl Iterator<Item = (&Pattern, Named)> {
    bodies.iter().enumerate().flat_map(|(i, body)| {
        let role = Named::Role(Role::Moving(i as u16));
        body.optional_tags.iter().map(move |tag| (tag, role))
    })
}

/// Returns every name in the schedule that the mesh must have, with its role.
fn all_named<'s>(
    bodies: &'s [Body],
    boundaries: &'s Boundaries,
) -> impl Iterator<Item = (&'s Pattern, Named)> {
    let moving = bodies.iter().enumerate().flat_map(|(i, body)| {
        let role = Role::Moving(i as u16);
        body.tags.iter().map(move |tag| (tag, Named::Role(role)))
    });
    let fixed = boundaries.fixed.iter();
    let slide = boundaries.slide.iter();
    let periodic = boundaries.periodic.iter().enumerate();
    moving
        .chain(fixed.map(|tag| (tag, Named::Role(Role::Fixed))))
        .chain(slide.map(|tag| (tag, Named::Role(Role::Sliding))))
        .chain(boundaries.free.iter().map(|tag| (tag, Named::Free)))
        .chain(periodic.flat_map(|(i, pair)| {
            [
                (&pair.a, Named::Periodic(i, 0)),
                (&pair.b, Named::Periodic(i, 1)),
            ]
        }))
}

fn two_roles(tag: &str, before: Named, after: Named, bodies: &[Body]) -> Error {
    let name = |named| match named {
        Named::Role(Role::Moving(body)) => {
            format!("in body \"{}\"", bodies[usize::from(body)].name)
        }
        Named::Role(Role::Fixed) => "fixed".into(),
        Named::Role(Role::Sliding) => "sliding".into(),
        Named::Periodic(..) => "periodic".into(),
        Named::Free => "free".into(),
    };
    Error::input(match (before, after) {
        (Named::Periodic(one, _), Named::Periodic(other, _)) if one == other => format!(
            "tag \"{tag}\" is on both sides of a periodic pair; each side needs tags of its own"
        ),
        (Named::Periodic(..), Named::Periodic(..)) => {
            format!("tag \"{tag}\" is in two periodic pairs; it can be in one at most")
        }
        _ => format!(
            "tag \"{tag}\" has two roles, {} and {}; give it one",
            name(before),
            name(after)
        ),
    })
}

fn not_named(names: &[&str], unnamed: &[usize]) -> Error {
    Error::input(format!(
        "the schedule gives these tags no role: {}; name them under a body, `fixed`, `slide`, `free` or `periodic`, or \
         set others = \"fixed\", \"free\" or \"slide\" in [boundaries]",
        list(unnamed.iter().map(|&i| names[i]))
    ))
}

/// Returns whether a tag is a side of a mesh of one layer.
fn is_empty_side(boundary: &Boundary, tag: &Group) -> bool {
    boundary.dimension() == 3 && tag.condition.as_deref() == Some(EMPTY)
}

/// Refuses a role for the sides of a mesh of one layer.
fn check_sides(
    names: &[&str],
    named: &[Option<Named>],
    is_side: impl Fn(usize) -> bool,
) -> Result<()> {
    let wrong = |i: &usize| is_side(*i) && !matches!(named[*i], None | Some(Named::Free));
    match (0..names.len()).find(wrong) {
        None => Ok(()),
        Some(i) => Err(Error::input(format!(
            "tag \"{}\" is of type empty: the nodes of that side move in its plane with the rest of the mesh, so give it no role",
            names[i]
        ))),
    }
}

/// Suggests entries for tags that the mesh describes further: pairs of periodic sides, and planes.
fn offers(boundary: &Boundary, tags: &[&Group], unnamed: &[usize]) -> String {
    let mut offers = Vec::new();
    for &i in unnamed {
        let tag = tags[i];
        let partner = neighbour_patch(&boundary.origin, &tag.name);
        match (tag.condition.as_deref(), partner) {
            (Some("cyclic"), Some(partner)) if tag.name < partner => offers.push(format!(
                "periodic = [{{ pair = [\"{}\", \"{partner}\"] }}] suits the cyclic patches {} and {partner}", tag.name, tag.name
            )),
            (Some(WEDGE), _) => offers.extend(offer_of_wedge(tags, i, unnamed)),
            (Some(kind), _) if is_interface(kind) => {
                offers.push(format!("fixed = [\"{}\"] suits the {kind} {}", tag.name, tag.name));
            }
            (Some(kind), _) if is_plane(kind) => {
                offers.push(format!("slide = [\"{}\"] suits the {kind} {}", tag.name, tag.name));
            }
            _ => {}
        }
    }
    offers.iter().map(|offer| format!("; {offer}")).collect()
}

/// The type of the two sides of an axisymmetric case.
const WEDGE: &str = "wedge";

/// Returns the pair that suits the sides of a wedge, once if both are unnamed.
fn offer_of_wedge(tags: &[&Group], side: usize, unnamed: &[usize]) -> Option<String> {
    let is_other = |i: &usize| *i != side && tags[*i].condition.as_deref() == Some(WEDGE);
    let others: Vec<usize> = (0..tags.len()).filter(is_other).collect();
    let name = &tags[side].name;
    match others[..] {
        [other] if other < side && unnamed.contains(&other) => None,
        [other] => Some(format!(
            "periodic = [{{ pair = [\"{name}\", \"{0}\"] }}] suits the wedge patches {name} and {0}",
            tags[other].name
        )),
        _ => Some(format!(
            "`periodic` with the side across from it suits the wedge patch {name}"
        )),
    }
}

/// Refuses sliding sides of a wedge: each node would move on its own side, but the solver takes the sides for images of
/// each other.
fn check_wedges(tags: &[&Group], named: &[Option<Named>]) -> Result<()> {
    let slides = |i: &usize| {
        named[*i] == Some(Named::Role(Role::Sliding))
            && tags[*i].condition.as_deref() == Some(WEDGE)
    };
    match (0..tags.len()).find(slides) {
        None => Ok(()),
        Some(i) => Err(Error::input(format!(
            "tag \"{}\" is of type wedge and would slide; its nodes have to move with the nodes of the other side of the wedge: {}",
            tags[i].name,
            offer_of_wedge(tags, i, &[]).unwrap_or_default()
        ))),
    }
}

/// Refuses free tags that the solver would no longer accept: its pairs have to match, and its planes to stay planes.
fn check_free(boundary: &Boundary, tags: &[&Group], unnamed: &[usize]) -> Result<()> {
    let is_bound = |kind: &str| {
        is_plane(kind) || kind.starts_with("cyclic") || kind.starts_with("nonConformal")
    };
    let bound = unnamed
        .iter()
        .find(|i| tags[**i].condition.as_deref().is_some_and(is_bound));
    match bound {
        None => Ok(()),
        Some(&i) => Err(Error::input(format!(
            "tag \"{}\" is of type {}, which it would not be any more with free nodes; name it under `fixed`, `slide` or \
             `periodic`{}",
            tags[i].name,
            tags[i].condition.as_deref().unwrap_or_default(),
            offers(boundary, tags, &[i])
        ))),
    }
}

/// Returns whether a boundary of this type has a partner with other nodes.
fn is_interface(kind: &str) -> bool {
    kind.starts_with("cyclic") && kind != "cyclic" || kind.starts_with("nonConformal")
}

/// Returns whether a solver treats boundaries of this type as planes.
fn is_plane(kind: &str) -> bool {
    ["symmetry", "symmetryPlane", "wedge", "BCSymmetryPlane"].contains(&kind)
}

fn periodic_tags(named: &[Option<Named>], boundaries: &Boundaries) -> Vec<PeriodicTags> {
    let of_side = |pair: usize, side: u8| {
        let what = Some(Named::Periodic(pair, side));
        (0..named.len()).filter(|&i| named[i] == what).collect()
    };
    let pairs = boundaries.periodic.iter().enumerate();
    pairs
        .map(|(i, pair)| PeriodicTags {
            a: of_side(i, 0),
            b: of_side(i, 1),
            place: pair.place.clone(),
        })
        .collect()
}

/// Returns whether a tag has a node in the zone that the interface does not already fix.
fn touches(tag: &Group, zone: Option<&DeformingZone>, boundary: &Boundary) -> bool {
    boundary
        .nodes_of(tag)
        .any(|node| zone.is_none_or(|zone| zone.sides.nodes.has(node) && !zone.is_interface(node)))
}

/// Checks that every body has faces, and that all its nodes can move.
fn check_bodies(
    tags: &[&Group],
    roles: &[TagRole],
    schedule: &Schedule,
    zone: Option<&DeformingZone>,
    boundary: &Boundary,
) -> Result<()> {
    let with_tags = schedule.bodies.iter().enumerate();
    for (i, body) in with_tags.filter(|(_, body)| body.zones.is_empty()) {
        let role = Some(Role::Moving(i as u16));
        let own = || (0..tags.len()).filter(|&tag| roles[tag].role == role);
        if own().all(|tag| tags[tag].cells.is_empty()) {
            return Err(Error::input(format!(
                "the tags of body \"{}\" have no faces in the mesh; it needs at least one",
                body.name
            ))
            .at(body.places.of("name")));
        }
        let Some(zone) = zone else { continue };
        let rotor = schedule.rotor_of(body)?;
        let turning = (schedule.rotors[rotor].frame == Frame::Inertial).then_some(rotor);
        let turns = |node: u32| zone.part_of(node).and_then(|part| part.rotor) == turning;
        for tag in own() {
            let free_to_move =
                |node: u32| zone.sides.nodes.has(node) && !zone.is_interface(node) && turns(node);
            if let Some(node) = boundary
                .nodes_of(tags[tag])
                .find(|&node| !free_to_move(node))
            {
                let place = if !zone.sides.nodes.has(node) {
                    "outside the zones that deform; name its zone as well"
                } else if zone.is_interface(node) {
                    "on the interface to the other zones, which stays fixed; name those zones as well"
                } else if turning.is_some() {
                    "in no zone that turns with its rotor; name its zone under `zones` of that rotor"
                } else {
                    "in a zone that turns with another rotor; give the body that rotor"
                };
                return Err(Error::input(format!(
                    "tag \"{}\" moves with body \"{}\", but its node {node} is {place}",
                    tags[tag].name, body.name
                ))
                .at(body.places.of("name")));
            }
        }
    }
    Ok(())
}
