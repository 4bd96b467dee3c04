"""The report in real Chromium: it loads, draws, zooms, and says nothing on the console."""

import re
from collections.abc import Iterator
from contextlib import ExitStack
from pathlib import Path

import pytest

from axisid import (
    Identification,
    twin_record,
)
from axisid.codegen.generated_axes.generated_axis import GeneratedAxis
from axisid.presentation.page import report_html, report_sweep
from tests.axisid.chromium import Browser, browser, find_chromium
from tests.files import text_file
from tests.unjudged import identify

FIGURES = 9


@pytest.fixture(scope="module")
def page(tmp_path_factory: pytest.TempPathFactory, result: Identification) -> Iterator[Browser]:
    program = find_chromium()
    if program is None:
        pytest.skip("no Chromium is installed (Debian: apt-get install chromium)")
    folder = tmp_path_factory.mktemp("report")
    file = text_file(folder / "report.html", report_html(result, report_sweep(result)))
    with ExitStack() as stack:
        try:
            opened = stack.enter_context(browser(program, folder / "profile"))
        except OSError as error:
            pytest.skip(f"{program} does not start: {error}")
        opened.emulate(1280, 900, "light")
        opened.open(file)
        yield opened


@pytest.fixture
def fresh(page: Browser) -> Iterator[Browser]:
    """The page scrolled to the force figure, everything seen; no complaint afterwards."""
    page.emulate(1280, 900, "light")
    page.evaluate("document.getElementById('figure-force').scrollIntoView({behavior: 'instant'})")
    page.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
    page.evaluate(
        "document.querySelectorAll('.tool[title=\"Show everything\"]').forEach(b => b.click())"
    )
    yield page
    assert page.complaints == []


def seen(page: Browser, figure: str = "force") -> tuple[float, float]:
    low, high = page.evaluate(
        f"(d => [+d.from, +d.to])(document.getElementById('plot-{figure}').dataset)"
    )
    return low, high


def middle(page: Browser, panel: int = 0) -> tuple[float, float, float, float]:
    """Left, top, width and height of a panel's drawing."""
    x, y, w, h = page.evaluate(
        "(r => [r.x, r.y, r.width, r.height])"
        f"(document.querySelectorAll('#plot-force svg')[{panel}].getBoundingClientRect())"
    )
    return x, y, w, h


def drag(page: Browser, a: tuple[float, float], b: tuple[float, float], **more: int) -> None:
    page.mouse("mouseMoved", *a)
    page.mouse("mousePressed", *a, button="left", buttons=1, clickCount=1, **more)
    page.mouse("mouseMoved", (a[0] + b[0]) / 2, (a[1] + b[1]) / 2, button="left", buttons=1, **more)
    page.mouse("mouseMoved", *b, button="left", buttons=1, **more)
    page.mouse("mouseReleased", *b, button="left", clickCount=1, **more)


@pytest.mark.slow
def test_every_figure_is_drawn_and_nothing_is_asked_of_the_network(page: Browser) -> None:
    counts = page.evaluate(
        "[...document.querySelectorAll('.plot')].map(p => [...p.querySelectorAll('svg')]"
        ".every(s => s.querySelector('.curve, .stems, .points')"
        " && s.querySelectorAll('.tick').length > 2))"
    )
    assert counts == [True] * FIGURES
    paths = "[...document.querySelectorAll('svg path')].map(p => p.getAttribute('d')).join()"
    assert not re.search("NaN|Infinity|undefined", page.evaluate(paths))
    assert all(url.startswith("file:") for url in page.requests)
    assert page.complaints == []


@pytest.mark.slow
def test_the_wheel_a_box_and_keys_zoom_and_both_panels_follow(fresh: Browser) -> None:
    whole = seen(fresh)
    x, y, w, h = middle(fresh)
    labels = "[...document.querySelectorAll('#plot-force .tick.x')].map(t => t.textContent).join()"
    before = fresh.evaluate(labels)
    lower = "document.querySelectorAll('#plot-force svg')[1]"
    curve = f"{lower}.querySelector('.curve').getAttribute('d')"
    path = fresh.evaluate(curve)
    at = (x + 0.75 * w, y + h / 2)
    fresh.mouse("mouseMoved", at[0] - 9, at[1])
    fresh.mouse("mouseMoved", *at)
    for _ in range(3):
        fresh.mouse("mouseWheel", *at, deltaX=0, deltaY=-120)
    low, high = seen(fresh)
    assert high - low == pytest.approx((whole[1] - whole[0]) / 1.4**3, rel=1e-6)
    assert low > whole[0] + 0.5 * (high - low) - 1e-6
    assert fresh.evaluate(curve) != path
    assert fresh.evaluate(labels) != before
    for _ in range(4):
        fresh.mouse("mouseWheel", *at, deltaX=0, deltaY=120)
    assert seen(fresh) == pytest.approx(whole)
    # A box, and a double click.
    drag(fresh, (x + 0.4 * w, y + 0.3 * h), (x + 0.5 * w, y + 0.6 * h))
    low, high = seen(fresh)
    assert (high - low) / (whole[1] - whole[0]) == pytest.approx(0.1 * w / (w - 76), rel=0.02)
    for count in (1, 2):
        for kind in ("mousePressed", "mouseReleased"):
            fresh.mouse(kind, x + w / 2, y + h / 2, button="left", clickCount=count)
    assert seen(fresh) == pytest.approx(whole)
    # Keys.
    fresh.evaluate("document.getElementById('plot-force').focus()")
    fresh.key("+")
    low, high = seen(fresh)
    assert high - low == pytest.approx((whole[1] - whole[0]) / 1.4)
    fresh.key("ArrowRight")
    assert seen(fresh)[0] > low
    fresh.key("0")
    assert seen(fresh) == pytest.approx(whole)


