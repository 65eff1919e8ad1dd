//! What nodes are to render: from what was typed, or from a configuration of nodes that are started elsewhere.

use std::path::{Path, PathBuf};

use kiloray_host::{Config, Folder, Job};
use kiloray_mesh::{MeshLayout, MeshOptions};
use kiloray_render::framing;

use crate::{
    args::{self, Bounds, Common, Division, Top},
    command::{
        division, engine, frames, least,
        node::{refused, refused_with},
    },
    failure::{Failure, Outcome},
    input,
    scene::{self, Scene},
};

/// All that is known before nodes are there.
pub(super) struct Prepared {
    /// What was typed, or what the configuration says instead.
    pub(super) common: Common,
    /// The same of the mesh, with what suits processes where nothing is said.
    pub(super) division: Division,
    pub(super) scenes: Vec<PathBuf>,
    pub(super) scene: Scene,
    pub(super) options: MeshOptions,
    pub(super) config: Config,
    /// The directory of the nodes, where they are to be started.
    pub(super) folder: Option<Folder>,
}

/// Finds it.
pub(super) fn prepare(host: &args::Host) -> Outcome<Prepared> {
    if host.common.threads.is_some() {
        return Err(Failure::usage("--threads: a node is one process; --nodes says how many"));
    }
    // The grammar does not require the configuration where there is a scene, which stands against it.
    if host.insecure && host.config.is_none() {
        return Err(Failure::usage(
            "--insecure: it goes with --config; nodes that are started here hear this machine alone",
        ));
    }
    let (mut prepared, layout) = match &host.config {
        Some(path) => of_config(host, path)?,
        None => of_options(host)?,
    };
    let few_frames = frames::of_mesh(&prepared.scene.file.view(), &prepared.options, &layout);
    prepared.scene.notes.extend(few_frames);
    prepared.options = layout.resolved(&prepared.options);
    Ok(prepared)
}

/// Nodes that are started elsewhere, with the same configuration.
fn of_config(host: &args::Host, path: &Path) -> Outcome<(Prepared, MeshLayout)> {
    let mut config = Config::read(path).map_err(refused)?;
    config.insecure = host.insecure;
    let secrets = config.tls.iter().flat_map(|tls| [&tls.root, &tls.certificate, &tls.key]);
    secrets.into_iter().try_for_each(|file| input::keep(file))?;
    if config.scene.extension().is_none_or(|extension| extension != "kilo") {
        return Err(Failure::file(
            &config.scene,
            "is no compiled scene: 'kiloray compile SCENE -o scene.kilo' makes one",
        ));
    }
    let scenes = vec![config.scene.clone()];
    let compiled = args::Scene { scenes: scenes.clone(), ..host.scene };
    let block = division::default_block(config.mesh.memory as u64);
    let scene = scene::load(&compiled, None, block, host.common.quiet)?;
    let Job { options, layout, .. } = job(&config, &scene)?;
    let settings = options.settings;
    let common = Common {
        width: Some(options.width),
        height: Some(options.height),
        samples: settings.samples,
        shadow_samples: Some(settings.shadow_samples).filter(|&samples| samples > 0),
        lights_per_point: settings.lights,
        bounces: settings.bounces.into(),
        seed: settings.seed,
        memory: Some(options.memory as u64),
        ..host.common.clone()
    };
    let division = Division {
        nodes: Some(options.topology.nodes().into()),
        topology: Some(config.mesh.topology.clone()),
        schedule: options.schedule,
        shadow: Some(options.shadow),
        points: Some(options.points),
        prefetch: Some(options.prefetch),
        task_order: Some(options.order),
        tile: options.tile.map(u32::from),
        group: Some(options.group.into()),
        refusals: Some(options.refusals.into()),
        placement: options.dealing,
        top: options.top.map(Top::Blocks),
        rom: None,
        block_replicas: options.replicas.into(),
        packet: Some(options.packet.into()),
    };
    let prepared = Prepared { common, division, scenes, scene, options, config, folder: None };
    Ok((prepared, layout))
}

