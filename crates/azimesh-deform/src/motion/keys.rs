//! The keys of the schedule. Each is described once: its kind of value, default, range and documentation. The
//! reader, the JSON schema and the tables of docs/schedule.md are generated from that.

use super::names::Pattern;
use super::reader::{Entry, Lines, Section};
use azimesh_core::error::Result;
use azimesh_core::geometry::vector::{Vector, unit};
use azimesh_io::formats::{Compression, Encoding, Precision};
use serde_json::{Map, Value, json};
use toml::de::DeTable;

/// A key of a table of the schedule. The texts are for the documentation page, which a test generates.
#[cfg_attr(not(test), expect(dead_code))]
pub(super) struct Key {
    pub name: &'static str,
    /// Kind of its value in words; empty where the schema lists names.
    pub words: &'static str,
    /// The default, in TOML.
    pub default: Option<&'static str>,
    /// Default in words, if it has no value.
    pub otherwise: &'static str,
    /// Example line for a required key.
    pub example: Option<&'static str>,
    pub doc: &'static str,
    pub schema: fn() -> Value,
}

/// A kind of value: its reader and its schema.
pub(super) struct Kind<T> {
    pub words: &'static str,
    pub read: fn(&Entry<'_>) -> Result<T>,
    pub schema: fn() -> Value,
}

impl<T> Kind<T> {
    /// Reads a default, written in TOML.
    pub fn value(&self, text: &str) -> T {
        let promise = "a default is a value of its kind";
        let text = format!("value = {text}");
        let (lines, document) = (Lines::of(&text), DeTable::parse(&text).expect(promise));
        let entry = Section::root(&lines, document.get_ref(), "").get("value");
        (self.read)(&entry.expect(promise)).expect(promise)
    }
}

/// A type that is read from a table, key by key.
pub(super) trait Keys: Sized {
    /// Title of the table in errors.
    const TITLE: &'static str;
    const KEYS: &'static [Key];

    /// The value with all defaults.
    fn empty() -> Self;

    /// Sets what the keys of a section give.
    fn set(&mut self, section: &Section<'_>) -> Result<()>;

    /// Reads the table under a key; an unknown key in it is an error.
    fn section<'a>(entry: &Entry<'a>) -> Result<Section<'a>> {
        entry.section(Self::TITLE, &Self::known())
    }

    fn known() -> Vec<&'static str> {
        Self::KEYS.iter().map(|key| key.name).collect()
    }

    fn read(entry: &Entry<'_>) -> Result<Self> {
        let mut new = Self::empty();
        new.set(&Self::section(entry)?)?;
        Ok(new)
    }

    /// The JSON schema of the table.
    fn schema() -> Value {
        let mut properties = Map::new();
        for key in Self::KEYS {
            let mut schema = (key.schema)();
            schema["description"] = without_links(key.doc).into();
            if let Some(default) = key.default {
                let default = toml::from_str::<Value>(&format!("value = {default}"));
                schema["default"] = default.expect("a default is TOML")["value"].take();
            }
            properties.insert(key.name.to_owned(), schema);
        }
        let required = Self::KEYS.iter().filter(|key| key.example.is_some());
        object(properties, required.map(|key| key.name).collect())
    }
}

/// Returns a schema of a table without other keys.
pub(super) fn object(properties: Map<String, Value>, required: Vec<&str>) -> Value {
    json!({ "type": "object", "properties": properties, "required": required, "additionalProperties": false })
}

/// Replaces the links in Markdown by their text.
fn without_links(doc: &str) -> String {
    let (mut text, mut rest) = (String::new(), doc.trim());
    while let Some((before, after)) = rest.split_once("](") {
        let (start, label) = before.rsplit_once('[').unwrap_or(("", before));
        text.extend([start, label]);
        rest = after.split_once(')').map_or("", |(_, rest)| rest);
    }
    text + rest
}

/// A field that stores the value of a key.
pub(super) trait Holds<T> {
    fn hold(&mut self, value: T);
}

impl<T> Holds<T> for T {
    fn hold(&mut self, value: T) {
        *self = value;
    }
}

impl<T> Holds<T> for Option<T> {
    fn hold(&mut self, value: T) {
        *self = Some(value);
    }
}

