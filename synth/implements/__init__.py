"""Implements: shapes that move the soil. One file each; a scene names one by its `kind`."""

from typing import Annotated

from pydantic import Field

from synth.implements.bucket import Bucket
from synth.implements.compliant_wheel import CompliantWheel
from synth.implements.outline import Outline, OutlineWheel
from synth.implements.plate import Plate
from synth.implements.rigid_wheel import GrouserWheel, RigidWheel
from synth.implements.shape import Shape

Implement = Annotated[
    RigidWheel | GrouserWheel | CompliantWheel | Bucket | Outline | OutlineWheel, Field(discriminator="kind")
]
"""What can work in a soil bin."""

__all__ = [
    "Bucket",
    "CompliantWheel",
    "GrouserWheel",
    "Implement",
    "Outline",
    "OutlineWheel",
    "Plate",
    "RigidWheel",
    "Shape",
]
