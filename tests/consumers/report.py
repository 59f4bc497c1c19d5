"""Opens pages that `gonio-embree report` has written in a headless Chromium, as people do.

    report.py --chromium /usr/bin/chromium --pictures DIR PAGE.html...

No page may complain on the console or ask for anything; sliders must change the pictures, by the keyboard alone; nothing may
need scrolling sideways on a phone. If there is PAGE.nc, the scripts must read of each facet what that has. DIR gets pictures of
each page on a desk, in the dark, on a phone and as printed.
"""

import argparse
import pathlib
import sys

import numpy as np
from playwright.sync_api import Page, sync_playwright
from scipy.io import netcdf_file

PICTURES = ["lobe", "map-up", "map-down"]
# What a canvas shows, as text: none if it is not there, empty if nothing is drawn.
LOOK = """id => {
    const canvas = document.querySelector(id === 'scan' || id === 'spectra' ? `#${id} canvas` : `#${id}`);
    if (!canvas || !canvas.width || !canvas.offsetParent) return null;
    const empty = document.createElement('canvas');
    [empty.width, empty.height] = [canvas.width, canvas.height];
    const picture = canvas.toDataURL();
    return picture === empty.toDataURL() ? '' : picture;
}"""


# How many things can be reached; of radio buttons those that are chosen.
OPERABLE = """() => [...document.querySelectorAll('input:enabled, canvas[tabindex], summary')]
    .filter((e) => e.offsetParent && (e.type !== 'radio' || e.checked)).length"""
FOCUSED = "() => { const e = document.activeElement; return e.id || e.value || e.tagName; }"
# All facets as the scripts of the page know them, and the entries of the ledger.
FACETS = """() => Array.from({ length: payload.incidences }, (_, i) => {
    const of = payload.incidence(i);
    return of.facets.map((facet, f) => ({
        angles: dome.angles(dome.center(dome.corners(facet))),
        found: dome.find(lobe.tree(i), dome.center(dome.corners(facet))).facet === f,
        trees: facet.trees,
        values: payload.wavelengths.map((_, w) => of.facet(f, w).value),
        errors: payload.wavelengths.map((_, w) => of.facet(f, w).se),
    }));
}).flat()"""
LEDGER = """name => Array.from({ length: payload.incidences }, (_, i) =>
    payload.wavelengths.map((_, w) => payload.incidence(i).share(name, w)).map((e) => [e.value, e.se]))"""
# What packing may do: the page says how much it does.
ROUNDING, ROUNDING_OF_ERRORS = 1e-3, 0.04


class Desk:
    """A page that is open, and what went wrong with it."""

    def __init__(self, browser, path: pathlib.Path, **options):
        self.context = browser.new_context(**options)
        self.page: Page = self.context.new_page()
        self.problems: list[str] = []
        self.page.on("console", lambda m: self.problems.append(f"console, {m.type}: {m.text}"))
        self.page.on("pageerror", lambda e: self.problems.append(f"exception: {e}"))
        self.page.on("request", self.asked)
        self.address = path.resolve().as_uri()
        self.page.goto(self.address)
        self.settle()

    def asked(self, request):
        if request.url != self.address and not request.url.startswith("data:"):
            self.problems.append(f"asked for {request.url}")

    def settle(self):
        self.page.evaluate("() => new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")

    def look(self) -> dict:
        return {name: self.page.evaluate(LOOK, name) for name in [*PICTURES, "scan", "spectra"]}

    def text(self, name: str) -> str:
        return self.page.text_content(f"#{name}") or ""

    def press(self, name: str, key: str):
        self.page.focus(f"#{name}")
        self.page.keyboard.press(key)
        self.settle()

    def close(self) -> list[str]:
        self.context.close()
        return self.problems


def expect(holds: bool, what: str, problems: list[str]):
    if not holds:
        problems.append(what)


