//! Numbers in documents. JSON has no NaN and no infinity: both are written as null.
//!
//! [`written_as`](crate::written_as) is for results whose documents differ from their fields.

use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::{Serialize, Serializer};
use std::borrow::Cow;

/// Format of a number that may be infinite or NaN: `#[serde(with = "Finite")]` on an `f64`.
#[derive(Debug, Clone, Copy)]
pub enum Finite {}

impl Finite {
    /// The number, or null.
    ///
    /// # Errors
    /// If the serializer fails.
    pub fn serialize<S: Serializer>(value: &f64, to: S) -> Result<S::Ok, S::Error> {
        value.is_finite().then_some(*value).serialize(to)
    }
}

impl JsonSchema for Finite {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> Cow<'static, str> {
        Option::<f64>::schema_name()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        Option::<f64>::json_schema(generator)
    }
}

/// Writes a type and its schema in the form of a different type: `written_as!(Map, MapDocument)`, with `impl From<&Map>
/// for MapDocument`.
#[macro_export]
macro_rules! written_as {
    ($type:ty, $written:ty) => {
        impl serde::Serialize for $type {
            fn serialize<S: serde::Serializer>(
                &self,
                to: S,
            ) -> std::result::Result<S::Ok, S::Error> {
                serde::Serialize::serialize(&<$written>::from(self), to)
            }
        }

        impl schemars::JsonSchema for $type {
            fn inline_schema() -> bool {
                <$written as schemars::JsonSchema>::inline_schema()
            }

            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($type).into()
            }

            fn schema_id() -> std::borrow::Cow<'static, str> {
                concat!(module_path!(), "::", stringify!($type)).into()
            }

            fn json_schema(generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
                <$written as schemars::JsonSchema>::json_schema(generator)
            }
        }
    };
}
