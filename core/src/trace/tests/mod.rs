//! The tests of the traversal. What is `shared` the tests of other lanes compile too; here it is asked of [`Scalar`](super::Scalar).

mod hostile;
mod scalar;
pub(crate) mod shared;
