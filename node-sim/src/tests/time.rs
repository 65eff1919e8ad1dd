//! Where the time of nodes goes: slow ones, shading that is interrupted, steps of a trace.

use super::*;

#[test]
fn a_very_slow_node_on_lossy_links_is_waited_for() {
    let file = scene("glass", 1024);
    let mut options = options(&file, "torus:3x2", 6);
    (options.mesh.memory, options.profile) = (64 << 10, Profile::T800);
    options.faults.loss = Rate { count: 1, of: 100 };
    options.faults.slow = vec![Slow { node: NodeId(5), factor: 1e5 }];
    let report = same(&file, &options).report;
    assert!(report.virtual_ns > 1_000_000_000_000, "{}", report.virtual_ns);
}

#[test]
fn a_node_that_would_take_for_ever_is_named() {
    let file = scene("glass", 1024);
    let mut options = options(&file, "torus:3x2", 6);
    let slow = |node, factor| Slow { node: NodeId(node), factor };
    for (factor, lost) in [(1e14, 1), (1e300, 0)] {
        options.faults.slow = vec![slow(4, 0.5), slow(2, 2.0), slow(5, factor), slow(3, 1.5)];
        options.faults.loss = Rate { count: lost, of: 100 };
        let outcome = run(&file, &options).expect("it runs");
        assert_eq!(outcome.end, crate::End::Slow(NodeId(5)), "{factor} {lost}");
        let report = outcome.report;
        let whole = |node: &NodeReport| node.time.busy() + node.time.idle() == report.virtual_ns;
        assert!(report.nodes.iter().all(whole));
    }
}

#[test]
fn shading_that_goes_on_takes_time_and_is_counted_apart() {
    for (name, schedule) in [("cornell", Schedule::Hybrid), ("glass", Schedule::Data)] {
        let file = scene(name, 1024);
        let [little, much] = [24 << 10, 16 << 20].map(|memory| {
            let mut options = options(&file, "line", 1);
            (options.mesh.memory, options.mesh.schedule) = (memory, schedule);
            options.mesh.settings.shadow_samples = 16;
            same(&file, &options).report.nodes.remove(0)
        });
        // Each hit is one, however often it was interrupted.
        assert_eq!(little.work.shadings, much.work.shadings, "{name}");
        let again = [&little, &much].map(|node| node.work.shadings_again);
        assert!(again[0] > 4 * again[1].max(1), "{name}: {again:?} of {}", much.work.shadings);
        assert!(little.work.light_samples >= much.work.light_samples, "{name}");
        for node in [&little, &much] {
            let (work, profile) = (&node.work, Profile::PC);
            let hits = work.shadings + work.shadings_again;
            let estimates = work.shadings * estimates(&file.view(), true) as u64;
            let ns: f64 = [
                (hits, profile.shading),
                (estimates, profile.light),
                (work.lights, profile.light_bundle),
                (work.light_samples, profile.light_sample),
            ]
            .map(|(count, each)| count as f64 * each)
            .iter()
            .sum();
            assert!((node.time.shade as f64 - ns).abs() <= 0.5 * node.steps as f64, "{name}");
        }
    }
}

#[test]
fn steps_of_a_trace_end_with_their_node_and_take_its_time() {
    let file = scene("glass", 1024);
    let mut options = options(&file, "ring", 5);
    (options.mesh.replicas, options.profile, options.trace) = (2, Profile::T800, usize::MAX);
    // It dies in the midst of a step: they take milliseconds.
    options.faults.crashes = vec![Crash { node: NodeId(2), at: 1_000_000 }];
    let report = same(&file, &options).report;
    for node in &report.nodes {
        let steps = report.trace.iter().filter(|step| step.node == node.node);
        let end = node.crashed_ns.unwrap_or(report.virtual_ns);
        assert!(steps.clone().all(|step| step.start_ns + step.duration_ns <= end));
        let busy: u64 = steps.map(|step| step.duration_ns).sum();
        assert_eq!(busy, node.time.busy(), "{}", node.node);
    }
}
