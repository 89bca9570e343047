"""A bench that behaves to the byte as instruments do, for whoever has none."""
