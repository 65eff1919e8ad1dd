//! Drawings as SVG: they take the colour of the text around them, so that they can be read in the dark.

mod ink;
mod layout;
mod lines;
mod map;

pub(crate) use ink::{SERIES, css, heat};
pub(crate) use layout::Layout;
pub(crate) use lines::{Line, Lines, Mark, Scale};
pub(crate) use map::{Map, map, scale_bar};
