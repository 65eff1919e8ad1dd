//! Serial lines as pairs of sockets.
//!
//! They are of TCP: QEMU writes byte by byte, and waits with all that it does where a socket takes no more, which one of the system's own does after
//! some hundred bytes; two boards would wait for each other.

use std::{
    io::{self, Read, Write},
    net::{Ipv4Addr, Shutdown, TcpListener, TcpStream},
    thread,
};

use fastrand::Rng;
use kiloray_core::network::{Mesh, NodeId};

/// Bytes that a noisy line carries at a time.
const CHUNK: usize = 256;

/// An end of a line: whose it is, and at which of its ports.
type End = (NodeId, u16, TcpStream);

/// Both ends of all lines of a mesh.
#[derive(Debug)]
pub(super) struct Lines(Vec<End>);

impl Lines {
    /// Lines that damage this part of their bytes.
    pub(super) fn new(mesh: &Mesh, noise: f64) -> io::Result<Self> {
        let mut ends = Vec::new();
        for node in (0..mesh.nodes()).map(NodeId) {
            for port in mesh.joined(node) {
                let (Some(far), Some(back)) =
                    (mesh.neighbour(node, port), mesh.reverse(node, port))
                else {
                    continue;
                };
                // Once for both of them.
                if (node, port) < (far, back) {
                    let (one, other) =
                        if noise > 0.0 { noisy(noise, ends.len() as u64)? } else { pair()? };
                    ends.push((node, port.0, one));
                    ends.push((far, back.0, other));
                }
            }
        }
        Ok(Self(ends))
    }

    /// The ends of a node, by port.
    pub(super) fn take(&mut self, node: NodeId) -> Vec<TcpStream> {
        let mut own: Vec<_> = self.0.extract_if(.., |end| end.0 == node).collect();
        own.sort_by_key(|end| end.1);
        own.into_iter().map(|end| end.2).collect()
    }
}

/// Two sockets that are linked to each other.
fn pair() -> io::Result<(TcpStream, TcpStream)> {
    let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0))?;
    let near = TcpStream::connect(listener.local_addr()?)?;
    let far = loop {
        let (far, who) = listener.accept()?;
        // Another process may have been faster.
        if who == near.local_addr()? {
            break far;
        }
    };
    near.set_nodelay(true)?;
    far.set_nodelay(true)?;
    Ok((near, far))
}

/// The same with a noisy line between them.
fn noisy(noise: f64, seed: u64) -> io::Result<(TcpStream, TcpStream)> {
    let ((near, left), (right, far)) = (pair()?, pair()?);
    let mut random = Rng::with_seed(seed);
    carry(left.try_clone()?, right.try_clone()?, noise, random.fork());
    carry(right, left, noise, random);
    Ok((near, far))
}

/// Carries bytes until one end is closed.
fn carry(mut from: TcpStream, mut to: TcpStream, noise: f64, mut random: Rng) {
    thread::spawn(move || {
        let mut chunk = [0; CHUNK];
        while let Ok(len @ 1..) = from.read(&mut chunk) {
            let bytes = chunk[..len].iter().filter_map(|&byte| damaged(byte, noise, &mut random));
            if to.write_all(&bytes.collect::<Vec<_>>()).is_err() {
                break;
            }
        }
        for end in [from, to] {
            let _ = end.shutdown(Shutdown::Both);
        }
    });
}

/// What becomes of a byte: mostly nothing; else it is another, or lost.
fn damaged(byte: u8, noise: f64, random: &mut Rng) -> Option<u8> {
    match random.f64() < noise {
        false => Some(byte),
        true => random.bool().then(|| byte ^ random.u8(1..)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn noise_is_as_much_as_was_asked_for() {
        let mut random = Rng::with_seed(1);
        let passed: Vec<_> = (0..100_000).map(|_| damaged(7, 0.01, &mut random)).collect();
        let count = |what: fn(&Option<u8>) -> bool| passed.iter().filter(|byte| what(byte)).count();
        let (lost, other) = (count(Option::is_none), count(|byte| byte.is_some_and(|b| b != 7)));
        assert!((400..600).contains(&lost) && (400..600).contains(&other), "{lost} {other}");
    }

    #[test]
    fn a_noisy_line_ends_with_either_end() {
        let (mut near, mut far) = noisy(1e-9, 1).expect("there are sockets");
        let mut byte = [0];
        near.write_all(&[5]).expect("it carries");
        far.read_exact(&mut byte).expect("it brings");
        assert_eq!(byte, [5]);
        drop(far);
        assert_eq!(near.read(&mut byte).ok(), Some(0));
    }
}
