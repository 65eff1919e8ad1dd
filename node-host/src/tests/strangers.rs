//! What somebody says who can connect, and is no process of the mesh.

use std::io;
use std::net::{SocketAddr, TcpListener, UdpSocket};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::thread;

use kiloray_core::network::NodeId;
use kiloray_scene::kilo::KiloFile;
use serde_json::json;
use tempfile::TempDir;
use zenoh::{Session, Wait};

use super::mesh::{config, reference, scene};
use crate::{
    Config, Control, Error, Frame, Identity, Job, Outcome, Place, Status, run_host, run_node,
};

/// A mesh of this machine, over TCP, whose scene lies in a directory.
pub(super) fn mesh(folder: &TempDir, file: &KiloFile, protocol: &str, nodes: usize) -> Config {
    let mut config = config(file, nodes, "full", 1 << 16);
    config.scene = folder.path().join("scene.kilo");
    file.write(&config.scene).expect("it is written");
    let free = if protocol == "quic" {
        free(nodes, || UdpSocket::bind("127.0.0.1:0"), UdpSocket::local_addr)
    } else {
        free(nodes, || TcpListener::bind("127.0.0.1:0"), TcpListener::local_addr)
    };
    config.addresses = free.iter().map(|address| format!("{protocol}/{address}")).collect();
    config
}

/// Addresses that nobody listens at.
fn free<T>(
    count: usize,
    bind: impl Fn() -> io::Result<T>,
    address: impl Fn(&T) -> io::Result<SocketAddr>,
) -> Vec<SocketAddr> {
    // Held together, so that no two are the same.
    let held: Vec<T> = (0..count).map(|_| bind().expect("a port")).collect();
    held.iter().map(|one| address(one).expect("an address")).collect()
}

/// Nodes as threads, and the host.
pub(super) fn render(
    config: &Config,
    file: &KiloFile,
    progress: &dyn Fn(&Status),
) -> Result<Outcome, Error> {
    let cancel = AtomicBool::new(false);
    thread::scope(|scope| {
        for node in 0..config.addresses.len() as u16 {
            scope
                .spawn(move || run_node(config, node, Identity::any_incarnation(), false).unwrap());
        }
        let control = Control { cancel: &cancel, progress };
        run_host(config, &file.view(), None, &control)
    })
}

/// Somebody who is connected to such addresses.
fn stranger(listen: &[String], connect: &[String]) -> Session {
    let settings = json!({
        "mode": "peer",
        "listen": { "endpoints": listen },
        "connect": {
            "endpoints": connect,
            "exit_on_failure": false,
            "timeout_ms": -1,
            "retry": { "period_init_ms": 10, "period_max_ms": 20, "period_increase_factor": 1 },
        },
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
    });
    let settings = zenoh::Config::from_json5(&settings.to_string()).expect("settings");
    zenoh::open(settings).wait().expect("a session")
}

#[test]
fn what_a_stranger_says_costs_no_pixel() {
    let folder = TempDir::new().expect("a directory");
    let file = scene("glass");
    let mut config = mesh(&folder, &file, "tcp", 3);
    // Some time to speak in.
    (config.picture.width, config.picture.samples) = (64, 16);
    let job = Job::new(&config, &file.view()).expect("a job");
    let (begin, begun) = mpsc::sync_channel(1);
    let end = AtomicBool::new(false);
    let outcome = thread::scope(|scope| {
        let (job, file, config, end) = (&job, &file, &config, &end);
        let session = stranger(&[], &config.addresses);
        scope.spawn(move || {
            if begun.recv().is_err() {
                return;
            }
            // All are there: these are false.
            let prefix = format!("kiloray/{}", config.name);
            let _tokens: Vec<_> = job
                .nodes()
                .chain([Place::HOST])
                .map(|place| job.identity(&file.view(), place, 1))
                .map(|identity| format!("{prefix}/there/{}", identity.to_key()))
                .chain([format!("{prefix}/there/x"), format!("{prefix}/there/9/0/0/0/0/0")])
                .map(|key| session.liveliness().declare_token(key).wait().expect("a token"))
                .collect();
            let mut random = fastrand::Rng::with_seed(1);
            while !end.load(Ordering::Relaxed) {
                garbage(&session, &prefix, job, &mut random);
                thread::yield_now();
            }
            session.close().wait().expect("it leaves");
        });
        let outcome = render(config, file, &|status| {
            // They know each other by then: who comes first is believed.
            if status.nodes == 3 && status.pixels > 0 {
                let _ = begin.try_send(());
            }
        });
        drop(begin);
        end.store(true, Ordering::Relaxed);
        outcome
    });
    let outcome = outcome.expect("a picture");
    assert!(outcome.complete);
    assert!(outcome.picture.pixels == reference(&file, &job));
    assert_eq!(outcome.nodes.len(), 3);
    let foreign: Vec<_> = outcome.nodes.iter().map(|node| node.foreign).collect();
    assert!(foreign.iter().all(|&foreign| foreign > 0), "{foreign:?}");
}

#[test]
fn a_node_of_another_version_is_named() {
    let folder = TempDir::new().expect("a directory");
    let file = scene("cornell");
    let config = mesh(&folder, &file, "tcp", 2);
    let job = Job::new(&config, &file.view()).expect("a job");
    let session = stranger(&config.addresses[1..], &[]);
    let own = job.identity(&file.view(), Place::new(NodeId(1)), 1);
    let older = Identity { version: "0.0.9".into(), ..own };
    let key = format!("kiloray/{}/there/{}", config.name, older.to_key());
    let _token = session.liveliness().declare_token(key).wait().expect("a token");
    let cancel = AtomicBool::new(false);
    let control = Control { cancel: &cancel, progress: &|_| {} };
    let error = run_host(&config, &file.view(), None, &control).expect_err("it is refused");
    let expected = format!("node 1 is of version 0.0.9, not {}", Identity::version());
    assert_eq!(error.to_string(), expected);
}

/// On every topic there is.
fn garbage(session: &Session, prefix: &str, job: &Job, random: &mut fastrand::Rng) {
    let places: Vec<_> = job.nodes().chain([Place::HOST]).collect();
    let topics = places.iter().flat_map(|from| {
        let to = places.iter().filter(move |to| *to != from);
        to.map(move |to| format!("link/{from}/{to}"))
    });
    let reports = job.nodes().map(|node| format!("report/{node}"));
    for topic in topics.chain(reports).chain(["over".into()]) {
        let mut bytes: Vec<u8> = (0..random.usize(..300)).map(|_| random.u8(..)).collect();
        if random.bool() && bytes.len() >= Frame::BYTES {
            bytes[..Frame::BYTES].copy_from_slice(&Frame { from: 1, to: random.u32(..3) }.bytes());
        }
        session.put(format!("{prefix}/{topic}"), bytes).wait().expect("it is said");
    }
}
