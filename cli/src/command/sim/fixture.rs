//! A report made by hand: figures that are easy to check, on any mesh.

use kiloray_core::{network::Topology, node::Counts};
use kiloray_sim::{
    CrashReport, FaultReport, Histogram, HistogramBucket, Latencies, LineReport, LinkReport,
    MeshReport, MessageReport, NodeReport, NodeTime, Report, Sample, TileReport, Timeline, Totals,
    TraceEvent, TraceFlow,
};

/// 1 ms, of which node `i` of `n` works `i / n`, and waits for blocks else.
pub(super) fn report(topology: &Topology) -> Report {
    const ALL: u64 = 1_000_000;
    let n = topology.nodes();
    let (shape, sizes, wraps, arity) = match topology {
        Topology::Grid(grid) => ("grid", grid.sizes().collect(), grid.wraps(), 0),
        Topology::Tree { arity, .. } => ("tree", vec![n], false, *arity),
        Topology::Full { .. } => ("full", vec![n], false, 0),
    };
    let mut totals = Totals { peak_node: n - 1, peak_bytes: 50_000, ..Totals::default() };
    let nodes: Vec<_> = (0..n)
        .map(|node| {
            let busy = ALL * u64::from(node) / u64::from(n);
            let messages = busy / 10;
            let time = NodeTime {
                trace: busy - messages,
                messages,
                idle_data: ALL - busy,
                ..NodeTime::default()
            };
            totals.time += time;
            let mut counts = Counts::default();
            counts.cache.hits = 900;
            counts.cache.misses = 100;
            counts.cache.fetched = u64::from(node);
            counts.tiles = 3;
            NodeReport {
                node,
                slow: 1.0,
                crashed_ns: (node == 2).then_some(500_000),
                time,
                steps: 10,
                counts,
                work: Default::default(),
                memory: 65_536,
                peak_bytes: 40_000 + usize::from(node),
                lines: vec![
                    LineReport {
                        name: "intersection points",
                        capacity: 66,
                        bytes: 4544,
                        peak: 9,
                        peak_bytes: 620,
                    },
                    LineReport {
                        name: "block frames",
                        capacity: 10,
                        bytes: 40_960,
                        peak: 10,
                        peak_bytes: 40_960,
                    },
                ],
                owned_blocks: 4,
            }
        })
        .collect();
    totals.counts.cache.hits = 900 * u64::from(n);
    totals.counts.cache.misses = 100 * u64::from(n);
    totals.counts.refused = 5;
    let mut links = Vec::new();
    for from in 0..n {
        for port in 0..topology.ports() {
            let (a, p) = (kiloray_core::network::NodeId(from), kiloray_core::network::Port(port));
            let Some(to) = topology.neighbour(a, p) else { continue };
            links.push(LinkReport {
                from: Some(from),
                to: Some(to.0),
                port,
                packets: 10,
                control_packets: 1,
                bytes: 1000 * u64::from(from.min(to.0) + 1),
                busy_ns: 1000 * u64::from(from + 1),
                buffers_peak: 2,
                buffers: 8,
            });
        }
    }
    let kinds = ["fetch", "part", "tile", "ray", "answer", "refusal"];
    let histogram = Histogram {
        count: 300,
        min: 1_000,
        mean: 3_000.0,
        p50: 2_000,
        p90: 4_000,
        p99: 7_000,
        p999: 8_000,
        max: 8_192,
        buckets: [2048, 4096, 8192].map(|up_to| HistogramBucket { up_to, count: 100 }).to_vec(),
    };
    Report {
        mesh: MeshReport { shape, sizes, wraps, arity, nodes: n, attached: vec![0, n - 1] },
        profile: "pc".to_owned(),
        virtual_ns: ALL,
        nodes,
        links,
        messages: kinds
            .map(|kind| MessageReport {
                kind,
                sent: 10,
                sent_bytes: 1000,
                received: 10,
                received_bytes: 1000,
            })
            .to_vec(),
        timeline: Timeline {
            step_ns: ALL / 100,
            samples: (0..100)
                .map(|i| Sample {
                    busy: f64::from(n) * 0.7,
                    useful: f64::from(n) * 0.6,
                    waiting: f64::from(n) * 0.2,
                    idle: f64::from(n) * 0.1,
                    dead: 0.0,
                    stored: i * 3,
                    link_bytes: i * 1000,
                    pixels: i * 40,
                })
                .collect(),
        },
        latencies: Latencies { fetch: histogram.clone(), ray: histogram, ..Latencies::default() },
        faults: FaultReport {
            lost: 3,
            crashes: vec![CrashReport { node: 2, at_ns: 500_000 }],
            ..FaultReport::default()
        },
        tiles: TileReport { given: 16, given_again: 2, ..TileReport::default() },
        totals,
        flows: vec![TraceFlow {
            block: 7,
            asker: 1,
            owner: 3,
            asked_ns: 1_500,
            served_ns: 2_600,
            arrived_ns: 3_700,
        }],
        trace: vec![TraceEvent { name: "trace", node: 1, start_ns: 1_234, duration_ns: 5_678 }],
        events: 1000,
        fingerprint: "00ff".into(),
    }
}
