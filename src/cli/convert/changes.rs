//! Changes of a mesh by `azimesh convert`.

use azimesh_core::error::{Error, Result, counted, nearest_name};
use azimesh_core::geometry::transform::Transform;
use azimesh_core::numbers::{short, with_verb};
use azimesh_core::{Note, note};
use azimesh_io::formats::openfoam::set_patch_types;
use azimesh_io::formats::su2;
use azimesh_io::mesh::join::{JoinCounts, RELATIVE_DISTANCE};
use azimesh_io::mesh::{Mesh, Plane, Turned};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::path::Path;

/// Changes of the mesh, made in this order: scale, rotate, translate, linearize, uncollapse, split, flatten, extrude, mirror, repeat, join, tag,
/// merge, drop, rename, types of patches, boundary or volume only; `--reorder` comes last.
#[derive(Debug, Clone, Default, PartialEq, clap::Args)]
pub struct Changes {
    /// Multiply all coordinates by this, as 0.001 for millimetres to metres
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Rotate by an angle in degrees: x,90 or 0,0,1,90; about a point with three more numbers:
    /// x,90,0.5,0,0. Arrays of three and nine real components turn as vectors and tensors
    #[arg(long, value_name = "AXIS,ANGLE", value_parser = rotation, allow_hyphen_values = true)]
    rotate: Option<Transform>,
    /// Move by this
    #[arg(long, value_name = "X,Y,Z", value_parser = translation, allow_hyphen_values = true)]
    translate: Option<[f64; 3]>,
    /// Keep corner nodes only: curved cells become linear
    #[arg(long)]
    linearize: bool,
    /// List cells with a node twice as what they are, such as hexahedra with an edge of no length as wedges
    #[arg(long)]
    uncollapse: bool,
    /// Split polyhedra into tetrahedra and pyramids, polygons into triangles and quadrilaterals: for SU2,
    /// Gmsh and UGRID, which have neither
    #[arg(long)]
    split_polyhedra: bool,
    /// Make a plane mesh of one layer of solid cells, as --extrude backwards; the tags of its two sides go
    #[arg(long, conflicts_with = "extrude")]
    flatten: bool,
    /// Make one layer of cells of this height, along z, from a mesh in a plane; its two sides get the
    /// tags back and front, which OpenFOAM takes as empty
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    extrude: Option<f64>,
    /// Make a whole of a half: add its mirror image across the plane x = 0, y = 0 or z = 0, or one at another position: y,0.5. Nodes
    /// on the plane are joined, the tag of the symmetry plane goes
    #[arg(long, value_name = "AXIS[,POSITION]", value_parser = plane, allow_hyphen_values = true)]
    mirror: Option<Plane>,
    /// Add this to the names of the boundary tags of the mirrored half
    #[arg(
        long,
        value_name = "S",
        requires = "mirror",
        allow_hyphen_values = true
    )]
    mirror_suffix: Option<String>,
    /// Make a whole of a sector: N copies around --axis. Periodic sides are joined and their tags go; the other tags are
    /// numbered: blade_1, blade_2
    #[arg(long, value_name = "N", requires = "axis", allow_negative_numbers = true, value_parser = clap::value_parser!(u32).range(2..))]
    repeat: Option<u32>,
    /// Axis of --repeat: x or 0,0,1; with the angle in degrees between copies, if it is not 360/N: x,30; then X,Y,Z of a
    /// point on the axis, if it is not the origin
    #[arg(long, value_name = "AXIS[,ANGLE]", requires = "repeat", value_parser = axis, allow_hyphen_values = true)]
    axis: Option<Axis>,
    /// Make one mesh of zones that share no nodes: where two outer faces without a tag lie at the very same place, or
    /// with nodes at most D apart, their nodes become one. With --merge, --mirror and --repeat D is the distance
    /// within which nodes are joined
    #[arg(long, value_name = "D", num_args = 0..=1, require_equals = true, default_missing_value = "0", value_parser = distance)]
    join: Option<f64>,
    /// Give outer faces without a tag the tags boundary_1, boundary_2, ..., the largest connected part
    /// first
    #[arg(long, value_name = "HOW")]
    tag_boundary: Option<TagBoundary>,
    /// Make one boundary tag, or one zone, of several: wall=upper,lower; repeatable
    #[arg(long, value_name = "NEW=A,B", value_parser = merging)]
    merge_tags: Vec<(String, Vec<String>)>,
    /// Remove a boundary tag, and its faces that no other tag has, or a zone with its cells; STL and VTP then hold the boundary faces that are left,
    /// and no other; repeatable
    #[arg(long, value_name = "TAG")]
    drop_tag: Vec<String>,
    /// Remove all boundary tags, or all zones, but this one, as --drop-tag does; repeatable
    #[arg(long, value_name = "TAG", conflicts_with = "drop_tag")]
    keep_tag: Vec<String>,
    /// Rename a boundary tag or zone, which may have = in its name; repeatable
    #[arg(long, value_name = "OLD=NEW", value_parser = renaming)]
    rename_tag: Vec<(String, String)>,
    /// Type of the patch that a boundary tag becomes in OpenFOAM: patch, wall, symmetry, symmetryPlane,
    /// empty or wedge; repeatable
    #[arg(long, value_name = "TAG=TYPE", value_parser = patch_type)]
    patch_type: Vec<(String, String)>,
    /// Keep the boundary faces with their tags, without the volume
    #[arg(long, conflicts_with = "volume_only")]
    boundary_only: bool,
    /// Keep the volume cells with their zones, without boundary faces
    #[arg(long)]
    volume_only: bool,
}

