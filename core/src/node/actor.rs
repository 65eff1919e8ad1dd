use super::group::Group;
use super::help::Helpers;
use super::outbox::Outbox;
use super::rom::Blocks;
use super::rules::Rule;
use super::slots::{FetchSlot, Onward, RaySlot, Root, RootState, Serve, Stage};
use super::tell::tell;
use super::tiles::Tiles;
use super::{
    Counts, Lack, Next, NodePlan, Prefetch, Progress, RayKind, Rom, Settings, ShadowPolicy, Time,
    Work, World,
};
use crate::network::{Channel, Mesh, NodeId, Router};
use crate::protocol::Message;
use crate::shade::{Shadow, Sum};
use crate::store::{Arena, ArenaFull, BlockCache, Budget, Line, Queue};

/// A node of a mesh: the actor, in the memory it was lent.
///
/// It never waits: [`poll`](Self::poll) does a few microseconds of work, [`router`](Self::router) is where links bring and fetch packets.
#[derive(Debug)]
pub struct Node<'a, W> {
    pub(super) world: W,
    pub(super) settings: Settings,
    pub(super) here: NodeId,
    pub(super) router: Router<'a>,
    pub(super) outbox: Outbox<'a>,
    pub(super) blocks: Blocks<'a>,
    pub(super) rays: &'a mut [RaySlot],
    /// Numbers of free ray slots; the first `free_len` count.
    pub(super) free: &'a mut [u16],
    pub(super) free_len: usize,
    /// Paths begun here; wraps.
    pub(super) begun: u32,
    /// Ray slots that wait for a block.
    pub(super) blocked: u16,
    /// Ray slots that can go on.
    pub(super) ready: Queue<'a, u16>,
    /// Shadow rays to be traced at the front, those that wait for a block at the end.
    pub(super) shadows: &'a mut [Shadow],
    /// Where those at the end go on, and those that do so.
    pub(super) onward: &'a mut [Onward],
    /// The block that each of those at the end waits for: all are gone through for each block that comes.
    pub(super) awaited: &'a mut [u32],
    pub(super) fresh: usize,
    /// So many of them, the last, have been looked at with their bundle.
    pub(super) looked_at: usize,
    /// Of these so many, the last, go on: the block that they waited for has come.
    pub(super) going: usize,
    pub(super) parked: usize,
    /// Shadow rays are traced until none is left to be: they are sorted.
    pub(super) draining: bool,
    /// The last sort was descending: the direction alternates.
    pub(super) turned: bool,
    /// Tiles first, then visits.
    pub(super) roots: &'a mut [Root],
    pub(super) tiles: Tiles,
    pub(super) group: Group<'a>,
    /// The sums of tile after tile.
    pub(super) sums: &'a mut [Sum],
    /// Visits among the roots.
    pub(super) visitors: u16,
    pub(super) fetches: &'a mut [FetchSlot],
    /// Those that stand for a block.
    pub(super) fetching: u16,
    /// Some fetch may be to be sent: while not, the table is not looked through for one.
    pub(super) unsent: bool,
    /// Some fetch may be complete: likewise.
    pub(super) complete: bool,
    /// Some ray waits for a block for which there was no frame.
    pub(super) starved: bool,
    /// The request packet that is being dealt with (rule 6).
    pub(super) inbox: &'a mut [u8],
    pub(super) inbox_at: usize,
    pub(super) inbox_len: usize,
    pub(super) inbox_from: NodeId,
    /// Blocks that are to be sent, the one that is being sent first.
    pub(super) serves: Queue<'a, Serve>,
    /// Bytes of the first that have been sent, beyond what it asked for.
    pub(super) served: usize,
    /// Bytes of a block in a message.
    pub(super) piece: usize,
    /// Nodes that have let a request wait in vain.
    pub(super) suspects: [u16; SUSPECTS],
    /// Nodes that would take some of its work.
    pub(super) helpers: Helpers,
    /// How often the first time limit of a fetch is halved, as packets are lost here rather than late.
    pub(super) haste: u8,
    /// How long fetches and rays have taken, smoothed.
    pub(super) fetch_time: Time,
    pub(super) ray_time: Time,
    /// No time limit passes before this moment.
    pub(super) next_deadline: Time,
    /// A block that no copy could be had of, to be reported.
    pub(super) lost: Option<u32>,
    pub(super) counts: Counts,
    /// Steps since another node has asked for something.
    pub(super) quiet: u8,
    /// Of the step that is being taken.
    pub(super) work: Work,
    /// A rule that a test has broken.
    #[cfg(test)]
    pub(super) broken: Option<super::rules::Rule>,
    budget: Budget,
}

