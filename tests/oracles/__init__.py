"""Slow, literal twins of the physics. They import nothing of skinviz."""
