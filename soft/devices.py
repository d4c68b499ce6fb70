"""Where kernels run: taichi is started here, unless somebody already has."""

import contextlib
import io
import os
from pathlib import Path
from typing import Any

DEVICES = ("cpu", "cuda")


def start_taichi(device: str = "cpu", threads: int | None = None) -> Any:
    """Start taichi unless somebody already has: a second start would destroy what others keep there.

    Parameters
    ----------
    device : {"cpu", "cuda"}
        Honoured by the first start in a process only.
    threads : int, optional
        Default: every core. Honoured by the first start only; results do not depend on it.

    Returns
    -------
    module
        taichi, started.

    Raises
    ------
    ValueError
        The device is not here.
    """
    os.environ.setdefault("ENABLE_TAICHI_HEADER_PRINT", "0")  # it greets on import,
    import taichi as ti

    with contextlib.redirect_stdout(io.StringIO()):  # and on its start
        if ti.lang.impl.get_runtime().prog is None:
            if device == "cuda" and not ti.lang.misc.is_arch_supported(ti.cuda):
                raise ValueError("device 'cuda': no CUDA device is found here")
            ti.init(
                arch=ti.cuda if device == "cuda" else ti.cpu,
                cpu_max_num_threads=threads or os.cpu_count() or 1,
                default_fp=ti.f64,
                fast_math=False,
                offline_cache=True,
                offline_cache_file_path=str(_kernel_cache()),
                log_level=ti.ERROR,
                enable_fallback=False,
            )
    return ti


def _kernel_cache() -> Path:
    """Folder of compiled kernels: in `$SOFTBED_CACHE`, else in the platform's user cache."""
    import platformdirs

    chosen = os.environ.get("SOFTBED_CACHE")
    folder = (Path(chosen) if chosen else Path(platformdirs.user_cache_dir("softbed"))) / "kernels"
    folder.mkdir(parents=True, exist_ok=True)
    return folder