/// Arrays that hold numbers of nodes.
pub const NODE_NUMBERS: [&str; 2] = [su2::EXCHANGED, su2::OWN_NODES];

/// Rule that gathers faces into tags.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum TagBoundary {
    /// Faces that share a node get the same tag
    Connected,
}

/// Reads `wing=wall`. The last `=` counts, since names of tags may have others.
fn pair(text: &str, form: &str) -> std::result::Result<(String, String), String> {
    match text.rsplit_once('=') {
        Some((old, new)) if !old.is_empty() && !new.is_empty() => Ok((old.into(), new.into())),
        _ => Err(form.into()),
    }
}

fn renaming(text: &str) -> std::result::Result<(String, String), String> {
    pair(text, "write OLD=NEW")
}

/// Reads `wall=upper,lower`. The first `=` counts, since names of tags may have others.
fn merging(text: &str) -> std::result::Result<(String, Vec<String>), String> {
    let wrong = || "write NEW=A,B, such as wall=upper,lower".to_owned();
    let (new, old) = text.split_once('=').ok_or_else(wrong)?;
    let old: Vec<String> = old.split(',').map(str::to_owned).collect();
    if new.is_empty() || old.iter().any(String::is_empty) {
        Err(wrong())
    } else {
        Ok((new.to_owned(), old))
    }
}

/// Reads the type of a patch.
pub fn patch_type(text: &str) -> std::result::Result<(String, String), String> {
    pair(text, "write TAG=TYPE, such as wing=wall")
}

/// An axis, with an optional angle in degrees.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Axis {
    direction: [f64; 3],
    angle: Option<f64>,
    origin: [f64; 3],
}

impl Axis {
    /// Returns the rotation by an angle in degrees.
    fn turn(&self, angle: f64) -> Transform {
        let mut turn = Transform::rotation(self.direction, self.origin, angle.to_radians());
        if angle % 90.0 == 0.0 && self.direction.iter().filter(|x| **x != 0.0).count() == 1 {
            // Quarter turns about an axis of coordinates are exact.
            turn.rotation = turn.rotation.map(|row| row.map(f64::round));
            let moved = turn.turn(self.origin);
            turn.translation = [0, 1, 2].map(|i| self.origin[i] - moved[i]);
        }
        turn
    }
}

/// Reads `x`, `0,0,1`, both with an angle behind, and all with a point behind.
fn axis(text: &str) -> std::result::Result<Axis, String> {
    let form = "write AXIS,ANGLE, such as x,90 or 0,0,1,90; then X,Y,Z of a point on the axis, if it is not the origin";
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    let (direction, rest) = match words[0] {
        "x" => ([1.0, 0.0, 0.0], &words[1..]),
        "y" => ([0.0, 1.0, 0.0], &words[1..]),
        "z" => ([0.0, 0.0, 1.0], &words[1..]),
        _ if words.len() < 3 => return Err(form.into()),
        _ => (vector(&words[..3])?, &words[3..]),
    };
    if direction == [0.0; 3] {
        return Err("the axis must have a length".into());
    }
    let (angle, point) = match rest.len() {
        1 | 4 => (Some(number(rest[0])?), &rest[1..]),
        0 | 3 => (None, rest),
        _ => return Err(form.into()),
    };
    let origin = if point.is_empty() {
        [0.0; 3]
    } else {
        vector(point)?
    };
    Ok(Axis {
        direction,
        angle,
        origin,
    })
}

