//! How far a picture is from a reference.

mod false_colour;
mod mask;
mod measure;

pub(crate) use false_colour::false_colour;
pub(crate) use mask::{bright, smooth};
pub(crate) use measure::{Measures, measure, relative_errors};
