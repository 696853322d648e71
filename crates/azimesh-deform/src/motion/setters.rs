//! Setters of types that are built by chained calls.

/// Defines methods that take `self`, change it and return it:
///
/// ```text
/// setters! { Rotor {
///     /// Hub centre, in mesh units.
///     hub(hub: Vector) |self| self.hub = hub;
/// } }
/// ```
macro_rules! setters {
    ($type:ty { $( $(#[$attribute:meta])* $name:ident($($value:ident: $of:ty),*) |$self:ident| $change:expr; )+ }) => {
        impl $type {
            $(
                $(#[$attribute])*
                #[must_use]
                pub fn $name(mut $self $(, $value: $of)*) -> Self {
                    $change;
                    $self
                }
            )+
        }
    };
}

pub(super) use setters;
