//! Files in HDF5 (`.cas.h5`, `.msh.h5`): the group `meshes`, with the same zones, faces and cells as [`Content`].

use super::content::{CellZone, Content, FaceList, FaceZone, INACTIVE, NONE, Named, check_cover};
use super::content::{kind_of_cells, kind_of_faces};
use super::numbers::TOO_MANY_NODES;
use super::sections::zones;
use crate::formats::hdf5::{Dataset, File, Group, is_hdf5};
use crate::formats::number::Chunk;
use crate::formats::{Notes, Source};
use crate::mesh::Values;
use azimesh_core::error::{Error, Position, Result};
use azimesh_core::note;
use std::ops::Range;

/// Name of the group that holds meshes.
const MESHES: &str = "meshes";

/// Returns whether a file in HDF5 is one of Fluent.
pub(super) fn is_of_fluent(source: &Source) -> bool {
    let has_mesh = || -> Result<bool> {
        let Some(meshes) = File::open(source)?.root()?.group(MESHES)? else {
            return Ok(false);
        };
        let first = meshes.groups()?.into_iter().next();
        first.map_or(Ok(false), |mesh| Ok(mesh.attribute("nodeCount")?.is_some()))
    };
    is_hdf5(source.bytes()) && has_mesh().unwrap_or(false)
}

/// Reads a file.
pub(super) fn read(source: &Source, notes: &mut Notes) -> Result<Content> {
    let root = File::open_with_short_chunks(source)?.root()?;
    let meshes = need_group(&root, MESHES)?;
    let mut all = meshes.groups()?;
    if all.is_empty() {
        return Err(Error::input("there is no mesh in it").dataset(MESHES));
    }
    if all.len() > 1 {
        let name = all[0].name();
        notes.push(note!(
            "name_not_kept",
            "the meshes besides \"{name}\" is not kept"
        ));
    }
    let mesh = all.swap_remove(0);
    let mut content = Content {
        dimension: match number(mesh.attribute("dimension")?) {
            Some(2) => 2,
            Some(3) | None => 3,
            Some(other) => {
                let message = format!("the dimension of the mesh is {other}; it must be 2 or 3");
                return Err(Error::input(message).dataset("meshes/1"));
            }
        },
        ..Content::default()
    };
    if let Some(settings) = root.group("settings")?
        && let Some(variables) = settings.dataset("Thread Variables")?
        && let Values::Text(texts) = variables.values()?
    {
        for text in texts {
            zones(text.as_bytes(), &mut content, notes)
                .map_err(|error| error.dataset("settings/Thread Variables"))?;
        }
    }
    content.points = points(&mesh, content.dimension)?;
    cells(&mesh, &mut content)?;
    faces(&mesh, &mut content)?;
    Ok(content)
}

fn need_group(group: &Group, name: &str) -> Result<Group> {
    let found = group.group(name)?;
    found.ok_or_else(|| Error::input("the group is missing").dataset(name))
}

/// The first number of an attribute.
fn number(attribute: Option<Values>) -> Option<i64> {
    attribute?.to_integers()?.first().copied()
}

/// Attributes `minId` and `maxId`, as indices from 0.
fn ids(read: impl Fn(&str) -> Result<Option<Values>>, of: &str) -> Result<Range<usize>> {
    let id = |name| -> Result<usize> {
        let value = number(read(name)?).and_then(|value| usize::try_from(value).ok());
        let value = value.filter(|value| *value <= NONE as usize);
        value.ok_or_else(|| {
            Error::input(format!("the attribute {name} must be a number from 1 on")).dataset(of)
        })
    };
    let (first, end) = (id("minId")?, id("maxId")?);
    match first.checked_sub(1).filter(|start| *start <= end) {
        Some(start) => Ok(start..end),
        None => Err(Error::input(format!("minId is {first} and maxId is {end}")).dataset(of)),
    }
}

fn range_of(dataset: &Dataset, path: &str) -> Result<Range<usize>> {
    let range = ids(|name| dataset.attribute(name), path)?;
    let n = dataset.n_rows();
    if n != range.len() as u64 {
        let message = format!(
            "it has {n} rows, but its minId and maxId give {}",
            range.len()
        );
        return Err(Error::input(message).dataset(path));
    }
    Ok(range)
}

/// The values of a dataset as indices.
fn indices(dataset: &Dataset, path: &str) -> Result<Vec<u32>> {
    let wrong = |what: String| Error::input(what).dataset(path);
    let values = match dataset.values()? {
        Values::U32(values) => return Ok(values),
        values => values.to_integers(),
    };
    let values = values.ok_or_else(|| wrong("its values must be integers".to_owned()))?;
    let narrow = |value: &i64| {
        u32::try_from(*value).map_err(|_| wrong(format!("{value} is not a 32-bit index")))
    };
    values.iter().map(narrow).collect()
}

