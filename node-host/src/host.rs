use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use kiloray_core::block::KiloView;
use kiloray_core::network::{HOST, Router};
use kiloray_core::node::{Actor, Next, Time};
use kiloray_core::store::{Arena, CHUNK_BYTES, Chunk};
use kiloray_mesh::watch::Latencies;
use kiloray_mesh::{Ledger, LedgerCounts};
use kiloray_render::Picture;

use crate::drive::Drive;
use crate::supervisor::{Replacement, Supervisor};
use crate::{Config, Error, Identity, Job, Network, NodeReport, Place, Spent, drive};

/// How the caller follows a run, and stops it.
#[derive(Clone, Copy)]
pub struct Control<'a> {
    /// Set from anywhere, it ends the run soon: what is rendered is given, marked as incomplete.
    pub cancel: &'a AtomicBool,
    /// Hears from time to time how far the run is.
    pub progress: &'a dyn Fn(&Status),
}

impl std::fmt::Debug for Control<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Control").field("cancel", self.cancel).finish_non_exhaustive()
    }
}

/// How far a run is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Status {
    /// Nodes that are there.
    pub nodes: usize,
    /// Pixels that are complete.
    pub pixels: u64,
    /// All pixels.
    pub pixels_all: u64,
    /// Nodes that were replaced so far.
    pub replaced: usize,
    /// The processes of the nodes that this one has started, by the system's number.
    pub processes: Vec<u32>,
}

/// What came of a run.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The picture; black where it is incomplete.
    pub picture: Picture,
    /// Whether all pixels are there.
    pub complete: bool,
    /// The block of which no copy is left, if that is why it is not complete; it was cancelled else.
    pub lost: Option<u32>,
    /// Pixels whose sum was too great to count.
    pub overflows: u64,
    /// What the nodes did: those that were there in the end, by number.
    pub nodes: Vec<NodeReport>,
    /// Nodes that were replaced, in their order.
    pub replacements: Vec<Replacement>,
    /// How long things took, as the ends saw it that waited: those of [`fetch`](Latencies::fetch) into parts are empty.
    pub latencies: Latencies,
    /// What the ledger heard and did.
    pub ledger: LedgerCounts,
    /// Where the time of the host's own process went.
    pub host: Spent,
    /// From the beginning until all nodes were there; `None` if it was cancelled before.
    pub start: Option<Duration>,
    /// From then until the last pixel.
    pub render: Duration,
}

/// How long all nodes may take to be there that somebody else starts; a supervisor knows of each of its own.
const START_LIMIT: Duration = Duration::from_secs(60);
/// How long nodes may take to report in the end, and when somebody waits for that.
const REPORT_LIMITS: [Duration; 2] = [Duration::from_secs(2), Duration::from_millis(250)];
/// How often the caller and the nodes' processes are looked at.
const LOOK: Duration = Duration::from_millis(25);

