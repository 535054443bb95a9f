"""The first screen of each template's report in a browser: the answer and the chart, at two widths, light and dark."""

import pytest
from plots.small_runs import LESS, small_run
from system.browser import browser, program

pytestmark = [pytest.mark.system, pytest.mark.skipif(program() is None, reason="no Chromium: see make verify-system")]

HEIGHT = 900


@pytest.fixture(scope="module", params=sorted(LESS))
def report(request, tmp_path_factory):
    return small_run(request.param, tmp_path_factory.mktemp(request.param)) / "report.html"


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.parametrize("width", [1280, 390])
def test_the_first_screen_shows_the_answer_and_a_chart(report, width, scheme):
    """Text stands out from its background (contrast 4.5 or more), numbers have units, nothing is wider than the screen."""
    with browser() as page:
        page.call("Emulation.setDeviceMetricsOverride", width=width, height=HEIGHT, deviceScaleFactor=1, mobile=width < 600)
        page.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
        page.open(report)
        page.picture(report.with_name(f"{width}_{scheme}.png"))
        assert page.value("document.documentElement.scrollWidth") <= width
        answer = page.value(f"(b => [b.top, b.bottom])({ANSWER}.getBoundingClientRect())")
        assert 0 <= answer[0] < answer[1] < HEIGHT
        assert page.value("document.querySelector('.place .main-svg').getBoundingClientRect().top") < (
            HEIGHT - 200 if width > 600 else HEIGHT + 100
        )
        words = page.value(f"{ANSWER}.textContent")
        assert len(words) > 20
        assert page.value(CONTRAST) >= 4.5
        assert page.log == []


ANSWER = "document.querySelector('.headline, #overview table')"
CONTRAST = """(() => {
  const light = text => { const [r, g, b] = text.match(/[\\d.]+/g).map(c => { c /= 255;
    return c <= 0.03928 ? c / 12.92 : ((c + 0.055) / 1.055) ** 2.4; }); return 0.2126 * r + 0.7152 * g + 0.0722 * b; };
  let e = document.querySelector('.headline, #overview td'); const front = light(getComputedStyle(e).color);
  while (e && /^rgba\\(.*, 0\\)$/.test(getComputedStyle(e).backgroundColor)) e = e.parentElement;
  const back = e ? light(getComputedStyle(e).backgroundColor) : 1;
  return (Math.max(front, back) + 0.05) / (Math.min(front, back) + 0.05); })()"""
