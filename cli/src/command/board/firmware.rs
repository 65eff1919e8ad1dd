//! The firmware of a board: found, built.

use std::{
    env,
    io::Read,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

use crate::{
    args::Machine,
    failure::{Failure, Outcome},
    progress::Progress,
};

/// What QEMU and the build must know of a board.
#[derive(Debug, Clone, Copy)]
pub(super) struct Board {
    /// QEMU's name.
    pub(super) name: &'static str,
    /// Serial lines before those that links are at.
    pub(super) skipped: usize,
    /// Where in the flash the share of the scene lies, and how much fits.
    pub(super) share_at: u64,
    pub(super) share_bytes: u64,
}

/// Links of a board.
pub(super) const LINKS: usize = 3;

impl Board {
    /// Of a machine. Its memory map is that of `node-board`.
    pub(super) const fn of(machine: Machine) -> Self {
        let mps2 =
            Self { name: "mps2-an386", skipped: 1, share_at: 0x0020_0000, share_bytes: 2 << 20 };
        match machine {
            Machine::Mps2An386 => mps2,
            Machine::Mps2An385 => Self { name: "mps2-an385", ..mps2 },
            Machine::Lm3s6965evb => Self {
                name: "lm3s6965evb",
                skipped: 0,
                share_at: 0x0003_0000,
                share_bytes: 64 << 10,
            },
        }
    }

    /// Builds its firmware, and says where it is.
    pub(super) fn build(&self, quiet: bool) -> Outcome<PathBuf> {
        let script = script()?;
        let progress = Progress::new("building", 0, quiet);
        progress.message(format!("the firmware of {}", self.name));
        let output = Command::new("bash")
            .arg(&script)
            .arg(self.name)
            .stdin(Stdio::null())
            .output()
            .map_err(|error| Failure::new(format_args!("bash: {error}; it builds the firmware")))?;
        let said = String::from_utf8_lossy(&output.stderr);
        let built = String::from_utf8_lossy(&output.stdout);
        match built.lines().last() {
            Some(path) if output.status.success() => Ok(PathBuf::from(path)),
            _ => Err(Failure::new(said.lines().last().unwrap_or("the firmware cannot be built"))),
        }
    }
}

/// How every firmware begins.
const ELF: [u8; 4] = *b"\x7fELF";

/// Checks that a file may be firmware, before a board is to find out.
pub(super) fn check(path: &Path) -> Outcome {
    let read = kiloray_scene::regular::open(path).and_then(|file| {
        let mut start = Vec::new();
        file.take(ELF.len() as u64).read_to_end(&mut start).map(|_| start)
    });
    match read.map_err(|error| Failure::io(path, &error))? {
        start if start == ELF => Ok(()),
        _ => Err(Failure::file(
            path,
            "is no firmware, which is an ELF file: 'bash node-board/firmware MACHINE' builds one",
        )),
    }
}

/// The script that builds it: in this folder, in one above it, or above the command itself.
fn script() -> Outcome<PathBuf> {
    let place = Path::new("node-board/firmware");
    let folders = [env::current_dir().ok(), env::current_exe().ok()];
    let mut above = folders.iter().flatten().flat_map(|folder| folder.ancestors());
    above.find_map(|folder| Some(folder.join(place)).filter(|path| path.is_file())).ok_or_else(|| {
        Failure::new(
            "no node-board/firmware here or above: run this within Kiloray's sources, or give --firmware FILE",
        )
    })
}
