use std::time::{Duration, Instant};

use kiloray_core::network::{NodeId, PacketHeader, Port, Received};
use kiloray_core::node::{Actor, Lack, Next, Time};
use kiloray_mesh::watch::{Sight, Waits, Watch};
use serde::{Deserialize, Serialize};

use crate::{Event, Job, Place, Transport};

/// How an actor is driven.
#[derive(Debug, Clone)]
pub struct Drive {
    /// The beginning of its time.
    pub start: Instant,
    /// Ports that lead to a neighbour. It begins when all are there, or a while has passed.
    pub joined: Vec<Port>,
    /// Ports, used or not.
    pub ports: u16,
    /// Greatest packet, header included \[bytes\].
    pub packet: usize,
    /// Bytes of a block.
    pub block_bytes: usize,
}

impl Drive {
    /// Of a place in a job, whose time begins at `start`.
    #[must_use]
    pub fn new(start: Instant, job: &Job, place: Place) -> Self {
        Self {
            start,
            joined: job.neighbours(place).into_iter().map(|(port, _)| port).collect(),
            ports: job.mesh.ports(place.id()),
            packet: usize::from(job.layout.packet()),
            block_bytes: job.layout.block_bytes(),
        }
    }
}

/// Where the time of a process went \[ns\].
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub struct Spent {
    /// In steps of the actor.
    pub busy_ns: u64,
    /// Taking packets from the network and handing them to it.
    pub network_ns: u64,
    /// Idle, as blocks were awaited.
    pub idle_data_ns: u64,
    /// Idle, as answers to rays were awaited.
    pub idle_answers_ns: u64,
    /// Idle, as there was no room to send.
    pub idle_credit_ns: u64,
    /// Idle, as the master had not answered.
    pub idle_master_ns: u64,
    /// Idle without work.
    pub idle_work_ns: u64,
    /// Before all neighbours were there.
    pub start_ns: u64,
    /// Of a processor, for the thread that drives; from when all neighbours were there. 0 where the system does not tell.
    pub driver_cpu_ns: u64,
    /// The same of all threads of the process: the rest is the network's.
    pub process_cpu_ns: u64,
    /// Steps of the actor.
    pub steps: u64,
    /// Packets sent, those that bring credit only included.
    pub packets_sent: u64,
    /// Bytes of these.
    pub bytes_sent: u64,
    /// Packets that came.
    pub packets_received: u64,
    /// Packets for neighbours that were not there, dropped.
    pub dropped: u64,
}

impl Spent {
    /// From when all neighbours were there to the end \[ns\].
    pub const fn all_ns(&self) -> u64 {
        let waits = self.idle_data_ns + self.idle_answers_ns + self.idle_credit_ns;
        self.busy_ns + self.network_ns + waits + self.idle_master_ns + self.idle_work_ns
    }

    fn idle(&mut self, lack: Lack) -> &mut u64 {
        match lack {
            Lack::Data => &mut self.idle_data_ns,
            Lack::Answers => &mut self.idle_answers_ns,
            Lack::Credit => &mut self.idle_credit_ns,
            Lack::Master => &mut self.idle_master_ns,
            Lack::Tiles => &mut self.idle_work_ns,
        }
    }
}

/// How often overdue credit is asked for: links lose packets only when a neighbour comes or goes.
const REMINDER: Duration = Duration::from_millis(250);
/// How often whoever drives looks whether it is over.
const LOOK: Duration = Duration::from_millis(50);
/// How long a beginning waits for neighbours that are not there: one may be dead for good.
const PATIENCE: Duration = Duration::from_secs(10);

/// Runs an actor over a transport until `is_over`, which is asked between its steps.
///
/// A neighbour that is not there is a link that loses everything: what waits to be sent to it is dropped, so that nothing stands behind it. One that
/// comes again as another process finds a link of which nothing was used.
pub fn drive<'m, A: Actor<'m>, T: Transport>(
    actor: &mut A,
    transport: &mut T,
    drive: &Drive,
    mut is_over: impl FnMut(&mut A, &mut T) -> bool,
) -> (Spent, Waits) {
    let mut this = Driver {
        transport,
        here: actor.router().here(),
        watch: Watch::new(drive.block_bytes, 0),
        packet: vec![0; drive.packet],
        up: vec![false; usize::from(drive.ports)],
        spent: Spent::default(),
    };
    let now = || nanoseconds(drive.start.elapsed());
    let begin = now();
    let all_there = |up: &[bool]| drive.joined.iter().all(|port| up[usize::from(port.0)]);
    while !all_there(&this.up) && now() - begin < nanoseconds(PATIENCE) {
        if is_over(actor, this.transport) {
            return (this.spent, Waits::default());
        }
        this.take(actor, now());
        this.transport.wait(LOOK);
    }
    let mut last = now();
    this.spent.start_ns = last - begin;
    let processor = Processor::now();
    let mut remind = last + nanoseconds(REMINDER);
    while !is_over(actor, this.transport) {
        if last >= remind {
            actor.router().remind();
            remind = last + nanoseconds(REMINDER);
        }
        // Most steps are short, and neither follow nor make packets: one look at the clock does for those.
        let taken = if this.take(actor, last) { now() } else { last };
        let next = actor.poll(Time(taken));
        this.spent.steps += 1;
        let polled = now();
        let sent = this.give(actor, polled);
        let given = if sent { now() } else { polled };
        this.spent.busy_ns += polled - taken;
        this.spent.network_ns += taken - last + (given - polled);
        last = given;
        // What has left has made room: the actor may go on.
        if let Next::Wait { until, lack } = next
            && !sent
        {
            let until = until.0.min(remind).min(given + nanoseconds(LOOK));
            this.transport.wait(Duration::from_nanos(until.saturating_sub(given)));
            last = now();
            *this.spent.idle(lack) += last - given;
        }
    }
    let used = Processor::now();
    this.spent.driver_cpu_ns = used.driver_ns.saturating_sub(processor.driver_ns);
    this.spent.process_cpu_ns = used.process_ns.saturating_sub(processor.process_ns);
    (this.spent, this.watch.waits().clone())
}

