"""Strata for scores: those of `synth.strata`, under the name that scoring knows them by."""

from synth.strata import (
    COMPLEX_ABOVE,
    COMPLEX_WITHIN,
    MEANINGS,
    MOVING_ABOVE,
    STRATA,
    Strata,
    camera_displacement,
    distance_to,
    find_strata,
    gradient_norm,
)

__all__ = [
    "COMPLEX_ABOVE",
    "COMPLEX_WITHIN",
    "MEANINGS",
    "MOVING_ABOVE",
    "STRATA",
    "Strata",
    "camera_displacement",
    "distance_to",
    "find_strata",
    "gradient_norm",
]