/// Reads `x,90`, `0,0,1,90`, and both with a point behind.
fn rotation(text: &str) -> std::result::Result<Transform, String> {
    let axis = axis(text)?;
    let angle = axis
        .angle
        .ok_or("the angle is missing: write AXIS,ANGLE, such as x,90 or 0,0,1,90")?;
    Ok(axis.turn(angle))
}

fn translation(text: &str) -> std::result::Result<[f64; 3], String> {
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    match words.len() {
        3 => vector(&words),
        _ => Err("write X,Y,Z".into()),
    }
}

/// Reads `y` and `y,0.5`.
fn plane(text: &str) -> std::result::Result<Plane, String> {
    let (axis, at) = text.split_once(',').unwrap_or((text, "0"));
    let axis = ["x", "y", "z"].iter().position(|name| *name == axis.trim());
    let axis = axis.ok_or("write x, y or z, or with the position of the plane: y,0.5")?;
    let at = number(at.trim())?;
    Ok(Plane { axis, at })
}

fn distance(text: &str) -> std::result::Result<f64, String> {
    let found = number(text)?;
    let wanted = || format!("{text}: a distance is not negative");
    (found >= 0.0).then_some(found).ok_or_else(wanted)
}

/// Writes `--join D` as `--join=D`, the form that cannot be taken for a mesh. A file of that name stays a mesh.
pub fn bind_distance(arguments: &mut Vec<OsString>) {
    let is_number = |text: &OsString| {
        text.to_str()
            .is_some_and(|text| text.parse::<f64>().is_ok())
    };
    let found = arguments
        .windows(2)
        .position(|two| two[0] == "--join" && is_number(&two[1]) && !Path::new(&two[1]).exists());
    if let Some(at) = found {
        let distance = arguments.remove(at + 1);
        arguments[at].push("=");
        arguments[at].push(distance);
    }
}

fn number(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|x: &f64| x.is_finite());
    found.ok_or_else(|| format!("\"{text}\" is not a number"))
}

fn vector(words: &[&str]) -> std::result::Result<[f64; 3], String> {
    Ok([number(words[0])?, number(words[1])?, number(words[2])?])
}

impl Changes {
    /// Refuses options that are wrong for every mesh.
    pub fn check(&self) -> Result<()> {
        let hint = " (a negative one would invert every cell)";
        if let (Some(n), Some(angle)) = (self.repeat, self.axis.and_then(|axis| axis.angle)) {
            let all = f64::from(n) * angle.abs();
            if angle == 0.0 || all > 360.0 * (1.0 + 1e-9) {
                return Err(Error::input(format!(
                    "--repeat {n}: {n} copies {} degrees apart must not be more than a turn, and not at one place",
                    short(angle)
                )));
            }
        }
        for (option, value, hint) in [("scale", self.scale, hint), ("extrude", self.extrude, "")] {
            if let Some(value) = value.filter(|x| !x.is_finite() || *x <= 0.0) {
                return Err(Error::input(format!(
                    "--{option} {value}: it must be a finite number above 0{hint}"
                )));
            }
        }
        Ok(())
    }

    /// Returns the joining distance that was given to options that copy or merge meshes.
    fn given_distance(&self) -> Option<f64> {
        self.join.filter(|distance| *distance > 0.0)
    }

    /// Returns the joining distance of options that copy or merge meshes.
    pub fn join_distance(&self, mesh: &Mesh) -> f64 {
        self.given_distance()
            .unwrap_or_else(|| mesh.join_distance())
    }

    /// Returns a remark on joined parts.
    pub fn joined(&self, option: &str, counts: &JoinCounts) -> Note {
        joined(option, counts, self.given_distance())
    }

    /// Returns whether `--join` is given.
    pub fn joins(&self) -> bool {
        self.join.is_some()
    }

