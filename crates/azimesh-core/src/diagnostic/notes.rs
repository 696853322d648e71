//! The macro that declares the notes of a module: the fields of each, and its sentence.

/// Declares the notes of a module: the enum, its sentences, and how it becomes the [`NoteKind`](super::NoteKind) after `as`,
/// where one is given.
/// A sentence is what `write!` takes, with the fields as names.
macro_rules! notes {
    ($(#[$doc:meta])* $name:ident $(as $kind:ident)? {$(
        $(#[$note_doc:meta])*
        $note:ident $({$( $(#[$field_doc:meta])* $field:ident: $type:ty ),* $(,)?})? => ($($sentence:tt)*)
    )*}) => {
        $(#[$doc])*
        #[derive(Debug, Clone, PartialEq)]
        pub enum $name {$(
            $(#[$note_doc])*
            $note $({$( $(#[$field_doc])* $field: $type, )*})?,
        )*}

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                match self {
                    $(Self::$note $({$( $field, )*})? => write!(f, $($sentence)*),)*
                }
            }
        }

        $(impl From<$name> for crate::diagnostic::NoteKind {
            fn from(note: $name) -> Self {
                Self::$kind(note)
            }
        })?
    };
}
pub(super) use notes;