def reach_by_tab(desk: Desk):
    """All that can be operated has to be reached by the key Tab alone."""
    wanted = desk.page.evaluate(OPERABLE)
    desk.page.evaluate("() => document.activeElement.blur()")
    reached = set()
    for _ in range(40):
        desk.page.keyboard.press("Tab")
        reached.add(desk.page.evaluate(FOCUSED))
    known = {*PICTURES, "incidence", "wavelength", "log", "linear", "value", "true", "SUMMARY"}
    expect(len(reached & known) >= wanted, f"by Tab only {sorted(reached & known)} of {wanted} are reached", desk.problems)


def sliders(desk: Desk):
    for name in ["incidence", "wavelength"]:
        if desk.page.is_disabled(f"#{name}"):
            continue
        desk.press(name, "Home")
        before, shown, scan = desk.look(), desk.text(f"{name}-shown"), desk.text("scan-table")
        desk.press(name, "End")
        after = desk.look()
        expect(desk.text(f"{name}-shown") != shown, f"{name}: the text stays {shown}", desk.problems)
        expect(desk.text("scan-table") != scan, f"{name}: the numbers of the scan stay", desk.problems)
        for picture in ["lobe", "scan", *(["map-up", "spectra"] if name == "incidence" else [])]:
            expect(before[picture] != after[picture], f"{name}: the picture {picture} stays", desk.problems)
        desk.press(name, "Home")
        expect(desk.look() == before, f"{name}: back again, but the pictures are others", desk.problems)


def choices(desk: Desk):
    before = desk.look()
    desk.press("lobe", "ArrowLeft")
    expect(desk.look()["lobe"] != before["lobe"], "an arrow key does not turn the lobe", desk.problems)
    desk.press("lobe", "0")
    expect(desk.look()["lobe"] == before["lobe"], "0 does not turn the lobe back", desk.problems)
    facets = desk.text("facet")
    desk.press("map-up", "ArrowRight")
    first = desk.text("facet")
    desk.press("map-up", "ArrowRight")
    expect(len({facets, first, desk.text("facet")}) == 3, "arrow keys do not go from facet to facet", desk.problems)
    box = desk.page.locator("#map-up").bounding_box()
    # Left of the middle, that is at an azimuth near 180 degrees.
    desk.page.locator("#map-up").hover(position={"x": box["width"] * 0.3, "y": box["height"] * 0.5})
    desk.settle()
    phi = float(desk.text("facet").split("φ ")[1].split("°")[0])
    expect(abs(phi - 180) < 45, f"left of the middle the map tells φ {phi}", desk.problems)
    known = desk.page.evaluate("() => payload.eye !== null")
    expect(desk.page.is_visible("#paint") == known, "true colour is offered, but not known, or the other way round", desk.problems)
    if known:
        desk.page.check("input[name=paint][value=true]")
        desk.settle()
        empty = desk.page.evaluate("() => payload.most === 0")
        expect(empty or desk.look()["lobe"] != before["lobe"], "true colour changes nothing", desk.problems)
        desk.page.check("input[name=paint][value=value]")
    desk.page.check("input[name=scale][value=linear]")
    desk.settle()
    expect(desk.look()["scan"] != before["scan"], "the scale of the scan stays", desk.problems)
    desk.page.check("input[name=scale][value=log]")
    desk.settle()


