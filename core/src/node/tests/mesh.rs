//! A mesh of nodes over a toy scene, whose every step is somebody's choice.

use super::super::*;
use super::toy::Toy;
use crate::network::{
    Channel, HOST, Mesh, NodeId, PacketHeader, Port, Received, Router, RouterMemory, RouterSize,
    Topology,
};
use crate::protocol::{Items, Message, write};
use crate::shade::Sum;
use crate::store::{Arena, CHUNK_BYTES, Chunk};
use std::collections::VecDeque;

/// What a mesh is made of.
#[derive(Debug, Clone)]
pub(super) struct Setup {
    pub(super) topology: Topology,
    pub(super) toy: Toy,
    pub(super) schedule: Schedule,
    pub(super) top: u32,
    pub(super) replicas: u16,
    pub(super) refusals: u8,
    pub(super) group: u16,
    /// Lengths in place of the least ones.
    pub(super) plan: fn(&mut NodePlan),
}

/// Something that can happen.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Action {
    /// A node (the last one: the host) takes a step.
    Poll(u16),
    /// A packet leaves a node over a port.
    Transmit(u16, u16),
    /// The oldest packet on a link arrives.
    Deliver(u16, u16),
    /// It is lost.
    Drop(u16, u16),
    /// It arrives, and stays on the link too.
    Double(u16, u16),
    /// Time goes on to the next time limit.
    Wait,
}

/// Nodes, links and the host.
pub(super) struct World<'a> {
    setup: Setup,
    mesh: Mesh,
    nodes: Vec<Node<'a, Toy>>,
    next: Vec<Next>,
    dead: Vec<bool>,
    host: Router<'a>,
    /// Packets under way from a node by a port; the host is the last node.
    links: Vec<Vec<VecDeque<Vec<u8>>>>,
    given: u32,
    pub(super) sums: Vec<Option<Sum>>,
    pub(super) lost: Option<u32>,
    pub(super) now: Time,
}

/// Memory for all nodes and the host.
pub(super) fn memory(setup: &Setup) -> (Vec<Vec<Chunk>>, Vec<u8>) {
    let mesh = Mesh::new(setup.topology);
    let nodes = (0..mesh.nodes()).map(|node| {
        let plan = setup.node_plan(NodeId(node));
        vec![Chunk::ZERO; plan.bytes() / CHUNK_BYTES]
    });
    let host = std::iter::once(vec![Chunk::ZERO; 4096]);
    let blocks = (0..setup.toy.blocks).flat_map(|block| setup.toy.bytes(block));
    (nodes.chain(host).collect(), blocks.collect())
}

impl Setup {
    pub(super) fn placement(&self) -> Placement {
        Placement {
            dealing: Dealing::Subtrees,
            blocks: self.toy.blocks,
            nodes: self.topology.nodes(),
            top: self.top,
            replicas: self.replicas,
        }
    }

    fn node_plan(&self, here: NodeId) -> NodePlan {
        let mesh = Mesh::new(self.topology);
        let remote = (0..self.toy.blocks).filter(|&b| !self.placement().holds(here, b)).count();
        let needs = NodeNeeds {
            mesh,
            here,
            block_bytes: self.toy.block_bytes,
            remote,
            owned: 0,
            splits: self.toy.splits as usize,
            schedule: self.schedule,
            side: 1,
            packet: 0,
            depth: 1,
        };
        let mut plan = NodePlan::least(&needs);
        (self.plan)(&mut plan);
        plan
    }
}

