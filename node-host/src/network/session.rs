use std::net::{TcpListener, UdpSocket};

use serde_json::{Value, json};
use zenoh::{Session, Wait};

use crate::{Config, Error, Job, NodeReport, Place, TlsConfig, security};

/// After so long without a sign of life a process counts as gone, and so much more for each node of the mesh, as they may wait for the same processors;
/// one that ends is missed at once \[ms\].
const LEASE_MS: [u32; 2] = [2000, 20];

/// How long a message waits for room in the engine's queue before it is lost: credit bounds what is under way to less than the queue holds,
/// unless the far end is frozen \[µs\].
const DROP_US: u32 = 20_000;

/// Opens the session of a place: it listens where the configuration says, and knows nobody but those it names.
pub(super) fn open(config: &Config, job: &Job, place: Place) -> Result<Session, Error> {
    security::check(config)?;
    let (listen, connect) = endpoints(config, job, place)?;
    let [lease, each] = LEASE_MS;
    let settings = json!({
        "mode": "peer",
        "listen": { "endpoints": listen, "exit_on_failure": true, "timeout_ms": 0 },
        "connect": {
            "endpoints": connect,
            "exit_on_failure": false,
            // For ever, beside all else.
            "timeout_ms": -1,
            "retry": { "period_init_ms": 20, "period_max_ms": 500, "period_increase_factor": 1.5 },
        },
        // Nobody is found that was not named.
        "scouting": { "multicast": { "enabled": false }, "gossip": { "enabled": false } },
        "open": { "return_conditions": { "connect_scouted": false, "declares": false } },
        "transport": {
            "unicast": { "accept_pending": 1000, "max_sessions": 1000 },
            "link": {
                "tx": {
                    "lease": lease + each * u32::from(job.mesh.nodes()),
                    "keep_alive": 4,
                    // By default the third message is dropped after 1 ms, which on busy processors is soon over.
                    "queue": {
                        "size": { "data_high": 16 },
                        "congestion_control": { "drop": { "wait_before_drop": DROP_US } },
                    },
                },
                // Nothing that is longer than a report is put together.
                "rx": { "max_message_size": 2 * NodeReport::BYTES_MAX },
                "tls": config.tls.as_ref().map_or_else(|| json!({}), tls),
            },
            "shared_memory": { "enabled": false },
        },
    });
    let config = zenoh::Config::from_json5(&settings.to_string())
        .map_err(|error| Error::Network(error.to_string()))?;
    zenoh::open(config).wait().map_err(|error| {
        Error::Network(match listen.first() {
            Some(address) => {
                // In its own words, if it is the system that refuses.
                let system =
                    address.split_once('/').and_then(|(protocol, address)| match protocol {
                        "tcp" => TcpListener::bind(address).err(),
                        "quic" => UdpSocket::bind(address).err(),
                        _ => None,
                    });
                let cause = system.map_or_else(|| plain(&error.to_string()), |e| e.to_string());
                format!("cannot listen at {address}: {cause}")
            }
            None => plain(&error.to_string()),
        })
    })
}

/// What the engine says of an error, without the places in its source.
fn plain(error: &str) -> String {
    let mut parts = error.split(" at /");
    let first = parts.next().unwrap_or_default().to_owned();
    parts.fold(first, |text, part| match part.split_once(".rs:") {
        Some((_, rest)) => {
            let rest = rest.trim_start_matches(|c: char| c.is_ascii_digit());
            text + rest.strip_prefix('.').unwrap_or(rest)
        }
        None => text + " at /" + part,
    })
}

/// Where a place listens, and to whom it connects: a node to those of its neighbours that have lesser numbers, the host to all.
fn endpoints(
    config: &Config,
    job: &Job,
    place: Place,
) -> Result<(Vec<String>, Vec<String>), Error> {
    let address = |place: Place| config.addresses.get(usize::from(place.id().0)).cloned();
    if place == Place::HOST {
        return Ok((Vec::new(), config.addresses.clone()));
    }
    let own = address(place).ok_or_else(|| {
        let last = config.addresses.len().saturating_sub(1);
        Error::Options(format!("there is no node {place}: the mesh has nodes 0 to {last}"))
    })?;
    let neighbours = job.neighbours(place).into_iter().map(|(_, far)| far);
    let connect = neighbours.filter(|far| *far < place).filter_map(address).collect();
    Ok((vec![config.listen.clone().unwrap_or(own)], connect))
}

/// Both ends of a connection show a certificate of the mesh, for the name that was called.
fn tls(tls: &TlsConfig) -> Value {
    let TlsConfig { root, certificate, key } = tls;
    json!({
        "root_ca_certificate": root,
        "listen_certificate": certificate,
        "listen_private_key": key,
        "connect_certificate": certificate,
        "connect_private_key": key,
        "enable_mtls": true,
        "verify_name_on_connect": true,
        "close_link_on_expiration": true,
    })
}

#[cfg(test)]
mod tests {
    use super::plain;

    #[test]
    fn an_error_is_told_without_the_places_of_its_source() {
        let text = "no listener at tcp/x:1: [in use (98) at /a/link-1.2/src/tcp.rs:61.] at /b/unicast.rs:338.";
        assert_eq!(plain(text), "no listener at tcp/x:1: [in use (98)]");
        assert_eq!(plain("no file at /etc/key.pem"), "no file at /etc/key.pem");
    }
}