def test_pointing_reads_out_values(fresh: Browser) -> None:
    x, y, w, h = middle(fresh)
    fresh.mouse("mouseMoved", x + 0.3 * w, y + h / 2)
    values = fresh.evaluate(
        "[...document.querySelectorAll('#plot-force .value')].map(v => v.textContent)"
    )
    assert sum(bool(re.fullmatch(r"\u2212?[\d.]+(e\u2212?\d+)?", v)) for v in values) >= 4
    fresh.mouse("mouseMoved", 2, 2)
    assert fresh.evaluate("document.querySelector('#plot-force .value').textContent") == ""


def test_a_legend_shows_what_was_aside(fresh: Browser) -> None:
    curves = "document.querySelectorAll('#plot-force svg:first-of-type .curve').length"
    before = fresh.evaluate(curves)
    key = "document.querySelector('#plot-force .key[aria-pressed=false]')"
    fresh.evaluate(f"({key}).click()")
    assert fresh.evaluate(curves) == before + 1


@pytest.mark.parametrize(("scheme", "dark"), [("light", False), ("dark", True)])
def test_the_page_follows_the_colour_scheme_and_the_button(
    fresh: Browser, scheme: str, dark: bool
) -> None:
    def brightness() -> float:
        color = fresh.evaluate("getComputedStyle(document.body).backgroundColor")
        return sum(map(float, re.findall(r"[\d.]+", color)[:3])) / 765

    fresh.emulate(1280, 900, scheme)
    assert (brightness() < 0.3) == dark
    fresh.evaluate("document.getElementById('theme').click()")
    assert (brightness() < 0.3) != dark
    fresh.evaluate("delete document.documentElement.dataset.theme")


@pytest.mark.slow
def test_a_narrow_window_needs_no_sideways_scrolling(fresh: Browser) -> None:
    fresh.emulate(380, 800, "light")
    fresh.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
    assert fresh.evaluate("document.documentElement.scrollWidth") <= 380
    widths = "Math.max(...[...document.querySelectorAll('.plot svg')].map(s => s.clientWidth))"
    assert fresh.evaluate(widths) <= 380


@pytest.mark.slow
def test_what_is_folded_is_printed_behind_the_rest_and_folded_again(fresh: Browser) -> None:
    order = (
        "[...document.querySelectorAll('main > section')]"
        ".map(s => [s.id, s.querySelectorAll('details[open]').length])"
    )
    before = dict(fresh.evaluate(order))
    assert set(before.values()) == {0}
    fresh.evaluate("window.dispatchEvent(new Event('beforeprint'))")
    printed = fresh.evaluate(order)
    assert printed[-1][0] == "appendix"
    assert printed[-1][1] >= 2
    fresh.evaluate("window.dispatchEvent(new Event('afterprint'))")
    assert dict(fresh.evaluate(order)) == before
    assert fresh.evaluate("document.querySelectorAll('.verdict details').length") >= 1


@pytest.mark.slow
def test_the_reader_picks_the_record_whose_figures_are_seen(
    page: Browser, tmp_path: Path, emps2015: GeneratedAxis
) -> None:
    result = identify(emps2015, [twin_record(emps2015, seed=seed) for seed in (1, 2)])
    file = text_file(tmp_path / "several.html", report_html(result))
    page.open(file)
    shown = (
        "[...document.querySelectorAll('figure[data-record]')].map(f => "
        "[f.dataset.record, f.getBoundingClientRect().height > 0])"
    )
    picker = "document.getElementById('record-picker')"
    assert page.evaluate(f"{picker}.getBoundingClientRect().height") > 0
    for number in ("1", "2", "1"):
        page.evaluate(f"{picker}.value = '{number}'")
        page.evaluate(f"{picker}.dispatchEvent(new Event('change'))")
        page.evaluate("new Promise(r => requestAnimationFrame(() => requestAnimationFrame(r)))")
        seen_now = page.evaluate(shown)
        assert {record for record, _ in seen_now} == {"1", "2"}
        assert all(visible == (record == number) for record, visible in seen_now)
        drawn = page.evaluate(
            f"[...document.querySelectorAll('figure[data-record=\"{number}\"] svg')]"
            ".every(s => s.querySelector('.curve, .stems, .points') && s.clientWidth > 100)"
        )
        assert drawn
    assert page.complaints == []
