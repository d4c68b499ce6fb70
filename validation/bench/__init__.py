"""Benchmarks: own code and peers on the same work, in turn, in the same call."""