    /// Changes the mesh, which may be a merged one; returns remarks.
    pub fn apply(&self, mesh: &mut Mesh, is_merged: bool) -> Result<Vec<Note>> {
        let mut remarks = Vec::new();
        let n_nodes = mesh.points.len();
        if let Some(factor) = self.scale {
            for point in &mut mesh.points {
                *point = point.map(|x| x * factor);
            }
        }
        if let Some(turn) = &self.rotate {
            remarks.extend(turned("--rotate", &mesh.transform(turn)));
        }
        if let Some(by) = self.translate {
            mesh.transform(&Transform::translation(by));
        }
        if self.scale.is_some() || self.rotate.is_some() || self.translate.is_some() {
            // Coordinates that overflow are found before anything is written.
            mesh.validate()?;
            remarks.extend(without(mesh, &[su2::BOXES, su2::PERIODIC]));
        }
        if self.linearize {
            let (n_cells, n_nodes) = mesh.linearize();
            if n_cells > 0 {
                remarks.push(note!(
                    "linearized",
                    "--linearize: {} made linear, {} removed",
                    with_verb(n_cells, "curved cell", "is"),
                    with_verb(n_nodes, "node", "is")
                ));
            }
        }
        if self.uncollapse {
            remarks.push(uncollapse(mesh));
        }
        if self.split_polyhedra {
            remarks.extend(split(mesh)?);
        }
        if self.flatten {
            remarks.extend(flatten(mesh)?);
        }
        if let Some(height) = self.extrude {
            mesh.extrude(height)?;
        }
        if let Some(plane) = self.mirror {
            let distance = self.join_distance(mesh);
            let (counts, names) = mesh.mirror(plane, self.mirror_suffix.as_deref(), distance)?;
            remarks.push(self.joined("--mirror", &counts));
            remarks.extend(turned("--mirror", &names));
        }
        if let (Some(n), Some(axis)) = (self.repeat, &self.axis) {
            let (distance, angle) = (
                self.join_distance(mesh),
                axis.angle.unwrap_or(360.0 / f64::from(n)),
            );
            let turn = |copy| axis.turn(copy as f64 * angle);
            let (counts, names) = mesh.repeat(n as usize, &turn, distance)?;
            remarks.push(self.joined("--repeat", &counts));
            remarks.extend(turned("--repeat", &names));
        }
        if self.mirror.is_some() || self.repeat.is_some() {
            mesh.validate()?;
            remarks.extend(without(mesh, &[su2::BOXES, su2::PERIODIC]));
        }
        match self.join {
            Some(distance) if !is_merged && self.mirror.is_none() && self.repeat.is_none() => {
                remarks.push(join(mesh, distance)?);
            }
            _ => {}
        }
        if self.tag_boundary.is_some() {
            let (n_faces, n_tags) = mesh.tag_connected_boundary()?;
            remarks.push(note!(
                "boundary_tagged",
                "--tag-boundary: {}, {}",
                counted(n_tags, "new tag"),
                counted(n_faces, "new boundary face")
            ));
        }
        for (new, old) in &self.merge_tags {
            mesh.merge_tags(new, &names(old))
                .map_err(|error| of_option("--merge-tags", error))?;
        }
        remarks.extend(self.drop_tags(mesh)?);
        rename(mesh, &self.rename_tag)?;
        set_patch_types(mesh, &self.patch_type)?;
        if self.boundary_only {
            let n = mesh.keep_boundary()?;
            remarks.push(note!(
                "boundary_kept",
                "--boundary-only: {} removed",
                with_verb(n, "inner node", "is")
            ));
        }
        if self.volume_only {
            mesh.keep_volume();
        }
        if is_merged || mesh.points.len() != n_nodes {
            remarks.extend(without(mesh, &NODE_NUMBERS));
        }
        remarks.extend(negative_areas(mesh));
        Ok(remarks)
    }

    /// Returns whether tags are removed with their faces.
    pub fn removes_tags(&self) -> bool {
        !self.drop_tag.is_empty() || !self.keep_tag.is_empty()
    }

    /// Removes tags by `--drop-tag` and `--keep-tag`.
    fn drop_tags(&self, mesh: &mut Mesh) -> Result<Option<Note>> {
        if !self.removes_tags() {
            return Ok(None);
        }
        let (option, n) = if self.keep_tag.is_empty() {
            ("--drop-tag", mesh.drop_tags(&names(&self.drop_tag)))
        } else {
            ("--keep-tag", mesh.keep_tags(&names(&self.keep_tag)))
        };
        let [n_faces, n_cells] = n.map_err(|error| of_option(option, error))?;
        let faces = with_verb(n_faces, "boundary face", "is");
        Ok(Some(match n_cells {
            0 => note!("tags_removed", "{option}: {faces} removed"),
            n => note!(
                "tags_removed",
                "{option}: {} and {faces} removed",
                counted(n, "cell")
            ),
        }))
    }
}

