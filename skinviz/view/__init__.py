"""Pictures for people: off-screen hands, spectral panels, figures."""
