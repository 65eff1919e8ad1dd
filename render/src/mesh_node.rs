use std::ops::{Deref, DerefMut};

use kiloray_core::network::{Mesh, Router};
use kiloray_core::node::{Actor, Next, Node, NodePlan, Picture, Progress, Rom, Settings, Time};
use kiloray_core::store::{Arena, ArenaFull, Budget};
use kiloray_simd::Auto;

use crate::ThreadScratch;

/// A node as it runs on this machine, simulated or as a process: with the machine's lanes, in the room of its thread.
///
/// All of tracing is compiled for it here, once, and not in each crate that runs nodes.
#[derive(Debug)]
pub struct MeshNode<'a>(Node<'a, Picture<'a, Auto, ThreadScratch>>);

impl<'a> MeshNode<'a> {
    /// As [`Node::new`].
    ///
    /// # Errors
    /// [`ArenaFull`] if the arena is smaller than the plan.
    #[inline(never)]
    pub fn new(
        arena: &mut Arena<'a>,
        plan: &NodePlan,
        budget: Budget,
        settings: Settings,
        rom: Rom<'a>,
        mesh: Mesh,
        picture: Picture<'a, Auto, ThreadScratch>,
    ) -> Result<Self, ArenaFull> {
        Node::new(arena, plan, budget, settings, rom, mesh, picture).map(Self)
    }

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
