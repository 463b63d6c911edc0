//! Methods that set a field and return the whole, for the structs of figures and reports.

/// Declares such methods: `fn title(title: impl Into<String>) => title = title.into();` sets a field, and
/// `fn with(panel: Panel) => panels.push(panel);` adds to one.
#[doc(hidden)]
#[macro_export]
macro_rules! setters {
    ($(
        $(#[$about:meta])*
        fn $name:ident($($value:ident: $type:ty),*) => $field:ident $(.push($added:expr))? $(= $set:expr)?;
    )+) => {$(
        $(#[$about])*
        #[must_use]
        pub fn $name(mut self $(, $value: $type)*) -> Self {
            self.$field $(.push($added))? $(= $set)?;
            self
        }
    )+};
}