/// Describes the keys of a table, one after another: documentation, name, kind, default.
///
/// ```text
/// keys! { impl Cyclic "[body.cyclic]" = Self::new(), {      // the value with all defaults
///     /// mean pitch
///     collective => pitch.mean, angle(), default 0;         // the field that it sets; without one it is read elsewhere
///     /// between rows of the table
///     interpolation => interpolation, choice::<Interpolation>(), default "linear", with table;    // only with another key
/// } }
/// keys! { pub struct RbfOptions "[rbf]" {                   // the fields are the keys
///     /// greater than 1e-9 of the diagonal of the mesh
///     pub support_radius: Option<f64>, positive("length"), or "chosen and reported";
/// } }
/// ```
///
/// Instead of a default: `or "words"`, or `needed "an example"` for a required key.
macro_rules! keys {
    ($(#[$attribute:meta])* $vis:vis struct $type:ident $title:literal { $(
        $(#[doc = $doc:literal])+
        $field:vis $key:ident: $of:ty, $kind:expr $(, default $default:tt)? $(, or $words:literal)? $(, with $other:ident)?;
    )+ }) => {
        $(#[$attribute])*
        $vis struct $type { $( $(#[doc = $doc])+ $field $key: $of, )+ }

        impl Default for $type {
            fn default() -> Self {
                Self { $( $key: keys!(@default $kind $(, $default)?), )+ }
            }
        }

        keys! { impl $type $title = Self::default(), { $(
            $(#[doc = $doc])+
            $key => $key, $kind $(, default $default)? $(, or $words)? $(, with $other)?;
        )+ } }
    };
    (impl $type:ident $title:literal = $empty:expr, { $(
        $(#[doc = $doc:literal])+
        $key:ident $(=> $($field:ident).+)?, $kind:expr $(, default $default:tt)? $(, or $words:literal)?
            $(, needed $example:literal)? $(, with $other:ident)?;
    )+ }) => {
        impl $crate::motion::keys::Keys for $type {
            const TITLE: &'static str = $title;
            const KEYS: &'static [$crate::motion::keys::Key] = &[ $( $crate::motion::keys::Key {
                name: stringify!($key),
                words: $kind.words,
                default: keys!(@text $(stringify!($default))?),
                otherwise: concat!($($words)?),
                example: keys!(@text $($example)?),
                doc: concat!($($doc),+),
                schema: $kind.schema,
            } ),+ ];

            fn empty() -> Self {
                $empty
            }

            #[allow(unused_variables)]
            fn set(&mut self, section: &$crate::motion::reader::Section<'_>) -> azimesh_core::error::Result<()> {
                $(
                    $( section.require(stringify!($key), $example)?; )?
                    $( if let Some(value) = section.optional(stringify!($key), $kind.read)? {
                        $crate::motion::keys::Holds::hold(&mut self.$($field).+, value);
                    } )?
                    $( section.only_with(stringify!($key), stringify!($other))?; )?
                )+
                Ok(())
            }
        }
    };
    (@default $kind:expr) => { Default::default() };
    (@default $kind:expr, $default:tt) => { $kind.value(stringify!($default)).into() };
    (@text) => { None };
    (@text $text:expr) => { Some($text) };
}

pub(super) use keys;

/// A type with a few named values.
pub(super) trait Named: Copy {
    fn names() -> Vec<(&'static str, Self)>;
}

/// Defines the names of the values of types.
macro_rules! names {
    ($($type:ident { $($name:literal => $value:ident),+ })+) => {
        $(impl $crate::motion::keys::Named for $type {
            fn names() -> Vec<(&'static str, Self)> {
                vec![$(($name, Self::$value)),+]
            }
        })+
    };
}

pub(super) use names;

macro_rules! names_of_formats {
    ($($type:ident),+) => {
        $(impl Named for $type {
            fn names() -> Vec<(&'static str, Self)> {
                Self::ALL.iter().map(|(name, value, _)| (*name, *value)).collect()
            }
        })+
    };
}

names_of_formats! { Precision, Encoding, Compression }

/// A finite number.
pub(super) const fn number(words: &'static str) -> Kind<f64> {
    Kind {
        words,
        read: |entry| entry.number(),
        schema: || json!({ "type": "number" }),
    }
}

/// A number greater than 0.
pub(super) const fn positive(words: &'static str) -> Kind<f64> {
    Kind {
        words,
        read: |entry| entry.positive(),
        schema: || json!({ "type": "number", "exclusiveMinimum": 0 }),
    }
}

/// An angle, in radians.
pub(super) const fn angle() -> Kind<f64> {
    Kind {
        read: |entry| entry.angle(),
        ..number("angle")
    }
}

/// A whole number greater than 0.
pub(super) const fn count(words: &'static str) -> Kind<usize> {
    Kind {
        words,
        read: |entry| entry.count(),
        schema: || json!({ "type": "integer", "minimum": 1 }),
    }
}

/// 1 or -1, as a factor.
pub(super) const fn sign() -> Kind<f64> {
    Kind {
        words: "1, -1",
        read: |entry| entry.sign(),
        schema: || json!({ "type": "integer", "enum": [1, -1] }),
    }
}

/// `true` or `false`.
pub(super) const fn boolean() -> Kind<bool> {
    Kind {
        words: "bool",
        read: |entry| entry.boolean(),
        schema: || json!({ "type": "boolean" }),
    }
}

/// A string that is not empty: text, a file, a name.
pub(super) const fn string<T: for<'s> From<&'s str>>() -> Kind<T> {
    Kind {
        words: "string",
        read: |entry| entry.string().map(T::from),
        schema: || json!({ "type": "string", "minLength": 1 }),
    }
}

/// Numbers in brackets.
pub(super) const fn numbers<const N: usize>(words: &'static str) -> Kind<[f64; N]> {
    Kind {
        words,
        read: |entry| entry.numbers(),
        schema: || json!({ "type": "array", "items": { "type": "number" }, "minItems": N, "maxItems": N }),
    }
}

/// A direction of any length, as a unit vector; zero for a zero vector.
pub(super) const fn direction() -> Kind<Vector> {
    Kind {
        words: "3 numbers",
        read: |entry| Ok(unit(entry.numbers()?).unwrap_or_default()),
        schema: numbers::<3>("").schema,
    }
}

/// Names or globs.
pub(super) const fn patterns() -> Kind<Vec<Pattern>> {
    Kind {
        words: "array of strings",
        read: |entry| entry.patterns(),
        schema: || json!({ "type": "array", "items": (string::<String>().schema)(), "minItems": 1 }),
    }
}

/// One of a few names.
pub(super) const fn choice<T: Named>() -> Kind<T> {
    Kind {
        words: "",
        read: |entry| entry.choice(&T::names()),
        schema: || {
            let names = T::names();
            json!({ "enum": names.iter().map(|(name, _)| name).collect::<Vec<_>>() })
        },
    }
}

/// A table with keys of its own.
pub(super) const fn table<T: Keys>() -> Kind<T> {
    Kind {
        words: "a table, below",
        read: T::read,
        schema: T::schema,
    }
}