def numbers(desk: Desk, result: pathlib.Path):
    """The scripts take out of the page what the result has, each facet in its place on the sphere."""
    with netcdf_file(result, mmap=False) as file:
        stored = {name: np.array(v.data) for name, v in file.variables.items()}
    facets = desk.page.evaluate(FACETS)
    read = {name: np.array([f[name] for f in facets]) for name in ["angles", "found", "trees", "values", "errors"]}
    expect(bool(read["found"].all()), "facets that are not found at their centres", desk.problems)
    expect(bool((read["trees"] == stored["facet_trees"]).all()), "facets were hit by other numbers of trees", desk.problems)
    theta, phi = np.radians(read["angles"]).T
    theta_o, phi_o = np.radians(stored["theta_o"]), np.radians(stored["phi_o"])
    cosine = np.cos(theta) * np.cos(theta_o) + np.sin(theta) * np.sin(theta_o) * np.cos(phi - phi_o)
    expect(bool((cosine > 1 - 1e-9).all()), "facets are in other places", desk.problems)
    values = np.isclose(read["values"], stored["bsdf"], rtol=ROUNDING, atol=0)
    expect(bool(values.all()), f"{(~values).sum()} values of facets differ", desk.problems)
    # What is exact but for rounding counts as having a millionth of its value.
    se = np.maximum(stored["bsdf_se"], np.where(stored["bsdf_se"] > 0, 1e-6 * stored["bsdf"], 0))
    errors = np.isclose(read["errors"], se, rtol=ROUNDING_OF_ERRORS, atol=0)
    expect(bool(errors.all()), f"{(~errors).sum()} standard errors of facets differ", desk.problems)
    for name in ["reflected", "transmitted", "specular", "lost_numeric"]:
        shares = np.array(desk.page.evaluate(LEDGER, name))
        same = all(np.allclose(shares[..., i], stored[name + end], rtol=1e-6, atol=1e-30) for i, end in enumerate(["", "_se"]))
        expect(same, f"the ledger has another {name}", desk.problems)


def wide(desk: Desk, least: int):
    width = desk.page.evaluate("() => Math.max(document.documentElement.scrollWidth, document.body.scrollWidth)")
    expect(width <= least, f"{width} pixels wide on a screen of {least}", desk.problems)


def on_desk(browser, path: pathlib.Path, pictures: pathlib.Path) -> list[str]:
    desk = Desk(browser, path, viewport={"width": 1280, "height": 900}, color_scheme="light", offline=True)
    look = desk.look()
    empty = [name for name, what in look.items() if not what and (name, what) != ("map-down", None)]
    expect(not empty, f"nothing is drawn in {empty}", desk.problems)
    if path.with_suffix(".nc").exists():
        numbers(desk, path.with_suffix(".nc"))
    reach_by_tab(desk)
    sliders(desk)
    choices(desk)
    wide(desk, 1280)
    desk.page.evaluate("() => { document.activeElement.blur(); scrollTo(0, 0); }")
    desk.page.screenshot(path=pictures / f"{path.stem}-desk.png", full_page=True)
    desk.page.pdf(path=pictures / f"{path.stem}-print.pdf", prefer_css_page_size=True)
    return desk.close()


def in_the_dark(browser, path: pathlib.Path, pictures: pathlib.Path) -> list[str]:
    desk = Desk(browser, path, viewport={"width": 1280, "height": 900}, color_scheme="dark")
    desk.page.screenshot(path=pictures / f"{path.stem}-dark.png", full_page=True)
    return desk.close()


def on_a_phone(browser, path: pathlib.Path, pictures: pathlib.Path) -> list[str]:
    desk = Desk(browser, path, viewport={"width": 360, "height": 740}, device_scale_factor=2, is_mobile=True, has_touch=True)
    wide(desk, 360)
    before = desk.text("facet")
    desk.page.tap("#map-up")
    desk.settle()
    expect(desk.text("facet") != before, "a tap chooses no facet", desk.problems)
    desk.page.evaluate("() => scrollTo(0, 0)")
    desk.page.screenshot(path=pictures / f"{path.stem}-phone.png", full_page=True)
    return desk.close()


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--chromium", default="/usr/bin/chromium")
    parser.add_argument("--pictures", type=pathlib.Path, required=True)
    parser.add_argument("pages", type=pathlib.Path, nargs="+")
    options = parser.parse_args()
    options.pictures.mkdir(parents=True, exist_ok=True)
    failed = 0
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=options.chromium, args=["--no-sandbox"])
        for path in options.pages:
            problems = [p for look in (on_desk, in_the_dark, on_a_phone) for p in look(browser, path, options.pictures)]
            failed += bool(problems)
            print(f"{path}: {'; '.join(problems) or 'fine'}")
        browser.close()
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
