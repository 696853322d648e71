//! Text in a file that only SU2 understands, kept unchanged in field arrays, one text for each zone.

use super::keyword::Keyword;
use crate::mesh::{MeshView, Values};

/// The boundary of partitioned and periodic meshes that exchanges nodes.
pub(super) const EXCHANGE: &str = "SEND_RECEIVE";
/// Field array with the centres and angles of periodic markers.
pub const PERIODIC: &str = "su2:PERIODIC";
/// Field array with the boxes for free-form deformation.
pub const BOXES: &str = "su2:FFD";
/// Field array of the second number of `NPOIN=`: the nodes that are no copies of others.
pub(super) const OWN_NODES: &str = "su2:NPOIN";

/// A kind of text that is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Extra {
    /// Offsets of the angles of attack and sideslip.
    Offset,
    /// Markers `SEND_RECEIVE`: nodes that are exchanged, and how.
    Exchange,
    /// Transformations between periodic boundaries.
    Periodic,
    /// Boxes for free-form deformation.
    Boxes,
}

impl Extra {
    /// Every kind, in the order in which they are written.
    pub const ALL: [Extra; 4] = [
        Extra::Offset,
        Extra::Exchange,
        Extra::Periodic,
        Extra::Boxes,
    ];

    /// Name of the field array.
    pub fn array(self) -> &'static str {
        match self {
            Extra::Offset => "su2:OFFSET",
            Extra::Exchange => "su2:SEND_RECEIVE",
            Extra::Periodic => PERIODIC,
            Extra::Boxes => BOXES,
        }
    }

    /// The kind of text that this keyword belongs to.
    pub fn of(keyword: &Keyword) -> Option<Self> {
        let name = keyword.name;
        match name {
            b"AOA_OFFSET" | b"AOS_OFFSET" => Some(Extra::Offset),
            b"NPERIODIC" => Some(Extra::Periodic),
            _ if name.starts_with(b"SEND_") => Some(Extra::Exchange),
            _ if name.starts_with(b"PERIODIC_") => Some(Extra::Periodic),
            _ if name.starts_with(b"FFD_") => Some(Extra::Boxes),
            _ => None,
        }
    }

    /// The text of each zone, where there is one for each of `n_zones`.
    pub fn texts<'a>(self, mesh: &MeshView<'a>, n_zones: usize) -> Option<&'a [String]> {
        match &mesh.field_array(self.array())?.values {
            Values::Text(texts) if texts.len() == n_zones => Some(texts),
            _ => None,
        }
    }
}

/// The second number of `NPOIN=` of each zone, where there is one for each of `n_zones`.
pub(super) fn own_nodes(mesh: &MeshView, n_zones: usize) -> Option<Vec<i64>> {
    let numbers = mesh.field_array(OWN_NODES)?.values.to_integers()?;
    (numbers.len() == n_zones).then_some(numbers)
}

/// Field arrays that are written for `n_zones`.
pub(super) fn written(mesh: &MeshView, n_zones: usize) -> Vec<&'static str> {
    let texts = Extra::ALL.into_iter();
    let texts = texts.filter(|extra| extra.texts(mesh, n_zones).is_some());
    let numbers = own_nodes(mesh, n_zones).map(|_| OWN_NODES);
    texts.map(Extra::array).chain(numbers).collect()
}
