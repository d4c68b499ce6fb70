"""What a flow estimator returns."""

from dataclasses import InitVar, dataclass, replace

import numpy as np


class FlowError(ValueError):
    """Pictures, method or options that flow cannot be estimated with; the message is one line."""


@dataclass(frozen=True, eq=False)
class FlowField:
    """Displacement at every pixel of the first picture.

    Integer coordinates lie at pixel centres, x right, y down; displacements are px, forward, from the first
    picture to the second, on the first picture's grid. A pixel is valid exactly where its displacement is
    finite: the constructor takes `valid` down where the displacement is not finite, and puts NaN everywhere
    that is not valid.

    Attributes
    ----------
    displacement : (H, W, 2) float32
        (u, v) in px.
    valid : (H, W) bool
        Where motion could be measured.
    uncertainty : (H, W, 2) float32 or None
        One sigma for each component in px, if the method tells it.
    gradient : (H, W, 2, 2) float32 or None
        d(u, v)_i / d(x, y)_j in px/px at [.., i, j], if the method tells it.
    nodes : (H, W, 2) float32 or None
        (x, y) in px of the place that a pixel's displacement was measured at, at most half a px from its
        centre each way; NaN for pixels of which the method does not tell. None: told of all, at the centres.
    copy : bool, only when made
        False: the arrays given are taken over and written into, where they are float32 already.

    Raises
    ------
    FlowError
        If shapes do not belong together.
    """

    displacement: np.ndarray
    valid: np.ndarray
    uncertainty: np.ndarray | None = None
    gradient: np.ndarray | None = None
    nodes: np.ndarray | None = None
    copy: InitVar[bool] = True

    def __post_init__(self, copy: bool) -> None:
        displacement = _as_float(self.displacement, copy)
        if displacement.ndim != 3 or displacement.shape[2] != 2:
            raise FlowError(f"displacement: shape {displacement.shape}: must be (H, W, 2)")
        shape = displacement.shape[:2]
        if np.shape(self.valid) != shape:
            raise FlowError(f"valid: shape {np.shape(self.valid)}: must be {shape}")
        valid = np.asarray(self.valid, dtype=bool) & known(displacement)
        if self.nodes is not None:
            object.__setattr__(self, "nodes", _checked_nodes(self.nodes, shape))
            valid &= known(self.nodes)
        _set_nan(displacement, valid)
        object.__setattr__(self, "displacement", displacement)
        object.__setattr__(self, "valid", valid)
        for name, tail in (("uncertainty", (2,)), ("gradient", (2, 2))):
            object.__setattr__(self, name, _companion(name, getattr(self, name), valid, tail, copy))

    def where(self, usable: np.ndarray, *, copy: bool = True) -> "FlowField":
        """Return the same field, valid only where `usable` (H, W) bool is true as well.

        Without `copy` this field's own arrays go over to it and are written into.
        """
        return replace(self, valid=self.valid & usable, copy=copy)


def known(vectors: np.ndarray) -> np.ndarray:
    """Tell where both components of vectors (.., 2) are finite; several times as fast as `all(axis=-1)`."""
    return np.isfinite(vectors[..., 0]) & np.isfinite(vectors[..., 1])


def _checked_nodes(nodes: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
    nodes = np.array(nodes, dtype=np.float32)
    if nodes.shape != (*shape, 2):
        raise FlowError(f"nodes: shape {nodes.shape}: must be {(*shape, 2)}")
    y, x = np.indices(shape, dtype=np.float32)
    off = np.nanmax(np.abs(nodes - np.stack([x, y], axis=2)), initial=0.0)
    if off > 0.5 + 1e-3:
        raise FlowError(f"nodes: {off:g} px from their pixel: must lie within half a px of its centre")
    return nodes


def _companion(
    name: str, values: np.ndarray | None, valid: np.ndarray, tail: tuple[int, ...], copy: bool
) -> np.ndarray | None:
    """`values` as float32 with NaN where the field is not valid."""
    if values is None:
        return None
    told = _as_float(values, copy)
    if told.shape != valid.shape + tail:
        raise FlowError(f"{name}: shape {told.shape}: must be {valid.shape + tail}")
    _set_nan(told, valid)
    return told


def _as_float(values: np.ndarray, copy: bool) -> np.ndarray:
    return np.array(values, dtype=np.float32) if copy else np.asarray(values, dtype=np.float32)


def _set_nan(values: np.ndarray, valid: np.ndarray) -> None:
    if valid.all():
        return
    if values.flags.c_contiguous:  # each pixel's two or four numbers as one: several times as fast
        kind = np.complex64 if values[0, 0].size == 2 else np.complex128
        values = values.reshape(*valid.shape, -1).view(kind)[:, :, 0]
    values[~valid] = np.full(4, np.nan, np.float32).view(values.dtype)[0]
