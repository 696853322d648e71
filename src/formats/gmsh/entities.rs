//! `$Entities` and `$PartitionedEntities` of version 4.1: which physical groups an entity is in.

use super::stream::Stream;
use crate::error::Result;
use std::collections::BTreeMap;

/// Physical groups by dimension and tag of the entity.
pub(super) type Physicals = BTreeMap<(u8, i32), Vec<i32>>;

/// Reads the entities of a whole model.
pub(super) fn read(stream: &mut Stream, physicals: &mut Physicals) -> Result<()> {
    let counts = counts(stream)?;
    for dimension in 0..4u8 {
        for _ in 0..counts[usize::from(dimension)] {
            let tag = stream.int("the tag of an entity")?;
            read_rest(stream, dimension, tag, physicals)?;
        }
    }
    Ok(())
}

/// Reads the entities of a partitioned model; they come beside the whole ones.
pub(super) fn read_partitioned(stream: &mut Stream, physicals: &mut Physicals) -> Result<()> {
    stream.size("the number of partitions")?;
    for _ in 0..stream.size("the number of ghost entities")? {
        stream.int("the tag of a ghost entity")?;
        stream.int("the partition of a ghost entity")?;
    }
    let counts = counts(stream)?;
    for dimension in 0..4u8 {
        for _ in 0..counts[usize::from(dimension)] {
            let tag = stream.int("the tag of an entity")?;
            stream.int("the dimension of a parent entity")?;
            stream.int("the tag of a parent entity")?;
            for _ in 0..stream.size("the number of partitions")? {
                stream.int("a partition")?;
            }
            read_rest(stream, dimension, tag, physicals)?;
        }
    }
    Ok(())
}

fn counts(stream: &mut Stream) -> Result<[usize; 4]> {
    Ok([
        stream.size("the number of points")?,
        stream.size("the number of curves")?,
        stream.size("the number of surfaces")?,
        stream.size("the number of volumes")?,
    ])
}

/// Reads position or box, physical groups and boundary of one entity.
fn read_rest(
    stream: &mut Stream,
    dimension: u8,
    tag: i32,
    physicals: &mut Physicals,
) -> Result<()> {
    for _ in 0..if dimension == 0 { 3 } else { 6 } {
        stream.real("a bound of an entity")?;
    }
    let mut groups = Vec::new();
    for _ in 0..stream.size("the number of physical groups")? {
        // A negative tag means the group holds the entity turned round.
        let group = stream.int("a physical group")?;
        let group = group
            .checked_abs()
            .ok_or_else(|| stream.error(format!("physical group {group} is out of range")))?;
        if !groups.contains(&group) {
            groups.push(group);
        }
    }
    if dimension > 0 {
        for _ in 0..stream.size("the number of bounding entities")? {
            stream.int("a bounding entity")?;
        }
    }
    if !groups.is_empty() {
        physicals.insert((dimension, tag), groups);
    }
    Ok(())
}
