use std::path::{Path, PathBuf};

use kiloray_core::network::NODES_MAX;
use kiloray_core::node::{Dealing, PointHome, Prefetch, Schedule, ShadowPolicy, TaskOrder};
use kiloray_core::render::Tiling;
use kiloray_core::scene::View;
use kiloray_core::shade;
use kiloray_mesh::MeshOptions;
use kiloray_scene::regular;
use serde::{Deserialize, Serialize};

use crate::{Error, TlsConfig};

/// Greatest file \[bytes\]: an address for each of the most nodes, and room to spare.
const BYTES_MAX: u64 = 16 << 20;

/// What all processes of a mesh are told: the same file for each of them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// What the mesh is called in the network: letters, digits, `-` and `_`.
    pub name: String,
    /// The scene, compiled; relative to the directory of the configuration.
    pub scene: PathBuf,
    /// Where each node listens, by its number, as in `tcp/127.0.0.1:7447` or `unixsock-stream//run/kiloray/0`.
    pub addresses: Vec<String>,
    /// Where this process listens, if not where the others find it, as behind a container's ports. Not in the file.
    #[serde(skip)]
    pub listen: Option<String>,
    /// Whether addresses beyond this machine may do without [`tls`](Self::tls). Not in the file.
    #[serde(skip)]
    pub insecure: bool,
    /// Who may take part. Without it the mesh is one of this machine.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tls: Option<TlsConfig>,
    /// The mesh.
    pub mesh: MeshConfig,
    /// The picture.
    pub picture: PictureConfig,
}

/// The mesh of a [`Config`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MeshConfig {
    /// Who is next to whom, as in `full` or `torus:4x2`.
    pub topology: String,
    /// Of each node, for all that it holds \[bytes\].
    pub memory: usize,
    /// Greatest packet, header included \[bytes\]; 0: by the memory.
    #[serde(default)]
    pub packet: u16,
    /// Which rays go where.
    pub schedule: Schedule,
    /// Who traces the shadow rays of a hit.
    #[serde(default)]
    pub shadow: ShadowPolicy,
    /// Where intersection points live.
    #[serde(default)]
    pub points: PointHome,
    /// How blocks are dealt out.
    pub placement: Dealing,
    /// Blocks that every node has; left out: as many as suit the scene.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub top: Option<u32>,
    /// Copies of each other block.
    pub replicas: u16,
    /// How many blocks are fetched ahead.
    pub prefetch: Prefetch,
    /// Which of the waiting rays goes on first.
    pub order: TaskOrder,
    /// Nodes for each sub-master; 0 for none.
    #[serde(default)]
    pub group: u16,
    /// Refusals of a ray after which it is run where it came from.
    pub refusals: u8,
    /// Side of a tile \[pixels\]; left out: by picture, nodes and memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tile: Option<u16>,
    /// Whether the system ends a process that holds more than its memory and [`PROCESS_BYTES`](crate::PROCESS_BYTES).
    #[serde(default)]
    pub enforce: bool,
}

/// The picture of a [`Config`].
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PictureConfig {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Camera paths for each pixel.
    pub samples: u32,
    /// Shadow rays for each light and point; 0: as many as its size and distance ask for.
    #[serde(default)]
    pub shadow_samples: u16,
    /// About how many lights a point asks at most.
    #[serde(default = "lights_per_point")]
    pub lights_per_point: u16,
    /// Most reflections and refractions on a path.
    pub bounces: u8,
    /// Of all random numbers, in words as numbers of 64 bits are not in TOML.
    pub seed: String,
    /// The camera.
    pub view: ViewConfig,
}

fn lights_per_point() -> u16 {
    shade::Settings::default().lights
}

/// The camera of a [`PictureConfig`]: see [`View`], in scene coordinates.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViewConfig {
    /// See [`View::kind`].
    pub kind: u32,
    /// See [`View::position`].
    pub position: [f32; 3],
    /// See [`View::direction`].
    pub direction: [f32; 3],
    /// See [`View::up`].
    pub up: [f32; 3],
    /// See [`View::size`].
    pub size: [f32; 2],
    /// See [`View::offset`].
    pub offset: [f32; 2],
    /// See [`View::clip`].
    pub clip: [f32; 2],
}

impl From<View> for ViewConfig {
    fn from(view: View) -> Self {
        let View { kind, name: _, position, direction, up, size, offset, clip } = view;
        Self { kind, position, direction, up, size, offset, clip }
    }
}

impl From<ViewConfig> for View {
    fn from(view: ViewConfig) -> Self {
        let ViewConfig { kind, position, direction, up, size, offset, clip } = view;
        Self { kind, name: [0; 20], position, direction, up, size, offset, clip }
    }
}

