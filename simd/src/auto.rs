use kiloray_core::trace::{Scalar, Search, Tracer};

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
    fn run<T: Search>(self, search: T) -> T::Answer {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = self.avx2 {
            // SAFETY: `lanes` proves that the machine has these features.
            return unsafe { run_avx2(lanes, search) };
        }
        Scalar.run(search)
    }
}

/// All that a search calls is inlined into it, and compiled for AVX2.
#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn run_avx2<T: Search>(lanes: Avx2, search: T) -> T::Answer {
    search.run(lanes)
}
