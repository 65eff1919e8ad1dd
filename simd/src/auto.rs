use kiloray_core::block::BlockSource;
use kiloray_core::trace::{Query, Scalar, Search, TraceError, Tracer};

#[cfg(target_arch = "x86_64")]
use crate::avx2::Avx2;

/// Traces with the widest lanes that the machine has.
#[derive(Debug, Clone, Copy)]
pub struct Auto {
    #[cfg(target_arch = "x86_64")]
    avx2: Option<Avx2>,
}

impl Auto {
    /// Finds out what the machine can do.
    #[must_use]
    pub fn detect() -> Self {
        Self {
            #[cfg(target_arch = "x86_64")]
            avx2: Avx2::detect(),
        }
    }

    /// What it traces with.
    #[must_use]
    pub fn name(self) -> &'static str {
        #[cfg(target_arch = "x86_64")]
        if self.avx2.is_some() {
            return "avx2";
        }
        "scalar"
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
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { run_avx2::<T, S, Q>(lanes, room, source, rays, queries) };
        }
        Scalar.run::<T, S, Q>(room, source, rays, queries)
    }
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
