//! `$Entities` and `$PartitionedEntities` of versions 3 and 4: which physical groups an entity is in,
//! and of which one it is a part.

use super::stream::{Stream, Version};
use azimesh_core::error::Result;
use std::collections::{BTreeMap, BTreeSet};

/// An entity by its dimension and tag.
pub(super) type Key = (u8, i32);

/// Physical groups and parents of the entities.
#[derive(Debug, Default)]
pub(super) struct Entities {
    /// Whether the file has them.
    pub are_known: bool,
    /// Physical groups of those that are in any.
    pub physicals: BTreeMap<Key, Vec<i32>>,
    /// For an entity of a partition the entity of its dimension that it is a part of, and the first
    /// of its partitions.
    pub parts: BTreeMap<Key, (i32, i32)>,
}

impl Entities {
    /// Reads the entities of a whole model.
    pub fn read(&mut self, stream: &mut Stream, version: Version) -> Result<()> {
        self.are_known = true;
        let counts = counts(stream, version)?;
        for dimension in 0..4u8 {
            for _ in 0..counts[usize::from(dimension)] {
                let what = "the tag of an entity";
                if version == Version::V3 {
                    let tag = stream.word(what)?.narrow(what)?;
                    self.read_v3(stream, (dimension, tag))?;
                } else {
                    let tag = stream.int(what)?;
                    self.read_rest(stream, version, (dimension, tag))?;
                }
            }
        }
        Ok(())
    }

    /// Reads the entities of a partitioned model; they are additional to those of the whole model.
    pub fn read_partitioned(&mut self, stream: &mut Stream, version: Version) -> Result<()> {
        self.are_known = true;
        stream.size("the number of partitions")?;
        for _ in 0..stream.size("the number of ghost entities")? {
            stream.int("the tag of a ghost entity")?;
            stream.int("the partition of a ghost entity")?;
        }
        let counts = counts(stream, version)?;
        for dimension in 0..4u8 {
            for _ in 0..counts[usize::from(dimension)] {
                let tag = stream.int("the tag of an entity")?;
                let parent_dimension = stream.int("the dimension of a parent entity")?;
                let parent = stream.int("the tag of a parent entity")?;
                let mut partition = 0;
                for i in 0..stream.size("the number of partitions")? {
                    let of = stream.int("a partition")?;
                    if i == 0 {
                        partition = of;
                    }
                }
                self.read_rest(stream, version, (dimension, tag))?;
                if parent_dimension == i32::from(dimension) {
                    self.parts.insert((dimension, tag), (parent, partition));
                    if let Some(groups) = self.physicals.get(&(dimension, parent)).cloned() {
                        self.physicals.entry((dimension, tag)).or_insert(groups);
                    }
                }
            }
        }
        Ok(())
    }

    /// Reads boundary and physical groups of an entity of version 3, text in binary files too.
    fn read_v3(&mut self, stream: &mut Stream, key: Key) -> Result<()> {
        let int = |stream: &mut Stream, what| -> Result<i32> { stream.word(what)?.narrow(what) };
        if key.0 > 0 {
            for _ in 0..int(stream, "the number of bounding entities")? {
                int(stream, "a bounding entity")?;
            }
        }
        let n = int(stream, "the number of physical groups")?;
        let groups = (0..n).map(|_| int(stream, "a physical group"));
        let groups: Vec<i32> = groups.collect::<Result<_>>()?;
        self.add(stream, key, &groups)
    }

    /// Reads position or box, physical groups and boundary of one entity.
    fn read_rest(&mut self, stream: &mut Stream, version: Version, key: Key) -> Result<()> {
        let is_position = key.0 == 0 && version == Version::V41;
        for _ in 0..if is_position { 3 } else { 6 } {
            stream.real("a bound of an entity")?;
        }
        let mut groups = Vec::new();
        for _ in 0..stream.size("the number of physical groups")? {
            groups.push(stream.int("a physical group")?);
        }
        if key.0 > 0 {
            for _ in 0..stream.size("the number of bounding entities")? {
                stream.int("a bounding entity")?;
            }
        }
        self.add(stream, key, &groups)
    }

    /// A negative group holds the entity turned round.
    fn add(&mut self, stream: &Stream, key: Key, groups: &[i32]) -> Result<()> {
        let mut kept = Vec::new();
        let mut seen = BTreeSet::new();
        for group in groups {
            let group = group
                .checked_abs()
                .ok_or_else(|| stream.error(format!("physical group {group} is out of range")))?;
            if seen.insert(group) {
                kept.push(group);
            }
        }
        if !kept.is_empty() {
            self.physicals.insert(key, kept);
        }
        Ok(())
    }
}

fn counts(stream: &mut Stream, version: Version) -> Result<[usize; 4]> {
    let mut counts = [0; 4];
    for (count, what) in counts
        .iter_mut()
        .zip(["points", "curves", "surfaces", "volumes"])
    {
        let what = format!("the number of {what}");
        *count = match version {
            Version::V3 => stream.word(&what)?.narrow(&what)?,
            _ => stream.size(&what)?,
        };
    }
    Ok(counts)
}
