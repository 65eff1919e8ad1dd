//! A node of any mesh, with any plan in any memory, that gets any packets at any time, over blocks of any bytes; and one as a board makes it, of any
//! share of a scene, by any setup.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::KiloView;
use kiloray_core::network::{Mesh, NodeId, Port, Topology};
use kiloray_core::node::{
    Dealing, Node, NodeNeeds, NodePlan, Picture, Placement, PointHome, Prefetch, Rom, Schedule,
    Settings, Setup, ShadowPolicy, Share, TaskOrder, Time,
};
use kiloray_core::render::Tiling;
use kiloray_core::shade::{Shader, Tables};
use kiloray_core::store::{Arena, Budget, Chunk};
use kiloray_core::trace::Scalar;
use kiloray_core::view::Camera;
use kiloray_no_panic::{any, any_bytes, any_room, any_router_size, any_shading, entry, print};

#[inline(never)]
fn shadow() -> ShadowPolicy {
    match any::<u8>() {
        0 => ShadowPolicy::Keep,
        1 => ShadowPolicy::Offer,
        _ => ShadowPolicy::Steal,
    }
}

fn points() -> PointHome {
    if any::<u8>() == 0 { PointHome::Finder } else { PointHome::Owner }
}

fn settings() -> Settings {
    let dealing = if any::<u8>() == 0 { Dealing::Subtrees } else { Dealing::RoundRobin };
    let placement = Placement { dealing, blocks: any(), nodes: any(), top: any(), replicas: any() };
    Settings {
        schedule: match any::<u8>() {
            0 => Schedule::Hybrid,
            1 => Schedule::Demand,
            _ => Schedule::Data,
        },
        shadow: shadow(),
        points: points(),
        placement,
        refusals: any(),
        prefetch: if any::<u8>() == 0 { Prefetch::All } else { Prefetch::Nearest(any()) },
        order: if any::<u8>() == 0 { TaskOrder::Made } else { TaskOrder::Ready },
        patience: Time(any()),
        bundle_age: Time(any()),
        group: any(),
        deaths_told: any(),
    }
}

#[inline(never)]
fn plan(mesh: Mesh, schedule: Schedule) -> Option<NodePlan> {
    let needs = NodeNeeds {
        mesh,
        here: NodeId(any()),
        block_bytes: any(),
        remote: any(),
        owned: any(),
        splits: any(),
        schedule,
        shadow: shadow(),
        points: points(),
        group: any(),
        side: any(),
        packet: any(),
        depth: any(),
        host_depth: any(),
    };
    black_box(NodePlan::least(&needs));
    match NodePlan::new(any(), &needs) {
        Ok(plan) => Some(plan),
        Err(error) => {
            print(&error);
            None
        }
    }
}

/// A plan that nobody has made: any lengths.
#[inline(never)]
fn any_plan() -> NodePlan {
    NodePlan {
        router: any_router_size(),
        bundles: any(),
        rays: any(),
        shadows: any(),
        tiles: any(),
        visits: any(),
        side: any(),
        fetches: any(),
        serves: any(),
        members: any(),
        frames: any(),
        block_bytes: any(),
        owned: any(),
    }
}

#[inline(never)]
fn run(file: KiloView<'_>, mesh: Mesh, settings: Settings, plan: &NodePlan, budget: Budget) {
    let mut memory = [Chunk::ZERO; 8];
    let mut arena = Arena::new(any_room(&mut memory));
    let shading = any_shading();
    let camera = file.views().first().and_then(|view| Camera::new(view, any(), any(), any()));
    let Some(camera) = camera else { return };
    let tiling = Tiling::new(any(), any(), any());
    let shader = Shader::new(Tables::of(&file), shading);
    let world = Picture::new(Scalar, shader, camera, tiling, file.limits());
    let rom = if any::<u8>() == 0 { Rom::of_file } else { Rom::of_share };
    let rom = rom(any_bytes(), any(), settings.placement, NodeId(any()));
    black_box((rom.block(any()), rom.holds_all(), rom.len()));
    let node = Node::new(&mut arena, plan, budget, settings, rom, mesh, world);
    let Ok(mut node) = node else { return };
    for _ in 0..any::<u32>() {
        let received = node.router().receive(Port(any()), any_bytes(), |_| any::<u8>() == 0);
        black_box(received);
        black_box(node.poll(Time(any())));
        black_box(node.router().transmit(Port(any()), any_room(&mut [0; 64])));
        black_box((node.counts(), node.stored(), node.budget()));
    }
}

#[inline(never)]
fn begin(share: &Share<'_>) {
    let Some(setup) = Setup::parse(any_bytes()) else { return };
    let topology = setup.mesh().map(|mesh| *mesh.topology());
    let setup = topology.map_or(setup, |topology| setup.with_topology(&topology));
    let mut memory = [Chunk::ZERO; 8];
    match setup.node(share, Scalar, any_room(&mut memory)) {
        Ok(mut node) => {
            black_box(node.poll(Time(any())));
            black_box(node.router().remind());
            let here = share.here();
            black_box(node.router().mesh().joined(here).count());
        }
        Err(error) => print(&error),
    }
}

entry!({
    if let Ok(file) = KiloView::parse(any_bytes()) {
        let mesh = Mesh::new(Topology::Full { nodes: any() });
        let settings = settings();
        let plan = plan(mesh, settings.schedule).unwrap_or_else(any_plan);
        if let Ok(budget) = plan.budget(any()) {
            run(file, mesh, settings, &plan, budget);
        }
    }
    match Share::parse(any_bytes()) {
        Ok(share) => {
            if let Err(error) = share.check_blocks() {
                print(&error);
            }
            black_box((share.scene(), share.here()));
            begin(&share);
        }
        Err(error) => print(&error),
    }
});