/// Nodes of this machine.
fn of_options(host: &args::Host) -> Outcome<(Prepared, MeshLayout)> {
    let common = host.common.clone();
    // What makes no sense is said before the scene is read.
    let division = host.division.for_processes();
    let topology = division.topology().map_err(Failure::usage)?;
    if topology.nodes() > PROCESSES_MAX && host.write_config.is_none() {
        return Err(Failure::usage(format_args!(
            "{} nodes: this machine gets at most {PROCESSES_MAX} processes; take fewer --nodes, 'kiloray sim' for a mesh of more, or --config for nodes on other machines",
            topology.nodes()
        )));
    }
    let scenes = host.scene.scenes.clone();
    let block = division::default_block(division::memory(&common));
    let scene = scene::load(&host.scene, common.block, block, common.quiet)?
        .with_view(common.view.as_ref());
    let view = scene.choose_view(common.view.as_ref())?;
    let bounds =
        Bounds::new(common.width, common.height, framing::aspect(&view)).map_err(Failure::usage)?;
    let view = framing::fitted(view, bounds.width, bounds.height);
    let mesh = least::Mesh {
        sources: &host.scene,
        block: common.block,
        scene: &scene,
        options: |scene: &Scene| {
            let file = scene.file.view();
            let mesh = division::options(&common, &division, bounds, topology, &file)?;
            Ok(kiloray_sim::Options { mesh, ..kiloray_sim::Options::new(1, 1, view, topology) })
        },
    };
    let options = mesh.check(engine::too_small)?.0.mesh;
    let nodes = options.topology.nodes();
    let (folder, file, addresses) = match &host.write_config {
        None => {
            let folder = Folder::new().map_err(refused)?;
            let (file, addresses) = (in_file(&folder, &scenes, &scene)?, folder.addresses(nodes));
            (Some(folder), file, addresses)
        }
        Some(path) => {
            let file = beside(path, &scenes, &scene)?;
            let addresses = (0..nodes)
                .map(|node| format!("tcp/127.0.0.1:{}", u32::from(PORT) + u32::from(node)));
            (None, file, addresses.collect())
        }
    };
    let topology = division.topology.as_deref().unwrap_or_default();
    let mut config = Config::new(file, addresses, topology, &options, view);
    config.mesh.enforce = host.enforce;
    let Job { layout, .. } = job(&config, &scene)?;
    Ok((Prepared { common, division, scenes, scene, options, config, folder }, layout))
}

/// What cannot be is found before there are processes.
fn job(config: &Config, scene: &Scene) -> Outcome<Job> {
    Job::new(config, &scene.file.view()).map_err(|error| refused_with(error, config.mesh.packet))
}

/// Most nodes that are started here. Each is a process of some 20 MB with a queue of its own for processors, and takes two of the 1024 files that a
/// process may have open by default.
const PROCESSES_MAX: u16 = 256;

/// The port of node 0 in a configuration that is written.
const PORT: u16 = 7447;

/// A scene that is in no file yet is written into the directory of the nodes.
fn in_file(folder: &Folder, scenes: &[PathBuf], scene: &Scene) -> Outcome<PathBuf> {
    match scenes {
        // It is compiled.
        [path] if scene.stats.is_none() => {
            std::fs::canonicalize(path).map_err(|error| Failure::io(path, &error))
        }
        _ => {
            let path = folder.path().join("scene.kilo");
            scene.file.write(&path).map_err(Failure::new)?;
            Ok(path)
        }
    }
}

/// The scene as a configuration names it: its name alone if it lies beside it.
fn beside(config: &Path, scenes: &[PathBuf], scene: &Scene) -> Outcome<PathBuf> {
    let [path] = scenes else { return Err(not_compiled()) };
    if scene.stats.is_some() {
        return Err(not_compiled());
    }
    let file = std::fs::canonicalize(path).map_err(|error| Failure::io(path, &error))?;
    let folder = config.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = std::fs::canonicalize(folder.unwrap_or(Path::new("."))).ok();
    let is_beside = folder.as_deref() == file.parent();
    Ok(file.file_name().filter(|_| is_beside).map_or_else(|| file.clone(), PathBuf::from))
}

fn not_compiled() -> Failure {
    Failure::usage(
        "--write-config: every node needs the file of the scene: 'kiloray compile SCENE -o scene.kilo', and name that",
    )
}
