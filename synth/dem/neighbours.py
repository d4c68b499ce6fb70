"""The Verlet list: who may touch whom until something has moved by half a skin, and what they remember."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree


@dataclass(frozen=True)
class NeighbourList:
    """Pairs of grains nearer than their radii and the skin, in a canonical order.

    Attributes
    ----------
    pairs : ndarray of int32, shape (2, P)
        Indices with ``pairs[0] < pairs[1]``, sorted by the first, then the second.
    first_contact : ndarray of int32, shape (N + 1,)
        Where each grain's part of `contacts` begins.
    ends : ndarray of int32, shape (2, P)
        Each pair's place among the contacts of its first grain and of its second, ascending in each grain.
    """

    pairs: np.ndarray
    first_contact: np.ndarray
    ends: np.ndarray

    @property
    def keys(self) -> np.ndarray:
        """One ascending integer a pair, the same for the same two grains in every list, shape (P,)."""
        grain_count = self.first_contact.size - 1
        return self.pairs[0].astype(np.int64) * grain_count + self.pairs[1]


def list_neighbours(position: np.ndarray, radius: np.ndarray, skin: float) -> NeighbourList:
    """List the pairs whose surfaces are nearer than `skin` (m).

    Parameters
    ----------
    position : ndarray, shape (2, N) or (3, N)
        m.
    radius : ndarray, shape (N,)
        m.
    """
    one, other = _candidates(position, radius, skin).T
    apart = position[:, one] - position[:, other]
    near = np.einsum("kp,kp->p", apart, apart) < (radius[one] + radius[other] + skin) ** 2
    one, other = one[near], other[near]
    keys = np.sort(np.minimum(one, other) * radius.size + np.maximum(one, other))
    return neighbour_list_of(np.stack(np.divmod(keys, radius.size)).astype(np.int32), radius.size)


def gap_between(position: np.ndarray, radius: np.ndarray, pairs: np.ndarray) -> np.ndarray:
    """Distance of the surfaces of two grains, m, negative where they overlap; `pairs` (2, P), shape (P,)."""
    apart = position[:, pairs[0]] - position[:, pairs[1]]
    return np.asarray(np.sqrt(np.einsum("kp,kp->p", apart, apart)) - radius[pairs].sum(axis=0))


def _candidates(position: np.ndarray, radius: np.ndarray, skin: float) -> np.ndarray:
    """Pairs that may be near enough, each once, shape (C, 2): by classes of radius, each twice the last.

    With one reach for all, a fine grain would have as many candidates as fit around the coarsest.
    """
    sizes = np.floor(np.log2(radius / radius.min())).astype(int)
    members = [np.flatnonzero(sizes == size) for size in np.unique(sizes)]
    # Quicker to build; looked into once, it is as quick unbalanced.
    loose = {"balanced_tree": False, "compact_nodes": False}
    trees = [cKDTree(position[:, chosen].T, **loose) for chosen in members]
    found = []
    for at, (chosen, tree) in enumerate(zip(members, trees, strict=True)):
        greatest = radius[chosen].max()
        found.append(chosen[tree.query_pairs(2 * greatest + skin, output_type="ndarray")])
        for other, finer in zip(members[:at], trees[:at], strict=True):
            reach = greatest + radius[other].max() + skin
            near = tree.sparse_distance_matrix(finer, reach, output_type="ndarray")
            found.append(np.stack([chosen[near["i"]], other[near["j"]]], axis=1))
    return np.concatenate(found).astype(np.int64, copy=False)


def neighbour_list_of(pairs: np.ndarray, grain_count: int) -> NeighbourList:
    """The list of these pairs, which are in canonical order: int32, shape (2, P)."""
    return NeighbourList(pairs, *_by_grain(pairs, grain_count))


def _by_grain(pairs: np.ndarray, grain_count: int) -> tuple[np.ndarray, np.ndarray]:
    grains = pairs.T.reshape(-1)  # entry 2 p is the first grain of pair p, entry 2 p + 1 the second
    ends = np.empty(grains.size, np.int32)
    ends[np.argsort(grains, kind="stable")] = np.arange(grains.size, dtype=np.int32)
    first_contact = np.zeros(grain_count + 1, np.int32)
    np.cumsum(np.bincount(grains, minlength=grain_count), out=first_contact[1:])
    return first_contact, ends.reshape(-1, 2).T


@dataclass(frozen=True)
class Carried:
    """Which contacts of a new list were in an old one, and where there.

    Attributes
    ----------
    old, new : ndarray, shape (K,)
        Places of the same contacts in the two lists.
    count : int
        Of contacts in the new list.
    """

    old: np.ndarray
    new: np.ndarray
    count: int

    @classmethod
    def between(cls, old_keys: np.ndarray, new_keys: np.ndarray) -> "Carried":
        """By keys, one ascending integer a contact, int64, shape (K_old,) and (K_new,)."""
        if old_keys.size == 0 or new_keys.size == 0:
            nothing = np.zeros(0, np.intp)
            return cls(nothing, nothing, new_keys.size)
        place = np.minimum(np.searchsorted(old_keys, new_keys), old_keys.size - 1)
        known = np.flatnonzero(old_keys[place] == new_keys)
        return cls(place[known], known, new_keys.size)

    def carry(self, memory: np.ndarray) -> np.ndarray:
        """What contacts of the old list remember, (K_old, n), at their places in the new one, (K_new, n).

        A new contact remembers nothing.
        """
        carried = np.zeros((self.count, memory.shape[1]))
        carried[self.new] = memory[self.old]
        return carried
