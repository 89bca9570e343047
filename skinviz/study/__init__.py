"""Studies: people, body sites and methods compared."""
