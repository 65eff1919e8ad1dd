//! Embree, by the peers' program.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::process::Command;

use crate::Error;
use crate::rates::Rates;

/// The built program.
pub(crate) struct Bench {
    program: PathBuf,
}

/// Its configurations, and how they are told.
const CONFIGURATIONS: [(&str, &[&str]); 3] =
    [("robust", &["robust=1"]), ("default", &[]), ("avx2", &["device=isa=avx2"])];

/// Rates by configuration, kind of ray and width of packets.
#[derive(Default)]
pub(crate) struct Table {
    rates: BTreeMap<(String, String, u32), Rates>,
    hits: BTreeMap<String, u64>,
}

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
        self.output(mesh, size, &[&rays]).map(|_| ())
    }

    /// All configurations once.
    pub(crate) fn run(&self, mesh: &Path, size: u32, table: &mut Table) -> Result<(), Error> {
        for (name, options) in CONFIGURATIONS {
            for line in self.output(mesh, size, options)?.lines().skip(1) {
                table.add(name, line)?;
            }
        }
        Ok(())
    }

    fn output(&self, mesh: &Path, size: u32, options: &[&str]) -> Result<String, Error> {
        let size = format!("size={size}");
        let out = Command::new(&self.program).arg(mesh).arg(size).args(options).output()?;
        if !out.status.success() {
            return Err("embree_bench failed".into());
        }
        Ok(String::from_utf8(out.stdout)?)
    }
}

impl Table {
    /// A line as `primary  8c  17.4 Mrays/s (best 17.5)  rays 1048576 hits 705562 sum_t 9.4e+06`.
    fn add(&mut self, configuration: &str, line: &str) -> Result<(), Error> {
        let words: Vec<&str> = line.split_whitespace().collect();
        let [kind, width, median, _, _, best, ..] = words[..] else {
            return Err("an unknown line".into());
        };
        let width: u32 = width.trim_end_matches('c').parse()?;
        let key = (configuration.to_string(), kind.to_string(), width);
        let best = best.trim_end_matches(')');
        self.rates.entry(key).or_default().add(median.parse()?, best.parse()?);
        let hits = words.iter().position(|w| *w == "hits").and_then(|i| words.get(i + 1));
        if let (1, "robust", Some(hits)) = (width, configuration, hits) {
            self.hits.insert(kind.to_string(), hits.parse()?);
        }
        Ok(())
    }

    /// The rates of a configuration, if there are any.
    pub(crate) fn rates(&self, configuration: &str, kind: &str, width: u32) -> Option<&Rates> {
        self.rates.get(&(configuration.to_string(), kind.to_string(), width))
    }

    /// How many rays hit, robust.
    pub(crate) fn hits(&self, kind: &str) -> Option<u64> {
        self.hits.get(kind).copied()
    }

    pub(crate) fn print(&self) {
        for ((configuration, kind, width), rates) in &self.rates {
            println!("embree {configuration:8} {kind:8} {width:2}  {rates}");
        }
    }
}
