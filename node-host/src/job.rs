use std::time::Duration;

use kiloray_core::block::{KiloView, checksum};
use kiloray_core::network::{Mesh, NodeId, Port, Topology};
use kiloray_core::node::Time;
use kiloray_core::render::Tiling;
use kiloray_core::scene::View;
use kiloray_core::shade::{self, Shader, Tables};
use kiloray_core::view::Camera;
use kiloray_mesh::{MeshLayout, MeshOptions};
use kiloray_render::camera;

use crate::{Config, Error, Identity, Place};

/// What the processes of a mesh work on, as each of them finds it from its configuration and the scene: they all find the same.
#[derive(Debug, Clone)]
pub struct Job {
    /// The mesh.
    pub mesh: Mesh,
    /// What decides how it is divided.
    pub options: MeshOptions,
    /// How it is.
    pub layout: MeshLayout,
    /// The camera.
    pub camera: Camera,
    scene: u32,
    checksum: u32,
}

/// How long a request may stay unanswered at first: many times what a process that waits for a processor among others does.
/// Nodes adapt it to what they see.
const FIRST_LIMIT: Duration = Duration::from_millis(500);
/// How long messages wait for others to the same node: some times what it takes to send a packet.
const BUNDLE_AGE: Duration = Duration::from_micros(200);

impl Job {
    /// Finds it.
    ///
    /// # Errors
    /// [`Error`], for what cannot be.
    pub fn new(config: &Config, file: &KiloView<'_>) -> Result<Self, Error> {
        let (mesh, picture) = (&config.mesh, &config.picture);
        let (width, height) = (picture.width, picture.height);
        config.check_numbers().map_err(Error::Options)?;
        let camera = camera(&View::from(picture.view), width, height, picture.samples)?;
        let block_bytes = file.limits().block_bytes;
        let least = MeshOptions::packet_min(block_bytes);
        if (1..least).contains(&mesh.packet) {
            return Err(Error::Options(format!(
                "packet = {}: blocks of {block_bytes} bytes need at least {least}",
                mesh.packet
            )));
        }
        let nodes = u32::try_from(config.addresses.len()).unwrap_or(u32::MAX);
        let options = MeshOptions {
            settings: shade::Settings {
                samples: picture.samples,
                shadow_samples: picture.shadow_samples,
                lights: picture.lights_per_point,
                bounces: picture.bounces,
                seed: config.seed().map_err(Error::Options)?,
            },
            memory: mesh.memory,
            packet: mesh.packet,
            schedule: mesh.schedule,
            dealing: mesh.placement,
            top: mesh.top,
            replicas: mesh.replicas,
            prefetch: mesh.prefetch,
            shadow: mesh.shadow,
            points: mesh.points,
            order: mesh.order,
            group: mesh.group,
            refusals: mesh.refusals,
            tile: mesh.tile,
            ..MeshOptions::new(width, height, Topology::parse(&mesh.topology, nodes)?)
        };
        let time = |time: Duration| Time(time.as_nanos() as u64);
        let layout = MeshLayout::new(file, &options, |_| (time(FIRST_LIMIT), time(BUNDLE_AGE)))?;
        let text = Config { addresses: Vec::new(), scene: "".into(), tls: None, ..config.clone() }
            .to_text()?;
        Ok(Self {
            mesh: Mesh::new(options.topology),
            options,
            layout,
            camera,
            scene: file.header().crc,
            checksum: checksum(text.as_bytes()),
        })
    }

    /// The shader of the scene.
    #[must_use]
    pub fn shader<'a>(&self, file: &KiloView<'a>) -> Shader<'a> {
        Shader::new(Tables::of(file), self.options.settings)
    }

    /// The tiles of the picture.
    #[must_use]
    pub fn tiling(&self) -> Tiling {
        Tiling::new(self.options.width, self.options.height, self.layout.side())
    }

    /// What a process at a place says of itself.
    #[must_use]
    pub fn identity(&self, file: &KiloView<'_>, place: Place, incarnation: u32) -> Identity {
        let share = match place {
            Place::HOST => 0,
            node => Identity::share_of(file, &self.layout.settings.placement, node.id()),
        };
        Identity {
            place,
            incarnation,
            version: Identity::version(),
            scene: self.scene,
            share,
            job: self.checksum,
        }
    }

    /// The neighbours of a place, by the port that leads to each.
    #[must_use]
    pub fn neighbours(&self, place: Place) -> Vec<(Port, Place)> {
        let ports = (0..self.mesh.ports(place.id())).map(Port);
        let far = |port| Some((port, Place::new(self.mesh.neighbour(place.id(), port)?)));
        ports.filter_map(far).collect()
    }

    /// All nodes.
    pub fn nodes(&self) -> impl Iterator<Item = Place> + use<> {
        (0..self.mesh.nodes()).map(|node| Place::new(NodeId(node)))
    }
}
