"""Analyses of a damper between two platforms with prescribed motion."""
