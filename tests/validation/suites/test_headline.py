"""Headlines and comparisons of lines whose numbers are known."""

import numpy as np

from validation.suites.headline import comparisons, headlines


def lines(method, error, pictures=(0, 1, 2, 3)):
    random = np.random.default_rng(0)
    for picture_seed in pictures:
        for pair in range(3):
            hard = random.normal(0, 0.02)
            for stratum, pixels in (("all", 1000), ("complex", 100), ("mixed", 0)):
                value = error + hard if pixels else np.nan
                yield {
                    "scene": "wheel",
                    "label": "",
                    "severity": "clean",
                    "stride": 1,
                    "seed": 1,
                    "picture_seed": picture_seed,
                    "pair": pair,
                    "stratum": stratum,
                    "method": method,
                    "pixel_count": pixels,
                    "median": value,
                    "p95": value,
                    "wrong_0.3": value,
                    "wrong_1.0": value,
                    "seconds": 0.5,
                }


def test_headlines():
    found = headlines([*lines("good", 0.1), *lines("bad", 0.2)])
    assert [(one.method, one.stratum) for one in found] == [
        (method, stratum) for method in ("good", "bad") for stratum in ("all", "complex")
    ]
    good = found[1]
    assert good.pixel_share == 0.1 and good.seconds == 0.5
    assert good.errors["median"].low < 0.1 < good.errors["median"].high
    assert (good.errors["median"].realisation_count, good.errors["median"].pair_count) == (4, 12)


def test_comparison_is_paired():
    # Alike but for 0.01, far less than the scatter between pictures; that is the same for both.
    (first, *_) = comparisons([*lines("good", 0.10), *lines("bad", 0.11)])
    assert first.better == "good" and first.p < 0.05


def test_no_difference():
    assert all(one.better is None for one in comparisons([*lines("a", 0.1), *lines("b", 0.1)]))


def test_methods_are_compared_on_what_both_saw():
    found = comparisons([*lines("fast", 0.1), *lines("slow", 0.1, pictures=(0, 1))])
    assert found[0].difference.realisation_count == 2
    three = [*lines("fast", 0.1), *lines("slow", 0.1, pictures=(0, 1)), *lines("good", 0.09)]
    counts = {(c.first, c.second): c.difference.realisation_count for c in comparisons(three)}
    assert counts["fast", "good"] == 4 and counts["slow", "good"] == 2
