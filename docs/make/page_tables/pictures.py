"""Tables of docs/pictures.md."""

from kept import Row, distinct, document, having, rows, the_one

from validation.markdown_tables import markdown_table

METHODS = ("robust-affine", "black-anandan", "dis", "farneback", "tvl1", "ilk")


def photograph() -> str:
    """What a photograph and a rendered picture are like."""
    fine, binned = document("compare-pictures-fine.json"), document("compare-pictures.json")
    quantities = {
        "mean grey level": ("mean", ".0f"),
        "contrast of the texture [grey]": ("contrast", ".1f"),
        "skewness of the grey levels": ("skewness", ".1f"),
        "autocorrelation length [px]": ("autocorrelation_length", ".1f"),
        "slope of the power spectrum, waves of 5-50 px": ("spectrum_slope", ".1f"),
        "mean intensity gradient [grey/px]": ("mean_intensity_gradient", ".1f"),
        "noise, at most [grey]": ("noise", ".1f"),
    }
    pictures = (fine["a"], binned["a"], binned["b"])
    table = [
        [told, *(format(one[name], form) for one in pictures)] for told, (name, form) in quantities.items()
    ]
    return markdown_table(["", "A, photograph", "A, every 4 x 4 px as one", "B, rendered"], table, words=1)


def nuisance() -> str:
    """Errors of each estimator at the greatest severity of each nuisance."""
    every = rows("nuisance.csv")
    severities: dict[str, float] = {}
    for name, severity in distinct(every, "nuisance", "severity"):
        severities[name] = max(severity, severities.get(name, 0))
    table = [_disturbed(having(every, nuisance=name, severity=most)) for name, most in severities.items()]
    head = ["at its greatest severity", "severity", "plate, 95 % [px]", "wheel, 95 % [px]"]
    return markdown_table([*head, "wheel, complex, above 1 px [%]"], table, words=1)


def _disturbed(seen: list[Row]) -> list[str]:
    name, severity = seen[0]["nuisance"], seen[0]["severity"]
    plate = _six(having(seen, scene="plate_rotation", stratum="all"), "p95", ".2f")
    wheel = _six(having(seen, scene="rolling_wheel", stratum="all"), "p95", ".2f")
    hard = _six(having(seen, scene="rolling_wheel", stratum="complex"), "wrong", ".1f")
    said = ["none", ""] if name == "none" else [f"`{name}`", f"{severity:g}"]
    return [*said, plate, wheel, hard]


def texture() -> str:
    """Errors of each estimator in complex flow, for each size of particles and motion of the texture."""
    every = rows("texture.csv")
    head = ["particles", "texture", "soil that is complex [%]", "median there [px]", "above 1 px there [%]"]
    table = [
        [
            f"{grain:g} mm, {pixels:.0f} px",
            motion,
            f"{share:.1f}",
            _six(own, "median", ".2f"),
            _six(own, "wrong", ".1f"),
            _six(own, "wrong_of_all", ".2f"),
        ]
        for grain, pixels, motion, share in distinct(
            every, "grain_diameter", "diameter_in_picture", "texture", "complex_share"
        )
        for own in [having(every, grain_diameter=grain, texture=motion)]
    ]
    return markdown_table([*head, "above 1 px of all soil [%]"], table, words=2)


def _six(measured: list[Row], quantity: str, form: str) -> str:
    """Of the methods, in their order; nothing where that was not taken."""
    found = [format(the_one(measured, method=name)[quantity], form) for name in METHODS if measured]
    return ", ".join(found) or "-"


def render() -> str:
    """How fast pictures are made."""
    quantities = {
        "pictures with truth a second": ("pictures with truth", 1, ".1f"),
        "processor time a picture [s]": ("processor time", 1, ".2f"),
        "until the first picture [s]": ("until the first picture", 1, ".0f"),
        "memory of all processes [GiB]": ("memory", 1, ".1f"),
        "micro-grains seen [million]": ("micro-grains that are seen", 1e-6, ".2f"),
        "micro-grains in view [million]": ("micro-grains in view, hidden ones too", 1e-6, ".2f"),
    }
    return _by_sampling("", quantities)


def render_stages() -> str:
    """How long each stage of making pictures takes, of all processes together."""
    stages = {
        "what covers what": "covering",
        "light and lens": "lighting",
        "motion of the grains, in each process": "moving",
        "truth": "truth",
        "sensor": "exposing",
        "writing": "writing",
    }
    quantities = {told: (stage, 1, ".2f") for told, stage in stages.items()}
    return _by_sampling("both processes together [s/picture]", quantities)


def _by_sampling(corner: str, quantities: dict[str, tuple[str, float, str]]) -> str:
    every = document("bench-render.json")["rows"]
    cases = [case for (case,) in distinct(every, "case")]
    table = [
        [told, *(format(the_one(every, case=one, metric=metric)["value"] * unit, form) for one in cases)]
        for told, (metric, unit, form) in quantities.items()
    ]
    return markdown_table([corner, *(case.split("px, ")[1] for case in cases)], table, words=1)


TABLES = {
    "photograph": photograph,
    "nuisance": nuisance,
    "texture": texture,
    "render": render,
    "render-stages": render_stages,
}
