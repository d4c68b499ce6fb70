"""Implements: what moves the soil. One file each; a scene names one by its `kind`."""

from synth.implements.plate import Plate
from synth.implements.rigid_wheel import RigidWheel

__all__ = ["Plate", "RigidWheel"]
