"""The table of docs/tutorials/score_my_method.md."""

from kept import document

from validation.markdown_tables import markdown_table

STRATA = ("all", "complex", "quiet")


def shear_band() -> str:
    """Scores of two methods on a shear band, stratum by stratum."""
    head = ["method", "stratum", "measured", "median px", "95 % px", "wrong by more than 0.3 px"]
    table = []
    for method, scores in document("shear-band-scores.json")["methods"].items():
        for stratum in STRATA:
            one = scores["strata"][stratum]
            table.append(
                [
                    f"`{method}`" if stratum == STRATA[0] else "",
                    stratum,
                    f"{100 * one['coverage']:.1f} %",
                    f"{one['median']:.3f}",
                    f"{one['p95']:.2f}",
                    f"{100 * one['wrong_share']['0.3']:.1f} %",
                ]
            )
    return markdown_table(head, table, words=2)


TABLES = {"shear-band": shear_band}
