use kiloray_core::network::Router;
use kiloray_core::node::{Progress, Time};

/// What runs at a place of the mesh, in the terms of the simulation.
pub(crate) trait Actor<'m> {
    /// Carries out one step, and says what it was.
    fn poll(&mut self, now: Time) -> Progress;

    /// Its end of the network.
    fn router(&mut self) -> &mut Router<'m>;

    /// Rays that it holds for later.
    fn stored(&self) -> u32 {
        0
    }

    /// Rays that it has traced.
    fn rays(&self) -> u64 {
        0
    }

    /// Camera paths that it has begun.
    fn begun(&self) -> u64 {
        0
    }

    /// Pixels that it knows to be complete.
    fn pixels(&self) -> u64 {
        0
    }

    /// Whether it may see the end of the run before more than so many bytes have come.
    fn may_end(&self, _bytes: u64) -> bool {
        false
    }

    /// Whether it has seen the end of the run.
    fn has_ended(&self) -> bool {
        false
    }
}
