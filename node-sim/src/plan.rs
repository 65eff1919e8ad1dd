use kiloray_core::block::KiloView;
use kiloray_core::store::BudgetError;
use kiloray_mesh::MeshLayout;

use crate::check::check;
use crate::pace::layout;
use crate::{Error, Options};

/// Divides blocks and memory as [`simulate`](crate::simulate()) would, and does no more.
///
/// # Errors
/// [`Error`]: for what cannot begin. A memory that is too small is told what is needed in the end ([`least`]).
pub fn plan(file: &KiloView<'_>, options: &Options) -> Result<MeshLayout, Error> {
    check(file, options)?;
    layout(file, options).or_else(|error| {
        // The next node may need more than the first that has too little.
        let (_, short) = grown(file, options)?;
        let short = short.unwrap_or(error);
        Err(BudgetError { memory: options.mesh.memory, ..short }.into())
    })
}

/// The least memory of a node with which these options work, whatever theirs is \[bytes\].
///
/// # Errors
/// [`Error`]: for what cannot begin with any.
pub fn least(file: &KiloView<'_>, options: &Options) -> Result<usize, Error> {
    check(file, options)?;
    Ok(grown(file, options)?.0)
}

/// The least memory that works, and what is needed where there is less: from nothing up, each that is too small names what it needs.
fn grown(
    file: &KiloView<'_>,
    options: &Options,
) -> Result<(usize, Option<BudgetError>), BudgetError> {
    let (mut memory, mut short) = (0, None);
    loop {
        match layout(file, &options.with_memory(memory)) {
            Err(error) if error.need() > memory => {
                (memory, short) = (error.need(), Some(error));
            }
            other => return other.map(|_| (memory, short)),
        }
    }
}
