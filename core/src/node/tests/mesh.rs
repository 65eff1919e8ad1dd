//! A mesh of nodes over a toy scene, whose every step is somebody's choice.

use super::super::rules::Rule;
use super::super::*;
use super::state::{NOW, Timer};
use super::toy::Toy;
use crate::network::{
    Channel, HOST, Mesh, NodeId, PacketHeader, Port, Received, Router, RouterSize, Topology,
};
use crate::protocol::{Items, Message, unpack, write};
use crate::shade::Sum;
use crate::store::{Arena, CHUNK_BYTES, Chunk};
use std::collections::VecDeque;

/// What a mesh is made of.
#[derive(Debug, Clone, Copy)]
pub(super) struct Setup {
    pub(super) topology: Topology,
    pub(super) toy: Toy,
    pub(super) schedule: Schedule,
    pub(super) shadow: ShadowPolicy,
    pub(super) points: PointHome,
    pub(super) top: u32,
    pub(super) replicas: u16,
    pub(super) refusals: u8,
    pub(super) group: u16,
    pub(super) order: TaskOrder,
    /// Memory beyond the least.
    pub(super) more: More,
    /// Bundles do not wait for company.
    pub(super) hasty: bool,
    /// Time goes on, and time limits pass when they do. Otherwise each is somebody's choice: when nothing else
    /// can happen, or too early as a fault.
    pub(super) timed: bool,
    /// Packets are at most on one link at a time, the host and credit without data do not wait: fewer states.
    pub(super) fused: bool,
    /// What may go wrong yet.
    pub(super) faults: Faults,
    pub(super) broken: Option<Broken>,
}

/// Lengths beyond the least.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct More {
    pub(super) rays: usize,
    pub(super) visits: usize,
    pub(super) shadows: usize,
    pub(super) fetches: usize,
    pub(super) frames: usize,
    pub(super) bundles: usize,
    pub(super) tiles: usize,
}

/// Faults, by kind.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Faults {
    pub(super) losses: u8,
    /// Packets that arrive twice.
    pub(super) doubles: u8,
    pub(super) crashes: u8,
    /// Time limits that pass early.
    pub(super) early: u8,
    /// Tiles that the host takes for overdue, and gives to another node as well.
    pub(super) overdue: u8,
}

/// A rule that is broken on purpose.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Broken {
    Node(Rule),
    /// 1: requests and replies share their buffers on links.
    OneChannel,
    /// 2: a ring without a dateline.
    NoDateline,
    /// Nobody asks for credit that is overdue.
    NoReminder,
}

/// Something that can happen. The host counts as the last node.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Action {
    /// A node takes a step.
    Poll(u16),
    /// A packet leaves a node over a port.
    Transmit(u16, u16),
    /// The oldest packet on a link arrives.
    Deliver(u16, u16),
    /// Both.
    Hop(u16, u16),
    /// It is lost.
    Lose(u16, u16),
    /// It arrives, and stays on the link too.
    Double(u16, u16),
    /// A node dies.
    Crash(u16),
    /// A time limit passes.
    Expire(u16, Timer),
    /// It passes early.
    Early(u16, Timer),
    /// Overdue credit is asked for.
    Remind,
    /// Time goes on to the next time limit.
    Wait,
}

/// Nodes, links and the host.
pub(super) struct World<'a> {
    pub(super) setup: Setup,
    pub(super) mesh: Mesh,
    pub(super) nodes: Vec<Node<'a, Toy>>,
    pub(super) next: Vec<Next>,
    pub(super) dead: Vec<bool>,
    pub(super) host: Router<'a>,
    /// Packets under way from a node by a port.
    pub(super) links: Vec<Vec<VecDeque<Vec<u8>>>>,
    pub(super) given: u32,
    /// The last grant of each node: its number, the first tile, how many.
    pub(super) grants: Vec<[u32; 3]>,
    pub(super) sums: Vec<Option<Sum>>,
    /// A tile came to something else than it should.
    pub(super) wrong: bool,
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
            shadow: self.shadow,
            points: self.points,
            group: self.group,
            side: 1,
            packet: 0,
            depth: 1,
            host_depth: 0,
        };
        let mut plan = NodePlan::least(&needs);
        let More { rays, visits, shadows, fetches, frames, bundles, tiles } = self.more;
        plan.rays += rays;
        if plan.visits > 0 {
            plan.visits += visits;
        }
        if plan.shadows > 0 {
            plan.shadows += shadows;
        }
        if remote > 0 {
            plan.frames += frames;
            plan.fetches += fetches;
        }
        plan.bundles += bundles;
        plan.tiles += tiles;
        plan
    }
}

