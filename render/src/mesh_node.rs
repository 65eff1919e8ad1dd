use std::ops::{Deref, DerefMut};

use kiloray_core::network::Router;
use kiloray_core::node::{Actor, Next, Node, Picture, Progress, Time};
use kiloray_simd::Auto;

use crate::ThreadScratch;

/// A node as it runs on this machine, simulated or as a process: with the machine's lanes, in the room of its thread.
///
/// All of tracing is compiled for it here, once, and not in each crate that runs nodes.
#[derive(Debug)]
pub struct MeshNode<'a>(pub Node<'a, Picture<'a, Auto, ThreadScratch>>);

impl MeshNode<'_> {
    /// Takes a step, as [`Node::poll`].
    #[inline(never)]
    pub fn poll(&mut self, now: Time) -> Progress {
        self.0.poll(now)
    }
}

impl<'a> Actor<'a> for MeshNode<'a> {
    fn poll(&mut self, now: Time) -> Next {
        self.poll(now).next
    }

    fn router(&mut self) -> &mut Router<'a> {
        self.0.router()
    }
}

impl<'a> Deref for MeshNode<'a> {
    type Target = Node<'a, Picture<'a, Auto, ThreadScratch>>;

    fn deref(&self) -> &Self::Target {
        &self.0
    }
}

impl DerefMut for MeshNode<'_> {
    fn deref_mut(&mut self) -> &mut Self::Target {
        &mut self.0
    }
}
