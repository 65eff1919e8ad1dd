use kiloray_core::block::KiloView;
use kiloray_core::network::{HOST, Mesh, NodeId};
use kiloray_core::node::Time;
use kiloray_core::store::BudgetError;
use kiloray_mesh::MeshLayout;

use crate::{Link, Options, Profile};

/// Divides a run, with time limits that suit its links. Routers outlive their nodes here, and tell of deaths.
pub(crate) fn layout(file: &KiloView<'_>, options: &Options) -> Result<MeshLayout, BudgetError> {
    let (link, mesh) = (&options.link, Mesh::new(options.mesh.topology));
    let jitter = options.faults.jitter;
    let mut layout = MeshLayout::new(file, &options.mesh, |packet| {
        let bundle_age = options.bundle_age.unwrap_or_else(|| link.bundle_age(packet));
        (patience(link, jitter, &options.profile, packet, &mesh), Time(bundle_age))
    })?;
    layout.settings.deaths_told = true;
    Ok(layout)
}

/// How long a request may stay unanswered at first: many times the longest way across the mesh and what a node does between two looks
/// at its messages. Nodes adapt it to what they see.
fn patience(link: &Link, jitter: u64, profile: &Profile, packet: usize, mesh: &Mesh) -> Time {
    let across = u64::from(mesh.distance(HOST, mesh.topology().antipode()))
        + u64::from(mesh.topology().distance(NodeId(0), mesh.topology().antipode()));
    let hop = link.latency.saturating_add(jitter).saturating_add(link.duration(packet));
    let way = across.saturating_mul(hop);
    Time(way.saturating_mul(16).saturating_add((profile.typical_ray() * 1000.0) as u64))
}
