//! The AVX2 lanes, their run-time detection, and the only unsafe code of the host side.