impl<'a> World<'a> {
    pub(super) fn new(setup: &Setup, memory: &'a mut [Vec<Chunk>], blocks: &'a [u8]) -> Self {
        let mesh = Mesh::new(setup.topology);
        let (host_memory, node_memory) = memory.split_last_mut().unwrap();
        let settings = Settings {
            schedule: setup.schedule,
            shadow: setup.shadow,
            points: setup.points,
            placement: setup.placement(),
            refusals: setup.refusals,
            prefetch: Prefetch::Nearest(0),
            order: setup.order,
            patience: Time(1 << 20),
            bundle_age: Time(if setup.hasty { 0 } else { 1 << 12 }),
            group: setup.group,
            deaths_told: false,
        };
        let nodes: Vec<_> = node_memory
            .iter_mut()
            .zip(0..)
            .map(|(memory, node)| {
                let here = NodeId(node);
                let plan = setup.node_plan(here);
                let rom = Rom::of_file(blocks, setup.toy.block_bytes, settings.placement, here);
                let budget = plan.budget(usize::MAX).unwrap();
                let mut arena = Arena::new(memory);
                let node = Node::new(&mut arena, &plan, budget, settings, rom, mesh, setup.toy);
                let mut node = node.unwrap();
                if let Some(Broken::Node(rule)) = setup.broken {
                    node.broken = Some(rule);
                    node.blocks.pins = rule == Rule::FrameFree;
                }
                node.router().one_channel = setup.broken == Some(Broken::OneChannel);
                node
            })
            .collect();
        let payload = NodePlan::packet_min(setup.toy.block_bytes) as u16;
        let size = RouterSize::new(&mesh, HOST, 1, payload);
        let mut arena = Arena::new(host_memory);
        let mut host = Router::new(&mut arena, mesh, HOST, size).unwrap();
        host.one_channel = setup.broken == Some(Broken::OneChannel);
        let count = nodes.len();
        let links = (0..mesh.nodes())
            .map(NodeId)
            .chain([HOST])
            .map(|node| vec![VecDeque::new(); mesh.ports(node).into()])
            .collect();
        Self {
            setup: *setup,
            mesh,
            nodes,
            next: vec![Next::Now; count],
            dead: vec![false; count],
            host,
            links,
            given: 0,
            grants: vec![[u32::MAX, 0, 0]; count],
            sums: vec![None; setup.toy.tiles as usize],
            wrong: false,
            lost: None,
            now: if setup.timed { Time(0) } else { NOW },
        }
    }

    pub(super) fn id(&self, index: u16) -> NodeId {
        if usize::from(index) == self.nodes.len() { HOST } else { NodeId(index) }
    }

    pub(super) fn index(&self, node: NodeId) -> u16 {
        if node == HOST { self.nodes.len() as u16 } else { node.0 }
    }

