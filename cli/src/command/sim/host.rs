//! A word on runs whose nodes wait for the host more than for anything else.

use kiloray_sim::{Faults, MeshOptions, Report};

use super::lost::lost;
use crate::console::percent;

/// There is a note where more than this part of the time is lost so.
const WORTH: f64 = 1.0 / 3.0;
/// A group that is advised, and the nodes from which it gains.
const GROUP: u16 = 16;
const MANY_NODES: u16 = 512;

/// What would make nodes wait less for the host's answers, where they waited much for them; of a run with faults these are the reason.
pub(super) fn waits(report: &Report, division: &MeshOptions, faults: &Faults) -> Option<String> {
    if faults.of_links() || !faults.slow.is_empty() || !faults.crashes.is_empty() {
        return None;
    }
    let losses = lost(report, None);
    let part = losses.iter().find(|loss| loss.name == "master")?.part;
    if part <= WORTH {
        return None;
    }
    let mut ways = Vec::new();
    ways.extend(larger_tile(division).map(|side| format!("--tile {side}")));
    if division.group == 0 && division.topology.nodes() >= MANY_NODES {
        ways.push(format!("--group {GROUP}"));
    }
    if ways.is_empty() {
        ways.push("fewer --nodes".to_owned());
    }
    Some(format!(
        "nodes waited for the host's answers {} of the time, as there is little to do in a tile: give {}",
        percent(part),
        ways.join(" or "),
    ))
}

/// Twice the side, where there is such a tile for each node, and memory for it.
fn larger_tile(division: &MeshOptions) -> Option<u32> {
    let side = 2 * u32::from(division.tile?);
    division.has_tiles(side, 1).then_some(side)
}

#[cfg(test)]
mod tests {
    use kiloray_core::network::Topology;

    use super::*;
    use crate::command::sim::{fixture, tests::with_run};

    /// What is said of a run by a command line whose nodes waited for the host this part of a millisecond.
    fn said(line: &str, part: f64) -> Option<String> {
        with_run(line, kiloray_sim::End::Complete, |run| {
            let division = MeshOptions { tile: Some(4), width: 64, height: 64, ..run.options.mesh };
            let mut report = fixture::report(&Topology::parse("line", 2).unwrap());
            for node in &mut report.nodes {
                node.time.idle_master = (part * report.virtual_ns as f64) as u64;
            }
            waits(&report, &division, &run.options.faults)
        })
    }

    #[test]
    fn larger_tiles_and_groups_are_advised_where_there_can_be_some() {
        for (line, advice) in [
            ("--nodes 64 --memory 64KiB", "give --tile 8"),
            ("--nodes 65 --memory 64KiB", "give fewer --nodes"),
            ("--nodes 64 --memory 11KiB", "give fewer --nodes"),
            ("--nodes 1024 --memory 64KiB", "give --group 16"),
            ("--nodes 1024 --memory 64KiB --group 8", "give fewer --nodes"),
        ] {
            assert_eq!(said(line, 0.33), None, "{line}");
            for fault in ["--jitter 1us", "--slow 1:9", "--crash 1@1us"] {
                assert_eq!(said(&format!("{line} {fault}"), 0.34), None, "{line} {fault}");
            }
            let said = said(line, 0.34).unwrap_or_else(|| panic!("{line}: nothing"));
            assert!(
                said.contains("34.0 % of the time") && said.ends_with(advice),
                "{line}: {said}"
            );
        }
    }
}
