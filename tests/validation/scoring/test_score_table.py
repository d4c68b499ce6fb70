from rich.console import Console

from validation.scoring.metrics import WRONG_ABOVE, ErrorSummary
from validation.scoring.score import MethodScore, Scores
from validation.scoring.score_table import score_table

SUMMARY = ErrorSummary(
    2_694_920, 0.999, 0.0153, 0.02, 0.0581, 0.03, 0.001, 0.0, {str(bound): 0.0123 for bound in WRONG_ABOVE}
)


def printed(*methods):
    """The table of these methods, at 80 columns: its lines."""
    scored = {name: MethodScore(0.93, {"all": SUMMARY, "complex": SUMMARY}) for name in methods}
    console = Console(width=80, record=True)
    console.print(score_table(Scores("rolling_wheel", 0, True, scored, {})))
    return console.export_text().splitlines()


def test_nothing_is_cut_short_at_80_columns():
    lines = printed("robust-affine", "robust-affine-fast")
    assert not any("\N{HORIZONTAL ELLIPSIS}" in line for line in lines)
    (method,) = (line for line in lines if "robust-affine-fast" in line)
    assert method.split() == ["robust-affine-fast", "0.93", "s/pair"]
    strata = [line.split() for line in lines if "complex" in line]
    assert strata == 2 * [["complex", "2", "694", "920", "99.9%", "0.015", "0.058", *["1.2%"] * 3]]


def test_a_long_name_is_folded_and_no_number_is_lost():
    lines = printed("my_package.of_mine.flow:estimate_it_well")
    assert "".join(line.split()[0] for line in lines if "my_" in line or "ow:" in line).startswith(
        "my_package"
    )
    assert any(line.split()[-4:] == ["0.058", *["1.2%"] * 3] for line in lines)
