//! The network of a mesh: routes against a search of the graph, credits by model checking.

mod credits;
mod routers;
mod routes;