/// Renders a picture on the nodes of a configuration: those that `supervisor` has started, or such as are started elsewhere.
///
/// # Errors
/// [`Error`], for what cannot begin or go on. What is cancelled, or has lost a block, gives an [`Outcome`] that is not complete.
pub fn run_host(
    config: &Config,
    file: &KiloView<'_>,
    mut supervisor: Option<&mut Supervisor>,
    control: &Control<'_>,
) -> Result<Outcome, Error> {
    let begin = Instant::now();
    let job = Job::new(config, file)?;
    let size = job.layout.host_router(&job.mesh);
    let mut chunks = vec![Chunk::ZERO; size.arena_bytes() / CHUNK_BYTES];
    let mut host = HostEnd {
        router: Router::new(&mut Arena::new(&mut chunks), job.mesh, HOST, size)?,
        ledger: job.layout.ledger(file, &job.options)?,
    };
    let own = job.identity(file, Place::HOST, Identity::any_incarnation());
    let mut watch = Watch { file, job: &job, own: own.clone(), replacements: Vec::new() };
    let mut network = Network::open(config, &job, own)?;
    let mut looked = begin;
    let is_supervised = supervisor.is_some();
    let mut look = |watch: &mut Watch<'_>, ledger: &Ledger, network: &mut Network| {
        let changes = network.take_changes();
        if changes.is_empty() && looked.elapsed() < LOOK {
            return Ok(control.cancel.load(Ordering::Relaxed));
        }
        looked = Instant::now();
        watch.look(changes, supervisor.as_deref_mut())?;
        (control.progress)(&Status {
            nodes: job.nodes().filter(|&node| network.there(node).is_some()).count(),
            pixels: ledger.pixels_done(),
            pixels_all: ledger.pixels(),
            replaced: watch.replacements.len(),
            processes: supervisor.as_deref().map(Supervisor::processes).unwrap_or_default(),
        });
        Ok::<_, Error>(control.cancel.load(Ordering::Relaxed))
    };

    // Until all are there.
    let missing = |network: &Network| job.nodes().find(|&node| network.there(node).is_none());
    let mut is_cancelled = false;
    while let Some(node) = missing(&network).filter(|_| !is_cancelled) {
        if !is_supervised && begin.elapsed() > START_LIMIT {
            let at = config.addresses.get(usize::from(node.id().0)).map_or("", String::as_str);
            let limit = START_LIMIT.as_secs();
            let or = if at.starts_with("quic/") {
                ", or its certificate is of another authority"
            } else {
                ""
            };
            let cause =
                format!("is not there after {limit} s: nobody of this mesh answers at {at}{or}");
            return Err(Error::Node { node, cause });
        }
        network.wait_for_news(LOOK);
        is_cancelled = look(&mut watch, &host.ledger, &mut network)?;
    }
    let waited = begin.elapsed();
    let start = missing(&network).is_none().then_some(waited);

    let mut failure = None;
    let drive_settings = Drive::new(begin, &job, Place::HOST);
    let (host_time, mut waits) =
        drive(&mut host, &mut network, &drive_settings, |host, network| {
            let ledger = &host.ledger;
            if ledger.is_complete() || ledger.lost().is_some() {
                return true;
            }
            look(&mut watch, ledger, network).unwrap_or_else(|error| {
                failure = Some(error);
                true
            })
        });
    let render = begin.elapsed() - waited;
    let replacements = std::mem::take(&mut watch.replacements);
    if let Some(error) = failure {
        return Err(error);
    }
    let is_cut_short = control.cancel.load(Ordering::Relaxed);
    let limit = REPORT_LIMITS[usize::from(is_cut_short)];
    let mut nodes = reports(&job, &mut network, limit)?;
    nodes.iter_mut().for_each(|node| waits.add(&std::mem::take(&mut node.waits)));
    network.close();
    let ledger = &host.ledger;
    let complete = ledger.is_complete();
    Ok(Outcome {
        picture: ledger.picture(),
        complete,
        lost: if complete { None } else { ledger.lost() },
        overflows: ledger.overflows(),
        nodes,
        replacements,
        latencies: waits.latencies(),
        ledger: ledger.counts(),
        host: host_time,
        start,
        render,
    })
}

/// Says that it is over, and hears what the nodes did.
fn reports(job: &Job, network: &mut Network, limit: Duration) -> Result<Vec<NodeReport>, Error> {
    network.say_over()?;
    let begin = Instant::now();
    let mut reports = BTreeMap::new();
    loop {
        reports.append(&mut network.take_reports());
        let awaited =
            |node: &Place| network.there(*node).is_some() && !reports.contains_key(&node.id().0);
        if !job.nodes().any(|node| awaited(&node)) || begin.elapsed() > limit {
            return Ok(reports.into_values().collect());
        }
        network.wait_for_news(LOOK);
    }
}

/// What the host knows of its nodes' processes.
struct Watch<'a> {
    file: &'a KiloView<'a>,
    job: &'a Job,
    own: Identity,
    replacements: Vec<Replacement>,
}

impl Watch<'_> {
    /// Looks who has come or gone; replaces those that have died.
    fn look(
        &mut self,
        changes: Vec<(Identity, bool)>,
        mut supervisor: Option<&mut Supervisor>,
    ) -> Result<(), Error> {
        for (identity, is_there) in changes {
            let node = identity.place;
            if node == Place::HOST {
                continue;
            }
            if is_there {
                let share = || self.job.identity(self.file, node, identity.incarnation).share;
                let differs = identity.differs(&self.own).or_else(|| {
                    (identity.share != share()).then(|| "has other blocks in its scene file".into())
                });
                if let Some(cause) = differs {
                    return Err(Error::Node { node, cause });
                }
            }
            if let Some(supervisor) = &mut supervisor {
                if is_there {
                    supervisor.is_there(node, identity.incarnation);
                } else {
                    // It has died, or does not answer: then it is made to.
                    self.replacements.extend(supervisor.silent(node, identity.incarnation)?);
                }
            }
        }
        if let Some(supervisor) = supervisor {
            self.replacements.extend(supervisor.look(Instant::now())?);
        }
        Ok(())
    }
}

/// The host's end of the mesh.
pub(crate) struct HostEnd<'m> {
    pub(crate) router: Router<'m>,
    pub(crate) ledger: Ledger,
}

impl<'m> Actor<'m> for HostEnd<'m> {
    fn poll(&mut self, now: Time) -> Next {
        self.ledger.poll(now, &mut self.router)
    }

    fn router(&mut self) -> &mut Router<'m> {
        &mut self.router
    }
}
