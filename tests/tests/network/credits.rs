//! The two ends of a channel, model checked: the real transition functions on a wire that loses, doubles and reorders.

use std::collections::BTreeSet;

use kiloray_core::network::{Arrival, CreditReceiver, CreditSender, Sequence};
use stateright::{Checker, Model, Property};

/// What travels, either way. `serial` is the test's own number of a packet, which never wraps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
enum Flying {
    Packet { number: u16, serial: u8 },
    Probe { sent: u16 },
    Credit { limit: u16 },
}

#[derive(Debug, Clone, PartialEq, Eq, Hash)]
struct State {
    sender: CreditSender,
    receiver: CreditReceiver,
    wire: Vec<Flying>,
    sent: u8,
    accepted: BTreeSet<u8>,
    faults: u8,
    overrun: bool,
    doubled: bool,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
enum Step {
    Send,
    Probe,
    Deliver(usize),
    Lose(usize),
    Double(usize),
    Release,
    Credit,
}

struct Channel {
    capacity: u16,
    packets: u8,
    faults: u8,
    /// Messages on the wire at once; the test's bound, not the protocol's.
    wire: usize,
    /// Without, a rule is broken on purpose: a lost packet's credit is never given back.
    probes: bool,
}

impl Channel {
    fn finished(&self, s: &State) -> bool {
        s.sent == self.packets && s.receiver.held() == 0 && s.sender.available() == self.capacity
    }
}

impl Model for Channel {
    type State = State;
    type Action = Step;

    fn init_states(&self) -> Vec<State> {
        vec![State {
            sender: CreditSender::new(self.capacity),
            receiver: CreditReceiver::new(self.capacity),
            wire: Vec::new(),
            sent: 0,
            accepted: BTreeSet::new(),
            faults: self.faults,
            overrun: false,
            doubled: false,
        }]
    }

    fn actions(&self, s: &State, steps: &mut Vec<Step>) {
        let room = s.wire.len() < self.wire;
        if room && s.sent < self.packets && s.sender.available() > 0 {
            steps.push(Step::Send);
        }
        if room && self.probes {
            steps.push(Step::Probe);
        }
        if room {
            steps.push(Step::Credit);
        }
        if s.receiver.held() > 0 {
            steps.push(Step::Release);
        }
        for i in 0..s.wire.len() {
            steps.push(Step::Deliver(i));
            if s.faults > 0 {
                steps.push(Step::Lose(i));
                if room {
                    steps.push(Step::Double(i));
                }
            }
        }
    }

    fn next_state(&self, before: &State, step: Step) -> Option<State> {
        let mut s = before.clone();
        match step {
            Step::Send => {
                let Sequence(number) = s.sender.take()?;
                s.wire.push(Flying::Packet { number, serial: s.sent });
                s.sent += 1;
            }
            Step::Probe => s.wire.push(Flying::Probe { sent: s.sender.probe().0 }),
            Step::Credit => s.wire.push(Flying::Credit { limit: s.receiver.limit().0 }),
            Step::Release => s.receiver.release(),
            Step::Lose(i) => {
                s.wire.remove(i);
                s.faults -= 1;
            }
            Step::Double(i) => {
                s.wire.push(s.wire[i]);
                s.faults -= 1;
            }
            Step::Deliver(i) => match s.wire.remove(i) {
                Flying::Packet { number, serial } => {
                    if let Arrival::Accepted { .. } = s.receiver.receive(Sequence(number)) {
                        s.doubled |= !s.accepted.insert(serial);
                        s.overrun |= s.receiver.held() > self.capacity;
                    }
                }
                Flying::Probe { sent } => {
                    s.receiver.probe(Sequence(sent));
                }
                Flying::Credit { limit } => s.sender.grant(Sequence(limit)),
            },
        }
        // The wire is a set: order on it does not matter, since any message may be delivered next.
        s.wire.sort_unstable();
        (s != *before).then_some(s)
    }

    fn properties(&self) -> Vec<Property<Self>> {
        vec![
            Property::always("no buffer overruns", |_, s: &State| !s.overrun),
            Property::always("no packet counts twice", |_, s: &State| !s.doubled),
            Property::always("credit never exceeds room", |m: &Self, s: &State| {
                s.sender.available() + s.receiver.held() <= m.capacity
            }),
            Property::sometimes("finished", |m: &Self, s: &State| m.finished(s)),
        ]
    }
}

fn channel(capacity: u16, faults: u8, probes: bool) -> Channel {
    Channel { capacity, packets: 4, faults, wire: 3, probes }
}

/// Whether the finished state can be reached from every state that can be reached.
fn always_finishes(model: &Channel) -> bool {
    let mut states = model.init_states();
    let mut index: std::collections::BTreeMap<String, usize> = Default::default();
    index.insert(format!("{:?}", states[0]), 0);
    let mut before: Vec<Vec<usize>> = vec![Vec::new()];
    let mut at = 0;
    while at < states.len() {
        let mut steps = Vec::new();
        model.actions(&states[at], &mut steps);
        for step in steps {
            let Some(next) = model.next_state(&states[at], step) else { continue };
            let to = *index.entry(format!("{next:?}")).or_insert_with(|| {
                states.push(next);
                before.push(Vec::new());
                states.len() - 1
            });
            before[to].push(at);
        }
        at += 1;
    }
    let mut good: Vec<bool> = states.iter().map(|s| model.finished(s)).collect();
    let mut queue: Vec<usize> = (0..states.len()).filter(|&i| good[i]).collect();
    while let Some(to) = queue.pop() {
        for &from in &before[to] {
            if !std::mem::replace(&mut good[from], true) {
                queue.push(from);
            }
        }
    }
    good.iter().all(|&g| g)
}

#[test]
fn credits_hold_under_loss_doubling_and_reordering() {
    for capacity in 1..=2 {
        for faults in 0..=2 {
            channel(capacity, faults, true).checker().spawn_bfs().join().assert_properties();
        }
    }
}

#[test]
fn credit_always_comes_back() {
    for capacity in 1..=2 {
        assert!(always_finishes(&channel(capacity, 1, true)), "capacity {capacity}");
    }
}

#[test]
fn without_probes_a_lost_packet_is_lost_credit() {
    assert!(!always_finishes(&channel(1, 1, false)));
}
