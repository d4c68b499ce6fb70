"""Wheels of a vehicle in one bin of grains: the granular simulator in the place of a wheel-soil law."""
