use std::net::IpAddr;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::{Config, Error};

/// Who may take part in a mesh: processes with a certificate of its authority, and nobody else. Each shows its own, whoever connects to whom.
///
/// The files are in PEM; paths are relative to the directory of the configuration. So the same configuration serves all machines, each with files of its own.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TlsConfig {
    /// Certificate of the authority that has signed those of the mesh, and no others.
    pub root: PathBuf,
    /// Certificate of this machine: for the name or address by which the others find it.
    pub certificate: PathBuf,
    /// Its private key.
    pub key: PathBuf,
}

impl TlsConfig {
    /// All its files.
    fn files(&mut self) -> [&mut PathBuf; 3] {
        [&mut self.root, &mut self.certificate, &mut self.key]
    }

    /// Takes paths as relative to a directory.
    pub(crate) fn move_to(&mut self, folder: &Path) {
        for file in self.files() {
            *file = folder.join(&*file);
        }
    }

    /// Checks that all are there and can be read.
    fn check(mut self) -> Result<(), Error> {
        for path in self.files() {
            kiloray_scene::regular::open(path)
                .map_err(|source| Error::Io { path: path.clone(), source })?;
        }
        Ok(())
    }
}

/// Checks that nobody beyond this machine can take part, or listen, but those with a certificate of the mesh, unless it was said that they may.
pub(crate) fn check(config: &Config) -> Result<(), Error> {
    for address in config.addresses.iter().chain(&config.listen) {
        match Reach::of(address).map_err(Error::Options)? {
            Reach::Machine => {}
            Reach::Authenticated if config.tls.is_some() => {}
            Reach::Authenticated => {
                return Err(Error::Options(format!(
                    "{address}: TLS needs certificates: name the files 'root', 'certificate' and 'key' in [tls]"
                )));
            }
            Reach::Anybody if config.insecure => {}
            Reach::Anybody => {
                let rest = address.split_once('/').map_or("", |(_, rest)| rest);
                return Err(Error::Options(format!(
                    "{address} can be reached from other machines, by anybody: write quic/{rest} and name certificates in [tls], \
                     or give --insecure where all who can reach it may see and change the picture"
                )));
            }
        }
    }
    config.tls.clone().map_or(Ok(()), TlsConfig::check)
}

/// Who can reach an address.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// Processes of this machine.
    Machine,
    /// Those with a certificate.
    Authenticated,
    /// All on the network.
    Anybody,
}

impl Reach {
    /// Of an address of the engine. What it could say beyond, it must not: there, the authentication can be switched off.
    fn of(address: &str) -> Result<Self, String> {
        let form = || {
            format!(
                "address '{address}': write quic/NAME:PORT, tcp/127.0.0.1:PORT or unixsock-stream/PATH"
            )
        };
        let (protocol, rest) = address.split_once('/').ok_or_else(form)?;
        if rest.is_empty() || rest.contains(['?', '#']) {
            return Err(form());
        }
        if protocol == "unixsock-stream" {
            return Ok(Self::Machine);
        }
        let (name, port) = rest.rsplit_once(':').ok_or_else(form)?;
        if name.is_empty() || port.parse::<u16>().is_err() {
            return Err(form());
        }
        let name = name.strip_prefix('[').and_then(|n| n.strip_suffix(']')).unwrap_or(name);
        // Other names are what somebody else says that they are.
        let is_loopback = name == "localhost"
            || name.parse::<IpAddr>().is_ok_and(|ip| ip.to_canonical().is_loopback());
        match protocol {
            "quic" => Ok(Self::Authenticated),
            "tcp" if is_loopback => Ok(Self::Machine),
            "tcp" => Ok(Self::Anybody),
            _ => Err(form()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn who_can_reach_an_address() {
        for (address, reach) in [
            ("unixsock-stream//run/kiloray/0", Some(Reach::Machine)),
            ("tcp/127.0.0.1:7447", Some(Reach::Machine)),
            ("tcp/127.8.0.1:7447", Some(Reach::Machine)),
            ("tcp/[::1]:7447", Some(Reach::Machine)),
            ("tcp/[::ffff:127.0.0.1]:7447", Some(Reach::Machine)),
            ("tcp/localhost:7447", Some(Reach::Machine)),
            ("tcp/0.0.0.0:7447", Some(Reach::Anybody)),
            ("tcp/[::]:7447", Some(Reach::Anybody)),
            ("tcp/192.168.1.2:7447", Some(Reach::Anybody)),
            ("tcp/localhost.example:7447", Some(Reach::Anybody)),
            ("quic/0.0.0.0:7447", Some(Reach::Authenticated)),
            ("quic/render-1.example:7447", Some(Reach::Authenticated)),
            ("quic/render-1.example:7447#enable_mtls=false", None),
            ("tcp/127.0.0.1:7447?prio=1-7", None),
            ("tls/render-1.example:7447", None),
            ("udp/127.0.0.1:7447", None),
            ("tcp/127.0.0.1", None),
            ("tcp/127.0.0.1:http", None),
            ("tcp/:7447", None),
            ("unixsock-stream/", None),
            ("127.0.0.1:7447", None),
            ("", None),
        ] {
            assert_eq!(Reach::of(address).ok(), reach, "{address}");
        }
    }
}
