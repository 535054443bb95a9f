"""Nonlinear modes: natural frequency and damping over the amplitude, and forced responses made from them."""
