//! Behaviour across crates, oracles, and benchmarks against peers.

pub mod export;
pub mod kills;
pub mod nothing_lost;
pub mod oracle;
pub mod pool;
pub mod reference;
pub mod same_bits;
pub mod signals;
pub mod statistics;
pub mod stress;