impl<'a> World<'a> {
    pub(super) fn new(setup: &Setup, memory: &'a mut [Vec<Chunk>], blocks: &'a [u8]) -> Self {
        let mesh = Mesh::new(setup.topology);
        let (host_memory, node_memory) = memory.split_last_mut().unwrap();
        let settings = Settings {
            schedule: setup.schedule,
            placement: setup.placement(),
            refusals: setup.refusals,
            prefetch: Prefetch::Nearest(0),
            order: TaskOrder::Made,
            patience: Time(1 << 20),
            bundle_age: Time(1 << 12),
            group: setup.group,
        };
        let nodes: Vec<_> = node_memory
            .iter_mut()
            .zip(0..)
            .map(|(memory, node)| {
                let here = NodeId(node);
                let plan = setup.node_plan(here);
                let rom = Rom::of_file(blocks, setup.toy.block_bytes, settings.placement, here);
                let router = |memory| Router::new(mesh, here, plan.router, memory);
                let budget = plan.budget(usize::MAX).unwrap();
                let mut arena = Arena::new(memory);
                Node::new(&mut arena, &plan, budget, settings, rom, router, setup.toy).unwrap()
            })
            .collect();
        let payload = NodePlan::packet_min(setup.toy.block_bytes) as u16;
        let size = RouterSize::new(&mesh, HOST, 1, payload);
        let mut arena = Arena::new(host_memory);
        let memory = RouterMemory {
            slots: arena.carve(size.slots()).unwrap(),
            fifos: arena.carve(size.queues()).unwrap(),
            ports: arena.carve(size.ports.into()).unwrap(),
            bytes: arena.carve(size.bytes()).unwrap(),
        };
        let count = nodes.len();
        let links = (0..mesh.nodes())
            .map(NodeId)
            .chain([HOST])
            .map(|node| vec![VecDeque::new(); mesh.ports(node).into()])
            .collect();
        Self {
            setup: setup.clone(),
            mesh,
            nodes,
            next: vec![Next::Now; count],
            dead: vec![false; count],
            host: Router::new(mesh, HOST, size, memory).unwrap(),
            links,
            given: 0,
            sums: vec![None; setup.toy.tiles as usize],
            lost: None,
            now: Time(0),
        }
    }

    fn id(&self, index: u16) -> NodeId {
        if usize::from(index) == self.nodes.len() { HOST } else { NodeId(index) }
    }

    fn index(&self, node: NodeId) -> usize {
        if node == HOST { self.nodes.len() } else { node.0.into() }
    }