fn names(tags: &[String]) -> Vec<&str> {
    tags.iter().map(String::as_str).collect()
}

fn of_option(option: &str, error: Error) -> Error {
    Error {
        message: format!("{option}: {}", error.message),
        ..error
    }
}

/// Joins zones; returns a remark.
fn join(mesh: &mut Mesh, distance: f64) -> Result<Note> {
    let counts = match distance {
        0.0 => mesh.join_zones(),
        distance => mesh.join_within(distance)?,
    };
    Ok(match counts.n_faces {
        0 => note!(
            "joined",
            "--join: no two outer faces without a tag lie at the same place"
        ),
        n => note!(
            "joined",
            "--join: faces that lay on one another are joined, pair by pair ({n}); {} removed",
            with_verb(counts.n_nodes, "node", "is")
        ),
    })
}

/// Returns a remark on joined parts.
fn joined(option: &str, counts: &JoinCounts, distance: Option<f64>) -> Note {
    let list = |is_listed: fn(usize) -> bool| {
        let tags = counts.tags.iter().filter(|(_, _, left)| is_listed(*left));
        let names: Vec<&str> = tags.map(|(name, _, _)| &**name).collect();
        names.join(", ")
    };
    // The same words for every step of a sequence.
    let apart = distance.map_or_else(
        || format!("{} of the diagonal of the mesh", short(RELATIVE_DISTANCE)),
        short,
    );
    let nodes = with_verb(counts.n_nodes, "node", "is");
    let mut text = format!("{option}: {nodes} joined, at most {apart} apart");
    for (words, names) in [
        ("tags that are gone", list(|left| left == 0)),
        ("tags with fewer faces", list(|left| left > 0)),
    ] {
        if !names.is_empty() {
            text += &format!("; {words}: {names}");
        }
    }
    Note::new("parts_joined", text)
}

/// Replaces collapsed cells; returns remarks.
fn uncollapse(mesh: &mut Mesh) -> Note {
    let counts = mesh.uncollapse();
    let mut text = format!(
        "--uncollapse: {} listed with each node once",
        with_verb(counts.n_cells, "cell", "is")
    );
    for (n, words) in [
        (counts.n_gone, "boundary faces that were lines are removed"),
        (counts.n_left, "cells of no volume stay"),
        (
            counts.n_curved,
            "curved cells with a node twice stay (--linearize keeps their corners, which are then replaced)",
        ),
    ] {
        if n > 0 {
            text += &format!("; {words}: {n}");
        }
    }
    Note::new("uncollapsed", text)
}

/// Flattens the mesh; returns remarks.
fn flatten(mesh: &mut Mesh) -> Result<Vec<Note>> {
    let found = mesh.flatten()?;
    let mut remarks = vec![note!(
        "layer_flattened",
        "--flatten: one layer along {}{}; tags of the sides, which are gone: {}",
        ["x", "y", "z"][found.axis],
        ["; y is x now and z is y", "; z is y now", ""][found.axis],
        found.sides.join(", ")
    )];
    remarks.extend(turned("--flatten", &found.turned));
    if !found.differ.is_empty() {
        remarks.push(note!(
            "sides_differ",
            "--flatten: arrays whose values at the two sides differ have those of the lower one: {}",
            found.differ.join(", ")
        ));
    }
    Ok(remarks)
}

/// Splits polyhedra and polygons; returns remarks on the counts and on cells with bad parts.
fn split(mesh: &mut Mesh) -> Result<Vec<Note>> {
    let counts = mesh.split_polyhedra()?;
    let mut remarks = Vec::new();
    if counts.n_cells + counts.n_faces > 0 {
        remarks.push(note!(
            "polyhedra_split",
            "--split-polyhedra: {} and {} split, {} added",
            counted(counts.n_cells, "cell"),
            with_verb(counts.n_faces, "boundary face", "is"),
            with_verb(counts.n_nodes, "node", "is"),
        ));
    }
    if let Some(first) = counts.first_not_positive {
        remarks.push(note!(
            "no_kernel",
            "--split-polyhedra: {} no point that sees all of its faces from within (the first is cell {first}); parts of such a cell have no or a negative volume",
            with_verb(counts.n_not_positive, "cell", "has"),
        ));
    }
    if counts.n_gone > 0 {
        remarks.push(note!(
            "small_cells_left_out",
            "--split-polyhedra: {} of fewer than three corners left out",
            with_verb(counts.n_gone, "cell", "is")
        ));
    }
    Ok(remarks)
}

