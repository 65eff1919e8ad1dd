use kiloray_core::block::KiloView;

use crate::{Error, Faults, MeshOptions, Options, Profile, Rate, Slow};

/// Longest that an operation may take \[ns\]: a second.
const LONGEST: f64 = 1e9;

/// Whether the options can be.
pub(crate) fn check(file: &KiloView<'_>, options: &Options) -> Result<(), Error> {
    if options.link.bandwidth == 0 {
        return Err(Error::Bandwidth);
    }
    profile(&options.profile)?;
    let (packet, least) = (options.mesh.packet, MeshOptions::packet_min(file.limits().block_bytes));
    if (1..least).contains(&packet) {
        return Err(Error::Packet { packet, least });
    }
    let nodes = options.mesh.topology.nodes();
    let Faults { loss, duplicate, slow, crashes, .. } = &options.faults;
    for Rate { count, of } in [*loss, *duplicate] {
        if of == 0 || count > of {
            return Err(Error::Rate { count, of });
        }
    }
    if loss.count == loss.of {
        return Err(Error::AllLost);
    }
    let named = slow.iter().map(|slow| slow.node).chain(crashes.iter().map(|crash| crash.node));
    for node in named {
        if node.0 >= nodes {
            return Err(Error::NoNode { node: node.0, last: nodes - 1 });
        }
    }
    for (at, &Slow { node, factor }) in slow.iter().enumerate() {
        if !(factor > 0.0 && factor.is_finite()) {
            return Err(Error::Factor { node: node.0, factor });
        }
        if slow[..at].iter().any(|other| other.node == node) {
            return Err(Error::SlowTwice { node: node.0 });
        }
    }
    let mut dying: Vec<u16> = crashes.iter().map(|crash| crash.node.0).collect();
    dying.sort_unstable();
    dying.dedup();
    if dying.len() == usize::from(nodes) {
        return Err(Error::AllDie { nodes });
    }
    Ok(())
}

/// Whether a machine can be so fast: without any time for a ray, virtual time would stand still.
fn profile(profile: &Profile) -> Result<(), Error> {
    let wrong =
        profile.operations().into_iter().find(|(_, ns)| !(0.0..=LONGEST).contains(ns)).or_else(
            || (profile.ray <= 0.0).then_some(("a ray, begun or gone on with", profile.ray)),
        );
    match wrong {
        Some((operation, ns)) => {
            Err(Error::Profile { name: profile.name.to_string(), operation, ns })
        }
        None => Ok(()),
    }
}