/// Checks that each of `n` items is in one range.
fn cover(
    ranges: impl Iterator<Item = Range<usize>>,
    n: usize,
    item: &str,
    path: &str,
) -> Result<()> {
    check_cover(ranges, n, item).map_err(|(_, message)| Error::input(message).dataset(path))
}

fn points(mesh: &Group, dimension: u8) -> Result<Vec<[f64; 3]>> {
    let coords = need_group(&need_group(mesh, "nodes")?, "coords")?;
    let path = |name: &str| format!("meshes/1/nodes/coords/{name}");
    let mut parts = Vec::new();
    for dataset in coords.datasets()? {
        let path = path(dataset.name());
        parts.push((range_of(&dataset, &path)?, dataset, path));
    }
    let n = parts.iter().map(|(range, ..)| range.end).max().unwrap_or(0);
    let ranges = parts.iter().map(|(range, ..)| range.clone());
    cover(ranges, n, "node", &path(""))?;
    parts.sort_by_key(|(range, ..)| range.start);
    let mut points = Vec::new();
    for (range, dataset, path) in parts {
        let row = dataset.row()?;
        if row != usize::from(dimension) && row != 3 {
            let message =
                format!("a node has {row} coordinates; the mesh has dimension {dimension}");
            return Err(Error::input(message).dataset(&path));
        }
        let values = dataset.values()?;
        let reals = Chunk::of(&values).filter(|chunk| !chunk.element.is_integer());
        let reals = reals.ok_or_else(|| {
            Error::input("coordinates must be floating-point numbers").dataset(&path)
        })?;
        let own = reals.points(row);
        drop(values);
        if let Some(x) = own.as_flattened().iter().find(|x| !x.is_finite()) {
            let message = format!("a coordinate is {x}, which is not finite");
            return Err(Error::input(message).dataset(&path));
        }
        points.reserve_exact(range.len());
        points.extend(own);
    }
    Ok(points)
}

/// The zones of cells or faces.
struct Topology {
    ids: Vec<u32>,
    items: Vec<Range<usize>>,
    /// Number of cells or faces.
    n: usize,
    /// Numbers of types; empty where the file has none.
    kinds: Vec<u32>,
    names: Vec<String>,
}

impl Topology {
    fn read(group: &Group, item: &str) -> Result<Self> {
        let path = format!("meshes/1/{item}s/zoneTopology");
        let group = need_group(group, "zoneTopology").map_err(|error| error.dataset(&path))?;
        let list = |name: &str| -> Result<Option<Vec<u32>>> {
            let dataset = group.dataset(name)?;
            let path = format!("{path}/{name}");
            dataset.map(|dataset| indices(&dataset, &path)).transpose()
        };
        let need = |name: &str| {
            let missing =
                || Error::input("the dataset is missing").dataset(&format!("{path}/{name}"));
            list(name)?.ok_or_else(missing)
        };
        let (ids, first, last) = (need("id")?, need("minId")?, need("maxId")?);
        let names = group.dataset("name")?.map(|names| names.values());
        let names = match names.transpose()? {
            Some(Values::Text(texts)) => texts.join(";"),
            _ => String::new(),
        };
        if first.len() != ids.len() || last.len() != ids.len() {
            return Err(Error::input("id, minId and maxId have different lengths").dataset(&path));
        }
        let mut items = Vec::with_capacity(ids.len());
        for (first, last) in first.into_iter().zip(last) {
            let Some(start) = first.checked_sub(1).filter(|start| *start <= last) else {
                let message = format!("a zone has items {first} to {last}");
                return Err(Error::input(message).dataset(&path));
            };
            items.push(start as usize..last as usize);
        }
        let kinds = list("zoneType")?.unwrap_or_default();
        let n = items.iter().map(|range| range.end).max().unwrap_or(0);
        cover(items.iter().cloned(), n, item, &path)?;
        Ok(Self {
            ids,
            items,
            n,
            kinds,
            names: names.split(';').map(str::to_owned).collect(),
        })
    }

    /// Gives the zones their names, where the settings do not name them.
    fn name_all(&self, content: &mut Content, word: fn(u32) -> &'static str) {
        for (i, zone) in self.ids.iter().enumerate() {
            if let Some(kind) = self.kinds.get(i) {
                content.names.entry(*zone).or_insert_with(|| Named {
                    kind: word(*kind).to_owned(),
                    name: self.names.get(i).cloned().unwrap_or_default(),
                });
            }
        }
    }
}

fn cells(mesh: &Group, content: &mut Content) -> Result<()> {
    let group = need_group(mesh, "cells")?;
    let topology = Topology::read(&group, "cell")?;
    topology.name_all(content, kind_of_cells);
    content.n_cells = topology.n;
    for (i, (zone, cells)) in topology.ids.iter().zip(&topology.items).enumerate() {
        content.cells.push(CellZone {
            zone: *zone,
            cells: cells.clone(),
            is_active: topology.kinds.get(i) != Some(&INACTIVE),
        });
    }
    content.refined_cells = tree(&group, "meshes/1/cells/tree")?;
    Ok(())
}

