"""Grains on the glass -> picture: texture, light, glass, lens, sensor."""
