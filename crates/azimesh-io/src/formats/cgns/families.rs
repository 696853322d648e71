//! Families of a base: the name a user knows a boundary by, and the type of its condition.

use super::node::Node;
use azimesh_core::error::Result;
use std::collections::BTreeMap;

/// The families of a base by name.
#[derive(Default)]
pub(super) struct Families {
    by_name: BTreeMap<String, Family>,
    base: String,
}

#[derive(Default)]
struct Family {
    /// Full name, where that is too long for CGNS.
    full_name: Option<String>,
    condition: Option<String>,
    /// Families that it belongs to.
    within: Vec<String>,
}

/// Names that programs give to what belongs to no family.
const NONE: [&str; 4] = ["", "Unspecified", "ORPHAN", "Null"];

impl Families {
    /// Reads the families of a base, also those inside one another.
    pub fn read(base: &Node) -> Result<Self> {
        let mut families = Self {
            base: base.name().to_owned(),
            ..Self::default()
        };
        for node in base.labelled("Family_t")? {
            families.add(node, "", 0)?;
        }
        Ok(families)
    }

    fn add(&mut self, node: &Node, above: &str, depth: usize) -> Result<()> {
        let name = format!("{above}{}", node.name());
        let mut family = Family::default();
        for child in node.children()? {
            match child.label() {
                "FamilyBC_t" => family.condition = condition(&child.text_or_none()?),
                "FamilyName_t" => family.within.push(child.text_or_none()?),
                "Descriptor_t" if child.name() == super::FULL_NAME => {
                    family.full_name = Some(child.own_text()?);
                }
                "Family_t" if depth < 8 => self.add(child, &format!("{name}/"), depth + 1)?,
                _ => {}
            }
        }
        family.within.retain(|name| !name.is_empty());
        self.by_name.insert(name, family);
        Ok(())
    }

    /// The names that users know a family by: those of the families it belongs to, or its own. None for a family that stands for no family.
    pub fn names(&self, family: &str) -> Vec<String> {
        let key = self.key(family);
        if NONE.contains(&key) {
            return Vec::new();
        }
        match self.by_name.get(key) {
            Some(family) if !family.within.is_empty() => family.within.clone(),
            Some(Family {
                full_name: Some(name),
                ..
            }) => vec![name.clone()],
            _ => vec![key.to_owned()],
        }
    }

    /// The type of a family's boundary condition.
    pub fn condition(&self, family: &str) -> Option<&str> {
        self.by_name.get(self.key(family))?.condition.as_deref()
    }

    /// A family may be named by its path from the root.
    fn key<'a>(&self, family: &'a str) -> &'a str {
        let rest = family.strip_prefix('/').unwrap_or(family);
        let below = rest.strip_prefix(&self.base);
        below
            .and_then(|rest| rest.strip_prefix('/'))
            .unwrap_or(family)
    }
}

/// A type of boundary condition; `None` for words that say nothing.
pub(super) fn condition(text: &str) -> Option<String> {
    let says_nothing = ["", "Null", "BCTypeNull", "FamilySpecified"].contains(&text);
    (!says_nothing).then(|| text.to_owned())
}
