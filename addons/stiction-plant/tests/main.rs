//! The tests of `stiction-plant`, in one program: linking is what takes long.

mod advice;
mod agree;
mod docs;
mod groups;
mod kept;
mod layouts;
mod made_up;
mod page;
mod scan;
