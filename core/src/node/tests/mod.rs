mod check;
mod mesh;
mod mesh_state;
mod state;
mod toy;
mod walks;

use self::mesh::{Faults, More, Setup};
use self::toy::Toy;
use super::{PointHome, Schedule, ShadowPolicy, TaskOrder};
use crate::network::Topology;

const SHADOWS: [ShadowPolicy; 3] = [ShadowPolicy::Keep, ShadowPolicy::Offer, ShadowPolicy::Steal];
const POINTS: [PointHome; 2] = [PointHome::Finder, PointHome::Owner];
const SCHEDULES: [Schedule; 3] = [Schedule::Hybrid, Schedule::Demand, Schedule::Data];

fn setup(topology: (&str, u32), schedule: Schedule, toy: Toy) -> Setup {
    Setup {
        topology: Topology::parse(topology.0, topology.1).unwrap(),
        toy,
        schedule,
        shadow: ShadowPolicy::Keep,
        points: PointHome::Finder,
        top: 1,
        replicas: 1,
        refusals: 1,
        group: 0,
        order: TaskOrder::Ready,
        more: More::default(),
        hasty: false,
        timed: false,
        fused: true,
        faults: Faults::default(),
        broken: None,
    }
}
