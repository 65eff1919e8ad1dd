use kiloray_core::block::BlockSource;
use kiloray_core::trace::{Kernel, Query, Search, TraceError, Tracer};

use crate::portable::{Portable, fused};

#[cfg(target_arch = "x86_64")]
use crate::wide::{Avx2, Avx512};

/// Traces with the best lanes that the machine has: eight on any, which do the same work.
#[derive(Debug, Clone, Copy)]
pub struct Auto(Found);

#[derive(Debug, Clone, Copy)]
enum Found {
    #[cfg(target_arch = "x86_64")]
    Avx512(Avx512),
    #[cfg(target_arch = "x86_64")]
    Avx2(Avx2),
    Portable,
}

impl Auto {
    /// Finds out what the machine can do.
    #[must_use]
    pub fn detect() -> Self {
        Self::all().next().unwrap_or(Self(Found::Portable))
    }

    /// All lanes that the machine has, the best first.
    pub fn all() -> impl Iterator<Item = Self> {
        #[cfg(target_arch = "x86_64")]
        let wide = [Avx512::detect().map(Found::Avx512), Avx2::detect().map(Found::Avx2)];
        #[cfg(not(target_arch = "x86_64"))]
        let wide = [None; 0];
        wide.into_iter().flatten().chain([Found::Portable]).map(Self)
    }

    /// Whether they are quicker than [`Scalar`](kiloray_core::trace::Scalar), which does other work. They are not where eight numbers go by twos, for want of an instruction.
    #[must_use]
    pub fn are_quick(self) -> bool {
        !matches!(self.0, Found::Portable) || fused::IS_INSTRUCTION
    }

    /// What it traces with.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self.0 {
            #[cfg(target_arch = "x86_64")]
            Found::Avx512(_) => "avx512",
            #[cfg(target_arch = "x86_64")]
            Found::Avx2(_) => "avx2",
            Found::Portable => "portable",
        }
    }
}

impl Default for Auto {
    fn default() -> Self {
        Self::detect()
    }
}

impl Tracer for Auto {
    #[inline]
    fn run<T: Search, S: BlockSource, Q: Query>(
        self,
        room: &mut T::Room,
        source: &mut S,
        rays: &T::Rays,
        queries: &mut T::Queries<Q>,
    ) -> Result<(), TraceError<S::Error>> {
        match self.0 {
            // SAFETY: `lanes` proves that the machine has these features.
            #[cfg(target_arch = "x86_64")]
            Found::Avx512(lanes) => unsafe {
                run_avx512::<T, S, Q>(lanes, room, source, rays, queries)
            },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Found::Avx2(lanes) => unsafe {
                run_avx2::<T, S, Q>(lanes, room, source, rays, queries)
            },
            Found::Portable => T::run(Portable, room, source, rays, queries),
        }
    }

    #[inline]
    fn compute<K: Kernel>(self, kernel: K) {
        match self.0 {
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Found::Avx512(lanes) => unsafe { compute_avx512(lanes, kernel) },
            // SAFETY: as above.
            #[cfg(target_arch = "x86_64")]
            Found::Avx2(lanes) => unsafe { compute_avx2(lanes, kernel) },
            Found::Portable => kernel.run(Portable),
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
#[cfg(target_arch = "x86_64")]
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

/// The same for AVX-512.
#[cfg(target_arch = "x86_64")]
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
