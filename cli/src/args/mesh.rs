use std::{fmt, path::PathBuf, str::FromStr};

use clap::{ArgMatches, Args, ValueEnum, ValueHint, parser::ValueSource};
use kiloray_core::{network::NODES_MAX, node::Prefetch, render::Tiling};
use kiloray_mesh::MeshOptions;
use serde::Serialize;

use super::{
    Division,
    options::{BLOCK_MIN, seed, whole},
    size::parse_bytes,
    units::{Part, parse_link_time, parse_part, parse_rate, parse_time},
};

/// Options of a simulated mesh.
#[derive(Debug, Clone, Args, Serialize)]
pub(crate) struct Mesh {
    #[command(flatten)]
    #[serde(flatten)]
    pub(crate) division: Division,
    /// How fast a node is: pc (a core of a PC, measured), t800 (transputer of 1987, 20 MHz), rp2350 (Raspberry Pi Pico 2: Cortex-M33 with FPU, 150 MHz),
    /// stm32f4 (STM32F407: Cortex-M4F, 168 MHz), or a file that 'kiloray calibrate' wrote
    #[arg(long, value_name = "P", default_value = "pc", value_hint = ValueHint::FilePath, help_heading = "Mesh")]
    pub(crate) profile: Profile,
    /// Nodes that are slower by a factor, as in 5:10 (repeatable)
    #[arg(long, value_name = "NODE:FACTOR", value_delimiter = ',', help_heading = "Mesh")]
    pub(crate) slow: Vec<Slow>,
    /// Owned blocks and the tables of materials and lights lie in the arena too, as on a board without flash
    #[arg(long, help_heading = "Mesh")]
    pub(crate) owned_in_arena: bool,

    /// Bandwidth of a link, each way, as in 1GB/s or 20Mbit/s [default: 1GB/s]
    #[arg(long, value_name = "RATE", value_parser = parse_rate, allow_hyphen_values = true, help_heading = "Links")]
    pub(crate) link_bandwidth: Option<u64>,
    /// Time of a byte over a link, as in 1us [default: 1us]
    #[arg(long, value_name = "TIME", value_parser = parse_link_time, allow_hyphen_values = true, help_heading = "Links")]
    pub(crate) link_latency: Option<u64>,
    /// Greatest age of messages that wait for others to the same node, to share a packet with them [default: as long as two packets take over a link]
    #[arg(long, value_name = "TIME", value_parser = parse_link_time, allow_hyphen_values = true, help_heading = "Links")]
    pub(crate) bundle: Option<u64>,
    /// Whether a router waits for a whole packet (store) or passes on its head at once (cut) [default: cut]
    #[arg(long, value_name = "S", value_enum, help_heading = "Links")]
    pub(crate) switching: Option<Switching>,

    /// Packets lost, of those sent over each link: 1/1000, 0.001 or 0.1%
    #[arg(long, value_name = "PART", value_parser = parse_part, allow_hyphen_values = true, help_heading = "Faults")]
    pub(crate) loss: Option<Part>,
    /// Packets doubled
    #[arg(long, value_name = "PART", value_parser = parse_part, allow_hyphen_values = true, help_heading = "Faults")]
    pub(crate) duplicate: Option<Part>,
    /// Each packet is late by a random time up to this one
    #[arg(long, value_name = "TIME", value_parser = parse_link_time, allow_hyphen_values = true, help_heading = "Faults")]
    pub(crate) jitter: Option<u64>,
    /// A node that crashes at a time of the run, as in 5@2ms (repeatable)
    #[arg(long, value_name = "NODE@TIME", value_delimiter = ',', help_heading = "Faults")]
    pub(crate) crash: Vec<Crash>,
    /// Which packets are lost, doubled and late: the same seed gives the same ones, whatever --seed says [default: that of --seed]
    #[arg(long, value_name = "N", value_parser = seed, allow_hyphen_values = true, help_heading = "Faults")]
    pub(crate) fault_seed: Option<u64>,
}

/// Whether any option of a mesh was typed.
pub(super) fn is_typed(matches: &ArgMatches) -> bool {
    let mesh = Mesh::augment_args(clap::Command::new("mesh"));
    mesh.get_arguments()
        .any(|a| matches.value_source(a.get_id().as_str()) == Some(ValueSource::CommandLine))
}

/// How fast a node is.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub(crate) enum Profile {
    /// As every machine knows it.
    Named(String),
    /// As measured on some machine.
    File(PathBuf),
}

impl FromStr for Profile {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if kiloray_sim::Profile::named(text).is_some() {
            return Ok(Self::Named(text.to_owned()));
        }
        let path = PathBuf::from(text);
        if path.extension().is_some_and(|extension| extension == "json") {
            return Ok(Self::File(path));
        }
        let names = kiloray_sim::Profile::ALL.map(|profile| profile.name);
        Err(format!(
            "'{text}' is no profile; there are {}, and files that 'kiloray calibrate -o my.json' wrote",
            names.join(", ")
        ))
    }
}

/// How a router passes packets on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Switching {
    /// Store and forward
    Store,
    /// Cut through
    Cut,
}