/// Nodes that can be suspected at once.
pub(super) const SUSPECTS: usize = 8;

/// Rays that a step works on before it looks for messages again: others wait for this node's blocks.
const QUANTUM: u32 = 2;
/// The same of a node that nobody has asked for anything of late.
const QUANTUM_QUIET: u32 = 8;
/// Requests that a step deals with.
const REQUESTS: u32 = 16;

impl<'a, W: World> Node<'a, W> {
    /// The node of `mesh` that `rom` is the share of, in its arena.
    ///
    /// # Errors
    /// [`ArenaFull`] if the arena is smaller than the plan.
    pub fn new(
        arena: &mut Arena<'a>,
        plan: &NodePlan,
        budget: Budget,
        settings: Settings,
        rom: Rom<'a>,
        mesh: Mesh,
        world: W,
    ) -> Result<Self, ArenaFull> {
        let here = rom.here();
        // A shadow ray that migrates is a task of its own.
        let migrates = settings.schedule.migrates(RayKind::Shadow);
        let shadow = if migrates { ShadowPolicy::Keep } else { settings.shadow };
        // Who has all blocks need not look for those to fetch.
        let has_all = rom.len() >= settings.placement.blocks as usize;
        let prefetch = if has_all { Prefetch::Nearest(0) } else { settings.prefetch };
        let router = Router::new(arena, mesh, here, plan.router)?;
        let payload = plan.payload();
        let outbox = Outbox::new(
            arena.carve(plan.bundles)?,
            arena.carve(plan.bundles.saturating_mul(payload))?,
            payload,
        );
        let free: &mut [u16] = arena.carve(plan.rays)?;
        free.iter_mut().zip((0..plan.rays as u16).rev()).for_each(|(place, slot)| *place = slot);
        let pixels = plan.tiles.saturating_mul(plan.pixels());
        Ok(Self {
            world,
            settings: Settings { shadow, prefetch, ..settings },
            here,
            router,
            outbox,
            rays: arena.carve(plan.rays)?,
            free_len: free.len(),
            free,
            begun: 0,
            blocked: 0,
            ready: Queue::new(arena.carve(plan.rays)?),
            shadows: arena.carve(plan.shadows)?,
            onward: arena.carve(plan.shadows)?,
            awaited: arena.carve(plan.shadows)?,
            fresh: 0,
            looked_at: 0,
            going: 0,
            parked: 0,
            draining: false,
            turned: false,
            roots: arena.carve(plan.tiles.saturating_add(plan.visits))?,
            tiles: Tiles::new(plan.tiles, plan.pixels()),
            group: Group::new(here, arena.carve(plan.members)?),
            sums: arena.carve(pixels)?,
            visitors: 0,
            fetches: arena.carve(plan.fetches)?,
            fetching: 0,
            unsent: false,
            complete: false,
            starved: false,
            inbox: arena.carve(usize::from(plan.router.payload_of(Channel::Request)))?,
            inbox_at: 0,
            inbox_len: 0,
            inbox_from: NodeId(0),
            serves: Queue::new(arena.carve(plan.serves)?),
            served: 0,
            piece: plan.piece(),
            suspects: [u16::MAX; SUSPECTS],
            helpers: Helpers::NONE,
            haste: 0,
            fetch_time: Time(0),
            ray_time: Time(0),
            next_deadline: Time::NEVER,
            lost: None,
            counts: Counts::default(),
            quiet: 0,
            work: Work::default(),
            #[cfg(test)]
            broken: None,
            blocks: Blocks {
                cache: BlockCache::new(arena, plan.block_bytes, plan.frames)?,
                rom,
                #[cfg(test)]
                pins: false,
            },
            budget,
        })
    }

