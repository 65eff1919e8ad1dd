//! The files that a command reads and those that it writes, as they were typed.

use std::path::{Path, PathBuf};

use crate::{
    args::{self, Command, Common, Profile, ViewChoice},
    failure::Outcome,
    input, scene,
};

/// Files by what becomes of them.
#[derive(Debug, Default)]
struct Files<'a> {
    read: Vec<&'a Path>,
    written: Vec<&'a Path>,
}

/// Refuses a command that would write over what it reads, before it does either. What it reads besides is known when it is found.
pub(super) fn check(command: &Command) -> Outcome {
    let Files { read, written } = Files::of(command);
    read.into_iter().try_for_each(input::keep)?;
    written.into_iter().filter(|path| *path != Path::new("-")).try_for_each(input::spare)
}

/// The same of what a point of a sweep reads.
pub(super) fn keep(point: &args::Sim) -> Outcome {
    Files::default().simulation(point).read.into_iter().try_for_each(input::keep)
}

impl<'a> Files<'a> {
    fn of(command: &'a Command) -> Self {
        let files = Self::default();
        match command {
            Command::Render(a) => files.scene(&a.scene).common(&a.common).writes(&a.output),
            Command::Sim(a) => files.simulation(a),
            #[cfg(feature = "host")]
            Command::Host(a) => {
                let files = files.scene(&a.scene).common(&a.common).reads(&a.config);
                files.writes(&a.output).writes(&a.write_config)
            }
            Command::Sweep(a) => files.scene(&a.scene).common(&a.common).profile(&a.mesh.profile),
            Command::Board(a) => {
                let files = files.scene(&a.scene).common(&a.common).reads(&a.firmware);
                files.writes(&a.output)
            }
            Command::Compile(a) => files.scene(&a.scene).writes(&a.output).writes(&a.json),
            Command::Plan(a) => files.scene(&a.scene).profile(&a.mesh.profile).writes(&a.json),
            Command::Compare(a) => {
                let files = files.reads([&a.reference, &a.image]).reads(&a.mask);
                files.writes(&a.output).writes(&a.json)
            }
            #[cfg(feature = "host")]
            Command::Node(_) => files,
            Command::LineNode(_)
            | Command::Calibrate(_)
            | Command::Scenes(_)
            | Command::Completions(_) => files,
        }
    }

    fn reads(mut self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        self.read.extend(paths.into_iter().map(PathBuf::as_path));
        self
    }

    fn writes(mut self, paths: impl IntoIterator<Item = &'a PathBuf>) -> Self {
        self.written.extend(paths.into_iter().map(PathBuf::as_path));
        self
    }

    fn simulation(self, sim: &'a args::Sim) -> Self {
        let files = self.scene(&sim.scene).common(&sim.common).profile(&sim.mesh.profile);
        files.writes(&sim.output).writes(&sim.trace)
    }

    fn scene(self, args::Scene { scenes, .. }: &'a args::Scene) -> Self {
        self.reads(scenes.iter().filter(|name| scene::is_file(name)))
    }

    fn common(mut self, common: &'a Common) -> Self {
        if let Some(ViewChoice::Options(file)) = &common.view {
            self.read.push(Path::new(file));
        }
        self.writes(&common.json)
    }

    fn profile(self, profile: &'a Profile) -> Self {
        match profile {
            Profile::File(path) => self.reads([path]),
            Profile::Named(_) => self,
        }
    }
}
