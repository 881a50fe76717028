"""Moving parts of a simulated machine besides its winches: masses, a retraction, lines that break."""
