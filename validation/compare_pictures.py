"""How alike two sorts of pictures are, told by what decides how well motion can be measured in them.

Lengths are px and grey levels are 0-255, whatever the pictures' depth. Spectrum and autocorrelation are means
over tiles of at most 256 px (Welch 1967, IEEE Trans. Audio Electroacoust. 15), each with its mean and its
slope taken out, so that uneven light does not count as texture.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from soft import Region

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SCHEMA_VERSION = 1
SLOPE_BAND = (0.02, 0.2)
"""1/px; between them the slope of the spectrum is fitted: waves of 5 to 50 px."""
NOISE_BAND = 0.4
"""1/px; where both frequencies are above it, a lens leaves little but noise."""
_TILE = 256
_LEAST_SIDE = 32
_MOST_PICTURES = 8
_LEVELS = 256
_SHOWN = 160
"""px, side of the part that the figure shows."""


class PicturesError(ValueError):
    """Pictures that cannot be compared; the message is one line."""


@dataclass(frozen=True, eq=False)
class PictureStatistics:
    """What a set of pictures is like.

    Attributes
    ----------
    name : str
        Where they are from.
    picture_count : int
    mean, deviation, skewness : float
        Of the grey levels; deviation of the texture alone, without uneven light, is `contrast`.
    p01, p99 : float
        Grey levels below which 1 and 99 % lie.
    contrast : float
        Grey levels, standard deviation within the tiles.
    autocorrelation_length : float
        px, where the autocorrelation has fallen to 1/e.
    spectrum_slope : float
        Exponent of the power spectrum over frequency, within `SLOPE_BAND`.
    mean_intensity_gradient : float
        Grey levels/px, mean of the gradient's magnitude (Pan et al. 2010, Opt. Lasers Eng. 48).
    noise : float
        Grey levels, standard deviation of white noise as strong as the finest waves (`NOISE_BAND`): an upper
        bound where texture reaches there, too low where JPEG has taken them away.
    histogram : (256,) array
        Share of the pixels at each grey level.
    frequency, power : arrays
        1/px; power of the texture a (1/px)^2, as a mean over directions.
    lag, autocorrelation : arrays
        px; 1 at lag 0, as a mean over directions.
    sample : array
        A part of the first picture, for looking at.
    """

    name: str
    picture_count: int
    mean: float
    deviation: float
    skewness: float
    p01: float
    p99: float
    contrast: float
    autocorrelation_length: float
    spectrum_slope: float
    mean_intensity_gradient: float
    noise: float
    histogram: np.ndarray
    frequency: np.ndarray
    power: np.ndarray
    lag: np.ndarray
    autocorrelation: np.ndarray
    sample: np.ndarray

    def to_dict(self) -> dict[str, Any]:
        """As `--json` gives it."""
        scalars = {name: getattr(self, name) for name in ("name", "picture_count", *QUANTITIES)}
        curves = ("histogram", "frequency", "power", "lag", "autocorrelation")
        return scalars | {name: getattr(self, name).tolist() for name in curves}


# name: (unit, words)
QUANTITIES = {
    "mean": ("grey", "mean grey level"),
    "deviation": ("grey", "standard deviation"),
    "contrast": ("grey", "contrast of the texture"),
    "skewness": ("1", "skewness of the grey levels"),
    "p01": ("grey", "1 % of the grey levels"),
    "p99": ("grey", "99 % of the grey levels"),
    "autocorrelation_length": ("px", "autocorrelation length"),
    "spectrum_slope": ("1", "slope of the power spectrum"),
    "mean_intensity_gradient": ("grey/px", "mean intensity gradient"),
    "noise": ("grey", "noise, at most"),
}


def read_pictures(path: Path, region: Region | None = None, *, binning: int = 1) -> list[np.ndarray]:
    """Grey levels (0-255) of a picture file, or of up to eight pictures of a folder, evenly chosen.

    Parameters
    ----------
    path : Path
    region : soft.Region, optional
        Only this part.
    binning : int
        Every `binning` x `binning` px of it are averaged to one.

    Raises
    ------
    PicturesError, soft.SequenceError
        There is no picture, one cannot be read, or does not hold the region.
    """
    from soft.natural_order import natural_key
    from soft.sequence import PICTURE_SUFFIXES, read_picture

    if not path.exists():
        raise PicturesError(f"{path}: no such picture or folder")
    files = [path]
    if path.is_dir():
        found = (file for file in path.iterdir() if file.suffix.lower() in PICTURE_SUFFIXES)
        files = sorted(found, key=natural_key)
        if not files:
            raise PicturesError(f"{path}: no picture in it: allowed are {', '.join(PICTURE_SUFFIXES)}")
        chosen = np.linspace(0, len(files) - 1, min(len(files), _MOST_PICTURES))
        files = [files[round(index)] for index in chosen]
    pictures = [read_picture(file) for file in files]
    parts = pictures if region is None else [region.of(picture, name=path.name) for picture in pictures]
    return [_binned(part, binning) for part in parts]


def _binned(picture: np.ndarray, side: int) -> np.ndarray:
    """Means over squares of `side` px; what is left over at the right and at the bottom is cut off."""
    rows, columns = picture.shape[0] // side, picture.shape[1] // side
    whole = picture[: rows * side, : columns * side].astype(np.float32)
    return np.asarray(whole.reshape(rows, side, columns, side).mean(axis=(1, 3)))


def picture_statistics(pictures: Sequence[np.ndarray], name: str) -> PictureStatistics:
    """Measure pictures; (H, W) grey levels 0-255 each.

    Raises
    ------
    PicturesError
        One is smaller than 32 px, or has no texture.
    """
    for picture in pictures:
        if min(picture.shape) < _LEAST_SIDE:
            height, width = picture.shape
            raise PicturesError(
                f"{name}: {width} x {height} px: at least {_LEAST_SIDE} px each way are needed"
            )
    grey = np.concatenate([picture.ravel() for picture in pictures]).astype(np.float64)
    spectrum = _power_spectrum(pictures)
    if not spectrum.mean() > 0:
        raise PicturesError(f"{name}: no texture: all its grey levels are one")
    radius = np.hypot(*_frequencies(len(spectrum)))
    frequency, power = _by_radius(radius, spectrum, 1 / len(spectrum), 0.5)
    lag, correlation = _autocorrelation(spectrum)
    return PictureStatistics(
        name=name,
        picture_count=len(pictures),
        mean=float(grey.mean()),
        deviation=float(grey.std()),
        skewness=float(np.mean(((grey - grey.mean()) / max(grey.std(), 1e-12)) ** 3)),
        p01=float(np.percentile(grey, 1)),
        p99=float(np.percentile(grey, 99)),
        contrast=float(np.sqrt(spectrum.mean())),
        autocorrelation_length=_falls_to(lag, correlation, 1 / np.e),
        spectrum_slope=_slope(frequency, power),
        mean_intensity_gradient=float(np.mean([_mean_gradient(picture) for picture in pictures])),
        noise=_noise(spectrum),
        histogram=np.bincount(np.rint(grey).astype(int).clip(0, _LEVELS - 1), minlength=_LEVELS) / grey.size,
        frequency=frequency,
        power=power,
        lag=lag,
        autocorrelation=correlation,
        sample=pictures[0][:_SHOWN, :_SHOWN],
    )


def _power_spectrum(pictures: Sequence[np.ndarray]) -> np.ndarray:
    """Mean power of windowed tiles; its mean over all frequencies is the texture's variance."""
    side = min(_TILE, *(min(picture.shape) for picture in pictures))
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(side) + 0.5) / side)
    window = np.outer(hann, hann)
    total, count = np.zeros((side, side)), 0
    for tile in _tiles(pictures, side):
        total += np.abs(np.fft.fft2(_without_slope(tile) * window)) ** 2
        count += 1
    return total / (count * np.sum(window**2))


