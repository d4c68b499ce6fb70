"""A suite's page in a browser: nothing fails, nothing is fetched, everything is there."""

import json
import re
import shutil
import subprocess

import pytest

from validation.suites.execution import carry_out
from validation.suites.plan import Motion, Realisation, Suite
from validation.suites.results import write_results
from validation.terminal import Terminal

BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
SUITE = Suite(
    "small",
    "a jump of the motion",
    tuple(Realisation(Motion("shear_band", 1, quick=True), seed, pair_count=1) for seed in (0, 1)),
    ("dis", "farneback"),
)
QUIET = (
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-extensions",
    "--no-first-run",
    "--disable-background-networking",
    "--host-resolver-rules=MAP * ~NOTFOUND",
    "--enable-logging=stderr",
    "--virtual-time-budget=5000",
)
MESSAGE = re.compile(r"CONSOLE[:(]|Refused to|net::ERR_")
FETCHED = re.compile(r"""(?:src|href)=["'](?!data:|#)([^"']+)|url\((?!["']?data:)([^)]+)\)|@import""")


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page of a small suite."""
    out = tmp_path_factory.mktemp("suite")
    assert carry_out(SUITE, out, processes=1, terminal=Terminal()) == []
    write_results(SUITE, out, [], command="softbed suite small OUT")
    return out / "small.html"


def browse(page, profile, *options):
    """Open a page, its requests beyond the file itself going nowhere; what it holds, and what was logged."""
    if BROWSER is None:
        pytest.skip("no Chromium here: .ci/run installs Debian's")
    command = [BROWSER, *QUIET, f"--user-data-dir={profile}", *options, "--dump-dom", page.as_uri()]
    done = subprocess.run(command, capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-2000:]
    return done.stdout, done.stderr


def requests_in(log_file):
    """Addresses that a page asked for, of the browser's network log; its own errands have no origin."""
    events = json.loads(log_file.read_text(encoding="utf-8", errors="replace"))["events"]
    asked = [event["params"] for event in events if "url" in event.get("params", {})]
    return {
        one["url"]
        for one in asked
        if one.get("initiator", "not an origin") != "not an origin"
        and not one["url"].startswith(("file:", "data:"))
    }


def test_page_in_a_browser(page, tmp_path):
    net = tmp_path / "net.json"
    document, log = browse(page, tmp_path / "profile", f"--log-net-log={net}")
    assert not [line for line in log.splitlines() if MESSAGE.search(line)]
    assert not requests_in(net)
    for section in ("leaderboard-clean", "profiles-clean", "scene-shear_band", "again"):
        assert f'id="{section}"' in document, section
    assert document.count("<img") >= 7 and "farneback" in document
    assert "softbed suite small OUT" in document


def test_the_browser_would_tell(page, tmp_path):
    """The test above fails on a page that logs an error and asks for a picture elsewhere."""
    broken = tmp_path / "broken.html"
    fault = '<script>console.error("fault")</script><img src="http://example.invalid/none.png">'
    broken.write_text(
        page.read_text(encoding="utf-8").replace("</body>", f"{fault}</body>"), encoding="utf-8"
    )
    net = tmp_path / "net.json"
    _, log = browse(broken, tmp_path / "profile", f"--log-net-log={net}")
    assert [line for line in log.splitlines() if MESSAGE.search(line)]
    assert any("none.png" in url for url in requests_in(net))


def test_page_refers_to_nothing_outside(page):
    assert not FETCHED.findall(page.read_text(encoding="utf-8"))
