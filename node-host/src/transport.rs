use std::time::Duration;

use kiloray_core::network::Port;

/// What a network brings.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Event {
    /// A packet has come, and was written to where the caller wanted it.
    Packet {
        /// The port that it came by.
        port: Port,
        /// Its length \[bytes\].
        len: usize,
    },
    /// A neighbour is there.
    Up {
        /// The port that leads to it.
        port: Port,
        /// It is another process than before, or the first: it knows nothing of what was said to the last one.
        is_new: bool,
    },
    /// A neighbour is gone, or cannot be heard.
    Down {
        /// The port that led to it.
        port: Port,
    },
}

/// What a process knows of a network: links to the neighbours of its node, one for each port.
///
/// A link may lose packets and double them, but knows damaged ones and those of other processes than the one that is there, and drops them. It
/// keeps their order, as far as it can: one that is overtaken counts as lost.
///
/// Nothing of it waits, apart from [`wait`](Self::wait): the credits of routers bound what is under way on a link, so that it needs no room beyond.
pub trait Transport {
    /// What has come, the oldest first. A packet is written to `packet`, which holds the greatest; a longer one is lost.
    fn next(&mut self, packet: &mut [u8]) -> Option<Event>;

    /// Sends a packet by a port, with the next [`flush`](Self::flush) at the latest. Where nobody is there it is lost.
    fn send(&mut self, port: Port, packet: &[u8]);

    /// Sends what waits for others that go the same way.
    fn flush(&mut self);

    /// Waits until something comes, or so long.
    fn wait(&mut self, most: Duration);
}
