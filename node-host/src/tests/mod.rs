mod hostile;
mod mesh;
mod secure;
mod strangers;
mod supervisor;
