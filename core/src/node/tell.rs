//! What a node sees go wrong, in words: by `log` or by `defmt`, for who links one of them. Without either nothing is left of it.

/// Sends a message at a level of both: `tell!(warn, "block {} is refused", block)`. Values are numbers.
macro_rules! tell {
    ($level:ident, $($message:tt)*) => {{
        #[cfg(feature = "log")]
        log::$level!($($message)*);
        #[cfg(feature = "defmt")]
        defmt::$level!($($message)*);
        #[cfg(not(any(feature = "log", feature = "defmt")))]
        if false {
            let _ = format_args!($($message)*);
        }
    }};
}

pub(super) use tell;
