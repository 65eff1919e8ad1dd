//! A node of any mesh, with any plan in any memory, that gets any packets at any time, over blocks of any bytes.
#![no_std]
#![no_main]

use core::hint::black_box;
use kiloray_core::block::KiloView;
use kiloray_core::network::{Mesh, NodeId, Port, Topology};
use kiloray_core::node::{
    Dealing, Node, NodeNeeds, NodePlan, Picture, Placement, PointHome, Prefetch, Rom, Schedule,
    Settings, ShadowPolicy, TaskOrder, Time,
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

entry!({
    if let Ok(file) = KiloView::parse(any_bytes()) {
        let mesh = Mesh::new(Topology::Full { nodes: any() });
        let settings = settings();
        let plan = plan(mesh, settings.schedule).unwrap_or_else(any_plan);
        if let Ok(budget) = plan.budget(any()) {
            run(file, mesh, settings, &plan, budget);
        }
    }
});