impl Config {
    /// A mesh of this machine: nodes that listen at the addresses, and a topology of as many as the options say.
    #[must_use]
    pub fn new(
        scene: PathBuf,
        addresses: Vec<String>,
        topology: &str,
        options: &MeshOptions,
        view: View,
    ) -> Self {
        Self {
            name: "mesh".into(),
            scene,
            addresses,
            listen: None,
            insecure: false,
            tls: None,
            mesh: MeshConfig {
                topology: topology.into(),
                memory: options.memory,
                packet: options.packet,
                schedule: options.schedule,
                shadow: options.shadow,
                points: options.points,
                placement: options.dealing,
                top: options.top,
                replicas: options.replicas,
                prefetch: options.prefetch,
                order: options.order,
                group: options.group,
                refusals: options.refusals,
                tile: options.tile,
                enforce: false,
            },
            picture: PictureConfig {
                width: options.width,
                height: options.height,
                samples: options.settings.samples,
                shadow_samples: options.settings.shadow_samples,
                lights_per_point: options.settings.lights,
                bounces: options.settings.bounces,
                seed: options.settings.seed.to_string(),
                view: view.into(),
            },
        }
    }

    /// Reads a file. The paths in it are then relative to where this process is.
    ///
    /// # Errors
    /// [`Error::Io`], [`Error::Config`].
    pub fn read(path: &Path) -> Result<Self, Error> {
        let bytes = regular::read(path, BYTES_MAX)
            .map_err(|source| Error::Io { path: path.into(), source })?;
        let wrong = |cause: String| Error::Config { path: path.into(), cause };
        let text = String::from_utf8(bytes).map_err(|_| wrong("is no text".into()))?;
        let mut config = Self::parse(&text).map_err(wrong)?;
        if let Some(folder) = path.parent() {
            config.scene = folder.join(&config.scene);
            if let Some(tls) = &mut config.tls {
                tls.move_to(folder);
            }
        }
        Ok(config)
    }

    /// Reads its text.
    ///
    /// # Errors
    /// What is wrong, and where.
    pub fn parse(text: &str) -> Result<Self, String> {
        let config: Self = toml::from_str(text).map_err(|error| {
            let before = error.span().and_then(|span| text.get(..span.start)).unwrap_or_default();
            let line = before.bytes().filter(|&b| b == b'\n').count() + 1;
            format!("line {line}: {}", error.message())
        })?;
        let is_plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
        if config.name.is_empty() || !config.name.chars().all(is_plain) {
            return Err(format!("name = '{}': write letters, digits, '-' and '_'", config.name));
        }
        if config.addresses.is_empty() {
            return Err("addresses: a mesh has a node at least".into());
        }
        config.seed()?;
        config.check_numbers()?;
        Ok(config)
    }

    /// Whether the command takes such numbers; the size of the picture apart, which its camera checks.
    ///
    /// # Errors
    /// The first that is none of these, and its bounds.
    pub(crate) fn check_numbers(&self) -> Result<(), String> {
        let (mesh, picture) = (&self.mesh, &self.picture);
        let packet_min = if mesh.packet == 0 { 0 } else { MeshOptions::packet_min(0).into() };
        let prefetch = match mesh.prefetch {
            Prefetch::All => 0,
            Prefetch::Nearest(blocks) => blocks.into(),
        };
        let nodes = u32::try_from(self.addresses.len()).unwrap_or(u32::MAX).max(1);
        let bounds: [(&str, u32, u32, u32); 9] = [
            ("samples", picture.samples, 1, shade::Settings::SAMPLES_MAX),
            ("shadow_samples", picture.shadow_samples.into(), 0, shade::Settings::BUNDLE_MAX),
            ("lights_per_point", picture.lights_per_point.into(), 1, u16::MAX.into()),
            ("bounces", picture.bounces.into(), 0, shade::Settings::BOUNCES_MAX.into()),
            ("packet", mesh.packet.into(), packet_min, MeshOptions::packet_max().into()),
            ("replicas", mesh.replicas.into(), 1, nodes),
            ("prefetch: nearest", prefetch, 0, Prefetch::MOST.into()),
            ("group", mesh.group.into(), 0, NODES_MAX),
            ("tile", mesh.tile.map_or(1, u32::from), 1, Tiling::SIDE_MAX),
        ];
        match bounds.iter().find(|&&(_, value, min, max)| !(min..=max).contains(&value)) {
            Some((name, value, min, max)) => {
                Err(format!("{name} = {value}: write a whole number from {min} to {max}"))
            }
            None => Ok(()),
        }
    }

    /// As text.
    ///
    /// # Errors
    /// [`Error::Options`] for what cannot be written in it.
    pub fn to_text(&self) -> Result<String, Error> {
        toml::to_string(self).map_err(|error| Error::Options(error.to_string()))
    }

    /// The seed as a number.
    pub(crate) fn seed(&self) -> Result<u64, String> {
        let seed = &self.picture.seed;
        seed.parse().map_err(|_| format!("seed = '{seed}': write a whole number below 2^64"))
    }
}
