//! The state of a whole mesh, for its checker.

use super::super::*;
use super::mesh::{Faults, World};
use crate::network::{LANES, PacketHeader, Port};
use crate::shade::Sum;
use crate::tests::snapshot::Snapshot;

impl World<'_> {
    /// Writes or reads all of it; what behaves alike is made alike before.
    pub(super) fn snapshot(&mut self, s: &mut Snapshot) {
        self.rebase();
        let faults = &mut self.setup.faults;
        let Faults { losses, doubles, crashes, early, overdue } = faults;
        for left in [losses, doubles, crashes, early, overdue] {
            s.pod(left);
        }
        for at in 0..self.nodes.len() {
            let mut ready = self.next[at] == Next::Now;
            s.bool(&mut ready);
            let (until, lack) = (Time::NEVER, Lack::Tiles);
            self.next[at] = if ready { Next::Now } else { Next::Wait { until, lack } };
            s.bool(&mut self.dead[at]);
            match self.dead[at] {
                true => self.nodes[at].router().snapshot(s),
                false => self.nodes[at].snapshot(s),
            }
        }
        self.host.snapshot(s);
        for link in self.links.iter_mut().flatten() {
            let mut packets = Vec::from(core::mem::take(link));
            s.list(&mut packets, |s, packet| s.list(packet, Snapshot::pod));
            *link = packets.into();
        }
        s.pod(&mut self.given);
        s.all(self.grants.as_flattened_mut());
        for sum in &mut self.sums {
            let mut known = sum.is_some();
            let mut value = sum.unwrap_or(Sum::ZERO);
            s.bool(&mut known);
            s.pod(&mut value);
            *sum = known.then_some(value);
        }
        s.bool(&mut self.wrong);
        let mut lost = self.lost.map_or(0, |block| block + 1);
        s.pod(&mut lost);
        self.lost = lost.checked_sub(1);
    }

    /// Counts the packets of each link and lane from the last that has arrived.
    fn rebase(&mut self) {
        for node in 0..=self.nodes.len() as u16 {
            for port in 0..self.links[usize::from(node)].len() as u16 {
                let from = self.id(node);
                let Some(far) = self.mesh.neighbour(from, Port(port)) else { continue };
                let back = self.mesh.reverse(from, Port(port)).unwrap();
                let far = self.index(far);
                let seen = self.router(far).seen(back);
                if seen == [0; LANES] {
                    continue;
                }
                self.router(node).rebase(Port(port), seen, [0; LANES]);
                self.router(far).rebase(back, [0; LANES], seen);
                let shift =
                    |packet: &mut Vec<u8>, on: fn(&mut PacketHeader) -> &mut [u16; LANES]| {
                        let header = &mut packet[..PacketHeader::BYTES];
                        let mut read: PacketHeader = bytemuck::pod_read_unaligned(header);
                        for (number, by) in on(&mut read).iter_mut().zip(seen) {
                            *number = number.wrapping_sub(by);
                        }
                        header.copy_from_slice(bytemuck::bytes_of(&read));
                    };
                self.link(node, port).iter_mut().for_each(|p| shift(p, |header| &mut header.sent));
                self.link(far, back.0)
                    .iter_mut()
                    .for_each(|p| shift(p, |header| &mut header.limits));
            }
        }
    }
}
