//! What `azimesh convert` does to a mesh on the way.

use azimesh_core::error::{Error, Result, counted, nearest_name};
use azimesh_core::geometry::transform::Transform;
use azimesh_core::numbers::with_verb;
use azimesh_core::{Note, note};
use azimesh_io::formats::openfoam::set_patch_types;
use azimesh_io::formats::su2;
use azimesh_io::mesh::{DataArray, Mesh, Values};
use std::collections::{BTreeMap, BTreeSet};

/// Changes of the mesh, made in this order: scale, rotate, linearize, split, extrude, join, tag, merge, drop, rename, types
/// of patches, boundary or volume only; `--reorder` comes last.
#[derive(Debug, Clone, Default, PartialEq, clap::Args)]
pub struct Changes {
    /// Multiply all coordinates by this, as 0.001 for millimetres to metres
    #[arg(long, value_name = "S", allow_negative_numbers = true)]
    scale: Option<f64>,
    /// Rotate by an angle in degrees: x,90 or 0,0,1,90; about a point with three more numbers:
    /// x,90,0.5,0,0. Arrays are not rotated
    #[arg(long, value_name = "AXIS,ANGLE", value_parser = rotation, allow_hyphen_values = true)]
    rotate: Option<Transform>,
    /// Keep corner nodes only: curved cells become linear
    #[arg(long)]
    linearize: bool,
    /// Split polyhedra into tetrahedra and pyramids, polygons into triangles and quadrilaterals: for SU2,
    /// Gmsh and UGRID, which have neither
    #[arg(long)]
    split_polyhedra: bool,
    /// Make one layer of cells of this height, along z, from a mesh in a plane; its two sides get the
    /// tags back and front, which OpenFOAM takes as empty
    #[arg(long, value_name = "H", allow_negative_numbers = true)]
    extrude: Option<f64>,
    /// Make one mesh of zones that share no nodes: where two outer faces without a tag lie at the very same place, their
    /// nodes become one
    #[arg(long)]
    join: bool,
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

/// How faces are gathered into tags.
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

/// Reads `x,90`, `0,0,1,90`, and both with a point behind.
fn rotation(text: &str) -> std::result::Result<Transform, String> {
    let form = "write AXIS,ANGLE, such as x,90 or 0,0,1,90; then X,Y,Z of a point on the axis, if it is not the origin";
    let words: Vec<&str> = text.split(',').map(str::trim).collect();
    let (axis, rest) = match words[0] {
        "x" => ([1.0, 0.0, 0.0], &words[1..]),
        "y" => ([0.0, 1.0, 0.0], &words[1..]),
        "z" => ([0.0, 0.0, 1.0], &words[1..]),
        _ if words.len() < 4 => return Err(form.into()),
        _ => (vector(&words[..3])?, &words[3..]),
    };
    let (angle, origin) = match rest {
        [angle] => (number(angle)?, [0.0; 3]),
        [angle, point @ ..] if point.len() == 3 => (number(angle)?, vector(point)?),
        _ => return Err(form.into()),
    };
    if axis == [0.0; 3] {
        return Err("the axis must have a length".into());
    }
    let mut turn = Transform::rotation(axis, origin, angle.to_radians());
    if angle % 90.0 == 0.0 && axis.iter().filter(|x| **x != 0.0).count() == 1 {
        // Quarter turns about an axis of coordinates are exact.
        turn.rotation = turn.rotation.map(|row| row.map(f64::round));
        let moved = turn.turn(origin);
        turn.translation = [0, 1, 2].map(|i| origin[i] - moved[i]);
    }
    Ok(turn)
}

fn number(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|x: &f64| x.is_finite());
    found.ok_or_else(|| format!("\"{text}\" is not a number"))
}

fn vector(words: &[&str]) -> std::result::Result<[f64; 3], String> {
    Ok([number(words[0])?, number(words[1])?, number(words[2])?])
}

impl Changes {
    /// Refuses what no mesh can be changed by.
    pub fn check(&self) -> Result<()> {
        let hint = " (a negative one would invert every cell)";
        for (option, value, hint) in [("scale", self.scale, hint), ("extrude", self.extrude, "")] {
            if let Some(value) = value.filter(|x| !x.is_finite() || *x <= 0.0) {
                return Err(Error::input(format!(
                    "--{option} {value}: it must be a finite number above 0{hint}"
                )));
            }
        }
        Ok(())
    }

    /// Changes the mesh; gives remarks on it.
    pub fn apply(&self, mesh: &mut Mesh) -> Result<Vec<Note>> {
        let mut remarks = Vec::new();
        if let Some(factor) = self.scale {
            for point in &mut mesh.points {
                *point = point.map(|x| x * factor);
            }
        }
        if let Some(turn) = &self.rotate {
            for point in &mut mesh.points {
                *point = turn.apply(*point);
            }
            remarks.extend(vectors(mesh));
        }
        if self.scale.is_some() || self.rotate.is_some() {
            // Coordinates that overflow are found before anything is written.
            mesh.validate()?;
            remarks.extend(places(mesh));
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
        if self.split_polyhedra {
            remarks.extend(split(mesh)?);
        }
        if let Some(height) = self.extrude {
            mesh.extrude(height)?;
        }
        if self.join {
            remarks.push(join(mesh));
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
        remarks.extend(negative_areas(mesh));
        Ok(remarks)
    }

    /// Returns whether tags are removed with their faces.
    pub fn removes_tags(&self) -> bool {
        !self.drop_tag.is_empty() || !self.keep_tag.is_empty()
    }

    /// Removes tags as `--drop-tag` and `--keep-tag` say.
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

/// Joins zones; a remark on what was joined.
fn join(mesh: &mut Mesh) -> Note {
    let counts = mesh.join_zones();
    match counts.n_faces {
        0 => note!(
            "joined",
            "--join: no two outer faces without a tag lie at the same place"
        ),
        n => note!(
            "joined",
            "--join: faces that lay on one another are joined, pair by pair ({n}); {} removed",
            with_verb(counts.n_nodes, "node", "is")
        ),
    }
}

/// Splits polyhedra and polygons; remarks on what has been split, and on cells that it has not done good.
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

/// A remark on cells of a mesh at one z whose nodes turn clockwise.
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

/// Takes away what holds places as text, which would be wrong now.
fn places(mesh: &mut Mesh) -> Option<Note> {
    let removed = mesh.remove_field_arrays(&[su2::BOXES, su2::PERIODIC]);
    (!removed.is_empty()).then(|| {
        note!(
            "places_left_out",
            "left out, since they hold positions from before: {}",
            removed.join(", ")
        )
    })
}

/// A remark on arrays that look like vectors.
fn vectors(mesh: &Mesh) -> Option<Note> {
    let is_vector = |array: &&DataArray| {
        array.n_components == 3 && matches!(array.values, Values::F32(_) | Values::F64(_))
    };
    let arrays = mesh.point_arrays.iter().chain(&mesh.cell_arrays);
    let names: Vec<&str> = arrays
        .filter(is_vector)
        .map(|array| array.name.as_str())
        .collect();
    (!names.is_empty()).then(|| {
        note!(
            "not_rotated",
            "--rotate: arrays of three components are not rotated: {}",
            names.join(", ")
        )
    })
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
