mod frame;
mod start;
