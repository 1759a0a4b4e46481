//! Values of `result.json`: numbers that may be null, words, objects whose keys are names.

use crate::fields;
use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, MapAccess, Unexpected, Visitor};
use serde::ser::{Serialize, Serializer};
use std::fmt;
use std::marker::PhantomData;
use wireloom_core::equilibrium::SlideMotion;
use wireloom_core::requirement::{Bound, Measure, Origin, Severity, Verdict};
use wireloom_core::{EventKind, Rotation, Status, Vector};

/// Version of the form.
pub const SCHEMA: u32 = 1;

/// The field `schema`: always [`SCHEMA`]; any other version is refused.
#[derive(Clone, Copy, Debug)]
pub struct Schema;

impl Serialize for Schema {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_u32(SCHEMA)
    }
}

impl<'de> Deserialize<'de> for Schema {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match u32::deserialize(deserializer)? {
            SCHEMA => Ok(Self),
            other => Err(D::Error::custom(format!(
                "version {other} is not known to this program, which reads version {SCHEMA}"
            ))),
        }
    }
}

/// The field `fields`: always the name of [`crate::fields::FILE`]; any other one is refused.
#[derive(Clone, Copy, Debug)]
pub struct FieldsFile;

impl Serialize for FieldsFile {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(fields::FILE)
    }
}

impl<'de> Deserialize<'de> for FieldsFile {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match String::deserialize(deserializer)?.as_str() {
            fields::FILE => Ok(Self),
            other => Err(D::Error::custom(format!("{other:?} is no file of fields, which is {:?}", fields::FILE))),
        }
    }
}

/// A number; null where it is not finite, which is read as NaN. A missing field is an error, unlike with `Option<f64>`.
#[derive(Clone, Copy, Debug)]
pub struct Number(pub f64);

/// A vector in world axes.
pub type Vector3 = [Number; 3];

/// A unit quaternion `[w, x, y, z]`.
pub type Quaternion = [Number; 4];

impl Serialize for Number {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if self.0.is_finite() { serializer.serialize_f64(self.0) } else { serializer.serialize_none() }
    }
}

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Numeric;
        impl Visitor<'_> for Numeric {
            type Value = Number;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or null")
            }
            fn visit_f64<E: Error>(self, number: f64) -> Result<Number, E> {
                Ok(Number(number))
            }
            fn visit_u64<E: Error>(self, number: u64) -> Result<Number, E> {
                Ok(Number(number as f64))
            }
            fn visit_i64<E: Error>(self, number: i64) -> Result<Number, E> {
                Ok(Number(number as f64))
            }
            fn visit_unit<E: Error>(self) -> Result<Number, E> {
                Ok(Number(f64::NAN))
            }
        }
        deserializer.deserialize_any(Numeric)
    }
}

/// A vector as it is written.
pub fn written(v: &Vector) -> Vector3 {
    [Number(v.x), Number(v.y), Number(v.z)]
}

/// A vector as it was read.
pub fn vector(v: Vector3) -> Vector {
    Vector::from(v.map(|number| number.0))
}

/// A rotation as it is written.
pub fn quaternion(q: &Rotation) -> Quaternion {
    [Number(q.w), Number(q.i), Number(q.j), Number(q.k)]
}

/// A rotation as it was read.
pub fn rotation(q: Quaternion) -> Rotation {
    let [w, i, j, k] = q.map(|number| number.0);
    Rotation::new_unchecked([i, j, k, w].into())
}

/// For fields that may be null but not missing.
pub fn nullable<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<Option<T>, D::Error> {
    Option::deserialize(deserializer)
}

/// For counts that are left out where they are 0.
#[expect(clippy::trivially_copy_pass_by_ref, reason = "the form that serde asks for")]
pub fn is_zero(count: &usize) -> bool {
    *count == 0
}

/// A value of which only the presence is checked.
#[derive(Clone, Copy, Debug)]
pub struct Skipped;

impl<'de> Deserialize<'de> for Skipped {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        IgnoredAny::deserialize(deserializer).map(|_| Self)
    }
}

/// A type of `core` whose values have words of their own.
pub trait Worded: Copy + 'static {
    /// The type, for error messages.
    const NAME: &'static str;
    /// All values.
    const ALL: &'static [Self];
    /// The word of a value.
    fn word(self) -> &'static str;
}

/// Makes the words of types of `core` their form in `result.json`.
macro_rules! worded {
    ($($type:ty: $name:literal),* $(,)?) => {$(
        impl Worded for $type {
            const NAME: &'static str = $name;
            const ALL: &'static [Self] = &<$type>::ALL;
            fn word(self) -> &'static str {
                self.word()
            }
        }
    )*};
}

worded! {
    Status: "status",
    EventKind: "kind of event",
    Verdict: "verdict",
    Measure: "quantity of a requirement",
    Severity: "severity",
    Origin: "origin of a requirement",
    Bound: "side of a limit",
}

impl Worded for SlideMotion {
    const NAME: &'static str = "motion of a sliding cable";
    const ALL: &'static [Self] = &[Self::Free, Self::Stick, Self::Slip, Self::Stopped];
    fn word(self) -> &'static str {
        self.word()
    }
}

/// A value written as its word.
#[derive(Clone, Copy, Debug)]
pub struct Word<T>(pub T);

impl<T: Worded> Serialize for Word<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.0.word())
    }
}

impl<'de, T: Worded> Deserialize<'de> for Word<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct OneOf<T>(PhantomData<T>);
        impl<T: Worded> Visitor<'_> for OneOf<T> {
            type Value = Word<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a {}", T::NAME)
            }
            fn visit_str<E: Error>(self, word: &str) -> Result<Word<T>, E> {
                let found = T::ALL.iter().copied().find(|value| value.word() == word);
                found.map(Word).ok_or_else(|| E::invalid_value(Unexpected::Str(word), &self))
            }
        }
        deserializer.deserialize_str(OneOf(PhantomData))
    }
}

/// An object whose keys are names, in the order of the text.
#[derive(Clone, Debug)]
pub struct Entries<T>(pub Vec<(String, T)>);

impl<T> Entries<T> {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

impl<T> Default for Entries<T> {
    fn default() -> Self {
        Self(Vec::new())
    }
}

impl<T> FromIterator<(String, T)> for Entries<T> {
    fn from_iter<I: IntoIterator<Item = (String, T)>>(entries: I) -> Self {
        Self(entries.into_iter().collect())
    }
}

impl<T: Serialize> Serialize for Entries<T> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_map(self.0.iter().map(|(name, value)| (name, value)))
    }
}

impl<'de, T: Deserialize<'de>> Deserialize<'de> for Entries<T> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Each<T>(PhantomData<T>);
        impl<'de, T: Deserialize<'de>> Visitor<'de> for Each<T> {
            type Value = Entries<T>;
            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("an object")
            }
            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Entries<T>, A::Error> {
                let mut entries = Vec::new();
                while let Some(entry) = map.next_entry()? {
                    entries.push(entry);
                }
                Ok(Entries(entries))
            }
        }
        deserializer.deserialize_map(Each(PhantomData))
    }
}
