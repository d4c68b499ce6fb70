"""Scenes without a simulator: grains move by a formula, and pixels integrate them in closed form."""
