mod answers;
mod network;
mod router;
