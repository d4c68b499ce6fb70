"""Suites: scenes x seeds x pictures x methods, measured once and kept, in one table."""
