use kiloray_core::{render::Neighbours, shade::Settings};
use kiloray_render::{Error, Options};
use serde_json::json;

use super::{
    super::{engine, frames},
    budget_json, too_small,
};
use crate::{
    args,
    console::{line, lines},
    failure::{self, Outcome},
    output::Output,
    scene,
};

/// What rays that go together are traced in, beside the memory.
const TOGETHER: usize = size_of::<Neighbours>();

/// Prints the budget of a node that is alone.
pub(super) fn run(arguments: &args::Plan) -> Outcome {
    let json_out = arguments.json.as_deref().map(Output::create).transpose()?;
    let to_standard = arguments.json.as_deref() == Some("-".as_ref());
    let memory = arguments.memory();
    let block = engine::default_block(Some(memory));
    let scene = scene::load(&arguments.scene, arguments.block, block, to_standard)?;
    scene.print_notes(to_standard);
    let view = scene.choose_view(None)?;
    let settings = Settings { bounces: arguments.bounces as u8, ..Settings::default() };
    let options = Options {
        memory: Some(usize::try_from(memory).unwrap_or(usize::MAX)),
        settings,
        ..Options::new(1, 1, view)
    };
    let plan = kiloray_render::plan(&scene.file.view(), &options).map_err(|error| match error {
        Error::Budget(error) => too_small(arguments, &error, error.need(), 0),
        other => engine::refused(other),
    })?;
    let budget = plan
        .budget(options.memory.unwrap_or(usize::MAX))
        .map_err(|error| too_small(arguments, &error, error.need(), 0))?;
    let file = scene.file.view();
    failure::note(frames::of_node(&file, &options).as_deref(), to_standard);
    let owned = file.header().blocks_at;
    if let Some(output) = json_out {
        let value = json!({
            "version": env!("CARGO_PKG_VERSION"),
            "scene": scene.name,
            "memory": memory,
            "total": budget.bytes(),
            "lines": budget_json(&budget),
            "blocks": file.blocks(),
            "block_bytes": file.header().block_bytes,
            "tables_bytes": owned,
            "together_bytes": TOGETHER,
        });
        output.write(format!("{value:#}\n").as_bytes())?;
    }
    if to_standard {
        return Ok(());
    }
    lines(format_args!("{budget}"))?;
    lines(format_args!(
        "\n{} of {} blocks of {} bytes can be in memory at once.",
        plan.frames,
        file.blocks(),
        plan.block_bytes
    ))?;
    line(format_args!(
        "Read in place, and not counted here: {owned} bytes of tables (materials, lights, views). Beside it rays that go together are traced in {TOGETHER} bytes (on a board they go one by one)."
    ))
}