/// What this thread and its process have had of the processors since they began \[ns\].
#[derive(Clone, Copy)]
struct Processor {
    driver_ns: u64,
    process_ns: u64,
}

impl Processor {
    #[cfg(unix)]
    fn now() -> Self {
        use rustix::time::{ClockId, clock_gettime};
        let read = |clock| {
            let time = clock_gettime(clock);
            (time.tv_sec as u64).saturating_mul(1_000_000_000).saturating_add(time.tv_nsec as u64)
        };
        Self { driver_ns: read(ClockId::ThreadCPUTime), process_ns: read(ClockId::ProcessCPUTime) }
    }

    #[cfg(not(unix))]
    const fn now() -> Self {
        Self { driver_ns: 0, process_ns: 0 }
    }
}

struct Driver<'t, T> {
    transport: &'t mut T,
    /// Whose packets begin and end here.
    here: NodeId,
    watch: Watch,
    packet: Vec<u8>,
    /// By port: whether the neighbour is there.
    up: Vec<bool>,
    spent: Spent,
}

impl<T: Transport> Driver<'_, T> {
    /// Takes what the network has brought until now: whether there was anything.
    fn take<'m>(&mut self, actor: &mut impl Actor<'m>, now: u64) -> bool {
        let mut any = false;
        while let Some(event) = self.transport.next(&mut self.packet) {
            let router = actor.router();
            match event {
                Event::Packet { port, len } => {
                    self.spent.packets_received += 1;
                    let packet = self.packet.get(..len).unwrap_or_default();
                    let received = router.receive(port, packet, |_| false);
                    if let Some((header, payload)) = PacketHeader::split(packet)
                        && received == Received::Buffered
                        && header.to() == self.here
                    {
                        let seen = Sight::arriving(header.from(), self.here, payload);
                        seen.for_each(|sight| self.watch.see(now, sight));
                    }
                }
                Event::Up { port, is_new } => {
                    if is_new {
                        router.renew(port);
                    }
                    self.set(port, true);
                }
                Event::Down { port } => {
                    self.set(port, false);
                    self.spent.dropped += u64::from(router.cut(port));
                }
            }
            any = true;
        }
        any
    }

    fn set(&mut self, port: Port, is_up: bool) {
        if let Some(place) = self.up.get_mut(usize::from(port.0)) {
            *place = is_up;
        }
    }

    /// Hands to the network what can leave now: whether there was anything.
    fn give<'m>(&mut self, actor: &mut impl Actor<'m>, now: u64) -> bool {
        let router = actor.router();
        let mut any = false;
        // What leaves by one port can let something leave by another.
        loop {
            let changed = router.take_changed();
            if changed == 0 {
                if any {
                    self.transport.flush();
                }
                return any;
            }
            for (port, is_up) in (0..).map(Port).zip(&self.up) {
                if changed & bit(port) == 0 {
                    continue;
                }
                if !is_up {
                    self.spent.dropped += u64::from(router.cut(port));
                    continue;
                }
                while let Some(len) = router.transmit(port, &mut self.packet) {
                    let packet = self.packet.get(..len).unwrap_or_default();
                    self.transport.send(port, packet);
                    if let Some((header, payload)) = PacketHeader::split(packet)
                        && header.kind == PacketHeader::DATA
                        && header.from() == self.here
                    {
                        let seen = Sight::leaving(self.here, header.to(), now, payload);
                        seen.for_each(|sight| self.watch.see(now, sight));
                    }
                    self.spent.packets_sent += 1;
                    self.spent.bytes_sent += len as u64;
                    any = true;
                }
            }
        }
    }
}

/// As routers have it: ports beyond the first 64 share bits with those before.
fn bit(port: Port) -> u64 {
    1 << (port.0 % 64)
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}
