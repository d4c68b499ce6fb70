"""Verification of the grain solver: what is known in closed form or published, against what it does."""
