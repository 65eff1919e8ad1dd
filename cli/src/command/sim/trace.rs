//! What the nodes did when, as trace events that Perfetto and Chrome open.

use std::io::{self, Write};

use kiloray_sim::{Options, Report};

/// Writes the events: a track for each node, a slice for each piece of work, and counters of the mesh.
///
/// The format is Google's "Trace Event Format"; times are in µs.
pub(super) fn write(report: &Report, options: &Options, out: &mut dyn Write) -> io::Result<()> {
    writeln!(
        out,
        "{{\"displayTimeUnit\":\"ns\",\"otherData\":{{\"cut\":\"{}\"}},",
        cut(report, options)
    )?;
    writeln!(out, "\"traceEvents\":[")?;
    write!(
        out,
        "{{\"ph\":\"M\",\"name\":\"process_name\",\"pid\":1,\"args\":{{\"name\":\"nodes\"}}}}"
    )?;
    for node in &report.nodes {
        let n = node.node;
        write!(
            out,
            ",\n{{\"ph\":\"M\",\"name\":\"thread_name\",\"pid\":1,\"tid\":{n},\"args\":{{\"name\":\"node {n}\"}}}}"
        )?;
        write!(
            out,
            ",\n{{\"ph\":\"M\",\"name\":\"thread_sort_index\",\"pid\":1,\"tid\":{n},\"args\":{{\"sort_index\":{n}}}}}"
        )?;
        if let Some(at) = node.crashed_ns {
            write!(
                out,
                ",\n{{\"ph\":\"i\",\"s\":\"t\",\"name\":\"crash\",\"pid\":1,\"tid\":{n},\"ts\":{}}}",
                micros(at)
            )?;
        }
    }
    flows(report, out)?;
    for event in &report.trace {
        write!(
            out,
            ",\n{{\"ph\":\"X\",\"name\":\"{}\",\"pid\":1,\"tid\":{},\"ts\":{},\"dur\":{}}}",
            event.name,
            event.node,
            micros(event.start_ns),
            micros(event.duration_ns)
        )?;
    }
    let step = report.timeline.step_ns;
    for (i, sample) in report.timeline.samples.iter().enumerate() {
        let at = micros(step * i as u64);
        write!(
            out,
            ",\n{{\"ph\":\"C\",\"name\":\"nodes\",\"pid\":1,\"ts\":{at},\"args\":{{\"at work\":{:.2},\"waiting\":{:.2},\"idle\":{:.2}}}}}",
            sample.busy, sample.waiting, sample.idle
        )?;
        for (name, value) in [
            ("rays held", sample.stored),
            ("bytes on links", sample.link_bytes),
            ("pixels done", sample.pixels),
        ] {
            write!(
                out,
                ",\n{{\"ph\":\"C\",\"name\":\"{name}\",\"pid\":1,\"ts\":{at},\"args\":{{\"value\":{value}}}}}"
            )?;
        }
    }
    writeln!(out, "\n]}}")
}

/// Arrows from who asks for a block to its owner, and back to the step that has it. They stand before the slices, so that one that ends when a step
/// begins belongs to that step.
fn flows(report: &Report, out: &mut dyn Write) -> io::Result<()> {
    let end = report.trace.last().map_or(0, |last| last.start_ns + last.duration_ns);
    for (id, flow) in report.flows.iter().enumerate().filter(|(_, flow)| flow.arrived_ns < end) {
        for (phase, node, at) in [
            ("s", flow.asker, flow.asked_ns),
            ("t", flow.owner, flow.served_ns),
            ("f", flow.asker, flow.arrived_ns),
        ] {
            write!(
                out,
                ",\n{{\"ph\":\"{phase}\",\"name\":\"fetch\",\"cat\":\"fetch\",\"id\":{id},\"pid\":1,\"tid\":{node},\"ts\":{},\"args\":{{\"block\":{}}}}}",
                micros(at),
                flow.block
            )?;
        }
    }
    Ok(())
}

/// What is missing, in words; empty if nothing is.
pub(super) fn cut(report: &Report, options: &Options) -> String {
    let Some(last) = report.trace.last().filter(|_| report.trace.len() >= options.trace) else {
        return String::new();
    };
    format!(
        "the trace holds the first {} events and ends at {} of {} of virtual time",
        report.trace.len(),
        crate::console::duration(last.start_ns + last.duration_ns),
        crate::console::duration(report.virtual_ns)
    )
}

/// Nanoseconds as microseconds, exactly.
fn micros(ns: u64) -> String {
    format!("{}.{:03}", ns / 1000, ns % 1000)
}
