use std::path::Path;

use kiloray_core::network::NodeId;
use kiloray_sim::{Options, Report};

use super::{Run, cut::link_name, lost::lost};
use crate::{
    command::mesh::{again, so_far},
    console::{bytes, count, counted, duration, line, percent},
    failure::Outcome,
    picture::Saved,
};

/// Least part of the time that is worth a word.
const WORTH: f64 = 0.005;

/// What a person wants to know first.
pub(super) fn print(run: &Run<'_>, path: &Path, saved: &Saved) -> Outcome {
    let done = run.done;
    let (outcome, report) = (&done.outcome, &done.outcome.report);
    line(format_args!(
        "{}: {} x {}, {} samples per pixel{}{}",
        path.display(),
        outcome.picture.width,
        outcome.picture.height,
        run.options.mesh.settings.samples,
        saved.said(),
        so_far(&outcome.picture, outcome.is_complete(), &report.tiles),
    ))?;
    line(format_args!("mesh       {}", mesh(run)))?;
    line(format_args!("time       {}", time(run)))?;
    let mut losses = lost(report, done.compared());
    losses.retain(|loss| loss.part >= WORTH);
    losses.sort_by(|a, b| b.part.total_cmp(&a.part));
    let losses: Vec<_> =
        losses.iter().map(|loss| format!("{} {}", loss.words, percent(loss.part))).collect();
    if !losses.is_empty() {
        line(format_args!("lost       {}", losses.join(", ")))?;
    }
    let counts = &report.totals.counts;
    line(format_args!(
        "messages   {}, {}; {} blocks fetched, {} rays migrated",
        count(report.messages.iter().map(|m| m.sent).sum()),
        bytes(report.messages.iter().map(|m| m.sent_bytes).sum()),
        count(counts.cache.fetched),
        count(counts.migrated),
    ))?;
    if let Some(link) = run.busiest_link() {
        let busy = link.busy_ns as f64 / report.virtual_ns.max(1) as f64;
        line(format_args!(
            "links      the busiest, {}, {} of the time",
            link_name(link),
            percent(busy)
        ))?;
    }
    line(format_args!(
        "memory     {} of {} at the fullest node, {}",
        bytes(report.totals.peak_bytes as u64),
        bytes(run.options.mesh.memory as u64),
        report.totals.peak_node,
    ))?;
    if let Some(faults) = faults(run) {
        line(format_args!("faults     {faults}"))?;
    }
    let of_faults = run.sim.mesh.fault_seed.map(|seed| format!(", of faults {seed}"));
    line(format_args!(
        "simulated  in {:.2} s, seed {}{}",
        done.all_s,
        run.options.mesh.settings.seed,
        of_faults.unwrap_or_default()
    ))?;
    match &run.sim.common.report {
        Some(folder) => line(format_args!("report     {}", folder.join("index.html").display())),
        None => Ok(()),
    }
}

/// The machine in a line.
pub(super) fn mesh(run: &Run<'_>) -> String {
    let nodes = run.options.mesh.topology.nodes();
    format!(
        "{nodes} {} of {}, {}, profile {}, schedule {}",
        if nodes == 1 { "node" } else { "nodes" },
        bytes(run.options.mesh.memory as u64),
        run.topology,
        run.options.profile.name,
        format!("{:?}", run.options.mesh.schedule).to_lowercase(),
    )
}

fn time(run: &Run<'_>) -> String {
    let virtual_time = format!("{} of virtual time", duration(run.done.outcome.report.virtual_ns));
    match (run.done.compared(), run.done.efficiency()) {
        (Some(one), Some(efficiency)) => format!(
            "{virtual_time}; one node takes {}: {:.1} times as fast, efficiency {efficiency:.3}",
            duration(one.virtual_ns),
            efficiency * run.done.outcome.report.nodes.len() as f64,
        ),
        _ => virtual_time,
    }
}

/// Nodes that were to crash, and have not: the run was over before.
pub(in crate::command) fn spared(report: &Report, options: &Options) -> Option<String> {
    let has_crashed = |node: NodeId| report.faults.crashes.iter().any(|crash| crash.node == node.0);
    let mut spared: Vec<_> = options.faults.crashes.iter().map(|crash| crash.node).collect();
    let mut named = Vec::new();
    spared.retain(|&node| {
        let is_new = !named.contains(&node);
        named.push(node);
        is_new && !has_crashed(node)
    });
    let (last, others) = spared.split_last()?;
    let others: Vec<_> = others.iter().map(|node| node.0.to_string()).collect();
    let nodes = match others.as_slice() {
        [] => format!("node {}", last.0),
        others => format!("nodes {} and {}", others.join(", "), last.0),
    };
    let end = duration(report.virtual_ns);
    Some(format!("{nodes} did not crash: the run was over at {end}"))
}

/// What went wrong by request, and what it led to.
pub(super) fn faults(run: &Run<'_>) -> Option<String> {
    let (f, slow) = (&run.done.outcome.report.faults, &run.options.faults.slow);
    let words: Vec<_> = [
        (f.lost, ["packet lost", "packets lost"]),
        (f.doubled, ["doubled"; 2]),
        (f.delayed, ["delayed"; 2]),
        (f.for_the_dead, ["dropped for the dead"; 2]),
        (f.crashes.len() as u64, ["node crashed", "nodes crashed"]),
        (slow.len() as u64, ["slow node", "slow nodes"]),
    ]
    .into_iter()
    .filter(|&(n, _)| n > 0)
    .map(|(n, words)| counted(n, words))
    .collect();
    if words.is_empty() {
        return None;
    }
    let again = again(&run.done.outcome.report.totals.counts);
    let again = counted(again, ["request made again", "requests made again"]);
    Some(format!("{}, {again}", words.join(", ")))
}
