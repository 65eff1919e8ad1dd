//! Embree, by the peers' program.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};

use kiloray_tests::signals::send;

use crate::Error;
use crate::rates::Rates;
use crate::rays::KINDS;

/// The built program.
pub(crate) struct Bench {
    program: PathBuf,
}

/// What a way of ours is held against: a configuration, and the width of its packets.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Rival {
    pub(crate) configuration: &'static str,
    pub(crate) width: u32,
}

/// The configurations, and how the program is told.
const CONFIGURATIONS: [(&str, &[&str]); 3] =
    [("robust", &["robust=1"]), ("default", &[]), ("avx2", &["device=isa=avx2"])];

/// Rates by rival and kind of ray.
#[derive(Default)]
pub(crate) struct Table {
    rates: BTreeMap<(Rival, &'static str), Rates>,
    hits: BTreeMap<&'static str, u64>,
}

/// The program while it runs, one run after the other. It is killed with this.
struct Running(Child);

impl Bench {
    /// Builds the program, unless it is there.
    pub(crate) fn build(peers: &Path, work: &Path) -> Result<Self, Error> {
        let program = work.join("embree_bench");
        if !program.exists() {
            let status = Command::new("g++")
                .args(["-O3", "-march=native", "-ffp-contract=off", "-std=c++17"])
                .arg(peers.join("embree_bench.cpp"))
                .arg("-o")
                .arg(&program)
                .arg("-lembree3")
                .status()?;
            if !status.success() {
                return Err("embree_bench did not build (it needs libembree-dev)".into());
            }
        }
        Ok(Self { program: std::path::absolute(program)? })
    }

    /// Leaves the rays in a file.
    pub(crate) fn write_rays(&self, mesh: &Path, size: u32, file: &Path) -> Result<(), Error> {
        let rays = format!("rays={}", file.display());
        if self.command(mesh, size, &[&rays]).stdout(Stdio::null()).status()?.success() {
            Ok(())
        } else {
            Err("embree_bench failed".into())
        }
    }

    /// Those configurations once that any of `rivals` has. After each run of one of these the program stands still for `then`: what is compared is measured
    /// within a second or two, as machines that are shared have good and bad tens of seconds.
    pub(crate) fn run(
        &self,
        mesh: &Path,
        size: u32,
        rivals: &[Rival],
        table: &mut Table,
        mut then: impl FnMut(Rival, &'static str) -> Result<(), Error>,
    ) -> Result<(), Error> {
        for (configuration, options) in CONFIGURATIONS {
            if rivals.iter().all(|rival| rival.configuration != configuration) {
                continue;
            }
            let mut running =
                Running(self.command(mesh, size, options).stdout(Stdio::piped()).spawn()?);
            let out = running.0.stdout.take().ok_or("embree_bench says nothing")?;
            for line in BufReader::new(out).lines().skip(1) {
                let (rival, kind) = table.add(configuration, &line?)?;
                if rivals.contains(&rival) {
                    send("-STOP", running.0.id())?;
                    then(rival, kind)?;
                    send("-CONT", running.0.id())?;
                }
            }
            if !running.0.wait()?.success() {
                return Err("embree_bench failed".into());
            }
        }
        Ok(())
    }

    fn command(&self, mesh: &Path, size: u32, options: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.arg(mesh).arg(format!("size={size}")).args(options);
        command
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

impl Table {
    /// A line as `primary  8c  17.4 Mrays/s (best 17.5)  rays 1048576 hits 705562 sum_t 9.4e+06`: whose it is, and its kind of ray.
    fn add(
        &mut self,
        configuration: &'static str,
        line: &str,
    ) -> Result<(Rival, &'static str), Error> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [kind, width, median, _, _, best, ..] = words[..] else {
            return Err("an unknown line".into());
        };
        let kind = KINDS.into_iter().find(|of| *of == kind).ok_or("an unknown kind of ray")?;
        let width: u32 = width.trim_end_matches('c').parse()?;
        let rival = Rival { configuration, width };
        let rates = self.rates.entry((rival, kind)).or_default();
        rates.add(median.parse()?, best.trim_end_matches(')').parse()?);
        let hits = words.iter().position(|w| *w == "hits").and_then(|i| words.get(i + 1));
        if let (1, "robust", Some(hits)) = (width, configuration, hits) {
            self.hits.insert(kind, hits.parse()?);
        }
        Ok((rival, kind))
    }

    /// The rates of a rival, if there are any.
    pub(crate) fn rates(&self, rival: Rival, kind: &'static str) -> Option<&Rates> {
        self.rates.get(&(rival, kind))
    }

    /// How many rays hit, robust.
    pub(crate) fn hits(&self, kind: &str) -> Option<u64> {
        self.hits.get(kind).copied()
    }

    pub(crate) fn print(&self) {
        for ((Rival { configuration, width }, kind), rates) in &self.rates {
            println!("embree {configuration:8} {kind:8} {width:2}  {rates}");
        }
    }
}