    /// The router, for its links.
    pub const fn router(&mut self) -> &mut Router<'a> {
        &mut self.router
    }

    /// What it computes.
    pub const fn world(&self) -> &W {
        &self.world
    }

    /// What it did so far.
    pub fn counts(&self) -> Counts {
        Counts { cache: self.blocks.cache.counts(), ..self.counts }
    }

    /// Its memory, line by line, with the most that each line ever held.
    #[must_use]
    pub fn budget(&self) -> Budget {
        let frames = self.blocks.cache.counts().frames_peak as usize;
        let packets = (self.router.packets_peak() as usize).saturating_add(self.outbox.peak());
        let mut budget = self.budget;
        budget.note_peaks(|line| match line.line {
            Line::Tables => line.capacity,
            Line::Frames | Line::FrameTable => frames,
            Line::Rays => self.counts.rays_peak as usize,
            Line::Bundles => self.counts.shadows_peak as usize,
            Line::Points => self.counts.visitors_peak as usize,
            Line::Tile => self.counts.tiles_peak as usize,
            Line::Messages => packets.saturating_add(usize::from(self.inbox_len > 0)),
        });
        budget
    }

    /// Rays, shadow rays and visits that it holds now.
    #[must_use]
    pub fn stored(&self) -> usize {
        self.rays.len() - self.free_len + self.fresh + self.parked + usize::from(self.visitors)
    }

    /// Takes a step.
    pub fn poll(&mut self, now: Time) -> Progress {
        self.work = Work::default();
        self.quiet = self.quiet.saturating_add(1);
        self.replies(now);
        self.requests(now, REQUESTS);
        if now >= self.next_deadline {
            self.deadlines(now);
        }
        // Blocks that come while shadow rays are gone through wait for the end of it: more rays come to need them meanwhile.
        let mut worked = u32::from(!self.draining && self.check_block(now));
        let quantum = if self.is_quiet() { QUANTUM_QUIET } else { QUANTUM };
        while worked < quantum {
            let rays = self.step(now);
            if rays == 0 {
                break;
            }
            worked = worked.saturating_add(rays);
        }
        // Behind the steps: nothing else tells that one of them has used a frame that others wait for.
        if self.starved && self.feed(now) {
            worked = worked.saturating_add(1);
        }
        // Before all else that wants room: requests for the block go on, and may take what there is each time.
        self.report_lost(now);
        self.answer_visits(now);
        self.send_tiles(now);
        self.send_fetches(now);
        let begun = self.begin_leased(now);
        self.answer_waiting(now);
        self.ask_for_tiles(now);
        let runnable = (worked > 0 || begun) && self.is_runnable();
        let age = self.settings.bundle_age;
        let all = !runnable && self.keeps(Rule::Flush);
        self.outbox.flush(&mut self.router, now, age, all, &mut self.counts, &mut self.work);
        #[cfg(debug_assertions)]
        self.check_invariants();
        let next = if runnable || self.has_mail() {
            Next::Now
        } else {
            // What is still in the outbox waits for room, which a link makes.
            let until = self.next_deadline.min(self.tiles.until(now));
            let lack = self.lack();
            #[cfg(feature = "bundles")]
            self.tiles.note_wait(lack);
            Next::Wait { until, lack }
        };
        Progress { work: self.work, next }
    }

    /// One unit of work: about how many rays it was, 0 if nothing can go on.
    fn step(&mut self, now: Time) -> u32 {
        if self.fresh == 0 {
            self.draining = false;
        }
        if self.draining || self.going > 0 || self.fresh > 0 && !self.has_shadow_room() {
            return self.light(now);
        }
        self.order_ready();
        let together = self.trace_together(now);
        if together > 0 {
            return together;
        }
        let mut stalled = 0;
        while stalled < self.ready.len() {
            let Some(slot) = self.ready.dequeue() else { break };
            if self.advance(slot, now) {
                return 1;
            }
            // Cannot go on for want of room: the others may.
            stalled = stalled.saturating_add(1);
            self.enqueue(slot);
        }
        if stalled > 0 {
            self.counts.stalls = self.counts.stalls.saturating_add(1);
        }
        if stalled == 0 && self.open_camera_rays() {
            return 1;
        }
        if self.fresh > 0 { self.light(now) } else { 0 }
    }

    fn is_runnable(&self) -> bool {
        self.fresh > 0
            || !self.ready.is_empty()
            || self.complete && self.fetches.iter().any(FetchSlot::is_complete)
            || self.can_open_camera_rays()
    }

    /// Whether a packet lies here that could be dealt with now.
    fn has_mail(&self) -> bool {
        let request = if self.inbox_at < self.inbox_len {
            self.can_answer()
        } else {
            self.router.arrived(Channel::Request).is_some()
        };
        request
            || self.router.arrived(Channel::Reply).is_some()
            || !self.serves.is_empty() && self.outbox.has_room(&self.router, Channel::Reply)
    }

    fn lack(&self) -> Lack {
        if self.fetching > 0 {
            Lack::Data
        } else if self.rays.iter().any(|slot| slot.stage() == Stage::Away) {
            Lack::Answers
        } else if !self.outbox.is_empty() {
            Lack::Credit
        } else if self.tiles.await_master() {
            Lack::Master
        } else {
            Lack::Tiles
        }
    }

    pub(super) fn push(&mut self, to: NodeId, message: &Message<'_>, now: Time) -> bool {
        let Self { outbox, router, counts, work, .. } = self;
        outbox.push(router, to, message, now, counts, work)
    }

    #[cfg_attr(not(feature = "bundles"), inline(never))]
    pub(super) fn enqueue(&mut self, slot: u16) {
        // There are as many places as slots, and a slot is in the queue once.
        let queued = self.ready.enqueue(slot);
        debug_assert!(queued, "a slot is queued once");
    }

    /// Counts what nobody waited for: it is dropped.
    pub(super) fn note_unasked(&mut self) {
        self.counts.unasked = self.counts.unasked.saturating_add(1);
    }

    /// Counts a packet of which the rest cannot be read: it is dropped.
    pub(super) fn note_damaged(&mut self) {
        tell!(warn, "node {}: a packet came damaged", self.here.0);
        self.counts.damaged = self.counts.damaged.saturating_add(1);
    }

    pub(super) fn note_deadline(&mut self, at: Time) {
        self.next_deadline = self.next_deadline.min(at);
    }

    /// Adds what a ray has brought to what waits for it.
    pub(super) fn add(&mut self, root: u16, pixel: u16, sum: Sum) {
        if let Some(place) = self.tiles.sum_of(usize::from(root), usize::from(pixel)) {
            if let Some(pixel) = self.sums.get_mut(place) {
                pixel.add(sum);
            }
        } else if let Some(root) = self.roots.get_mut(usize::from(root)) {
            root.sum.add(sum);
        }
    }

    /// So many more rays belong to a root.
    pub(super) fn open(&mut self, root: u16, rays: u32) {
        if let Some(root) = self.roots.get_mut(usize::from(root)) {
            root.open = root.open.saturating_add(rays);
        }
    }

    /// So many rays of a root have ended.
    pub(super) fn close(&mut self, root: u16, rays: u32) {
        let Some(root) = self.roots.get_mut(usize::from(root)) else { return };
        #[cfg(test)]
        self.blocks.cache.unpin();
        debug_assert!(root.open >= rays, "a ray ends once");
        root.open = root.open.saturating_sub(rays);
        if root.open == 0 {
            match root.state() {
                RootState::Visit => root.set_state(RootState::Answering),
                RootState::Rendering => root.set_state(RootState::Sending),
                _ => {}
            }
        }
    }

    /// Answers the visits that have ended. A visit keeps its answer until there is room for it (rule 3).
    fn answer_visits(&mut self, now: Time) {
        let visits = if self.visitors > 0 { self.tiles.len()..self.roots.len() } else { 0..0 };
        for at in visits {
            let Some(root) = self.roots.get(at) else { break };
            if root.state() != RootState::Answering {
                continue;
            }
            let (to, sum) = (root.to, root.sum);
            if !self.push(to.node(), &Message::Answer { to, sum }, now) {
                break;
            }
            self.free_root(at);
        }
    }

    pub(super) fn free_root(&mut self, at: usize) {
        if let Some(root) = self.roots.get_mut(at) {
            self.visitors = self.visitors.saturating_sub(u16::from(root.is_visit()));
            *root = bytemuck::Zeroable::zeroed();
        }
    }

    /// What it holds, in words.
    #[cfg(test)]
    pub(super) fn summary(&self) -> std::string::String {
        let rays: std::vec::Vec<_> = self
            .rays
            .iter()
            .map(|r| (r.stage(), r.root, r.trail().block(), r.ray.depth(), r.home, r.tries))
            .collect();
        let roots: std::vec::Vec<_> =
            self.roots.iter().map(|r| (r.state(), r.open, r.tile)).collect();
        let fetches: std::vec::Vec<_> =
            self.fetches.iter().map(|f| (f.block, f.state, f.tries)).collect();
        std::format!(
            "{} next {:?} mail {} rays {rays:?} ready {} free {} fresh {} parked {} draining {} roots {roots:?} fetches {fetches:?} starved {} tiles {:?} outbox empty {} serves {} inbox {}/{}",
            self.here.0,
            self.next_deadline,
            self.has_mail(),
            self.ready.len(),
            self.free_len,
            self.fresh,
            self.parked,
            self.draining,
            self.starved,
            self.tiles,
            self.outbox.is_empty(),
            self.serves.len(),
            self.inbox_at,
            self.inbox_len
        )
    }

    fn report_lost(&mut self, now: Time) {
        if let Some(block) = self.lost
            && self.push(crate::network::HOST, &Message::Lost { block }, now)
        {
            self.lost = None;
        }
    }
}
