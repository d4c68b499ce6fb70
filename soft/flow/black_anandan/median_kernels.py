"""Kernels: weighted median of motion around chosen pixels.

Every number has one writer, so results are the same bytes on any number of threads. Import only after
`soft.devices.start_taichi`.
"""

import taichi as ti

Picture = ti.types.ndarray(ti.f32, ndim=2)
Channels = ti.types.ndarray(ti.f32, ndim=3)
Places = ti.types.ndarray(ti.i32, ndim=2)

BINS = 64
"""Bins in which weights are summed."""
_UNLIKE = 3.0
"""Standard deviations of grey level beyond which a pixel has no weight."""


@ti.func
def gathered(
    place,
    row,
    column,
    grey: ti.template(),
    worth: ti.template(),
    flow: ti.template(),
    near: ti.template(),
    contrast,
    votes: ti.template(),
):
    """Weight and motion of the pixels around a place, into `votes`; how many have a weight."""
    side = near.shape[0]
    reach, count, own = side // 2, 0, grey[row, column]
    for y in range(ti.max(0, row - reach), ti.min(grey.shape[0], row + reach + 1)):
        for x in range(ti.max(0, column - reach), ti.min(grey.shape[1], column + reach + 1)):
            apart = (grey[y, x] - own) / contrast
            if ti.abs(apart) < _UNLIKE and worth[y, x] > 0:
                weight = worth[y, x] * near[y - row + reach, x - column + reach]
                votes[place, count, 0] = weight * ti.exp(-apart * apart / 2)
                votes[place, count, 1], votes[place, count, 2] = flow[y, x, 0], flow[y, x, 1]
                count += 1
    return count


@ti.func
def crossed(place, count, k: ti.template(), low, high, half, votes: ti.template(), bins: ti.template()):
    """Bin of [low, high] in which the weights, summed by rising motion, reach `half`."""
    for each in range(BINS):
        bins[place, each] = 0
    below, scale = ti.f32(0.0), BINS / (high - low)
    for vote in range(count):
        value = (votes[place, vote, 1 + k] - low) * scale
        if value < 0:
            below += votes[place, vote, 0]
        elif value < BINS:
            bins[place, ti.cast(value, ti.i32)] += votes[place, vote, 0]
    found = 0
    while found < BINS - 1 and below + bins[place, found] < half:
        below += bins[place, found]
        found += 1
    return found


@ti.kernel
def weighted_median(
    places: Places,
    grey: Picture,
    worth: Picture,
    flow: Channels,
    near: Picture,
    contrast: ti.f32,
    votes: Channels,
    bins: Picture,
    median: Picture,
):
    """Weighted median of u and of v around each place, to 1 / 4096 of the range of values there.

    Weights are summed in bins over that range, then in as many over the bin that holds the median.
    """
    for place in range(places.shape[0]):
        row, column = places[place, 0], places[place, 1]
        count = gathered(place, row, column, grey, worth, flow, near, contrast, votes)
        for k in ti.static(range(2)):
            total, low = ti.f32(0.0), flow[row, column, k]
            high = low
            for vote in range(count):
                total += votes[place, vote, 0]
                low = ti.min(low, votes[place, vote, 1 + k])
                high = ti.max(high, votes[place, vote, 1 + k])
            for _ in ti.static(range(2)):
                if high > low:
                    width = (high - low) / BINS
                    low += width * crossed(place, count, k, low, high, total / 2, votes, bins)
                    high = low + width
            median[place, k] = (low + high) / 2
