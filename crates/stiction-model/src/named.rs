//! Enums whose members have names, which documents show.

/// Declares an enum with a name for each member: its list `ALL`, in the order of the declaration, and its `name()`.
#[macro_export]
macro_rules! named {
    ($(#[$of:meta])* $visible:vis enum $named:ident { $($(#[$about:meta])* $member:ident = $name:literal),+ $(,)? }) => {
        $(#[$of])*
        $visible enum $named { $($(#[$about])* $member),+ }

        impl $named {
            /// All of them, in order.
            $visible const ALL: [Self; [$($name),+].len()] = [$(Self::$member),+];

            /// Name.
            $visible fn name(self) -> &'static str {
                match self { $(Self::$member => $name),+ }
            }
        }
    };
}

/// Writes types by their `name()`, as text; without the feature `serde` of the calling crate, nothing.
#[macro_export]
macro_rules! written_by_name {
    ($($named:ty),+ $(,)?) => {$(
        #[cfg(feature = "serde")]
        $crate::always_written_by_name!($named);
    )+};
}

/// Writes types by their `name()`, as text, in a crate that always serialises.
#[macro_export]
macro_rules! always_written_by_name {
    ($($named:ty),+ $(,)?) => {$(
        impl serde::Serialize for $named {
            fn serialize<S: serde::Serializer>(&self, to: S) -> std::result::Result<S::Ok, S::Error> {
                to.serialize_str(self.name())
            }
        }

        impl schemars::JsonSchema for $named {
            fn inline_schema() -> bool {
                true
            }

            fn schema_name() -> std::borrow::Cow<'static, str> {
                stringify!($named).into()
            }

            fn json_schema(of: &mut schemars::SchemaGenerator) -> schemars::Schema {
                <str as schemars::JsonSchema>::json_schema(of)
            }
        }
    )+};
}
