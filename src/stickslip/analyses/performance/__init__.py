"""Resonance peaks against load and design: performance curves and their band, what matters, the design of a damper."""
