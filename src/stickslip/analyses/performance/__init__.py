"""Resonance peaks against load and design: performance curves and their band, sensitivity indices, damper design."""
