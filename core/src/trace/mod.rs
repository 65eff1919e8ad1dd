//! Closest hit and any hit over blocks.