    pub(super) fn router(&mut self, index: u16) -> &mut Router<'a> {
        match self.nodes.get_mut(usize::from(index)) {
            Some(node) => node.router(),
            None => &mut self.host,
        }
    }

    fn is_dead(&self, index: u16) -> bool {
        self.dead.get(usize::from(index)) == Some(&true)
    }

    pub(super) fn link(&mut self, node: u16, port: u16) -> &mut VecDeque<Vec<u8>> {
        &mut self.links[usize::from(node)][usize::from(port)]
    }

    /// Whether the picture is complete.
    pub(super) fn is_complete(&self) -> bool {
        self.sums.iter().all(Option::is_some)
    }

    /// Whether the picture is complete and all buffers, slots and frames are free again.
    pub(super) fn is_finished(&mut self) -> bool {
        let mut nodes = self.nodes.iter_mut().zip(&self.dead);
        self.sums.iter().all(Option::is_some)
            && self.links.iter().flatten().all(VecDeque::is_empty)
            && self.host.is_idle()
            && nodes.all(|(node, &dead)| match dead {
                true => node.router().is_idle(),
                false => node.is_empty(),
            })
    }

    /// What can happen now, faults apart.
    pub(super) fn actions(&mut self) -> Vec<Action> {
        let mut actions = Vec::new();
        for node in 0..=self.nodes.len() as u16 {
            if self.can_poll(node) {
                actions.push(Action::Poll(node));
            }
            for port in 0..self.links[usize::from(node)].len() as u16 {
                if !self.link(node, port).is_empty() {
                    actions.push(Action::Deliver(node, port));
                } else if self.router(node).is_ready(Port(port)) {
                    let hops = self.setup.fused;
                    actions.push(if hops { Action::Hop } else { Action::Transmit }(node, port));
                }
            }
        }
        if self.setup.timed {
            let heals = actions.is_empty() && self.remind();
            if actions.is_empty() && (heals || self.deadline() < Time::NEVER) {
                actions.push(Action::Wait);
            }
            return actions;
        }
        actions.extend(self.timers(|timer| matches!(timer, Timer::Refused(_))));
        // Overdue credit is asked for much sooner than a time limit passes.
        let heals = self.setup.broken != Some(Broken::NoReminder) && self.is_credit_out();
        if actions.is_empty() && heals {
            actions.push(Action::Remind);
        } else if actions.is_empty() {
            // Who was told that there is no tile may be given one later.
            let more = self.setup.group > 0 || self.dead.contains(&true);
            let asks = more && !self.is_complete();
            actions.extend(self.timers(|timer| timer != Timer::Dry || asks));
        }
        actions
    }

    /// What can go wrong now.
    pub(super) fn faults(&mut self) -> Vec<Action> {
        let mut actions = Vec::new();
        let left = self.setup.faults;
        for node in 0..=self.nodes.len() as u16 {
            if left.crashes > 0 && node > 0 && node < self.nodes.len() as u16 && !self.is_dead(node)
            {
                actions.push(Action::Crash(node));
            }
            for port in 0..self.links[usize::from(node)].len() as u16 {
                let full = !self.link(node, port).is_empty();
                if full || self.setup.fused && self.router(node).is_ready(Port(port)) {
                    actions.extend((left.losses > 0).then_some(Action::Lose(node, port)));
                    actions.extend((left.doubles > 0).then_some(Action::Double(node, port)));
                }
            }
        }
        if left.early > 0 {
            let timers = self.timers(|timer| !matches!(timer, Timer::Refused(_) | Timer::Dry));
            actions.extend(timers.into_iter().map(|action| match action {
                Action::Expire(node, timer) => Action::Early(node, timer),
                other => other,
            }));
        }
        actions
    }

    fn can_poll(&mut self, node: u16) -> bool {
        let is_host = usize::from(node) == self.nodes.len();
        if is_host || self.is_dead(node) {
            return Channel::ALL.iter().any(|&c| self.router(node).arrived(c).is_some())
                && (!is_host || self.host.room(Channel::Reply) > 0);
        }
        match self.next[usize::from(node)] {
            Next::Now => true,
            Next::Wait { until, .. } => self.setup.timed && until <= self.now,
        }
    }

    fn timers(&mut self, filter: impl Fn(Timer) -> bool) -> Vec<Action> {
        let mut actions = Vec::new();
        for (node, at) in self.nodes.iter_mut().zip(0_u16..) {
            if !self.dead[usize::from(at)] {
                let timers = node.timers().into_iter().filter(|&timer| filter(timer));
                actions.extend(timers.map(|timer| Action::Expire(at, timer)));
            }
        }
        actions
    }

    fn remind(&mut self) -> bool {
        (0..=self.nodes.len() as u16).filter(|&node| self.router(node).remind()).count() > 0
    }

    fn is_credit_out(&mut self) -> bool {
        (0..=self.nodes.len() as u16).any(|node| self.router(node).is_credit_out())
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
            Action::Transmit(node, port) => self.transmit(node, port),
            Action::Deliver(node, port) => self.deliver(node, port, true),
            Action::Double(node, port) => {
                self.setup.faults.doubles = self.setup.faults.doubles.saturating_sub(1);
                if self.link(node, port).is_empty() {
                    self.transmit(node, port);
                }
                self.deliver(node, port, false);
            }
            Action::Hop(node, port) => {
                self.transmit(node, port);
                self.deliver(node, port, true);
            }
            Action::Lose(node, port) => {
                self.setup.faults.losses = self.setup.faults.losses.saturating_sub(1);
                if self.link(node, port).is_empty() {
                    self.transmit(node, port);
                }
                self.link(node, port).pop_front();
            }
            Action::Crash(node) => {
                self.setup.faults.crashes = self.setup.faults.crashes.saturating_sub(1);
                self.dead[usize::from(node)] = true;
            }
            Action::Expire(node, timer) => {
                self.nodes[usize::from(node)].expire(timer);
                self.poll(node);
            }
            Action::Early(node, timer) => {
                self.setup.faults.early = self.setup.faults.early.saturating_sub(1);
                self.nodes[usize::from(node)].expire(timer);
                self.poll(node);
            }
            Action::Remind => {
                self.remind();
            }
            Action::Wait => {
                // Lost packets and credit heal on a timer.
                let heals = Time(self.now.0 + (1 << 14));
                self.now = self.deadline().min(heals).max(self.now);
            }
        }
        if self.setup.fused {
            self.settle();
        }
    }

    /// What does not wait: credit without data, and the host.
    fn settle(&mut self) {
        loop {
            let host = self.nodes.len() as u16;
            if self.can_poll(host) {
                self.poll(host);
                continue;
            }
            let mut ports = (0..=host)
                .flat_map(|node| {
                    (0..self.links[usize::from(node)].len() as u16).map(move |port| (node, port))
                })
                .collect::<Vec<_>>()
                .into_iter();
            let control = ports.find(|&(node, port)| self.router(node).would_tell(Port(port)));
            let Some((node, port)) = control else { break };
            self.transmit(node, port);
            self.deliver(node, port, true);
        }
    }

    fn transmit(&mut self, node: u16, port: u16) {
        let mut room = [0; 4096];
        let before = Channel::ALL.map(|channel| self.router(node).room(channel));
        let Some(len) = self.router(node).transmit(Port(port), &mut room) else { return };
        let after = Channel::ALL.map(|channel| self.router(node).room(channel));
        if after != before {
            // Room to send: the node may go on.
            self.wake(node);
        }
        self.link(node, port).push_back(room[..len].to_vec());
    }

    fn wake(&mut self, node: u16) {
        if let Some(next) = self.next.get_mut(usize::from(node)) {
            *next = Next::Now;
        }
    }

    fn deliver(&mut self, node: u16, port: u16, takes: bool) {
        let (from, port) = (self.id(node), Port(port));
        let far = self.mesh.neighbour(from, port).unwrap();
        let back = self.mesh.reverse(from, port).unwrap();
        let link = self.link(node, port.0);
        let packet = if takes { link.pop_front() } else { link.front().cloned() }.unwrap();
        let index = self.index(far);
        let flat = self.setup.broken == Some(Broken::NoDateline);
        let router = self.router(index);
        let received = router.receive(back, &packet, |_| false);
        if flat {
            router.flatten();
        }
        if Channel::ALL.iter().any(|&channel| router.arrived(channel).is_some()) {
            self.wake(index);
        }
        assert_ne!(received, Received::Bad, "{:?}", PacketHeader::split(&packet));
    }

    fn poll(&mut self, node: u16) {
        let now = self.now;
        if self.is_dead(node) {
            // Its router drops what is for it, and tells who has asked.
            let router = self.router(node);
            if let Some((sender, _)) = router.arrived(Channel::Request) {
                signal(router, sender, &Message::Gone);
            }
            for channel in Channel::ALL {
                router.consume(channel);
            }
            return;
        }
        let flat = self.setup.broken == Some(Broken::NoDateline);
        if let Some(actor) = self.nodes.get_mut(usize::from(node)) {
            self.next[usize::from(node)] = actor.poll(now).next;
            actor.check_invariants();
            if flat {
                actor.router().flatten();
            }
            return;
        }
        self.poll_host();
    }

    fn poll_host(&mut self) {
        self.host.consume(Channel::Reply);
        let Some((from, bytes)) = self.host.arrived(Channel::Request) else { return };
        if self.host.room(Channel::Reply) == 0 {
            return;
        }
        // What a dead node had is given again: no other tile is ever missed for good.
        let lost = self.dead.contains(&true);
        let overdue = &mut self.setup.faults.overdue;
        let mut out = [0; 256];
        let mut len = 0;
        for message in Items::new(bytes) {
            let reply = match message {
                Message::Ask { number, count } => {
                    let asker = &mut self.grants[usize::from(from.0)];
                    if asker[0] != number {
                        let tiles = self.setup.toy.tiles;
                        // Fresh tiles first, then any that is not there yet.
                        let count = count.min(tiles - self.given.min(tiles));
                        let missing = self.sums.iter().position(Option::is_none);
                        let late = if self.setup.timed { self.now.0 > 1 << 22 } else { lost };
                        *asker = match missing.filter(|_| late || *overdue > 0) {
                            _ if count > 0 => [number, self.given, count],
                            Some(tile) => {
                                *overdue = overdue.saturating_sub(1);
                                [number, tile as u32, 1]
                            }
                            // A node that may have work: all in turn.
                            None => [number, number % self.nodes.len() as u32, 0],
                        };
                        self.given += count;
                    }
                    let [number, first, count] = *asker;
                    Message::Grant { number, first, count, wait: 1 << 12 }
                }
                Message::Pixels { tile, first: 0, width, sums } => {
                    let sum = unpack(sums, width).and_then(|mut sums| sums.next()).unwrap();
                    self.wrong |= sum != self.setup.toy.expected(tile);
                    self.sums[tile as usize] = Some(sum);
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
        if self.setup.broken == Some(Broken::NoDateline) {
            self.host.flatten();
        }
    }

    /// What the nodes hold, in words.
    pub(super) fn summary(&self) -> Vec<String> {
        self.nodes.iter().map(Node::summary).collect()
    }
}
