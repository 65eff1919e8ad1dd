use std::fmt;

use kiloray_core::block::{KiloView, checksum};
use kiloray_core::network::{HOST, NodeId};
use kiloray_core::node::{Placement, Setup};

/// A node, or the host beside the mesh.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Place(NodeId);

impl Place {
    /// The host.
    pub const HOST: Self = Self(HOST);

    /// The place of a node, or of the host.
    #[must_use]
    pub const fn new(id: NodeId) -> Self {
        Self(id)
    }

    /// Its name in the network.
    #[must_use]
    pub const fn id(self) -> NodeId {
        self.0
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0 == HOST { f.write_str("host") } else { write!(f, "{}", self.0.0) }
    }
}

impl std::str::FromStr for Place {
    type Err = ();

    fn from_str(text: &str) -> Result<Self, ()> {
        match text {
            "host" => Ok(Self::HOST),
            number => {
                number.parse().ok().filter(|&n| n != HOST.0).map(|n| Self(NodeId(n))).ok_or(())
            }
        }
    }
}

/// What a process says of itself when it is there: who it is, and what it works on. Processes that differ in the latter cannot make a picture together.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Identity {
    /// Where it is.
    pub place: Place,
    /// Which of those that were there.
    pub incarnation: u32,
    /// Of the program.
    pub version: String,
    /// Of header and tables of the scene's file.
    pub scene: u32,
    /// Of the blocks that it holds.
    pub share: u32,
    /// Of the options.
    pub job: u32,
}

impl Identity {
    /// The version of this program, and of what nodes agree on, which changes between its releases.
    #[must_use]
    pub fn version() -> String {
        format!("{}+{}", env!("CARGO_PKG_VERSION"), Setup::VERSION)
    }

    /// A number for one that nobody counts: by chance, as numbers of processes come again, in containers every time.
    #[must_use]
    pub fn any_incarnation() -> u32 {
        fastrand::u32(..)
    }

    /// The checksum of all blocks that a node holds: of their checksums, in their order.
    #[must_use]
    pub fn share_of(file: &KiloView<'_>, placement: &Placement, node: NodeId) -> u32 {
        let held = (0..file.blocks()).filter(|&block| placement.holds(node, block));
        let sums: Vec<u8> = held
            .filter_map(|block| file.trusted_block(block))
            .flat_map(|block| block.header().crc.to_le_bytes())
            .collect();
        checksum(&sums)
    }

    /// What it is in words, for the network: its fields between slashes.
    #[must_use]
    pub fn to_key(&self) -> String {
        let Self { place, incarnation, version, scene, share, job } = self;
        format!("{place}/{incarnation:08x}/{version}/{scene:08x}/{share:08x}/{job:08x}")
    }

    /// The other way round; `None` for what no process says.
    #[must_use]
    pub fn from_key(key: &str) -> Option<Self> {
        let mut parts = key.split('/');
        let place = parts.next()?.parse().ok()?;
        let incarnation = hexadecimal(parts.next()?)?;
        let version = parts.next().filter(|version| is_version(version))?.to_owned();
        let [scene, share, job] = [(); 3].map(|()| parts.next().and_then(hexadecimal));
        let all = Self { place, incarnation, version, scene: scene?, share: share?, job: job? };
        // In no other spelling: the end of another's would be taken for the end of this one.
        (all.to_key() == key).then_some(all)
    }

    /// Why two processes cannot work together, if so: how this one differs from what is expected. Whose share it is does not matter.
    #[must_use]
    pub fn differs(&self, expected: &Self) -> Option<String> {
        if self.version != expected.version {
            Some(format!("is of version {}, not {}", self.version, expected.version))
        } else if self.scene != expected.scene {
            Some("has another scene file".into())
        } else if self.job != expected.job {
            Some("was given other options".into())
        } else {
            None
        }
    }
}

/// Whether it can be shown to a person: it comes from anybody.
fn is_version(text: &str) -> bool {
    let is_plain = |c: char| c.is_ascii_alphanumeric() || ".-+".contains(c);
    (1..=VERSION_LEN).contains(&text.len()) && text.chars().all(is_plain)
}

/// Longest version.
const VERSION_LEN: usize = 32;

fn hexadecimal(text: &str) -> Option<u32> {
    (text.len() == 8).then(|| u32::from_str_radix(text, 16).ok()).flatten()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_says_it_all() {
        let identity = Identity {
            place: Place::new(NodeId(12)),
            incarnation: 0xfe,
            version: "1.2.3".into(),
            scene: 1,
            share: 2,
            job: 0x8000_0000,
        };
        let key = identity.to_key();
        assert_eq!(key, "12/000000fe/1.2.3/00000001/00000002/80000000");
        assert_eq!(Identity::from_key(&key), Some(identity.clone()));
        assert_eq!(
            Identity::from_key("host/00000000/1/00000000/00000000/00000000").map(|i| i.place),
            Some(Place::HOST)
        );
        for bad in [
            "",
            "12",
            "x/000000fe/1.2.3/00000001/00000002/80000000",
            &format!("{key}/"),
            "65535/000000fe/1/00000001/00000002/80000000",
            "1/fe/1/00000001/00000002/80000000",
            "1/000000fe/1.2\u{1b}[2J/00000001/00000002/80000000",
            &key.replace("1.2.3", &"1".repeat(33)),
            &key.replace("12/", "+12/"),
            &key.replace("fe", "FE"),
        ] {
            assert_eq!(Identity::from_key(bad), None, "{bad}");
        }
        assert_eq!(identity.differs(&Identity { share: 9, ..identity.clone() }), None);
        assert!(identity.differs(&Identity { scene: 9, ..identity.clone() }).is_some());
    }
}
