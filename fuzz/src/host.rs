//! What comes to a process from the network, and its configuration.

use kiloray_core::node::Counts;
use kiloray_host::{Config, Frame, Identity, Job, NodeReport, Place};

use crate::mesh::{SCENE, feed_packet, packets};

/// Messages as they come over a link of processes: of one packet each, and of all.
pub(crate) fn wires() -> Vec<Vec<u8>> {
    let message = |packets: &[Vec<u8>]| {
        let mut message = Vec::from(Frame { from: 1, to: 2 }.bytes());
        packets.iter().for_each(|packet| Frame::add(&mut message, packet));
        message
    };
    let packets = packets();
    packets.chunks(1).chain([&packets[..]]).map(message).collect()
}

/// A link brings any bytes: of what is behind the frame the first packet comes to a router.
pub(crate) fn feed_wire(input: &[u8]) -> String {
    let Some((frame, packets)) = Frame::split(input) else { return "short".into() };
    let mut again = Vec::from(frame.bytes());
    let (mut rest, mut first) = (packets, None);
    while let Some((packet, others)) = Frame::next(rest) {
        Frame::add(&mut again, packet);
        first.get_or_insert(packet);
        rest = others;
    }
    again.extend_from_slice(rest);
    assert_eq!(again, input);
    assert_eq!(Frame::is_whole(packets, usize::MAX), rest.is_empty());
    first.map_or_else(|| "none".into(), feed_packet)
}

fn config() -> Config {
    let text = std::str::from_utf8(include_bytes!("../corpus/config/all.toml"));
    Config::parse(text.expect("it is text")).expect("it is a configuration")
}

/// What the host and a node say of themselves.
pub(crate) fn identities() -> Vec<Vec<u8>> {
    let file = SCENE.view();
    let job = Job::new(&config(), &file).expect("a job");
    let key = |place| job.identity(&file, place, 7).to_key().into_bytes();
    job.nodes().take(1).chain([Place::HOST]).map(key).collect()
}

/// Any words are an identity, or none; one that is can be said again, and shown in a line.
pub(crate) fn feed_identity(input: &[u8]) -> String {
    let text = String::from_utf8_lossy(input);
    let Some(identity) = Identity::from_key(&text) else { return "none".into() };
    assert_eq!(Identity::from_key(&identity.to_key()).as_ref(), Some(&identity));
    let file = SCENE.view();
    let own = Job::new(&config(), &file).expect("a job").identity(&file, Place::HOST, 7);
    let differs = identity.differs(&own).unwrap_or_default();
    let is_line = differs.len() < 200 && !differs.contains(char::is_control);
    assert!(is_line, "a line that can be shown: {differs:?}");
    format!("{} {differs}", identity.place)
}

/// Any bytes are a report, or none; what is one can be added up and said again.
pub(crate) fn feed_report(input: &[u8]) -> String {
    let Some(report) = NodeReport::parse(input) else {
        return serde_json::from_slice::<NodeReport>(input)
            .map_or_else(|error| error.to_string(), |_| "too long".into());
    };
    let mut sums = Counts::default();
    sums.add(&report.counts);
    sums.add(&report.counts);
    let text = serde_json::to_vec(&report).expect("it can be said");
    assert_eq!(NodeReport::parse(&text).as_ref(), Some(&report));
    format!("report {}", report.lines.is_empty())
}

/// Any text is a configuration, or an error; what is one can be written, and divided into a job or not.
pub(crate) fn feed_config(input: &[u8]) -> String {
    let config = match Config::parse(&String::from_utf8_lossy(input)) {
        Ok(config) => config,
        // Where it is wrong stands before what is: the rest is the text.
        Err(error) => return error.lines().last().unwrap_or_default().into(),
    };
    let text = config.to_text().expect("it can be written");
    let again = Config::parse(&text).map(|config| config.to_text().expect("it can be written"));
    // Not the configurations: a view may not be a number.
    assert_eq!(again.as_ref(), Ok(&text));
    match Job::new(&config, &SCENE.view()) {
        Ok(job) => format!("job {}", job.layout.plans.len().min(4)),
        Err(error) => error.to_string(),
    }
}
