//! Who may take part: those with a certificate of the mesh.

use std::fs;
use std::path::Path;
use std::thread;
use std::time::Duration;

use rcgen::{BasicConstraints, CertificateParams, IsCa, Issuer, KeyPair, KeyUsagePurpose};
use serde_json::json;
use tempfile::TempDir;
use zenoh::Wait;

use super::mesh::{reference, scene};
use super::strangers::{mesh, render};
use crate::{Error, Identity, Job, Network, Place, TlsConfig, run_node};

/// Signs certificates.
struct Authority {
    issuer: Issuer<'static, KeyPair>,
    certificate: String,
}

impl Authority {
    fn new() -> Self {
        let mut params = CertificateParams::new(Vec::new()).expect("no names");
        params.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        params.key_usages = vec![KeyUsagePurpose::KeyCertSign, KeyUsagePurpose::DigitalSignature];
        let key = KeyPair::generate().expect("a key");
        let certificate = params.self_signed(&key).expect("a certificate").pem();
        Self { issuer: Issuer::new(params, key), certificate }
    }

    /// Certificate and key for this machine, in files; the authority's certificate beside them.
    fn sign(&self, folder: &Path, who: &str) -> TlsConfig {
        let key = KeyPair::generate().expect("a key");
        let params = CertificateParams::new(vec!["127.0.0.1".into()]).expect("an address");
        let certificate = params.signed_by(&key, &self.issuer).expect("a certificate").pem();
        let file = |name: &str, text: &str| {
            let path = folder.join(format!("{who}-{name}.pem"));
            fs::write(&path, text).expect("it is written");
            path
        };
        TlsConfig {
            root: file("root", &self.certificate),
            certificate: file("certificate", &certificate),
            key: file("key", &key.serialize_pem()),
        }
    }
}

#[test]
fn a_mesh_over_quic_renders_the_same_bits() {
    let folder = TempDir::new().expect("a directory");
    let file = scene("glass");
    let mut config = mesh(&folder, &file, "quic", 3);
    config.tls = Some(Authority::new().sign(folder.path(), "all"));
    let job = Job::new(&config, &file.view()).expect("a job");
    let outcome = render(&config, &file, &|_| {}).expect("a picture");
    assert!(outcome.picture.pixels == reference(&file, &job));
    assert_eq!(outcome.nodes.len(), 3);
}

#[test]
fn a_node_stays_until_the_host_has_heard_its_report() {
    const LOOK: Duration = Duration::from_millis(20);
    let folder = TempDir::new().expect("a directory");
    let file = scene("cornell");
    let mut config = mesh(&folder, &file, "quic", 1);
    config.tls = Some(Authority::new().sign(folder.path(), "all"));
    let job = Job::new(&config, &file.view()).expect("a job");
    let place = job.nodes().next().expect("a node");
    thread::scope(|scope| {
        let node = scope.spawn(|| run_node(&config, 0, 7, false));
        let own = job.identity(&file.view(), Place::HOST, Identity::any_incarnation());
        let mut host = Network::open(&config, &job, own).expect("it connects");
        while host.there(place).is_none() && !node.is_finished() {
            host.wait_for_news(LOOK);
        }
        while host.take_reports().is_empty() && !node.is_finished() {
            // It may not have heard yet who the host is.
            host.say_over().expect("it is said");
            host.wait_for_news(LOOK);
        }
        for _ in 0..10 {
            host.wait_for_news(LOOK);
        }
        let stays = host.there(place).is_some();
        host.close();
        node.join().expect("no panic").expect("it ends well");
        assert!(stays, "it has left before the host");
    });
}

#[test]
fn nobody_takes_part_without_a_certificate_of_the_mesh() {
    let folder = TempDir::new().expect("a directory");
    let file = scene("cornell");
    let mut config = mesh(&folder, &file, "quic", 1);
    let authority = Authority::new();
    config.tls = Some(authority.sign(folder.path(), "node"));
    let job = Job::new(&config, &file.view()).expect("a job");
    let own = job.identity(&file.view(), job.nodes().next().expect("a node"), 1);
    let _node = Network::open(&config, &job, own).expect("it listens");

    let address = &config.addresses[0];
    let member = authority.sign(folder.path(), "member");
    let foreign = Authority::new().sign(folder.path(), "foreign");
    // Knows whom to trust, but shows what another authority has signed.
    let impostor = TlsConfig { root: member.root.clone(), ..foreign.clone() };
    assert!(joins(address, Some(&member)));
    assert!(!joins(address, Some(&impostor)), "another certificate");
    assert!(!joins(address, Some(&foreign)), "another authority");
    assert!(!joins(address, None), "no certificate");
    let plain = address.replace("quic/", "tcp/");
    assert!(!joins(&plain, None), "no TLS");
}

/// Whether a process can connect to an address.
fn joins(address: &str, tls: Option<&TlsConfig>) -> bool {
    let tls = tls.map_or_else(
        || json!({ "verify_name_on_connect": false }),
        |tls| {
            json!({
                "root_ca_certificate": tls.root,
                "connect_certificate": tls.certificate,
                "connect_private_key": tls.key,
                "enable_mtls": true,
            })
        },
    );
    let settings = json!({
        "mode": "client",
        "connect": { "endpoints": [address], "exit_on_failure": true, "timeout_ms": 1000 },
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "transport": { "link": { "tls": tls } },
    });
    let config = zenoh::Config::from_json5(&settings.to_string()).expect("settings");
    zenoh::open(config).wait().is_ok_and(|session| session.close().wait().is_ok())
}

#[test]
fn what_others_could_reach_is_refused() {
    let folder = TempDir::new().expect("a directory");
    let file = scene("cornell");
    let mut config = mesh(&folder, &file, "tcp", 1);
    let job = Job::new(&config, &file.view()).expect("a job");
    let open = |config: &crate::Config| {
        let own = job.identity(&file.view(), Place::HOST, Identity::any_incarnation());
        Network::open(config, &job, own).map(Network::close)
    };
    let refused = |config: &crate::Config, words: &[&str]| match open(config) {
        Err(error @ (Error::Options(_) | Error::Io { .. })) => {
            let error = error.to_string();
            assert!(words.iter().all(|word| error.contains(word)), "{error}");
        }
        other => panic!("{other:?}"),
    };
    open(&config).expect("a network of this machine");
    config.addresses = vec!["tcp/192.0.2.1:7447".into()];
    refused(&config, &["tcp/192.0.2.1:7447", "quic/192.0.2.1:7447", "[tls]", "--insecure"]);
    config.insecure = true;
    open(&config).expect("as it was said");
    config.insecure = false;
    config.addresses = vec!["quic/192.0.2.1:7447".into()];
    refused(&config, &["quic/192.0.2.1:7447", "root", "certificate", "key"]);
    let mut tls = Authority::new().sign(folder.path(), "node");
    tls.key = folder.path().join("nowhere.pem");
    config.tls = Some(tls);
    refused(&config, &["nowhere.pem"]);
    config.addresses = vec!["quic/192.0.2.1:7447#enable_mtls=false".into()];
    refused(&config, &["enable_mtls=false", "quic/NAME:PORT"]);
}