/// Returns a remark on clockwise cells of a plane mesh.
fn negative_areas(mesh: &Mesh) -> Option<Note> {
    if mesh.dimension() != 2 || mesh.space_dimension() != 2 {
        return None;
    }
    let (n, first) = mesh.view().clockwise();
    let first = first?;
    Some(note!(
        "negative_areas",
        "{} a negative area (the first is cell {first}): their nodes turn clockwise, seen from +z",
        with_verb(n, "cell", "has")
    ))
}

/// Removes the arrays of these names, which hold positions or numbers of nodes that are wrong now.
pub fn without(mesh: &mut Mesh, names: &[&str]) -> Option<Note> {
    let removed = mesh.remove_field_arrays(names);
    (!removed.is_empty()).then(|| {
        note!(
            "places_left_out",
            "left out, since they hold positions or numbers of nodes from before: {}",
            removed.join(", ")
        )
    })
}

/// Returns remarks on rotated arrays, and on arrays that may hold vectors and were not rotated.
fn turned(option: &str, names: &Turned) -> Vec<Note> {
    let axial = match option {
        "--mirror" => " (a pseudovector, such as a vorticity, then has the wrong sign)",
        _ => "",
    };
    let mut remarks = Vec::new();
    if !names.turned.is_empty() {
        remarks.push(note!(
            "vectors_turned",
            "{option}: arrays turned as vectors and tensors: {}{axial}",
            names.turned.join(", ")
        ));
    }
    if !names.kept.is_empty() {
        remarks.push(note!(
            "not_rotated",
            "{option}: arrays that may hold components of vectors or tensors keep them: {}",
            names.kept.join(", ")
        ));
    }
    remarks
}

/// Renames all at once, so that two tags can swap their names.
fn rename(mesh: &mut Mesh, renamings: &[(String, String)]) -> Result<()> {
    if renamings.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = mesh.groups.iter().map(|group| group.name.clone()).collect();
    let known: BTreeSet<&str> = names.iter().map(String::as_str).collect();
    let mut new_names: BTreeMap<&str, &str> = BTreeMap::new();
    for (old, new) in renamings {
        if !known.contains(&**old) {
            let hint = nearest_name(old, names.iter().map(String::as_str))
                .map_or_else(String::new, |name| format!(" (did you mean \"{name}\"?)"));
            return Err(Error::input(format!(
                "--rename-tag: there is no \"{old}\"{hint}; there are: {}",
                names.join(", ")
            )));
        }
        new_names.entry(old).or_insert(new);
    }
    // Groups that shared a name before may go on doing so.
    let mut before: BTreeMap<(u8, &str), &str> = BTreeMap::new();
    for (group, old) in mesh.groups.iter_mut().zip(&names) {
        let new = *new_names.get(&**old).unwrap_or(&&**old);
        if *before.entry((group.dimension, new)).or_insert(old) != old {
            return Err(Error::input(format!(
                "--rename-tag: two groups would be called \"{new}\""
            )));
        }
        group.name = new.to_owned();
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quarter_turn_is_exact() {
        let turn = rotation("x,90").expect("a good form");
        assert_eq!(turn.apply([1.0, 2.0, 3.0]), [1.0, -3.0, 2.0]);
        let about = rotation("0,0,2,-180,1,0,0").expect("a good form");
        assert_eq!(about.apply([3.0, 1.0, 5.0]), [-1.0, -1.0, 5.0]);
        let slanted = rotation("1,1,1,120")
            .expect("a good form")
            .apply([1.0, 0.0, 0.0]);
        assert!((slanted[1] - 1.0).abs() < 1e-15, "{slanted:?}");
        for wrong in ["x", "w,90", "1,2,90", "0,0,0,90", "x,90,1", "x,nan"] {
            assert!(rotation(wrong).is_err(), "{wrong}");
        }
    }
}
