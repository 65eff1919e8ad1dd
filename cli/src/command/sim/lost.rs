//! Where the time of the nodes went that one node would not have needed.

use kiloray_sim::{NodeTime, Report};

use crate::command::mesh::Loss;

/// The one-node run that efficiency is measured against.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(in crate::command) struct Baseline {
    /// Its virtual time \[ns\].
    pub(in crate::command) virtual_ns: u64,
    /// What it went to.
    pub(in crate::command) time: NodeTime,
}

/// T1 / (nodes × TN).
pub(in crate::command) fn efficiency(report: &Report, baseline: &Baseline) -> f64 {
    baseline.virtual_ns as f64 / all_nodes_ns(report).max(1.0)
}

/// Splits 1 − efficiency by cause; some parts can be below zero, the sum is exact.
///
/// Without a baseline what was traced more than once cannot be known: it is left out.
pub(in crate::command) fn lost(report: &Report, baseline: Option<&Baseline>) -> Vec<Loss> {
    let all = all_nodes_ns(report).max(1.0);
    let mut t = NodeTime::default();
    for node in &report.nodes {
        t += node.time.at_full_speed(node.slow);
    }
    let one = baseline.map(|b| b.time).unwrap_or_default();
    let more = |many: u64, one: u64| (many as f64 - one as f64) / all;
    let handling = more(t.messages + t.copies, one.messages + one.copies);
    let refused = handling * refused_share(report);
    let mut losses = vec![
        ("data", "waiting for blocks", more(t.idle_data, one.idle_data)),
        ("answers", "waiting for answers to rays", more(t.idle_answers, one.idle_answers)),
        ("credit", "waiting for room to send", more(t.idle_credit, one.idle_credit)),
        ("master", "waiting for the host's answers", more(t.idle_master, one.idle_master)),
        ("imbalance", "no work left to ask for", more(t.idle_work, one.idle_work)),
        ("messages", "handling messages", handling - refused),
        ("refused", "rays refused and sent again", refused),
        ("checks", "checking blocks that arrived", more(t.checks, one.checks)),
        ("forwards", "passing on packets of others", more(t.forwards, one.forwards)),
        ("clip", "clipping bundles", more(t.clip, one.clip)),
        ("crashed", "nodes after their crash", more(t.dead, one.dead)),
    ];
    if report.nodes.iter().any(|node| (node.slow - 1.0).abs() > 0.0) {
        losses.push(("slow", "nodes that are slow", more(report.totals.time.busy(), t.busy())));
    }
    if baseline.is_some() {
        let repeated = more(t.trace + t.shade, one.trace + one.shade);
        losses.push(("repeated", "tracing and shading that one node does not do", repeated));
    }
    losses.into_iter().map(|(name, words, part)| Loss { name, words, part }).collect()
}

/// Time of all nodes together \[ns\].
fn all_nodes_ns(report: &Report) -> f64 {
    report.nodes.len() as f64 * report.virtual_ns as f64
}

/// Of all messages handled, those that are refusals, and the rays that were sent in vain.
fn refused_share(report: &Report) -> f64 {
    let handled = |kind: Option<&str>| -> u64 {
        report
            .messages
            .iter()
            .filter(|m| kind.is_none_or(|kind| m.kind == kind))
            .map(|m| m.sent + m.received)
            .sum()
    };
    let in_vain = handled(Some("refusal")) + 2 * report.totals.counts.refused;
    (in_vain as f64 / handled(None).max(1) as f64).min(1.0)
}

/// What a run cannot be faster than.
pub(in crate::command) struct Bound {
    /// Its name for scripts.
    pub(in crate::command) key: &'static str,
    /// The same in words, with the place.
    pub(in crate::command) text: String,
    pub(in crate::command) ns: u64,
}

/// What no run of these nodes and links can be faster than; the first, the work of a run that divides picture and memory in another way, but for a few
/// per cent.
pub(in crate::command) fn bounds(
    report: &Report,
    baseline: Option<&Baseline>,
    cut: Option<&super::cut::Cut>,
) -> Vec<Bound> {
    let mut bounds = Vec::new();
    let mut add = |key, text, ns| bounds.push(Bound { key, text, ns });
    if let Some(baseline) = baseline {
        let share = baseline.virtual_ns / report.nodes.len().max(1) as u64;
        add("work", "the work of one node, shared evenly".to_owned(), share);
    }
    let busy = report.nodes.iter().map(|n| (n.time.busy(), n.node)).max_by_key(|&(ns, _)| ns);
    if let Some((ns, node)) = busy {
        add("node", format!("the busiest node ({node}), without a wait"), ns);
    }
    let link = report.links.iter().max_by_key(|link| link.busy_ns);
    if let Some(link) = link {
        let name = format!("the busiest link ({})", super::cut::link_name(link));
        add("link", name, link.busy_ns);
    }
    if let Some(cut) = cut {
        add("cut", format!("the worst cut ({}), at full bandwidth", cut.name), cut.bound_ns);
    }
    bounds
}
