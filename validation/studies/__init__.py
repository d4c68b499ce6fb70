"""Studies: what one scene, run several times with something changed, says about soil or simulation.

One file each, with a `Study` named `STUDY`; its line here makes it known.
"""

import importlib
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from validation.studies.study import Study

STUDIES = {
    "grain-size": "sinkage, drawbar pull, torque and shear-band width against grain diameter",
    "grading": "sinkage, drawbar pull and torque in graded and in uniform beds, over several seeds",
    "convergence": "their change, and that of the flow, with speed-up, box, time step and seed",
    "speed-up": "what driving faster than in the laboratory changes, and the soil's inertial number",
    "glass-friction": "soil's motion at the glass against that at mid-plane, by glass friction",
    "grouser-spacing": "soil pushed ahead of the wheel against the number of grousers",
    "nuisance": "error of every estimator against each severity of what disturbs a picture",
    "texture": "error in complex flow against particle size, by how the texture moves",
    "rim-compliance": "soil motion below a wheel with an elastic rim / below the rigid one",
}
"""What each is about, by name."""

__all__ = ["STUDIES", "find_study"]


def find_study(name: str) -> "Study":
    """The study of that name.

    Raises
    ------
    ValueError
        There is none.
    """
    if name not in STUDIES:
        raise ValueError(f"study {name!r}: allowed are {', '.join(STUDIES)}")
    return importlib.import_module(f"validation.studies.{name.replace('-', '_')}").STUDY
