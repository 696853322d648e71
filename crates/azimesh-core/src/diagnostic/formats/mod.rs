//! Notes of readers and writers of mesh files: what a file holds that a mesh does not, and what of a mesh a
//! format does not hold.
//!
//! In the fields, `what` is the kind of an array (`point`, `cell`, `field`), of a group (`tag`, `group`) or of an
//! item (`node`, `element`), and `format` the name of a format in a sentence.

mod fluent;
mod foam;
mod read;
mod write;

pub use fluent::Fluent;
pub use foam::Foam;
pub use read::{ArrayRead, NotKept, Pieces, Read};
pub use write::{ArrayWritten, Condition, GroupWritten, NotTaken, Written};

use super::NoteKind;
use std::fmt::{self, Display, Formatter};
use std::mem::discriminant;

/// Names that a sentence lists before the rest is counted.
const LISTED: usize = 5;

/// A note of a reader or a writer, by what it is about.
#[derive(Debug, Clone, PartialEq)]
pub enum FormatNote {
    /// An array that was read.
    ArrayRead(ArrayRead),
    /// A part of a file that a mesh does not hold.
    NotKept(NotKept),
    /// Something else in a file that was read.
    Read(Read),
    /// How the pieces of a mesh were joined.
    Pieces(Pieces),
    /// An array that was written, or was not.
    ArrayWritten(ArrayWritten),
    /// A group or its name.
    GroupWritten(GroupWritten),
    /// What programs that read the file do not take.
    NotTaken(NotTaken),
    /// The type of a boundary condition.
    Condition(Condition),
    /// Something else that a file does not hold as it was.
    Written(Written),
    /// An OpenFOAM case.
    Foam(Foam),
    /// A file of Fluent.
    Fluent(Fluent),
}

macro_rules! kinds {
    ($($kind:ident),*) => {
        impl FormatNote {
            /// Whether it is of the same sort: the same but for names and numbers.
            pub(super) fn is_like(&self, other: &Self) -> bool {
                match (self, other) {
                    $((Self::$kind(one), Self::$kind(other)) => discriminant(one) == discriminant(other),)*
                    _ => false,
                }
            }
        }
        impl Display for FormatNote {
            fn fmt(&self, f: &mut Formatter<'_>) -> fmt::Result {
                match self {
                    $(Self::$kind(note) => note.fmt(f),)*
                }
            }
        }
        $(
            impl From<$kind> for NoteKind {
                fn from(note: $kind) -> Self {
                    Self::Format(FormatNote::$kind(note))
                }
            }
        )*
    };
}

kinds!(
    ArrayRead,
    NotKept,
    Read,
    Pieces,
    ArrayWritten,
    GroupWritten,
    NotTaken,
    Condition,
    Written,
    Foam,
    Fluent
);

/// Names in quotes.
fn quoted(names: &[String]) -> String {
    let names = names.iter().map(|name| format!("\"{name}\""));
    names.collect::<Vec<_>>().join(", ")
}

/// What a list of so many names leaves unsaid.
fn more(n: usize, listed: usize) -> String {
    match n.saturating_sub(listed) {
        0 => String::new(),
        n => format!(" and {n} more"),
    }
}
