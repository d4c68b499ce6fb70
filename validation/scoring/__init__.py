"""Measured against true motion: errors by stratum, regions, lines, means over pairs, and their table."""