/// Items that were refined.
fn tree(group: &Group, path: &str) -> Result<Vec<Range<usize>>> {
    let Some(tree) = group.group("tree")? else {
        return Ok(Vec::new());
    };
    let sections = tree.groups()?;
    let range = |section: &Group| ids(|name| section.attribute(name), path);
    sections.iter().map(range).collect()
}

fn faces(mesh: &Group, content: &mut Content) -> Result<()> {
    let group = need_group(mesh, "faces")?;
    let topology = Topology::read(&group, "face")?;
    topology.name_all(content, kind_of_faces);
    let n = topology.n;
    content.refined_faces = tree(&group, "meshes/1/faces/tree")?;
    let (ends, nodes) = nodes(&group, n)?;
    let mut cells = vec![[NONE; 2]; n];
    for (side, name) in ["c0", "c1"].into_iter().enumerate() {
        let sections = need_group(&group, name)?;
        for dataset in sections.datasets()? {
            let path = format!("meshes/1/faces/{name}/{}", dataset.name());
            let range = range_of(&dataset, &path)?;
            let Some(own) = cells.get_mut(range.clone()) else {
                let message = format!("its maxId is {}, but there are {n} faces", range.end);
                return Err(Error::input(message).dataset(&path));
            };
            for (cells, cell) in own.iter_mut().zip(indices(&dataset, &path)?) {
                cells[side] = cell.wrapping_sub(1);
            }
        }
    }
    let mut order: Vec<usize> = (0..topology.ids.len()).collect();
    order.sort_by_key(|i| topology.items[*i].start);
    let end_of = |n: usize| n.checked_sub(1).map_or(0, |last| ends[last]);
    for i in order {
        let items = topology.items[i].clone();
        let (start, end) = (end_of(items.start), end_of(items.end));
        content.faces.push(FaceZone {
            zone: topology.ids[i],
            first: items.start,
            kind: topology.kinds.get(i).copied().unwrap_or(0),
            place: Position::Dataset("meshes/1/faces".to_owned()),
            body: None,
            list: list(
                &ends[items.clone()],
                start,
                &nodes[start as usize..end as usize],
                &cells[items],
            ),
        });
    }
    Ok(())
}

/// Faces that end in all nodes at `ends`, the first of them starting at `start`.
fn list(ends: &[u32], start: u32, nodes: &[u32], cells: &[[u32; 2]]) -> FaceList {
    let size = ends.first().map_or(0, |end| end - start);
    let is_regular = size > 0
        && (1_u64..)
            .zip(ends)
            .all(|(i, end)| i * u64::from(size) == u64::from(end - start));
    FaceList {
        size: if is_regular { size as usize } else { 0 },
        ends: if is_regular {
            Vec::new()
        } else {
            ends.iter().map(|end| end - start).collect()
        },
        nodes: nodes.to_vec(),
        cells: cells.to_vec(),
    }
}

/// Ends of all faces in their nodes, and the nodes, from 0.
fn nodes(faces: &Group, n: usize) -> Result<(Vec<u32>, Vec<u32>)> {
    let group = need_group(faces, "nodes")?;
    let mut sections = Vec::new();
    for section in group.groups()? {
        let path = format!("meshes/1/faces/nodes/{}", section.name());
        sections.push((ids(|name| section.attribute(name), &path)?, section, path));
    }
    let ranges = sections.iter().map(|(range, ..)| range.clone());
    cover(ranges, n, "face", "meshes/1/faces/nodes")?;
    sections.sort_by_key(|(range, ..)| range.start);
    let (mut ends, mut nodes) = (Vec::new(), Vec::new());
    for (range, section, path) in sections {
        let counts = indices(&section.need("nnodes")?, &path)?;
        let own = indices(&section.need("nodes")?, &path)?;
        let total: u64 = counts.iter().map(|n| u64::from(*n)).sum();
        if counts.len() != range.len() || total != own.len() as u64 {
            return Err(Error::input(format!(
                "its {} faces have {total} nodes by nnodes, but there are {} nodes and the faces of minId to maxId are {}",
                counts.len(),
                own.len(),
                range.len()
            ))
            .dataset(&path));
        }
        let mut end = nodes.len() as u64;
        if end + total > u64::from(u32::MAX) {
            return Err(Error::input(TOO_MANY_NODES).dataset(&path));
        }
        ends.extend(counts.iter().map(|n| {
            end += u64::from(*n);
            end as u32
        }));
        nodes.extend(own.iter().map(|node| node.wrapping_sub(1)));
    }
    Ok((ends, nodes))
}
