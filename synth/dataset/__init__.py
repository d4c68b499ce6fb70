"""Recordings and footage in the formats of others."""
