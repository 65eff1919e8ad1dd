mod hostile;
mod mesh;