/// How much lies with every node.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Top {
    Blocks(u32),
    Bytes(u64),
}

impl Top {
    /// In blocks of a size.
    pub(crate) fn blocks(self, block_bytes: u64) -> u32 {
        match self {
            Self::Blocks(blocks) => blocks,
            Self::Bytes(bytes) => (bytes / block_bytes.max(1)).min(u64::from(u32::MAX)) as u32,
        }
    }
}

impl FromStr for Top {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text.parse() {
            Ok(blocks) => Ok(Self::Blocks(blocks)),
            Err(_) => parse_bytes(text)
                .map(Self::Bytes)
                .map_err(|_| "write a size as in 16KiB, or a number of blocks".into()),
        }
    }
}

impl fmt::Display for Top {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Blocks(blocks) => write!(f, "{blocks}"),
            Self::Bytes(bytes) => write!(f, "{bytes}B"),
        }
    }
}

impl Serialize for Top {
    fn serialize<S: serde::Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        to.collect_str(self)
    }
}

/// A slow node.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Slow {
    pub(crate) node: u16,
    pub(crate) factor: f64,
}

impl FromStr for Slow {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parsed = text.split_once(':').and_then(|(node, factor)| {
            Some(Self { node: node.parse().ok()?, factor: factor.parse().ok()? })
        });
        parsed
            .filter(|slow| (1.0..=1e6).contains(&slow.factor))
            .ok_or_else(|| "write a node and a factor from 1 to 1000000, as in 5:10".into())
    }
}

/// A node's end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub(crate) struct Crash {
    pub(crate) node: u16,
    #[serde(rename = "time_ns")]
    pub(crate) time: u64,
}

impl FromStr for Crash {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (node, time) =
            text.split_once('@').ok_or("write a node and a time of the run, as in 5@2ms")?;
        let node =
            node.parse().map_err(|_| format!("'{node}' is no node; write it as in 5@2ms"))?;
        Ok(Self { node, time: parse_time(time)? })
    }
}

/// How many blocks are fetched ahead.
pub(super) fn prefetch(text: &str) -> Result<Prefetch, String> {
    match text.parse() {
        _ if text == "all" => Ok(Prefetch::All),
        Ok(number) if number <= Prefetch::MOST => Ok(Prefetch::Nearest(number)),
        _ => Err(format!("write 'all', or a number of blocks from 0 to {}", Prefetch::MOST)),
    }
}

pub(super) fn nodes(text: &str) -> Result<u32, String> {
    whole(text, 1, NODES_MAX)
}

/// Each is an operating system's process of some 50 MB.
pub(super) fn emulators(text: &str) -> Result<u32, String> {
    whole(text, 1, 64)
}

pub(super) fn processes(text: &str) -> Result<u32, String> {
    whole(text, 0, 64)
}

/// Bits of a serial line in a second.
pub(super) fn baud(text: &str) -> Result<u32, String> {
    whole(text, 300, 4_000_000)
}

pub(super) fn node(text: &str) -> Result<u16, String> {
    whole(text, 0, NODES_MAX - 1).map(|node| node as u16)
}

pub(super) fn tile(text: &str) -> Result<u32, String> {
    whole(text, 1, Tiling::SIDE_MAX)
}

pub(super) fn group(text: &str) -> Result<u32, String> {
    whole(text, 0, NODES_MAX)
}

pub(super) fn refusals(text: &str) -> Result<u32, String> {
    whole(text, 0, 255)
}

pub(super) fn replicas(text: &str) -> Result<u32, String> {
    whole(text, 1, NODES_MAX)
}

pub(super) fn packet(text: &str) -> Result<u32, String> {
    let bytes = parse_bytes(text)?;
    // Great blocks need more: their size is known later.
    let [least, most] = [MeshOptions::packet_min(BLOCK_MIN as usize), MeshOptions::packet_max()];
    let fits = (least.into()..=u64::from(most)).contains(&bytes);
    if fits { Ok(bytes as u32) } else { Err(format!("a packet has {least}B to {most}B")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_a_node_and_a_number() {
        assert_eq!("5@2ms".parse(), Ok(Crash { node: 5, time: 2_000_000 }));
        assert_eq!("5:2.5".parse(), Ok(Slow { node: 5, factor: 2.5 }));
        for text in ["", "5", "5@", "@1ms", "5@1", "-1@1ms", "5@-1ms"] {
            assert!(text.parse::<Crash>().is_err(), "{text}");
        }
        for text in ["", "5", "5:", "5:0", "5:-1", "5:inf", "5:NaN", "a:2"] {
            assert!(text.parse::<Slow>().is_err(), "{text}");
        }
    }

    #[test]
    fn the_top_is_bytes_or_blocks() {
        assert_eq!("16KiB".parse(), Ok(Top::Bytes(16_384)));
        assert_eq!("5".parse(), Ok(Top::Blocks(5)));
        assert_eq!(Top::Bytes(16_384).blocks(4096), 4);
        assert!("many".parse::<Top>().is_err());
    }
}