def _tiles(pictures: Sequence[np.ndarray], side: int) -> Iterator[np.ndarray]:
    """Tiles of `side` px that overlap by half or more, up to every edge."""
    for picture in pictures:
        starts = [
            np.unique(np.linspace(0, n - side, 1 + -(-2 * (n - side) // side), dtype=int))
            for n in picture.shape
        ]
        for top in starts[0]:
            for left in starts[1]:
                yield picture[top : top + side, left : left + side].astype(np.float64)


def _without_slope(tile: np.ndarray) -> np.ndarray:
    """Take the mean and the best plane out."""
    side = len(tile)
    ramp = np.arange(side) - (side - 1) / 2
    square = side * np.sum(ramp**2)
    down, right = (ramp @ tile).sum() / square, (tile @ ramp).sum() / square
    return tile - tile.mean() - down * ramp[:, None] - right * ramp


def _frequencies(side: int) -> tuple[np.ndarray, np.ndarray]:
    frequency = np.fft.fftfreq(side)
    return frequency[:, None], frequency[None, :]


def _by_radius(
    radius: np.ndarray, values: np.ndarray, step: float, end: float
) -> tuple[np.ndarray, np.ndarray]:
    """Mean of values over rings of width `step`: their mean radius and value, without the innermost."""
    ring = np.rint(radius / step).astype(int).ravel()
    count = np.bincount(ring)
    kept = (np.arange(len(count)) * step <= end) & (count > 0)
    kept[0] = False
    means = [np.bincount(ring, weights=w.ravel())[kept] / count[kept] for w in (radius, values)]
    return means[0], means[1]


def _autocorrelation(spectrum: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Mean over directions, to a quarter of the tile; what the window takes is given back."""
    side = len(spectrum)
    hann = 0.5 - 0.5 * np.cos(2 * np.pi * (np.arange(side) + 0.5) / side)
    window = np.fft.ifft(np.abs(np.fft.fft(hann)) ** 2).real
    taken = np.outer(window, window) / window[0] ** 2
    found = np.fft.ifft2(spectrum).real
    # Far from the middle the window leaves nothing, and circular neighbours come in.
    correlation = np.where(taken > 0.1, found / np.maximum(taken, 0.1), 0.0) / found[0, 0]
    lag = side * np.hypot(*_frequencies(side))
    lags, means = _by_radius(lag, correlation, 1.0, side / 4)
    return np.concatenate([[0.0], lags]), np.concatenate([[1.0], means])


def _falls_to(lag: np.ndarray, correlation: np.ndarray, level: float) -> float:
    """Lag at which a curve first falls to a level, between points by a straight line; infinite if never."""
    below = np.flatnonzero(correlation <= level)
    if not below.size:
        return float("inf")
    k = below[0]
    share = (correlation[k - 1] - level) / (correlation[k - 1] - correlation[k])
    return float(lag[k - 1] + share * (lag[k] - lag[k - 1]))


def _slope(frequency: np.ndarray, power: np.ndarray) -> float:
    chosen = (frequency >= SLOPE_BAND[0]) & (frequency <= SLOPE_BAND[1])
    return float(np.polyfit(np.log(frequency[chosen]), np.log(power[chosen]), 1)[0])


def _mean_gradient(picture: np.ndarray) -> float:
    down, right = np.gradient(picture.astype(np.float64))
    return float(np.hypot(down, right)[1:-1, 1:-1].mean())


def _noise(spectrum: np.ndarray) -> float:
    down, right = _frequencies(len(spectrum))
    corners = (np.abs(down) > NOISE_BAND) & (np.abs(right) > NOISE_BAND)
    return float(np.sqrt(spectrum[corners].mean()))


def comparison_lines(a: PictureStatistics, b: PictureStatistics) -> list[str]:
    """One line a quantity: A beside B."""
    widest = max(len(words) for _, words in QUANTITIES.values())
    lines = [f"{'':{widest}}  {'A':>9}  {'B':>9}"]
    for name, (unit, words) in QUANTITIES.items():
        values = "  ".join(f"{getattr(one, name):9.2f}" for one in (a, b))
        lines.append(f"{words:{widest}}  {values}  {'' if unit == '1' else unit}".rstrip())
    return lines


def draw_comparison(a: PictureStatistics, b: PictureStatistics) -> "Figure":
    """Draw A beside B: a part of each at the same size of a pixel, histogram, autocorrelation, spectrum."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10, 6.4), layout="constrained")
    axes = figure.subplots(2, 3)
    for one, letter, place in ((a, "A", axes[0, 0]), (b, "B", axes[0, 1])):
        place.imshow(one.sample, cmap="gray", vmin=0, vmax=255, interpolation="nearest")
        place.set_title(f"{letter}: {one.name}", fontsize=9)
        place.set_xlabel("x [px]")
        place.set_ylabel("y [px]")
    axes[0, 2].axis("off")
    axes[0, 2].text(0, 0.98, "\n".join(comparison_lines(a, b)), family="monospace", fontsize=6.5, va="top")
    for one, letter, colour in ((a, "A", "#4c78a8"), (b, "B", "#e45756")):
        axes[1, 0].plot(100 * one.histogram, color=colour, label=letter)
        axes[1, 1].plot(one.lag, one.autocorrelation, color=colour, label=letter)
        axes[1, 2].loglog(one.frequency, one.power, color=colour, label=letter)
    axes[1, 0].set(xlabel="grey level", ylabel="share of the pixels [%]", xlim=(0, 255), ylim=(0, None))
    axes[1, 1].axhline(1 / np.e, color="0.6", linewidth=0.8)
    axes[1, 1].set(xlabel="lag [px]", ylabel="autocorrelation", xlim=(0, 32))
    axes[1, 2].set(xlabel="frequency [1/px]", ylabel="power [grey² px²]")
    for place in axes[1]:
        place.legend(frameon=False)
        place.grid(alpha=0.3)
    return figure


def comparison_document(a: PictureStatistics, b: PictureStatistics, figure: Path) -> dict[str, Any]:
    """As `--json` gives it; a length that is never reached is null."""
    rows = {letter: one.to_dict() for letter, one in (("a", a), ("b", b))}
    for row in rows.values():
        if not np.isfinite(row["autocorrelation_length"]):
            row["autocorrelation_length"] = None
    return {"schema_version": SCHEMA_VERSION, "figure": str(figure), **rows}
