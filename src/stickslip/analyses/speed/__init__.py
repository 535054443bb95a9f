"""Rotating machines: structures over the rotor speed, and the Campbell diagram."""
