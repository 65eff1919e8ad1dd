use kiloray_core::block::{BlockSource, BlockView, ExpandedTop};
use kiloray_core::trace::{Kernel, Lanes, Query, Search, TraceError, Tracer};

use crate::Quickest;
use crate::portable::Portable;

#[cfg(target_arch = "x86_64")]
use crate::wide::Avx2;
#[cfg(avx512)]
use crate::wide::Avx512;

/// Traces with the best lanes that the machine has, and `Else` where it has none of its own: eight on any machine do the same work.
#[derive(Debug, Clone, Copy)]
pub struct Auto<Else = Portable> {
    wide: Option<Wide>,
    rest: Else,
}

/// Lanes of some machines.
#[derive(Debug, Clone, Copy)]
enum Wide {
    #[cfg(avx512)]
    Avx512(Avx512),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
}

impl Auto {
    /// Finds out what the machine can do.
    #[must_use]
    pub fn detect() -> Self {
        Self::all().next().unwrap_or(Self::only(Portable))
    }

    /// All lanes that the machine has, the best first.
    pub fn all() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wide = [
            #[cfg(avx512)]
            Avx512::detect().map(Wide::Avx512),
            Avx2::detect().map(Wide::Avx2),
        ];
        #[cfg(not(target_arch = "x86_64"))]
        let wide = [None; 0];
        let wide = wide.into_iter().flatten().map(Some);
        wide.chain([None]).map(|wide| Self { wide, rest: Portable })
    }

    /// What it traces with.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.wide {
            #[cfg(avx512)]
            Some(Wide::Avx512(_)) => "avx512",
            #[cfg(target_arch = "x86_64")]
            Some(Wide::Avx2(_)) => "avx2",
            None => "portable",
        }
    }

    /// The same, but for what is quickest where the machine has no lanes.
    #[must_use]
    pub fn quickest(self) -> Auto<Quickest> {
        Auto { wide: self.wide, rest: Quickest::default() }
    }
}

impl<Else> Auto<Else> {
    /// Traces with these on any machine.
    #[must_use]
    pub const fn only(rest: Else) -> Self {
        Self { wide: None, rest }
    }
}

impl Default for Auto {
    fn default() -> Self {
        Self::detect()
    }
}

impl<Else: Lanes> Tracer for Auto<Else> {
    #[inline]
    fn run<T: Search, S: BlockSource, Q: Query>(
        self,
        room: &mut T::Room,
        source: &mut S,
        rays: &T::Rays,
        queries: &mut T::Queries<Q>,
    ) -> Result<(), TraceError<S::Error>> {
        match self.wide {
            // SAFETY: `lanes` proves that the machine has these features.
            #[cfg(avx512)]
            Some(Wide::Avx512(lanes)) => unsafe {
                run_avx512::<T, S, Q>(lanes, room, source, rays, queries)
            },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Some(Wide::Avx2(lanes)) => unsafe {
                run_avx2::<T, S, Q>(lanes, room, source, rays, queries)
            },
            None => run_else::<T, S, Q, _>(self.rest, room, source, rays, queries),
        }
    }

    #[inline]
    fn compute<K: Kernel>(self, kernel: K) {
        match self.wide {
            // SAFETY: as above.
            #[cfg(avx512)]
            Some(Wide::Avx512(lanes)) => unsafe { compute_avx512(lanes, kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Some(Wide::Avx2(lanes)) => unsafe { compute_avx2(lanes, kernel) },
            None => kernel.run(self.rest),
        }
    }
}

/// All that a kernel calls is inlined into it, and compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn compute_avx2<K: Kernel>(lanes: Avx2, kernel: K) {
    kernel.run(lanes);
}

/// The same for AVX-512.
#[cfg(avx512)]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512bw,avx512dq")]
fn compute_avx512<K: Kernel>(lanes: Avx512, kernel: K) {
    kernel.run(lanes);
}

/// All that a search calls is inlined into it, and compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<T: Search, S: BlockSource, Q: Query>(
    lanes: Avx2,
    room: &mut T::Room,
    source: &mut S,
    rays: &T::Rays,
    queries: &mut T::Queries<Q>,
) -> Result<(), TraceError<S::Error>> {
    T::run(lanes, room, source, rays, queries)
}

/// The same for any other lanes. A function too: inlined, its registers would be kept for it at each call of the others.
#[inline(never)]
fn run_else<T: Search, S: BlockSource, Q: Query, L: Lanes>(
    lanes: L,
    room: &mut T::Room,
    source: &mut S,
    rays: &T::Rays,
    queries: &mut T::Queries<Q>,
) -> Result<(), TraceError<S::Error>> {
    let mut told = Told { source, error: None };
    let any: &mut dyn BlockSource<Error = Lacking> = &mut told;
    run_any::<T, Q, L>(lanes, room, any, rays, queries).map_err(|error| match error {
        TraceError::Source(Lacking) => {
            TraceError::Source(told.error.expect("what is lacking is told"))
        }
        TraceError::Corrupt { block } => TraceError::Corrupt { block },
    })
}

/// A search with any lanes, compiled once for all sources: few machines come here, and each took as long to compile as those of other lanes.
fn run_any<T: Search, Q: Query, L: Lanes>(
    lanes: L,
    room: &mut T::Room,
    mut source: &mut dyn BlockSource<Error = Lacking>,
    rays: &T::Rays,
    queries: &mut T::Queries<Q>,
) -> Result<(), TraceError<Lacking>> {
    T::run(lanes, room, &mut source, rays, queries)
}

/// A source of any type, which keeps the first of its errors: that with which a search ends.
struct Told<'a, S: BlockSource> {
    source: &'a mut S,
    error: Option<S::Error>,
}

/// There is an error.
struct Lacking;

impl<S: BlockSource> BlockSource for Told<'_, S> {
    type Error = Lacking;

    fn block(&mut self, block: u32) -> Result<BlockView<'_>, Lacking> {
        self.source.block(block).map_err(|error| {
            self.error.get_or_insert(error);
            Lacking
        })
    }

    fn holds_all(&self) -> bool {
        self.source.holds_all()
    }

    fn top(&self) -> ExpandedTop<'_> {
        self.source.top()
    }
}

/// The same for AVX-512.
#[cfg(avx512)]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512bw,avx512dq")]
fn run_avx512<T: Search, S: BlockSource, Q: Query>(
    lanes: Avx512,
    room: &mut T::Room,
    source: &mut S,
    rays: &T::Rays,
    queries: &mut T::Queries<Q>,
) -> Result<(), TraceError<S::Error>> {
    T::run(lanes, room, source, rays, queries)
}
