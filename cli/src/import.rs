//! Until the readers of files are there.

use std::path::Path;

use kiloray_scene::model::{Model, View};

#[derive(Default)]
pub(crate) struct ImportOptions {}

pub(crate) fn load<P: AsRef<Path>>(paths: &[P], _: &ImportOptions) -> Result<Model, String> {
    Err(format!("{}: files are not read yet", paths[0].as_ref().display()))
}

pub(crate) fn view(text: &str, _: Option<&View>) -> Result<View, String> {
    Err(format!("{text}: files are not read yet"))
}