    fn router(&mut self, index: u16) -> &mut Router<'a> {
        match self.nodes.get_mut(usize::from(index)) {
            Some(node) => node.router(),
            None => &mut self.host,
        }
    }

    pub(super) fn is_complete(&self) -> bool {
        self.sums.iter().all(Option::is_some)
    }

    pub(super) fn nodes(&self) -> &[Node<'a, Toy>] {
        &self.nodes
    }

    /// A node dies: its router lives.
    pub(super) fn crash(&mut self, node: u16) {
        self.dead[usize::from(node)] = true;
    }

    /// What can happen now, losses and doublings apart.
    pub(super) fn actions(&mut self) -> Vec<Action> {
        let mut actions = Vec::new();
        let count = self.nodes.len() as u16;
        for node in 0..=self.nodes.len() as u16 {
            let ready = match self.next.get(usize::from(node)) {
                _ if self.dead.get(usize::from(node)) == Some(&true) => true,
                Some(Next::Now) | None => true,
                Some(Next::Wait { until, .. }) => *until <= self.now,
            };
            let mail = Channel::ALL.iter().any(|&c| self.router(node).arrived(c).is_some());
            let last = usize::from(node) == self.nodes.len();
            let dead = self.dead.get(usize::from(node)) == Some(&true);
            if mail && (last || dead) || ready && !last && !dead {
                actions.push(Action::Poll(node));
            }
            for port in 0..self.links[usize::from(node)].len() as u16 {
                if self.links[usize::from(node)][usize::from(port)].is_empty()
                    && self.can_transmit(node, port)
                {
                    actions.push(Action::Transmit(node, port));
                }
                if !self.links[usize::from(node)][usize::from(port)].is_empty() {
                    actions.push(Action::Deliver(node, port));
                }
            }
        }
        let heals = actions.is_empty()
            && (0..=count).filter(|&node| self.router(node).remind()).count() > 0;
        if actions.is_empty() && (heals || self.deadline() < Time::NEVER) {
            actions.push(Action::Wait);
        }
        actions
    }

    fn can_transmit(&mut self, node: u16, port: u16) -> bool {
        self.router(node).would_transmit(Port(port))
    }

    fn deadline(&self) -> Time {
        let alive = self.next.iter().zip(&self.dead).filter(|&(_, &dead)| !dead);
        let until = alive.map(|(next, _)| match next {
            Next::Now => self.now,
            Next::Wait { until, .. } => *until,
        });
        until.min().unwrap_or(Time::NEVER)
    }

    pub(super) fn act(&mut self, action: Action) {
        match action {
            Action::Poll(node) => self.poll(node),
            Action::Transmit(node, port) => {
                let mut room = [0; 4096];
                if let Some(len) = self.router(node).transmit(Port(port), &mut room) {
                    // Room to send: the node may go on.
                    if let Some(next) = self.next.get_mut(usize::from(node)) {
                        *next = Next::Now;
                    }
                    let link = &mut self.links[usize::from(node)][usize::from(port)];
                    link.push_back(room[..len].to_vec());
                }
            }
            Action::Deliver(node, port) => self.deliver(node, port, true),
            Action::Double(node, port) => self.deliver(node, port, false),
            Action::Drop(node, port) => {
                self.links[usize::from(node)][usize::from(port)].pop_front();
            }
            Action::Wait => {
                // Lost packets and credit heal on a timer.
                let heals = Time(self.now.0 + (1 << 14));
                self.now = self.deadline().min(heals).max(self.now);
            }
        }
    }

    fn deliver(&mut self, node: u16, port: u16, takes: bool) {
        let (from, port) = (self.id(node), Port(port));
        let far = self.mesh.neighbour(from, port).unwrap();
        let back = self.mesh.reverse(from, port).unwrap();
        let link = &mut self.links[usize::from(node)][usize::from(port.0)];
        let packet = if takes { link.pop_front() } else { link.front().cloned() }.unwrap();
        let index = self.index(far) as u16;
        let received = self.router(index).receive(back, &packet, |_| false);
        if let Some(next) = self.next.get_mut(usize::from(index)) {
            *next = Next::Now;
        }
        assert_ne!(received, Received::Bad, "{:?}", PacketHeader::split(&packet));
    }

    fn poll(&mut self, node: u16) {
        let now = self.now;
        if self.dead.get(usize::from(node)) == Some(&true) {
            // Its router drops what is for it.
            for channel in Channel::ALL {
                self.router(node).consume(channel);
            }
            return;
        }
        if let Some(actor) = self.nodes.get_mut(usize::from(node)) {
            self.next[usize::from(node)] = actor.poll(now).next;
            return;
        }
        self.host.consume(Channel::Reply);
        let Some((from, bytes)) = self.host.arrived(Channel::Request) else { return };
        if self.host.room(Channel::Reply) == 0 {
            return;
        }
        let mut out = [0; 256];
        let mut len = 0;
        for message in Items::new(bytes) {
            let tiles = self.setup.toy.tiles;
            let reply = match message {
                Message::Ask { number, count } => {
                    // Fresh tiles first, then any that is not there yet.
                    let count = count.min(tiles - self.given.min(tiles));
                    let (first, count) = if count > 0 {
                        self.given += count;
                        (self.given - count, count)
                    } else {
                        match self.sums.iter().position(Option::is_none) {
                            Some(tile) if now.0 > 1 << 22 => (tile as u32, 1),
                            _ => (0, 0),
                        }
                    };
                    Message::Grant { number, first, count, wait: 1 << 12 }
                }
                Message::Pixels { tile, first: 0, sums } => {
                    let sum: Sum = bytemuck::pod_read_unaligned(sums);
                    let place = &mut self.sums[tile as usize];
                    assert!(place.is_none_or(|before| before == sum), "two sums of a tile");
                    *place = Some(sum);
                    Message::Accepted { tile }
                }
                Message::Lost { block } => {
                    self.lost = Some(block);
                    continue;
                }
                other => panic!("{other:?}"),
            };
            len = write(&mut out, len, &reply).unwrap();
        }
        self.host.consume(Channel::Request);
        if len > 0 {
            self.host.inject(from, Channel::Reply, 3, &out[..len]).unwrap();
        }
    }
}
