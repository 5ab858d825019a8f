#!/usr/bin/env python3
"""Opens the report of write_test_report in headless Chromium and uses it: report_test.py WRITE_TEST_REPORT OUT.

Leaves OUT/report.html and OUT/report.png, and of sequences sequences.html and sequences.png. What the pictures hold is said in write_test_report.cpp.
"""
import json
import math
import subprocess
import sys
import tempfile
from pathlib import Path

from selenium import webdriver
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.chrome.service import Service
from selenium.webdriver.support.ui import Select, WebDriverWait

FLAT = "<img src=x onerror=alert(1)>"
LABELS = ["noisy", "blur", FLAT, "mean", "reference"]


def srgb(x):
    return 12.92 * x if x <= 0.0031308 else 1.055 * x ** (1 / 2.4) - 0.055


def shown(x, exposure=0.0):
    """The shade of the tone map of the metrics: sRGB of log(1 + x)."""
    return min(round(255 * srgb(math.log1p(x * 2 ** exposure))), 255)


def open_browser(profile):
    options = webdriver.ChromeOptions()
    for argument in ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars",
                     "--force-device-scale-factor=1", "--window-size=1400,1500", f"--user-data-dir={profile}"):
        options.add_argument(argument)
    options.set_capability("goog:loggingPrefs", {"browser": "ALL", "performance": "ALL"})
    driver = webdriver.Chrome(service=Service("/usr/bin/chromedriver"), options=options)
    driver.set_page_load_timeout(60)
    return driver


class Report:
    def __init__(self, driver, path):
        self.driver = driver
        driver.get(path.as_uri())
        self.wait_for_frame(0)

    def wait_for_frame(self, index):
        WebDriverWait(self.driver, 30).until(lambda d: d.execute_script("return document.body.dataset.ready") == str(index))

    def js(self, code, *arguments):
        return self.driver.execute_script(code, *arguments)

    def keys(self, *keys):
        ActionChains(self.driver).send_keys(*keys).perform()

    def element(self, name):
        return self.driver.find_element(By.ID, name)

    def texts(self, selector):
        return [element.text for element in self.driver.find_elements(By.CSS_SELECTOR, selector)]

    def method(self):
        return self.js("return document.querySelector('#method-tabs [aria-selected=true]').title")

    def colour(self, x, y):
        """What the large canvas shows in the middle of a pixel of the picture."""
        return self.js("""
          const canvas = document.getElementById('view'), scale = state.view.scale * devicePixelRatio;
          const left = Math.round(canvas.width / 2 - state.view.x * scale), top = Math.round(canvas.height / 2 - state.view.y * scale);
          return [...canvas.getContext('2d').getImageData(left + (arguments[0] + 0.5) * scale, top + (arguments[1] + 0.5) * scale, 1, 1).data];
        """, x, y)[:3]

    def hover(self, x, y):
        place = self.js("""
          const canvas = document.getElementById('view'), view = state.view;
          return [(arguments[0] + 0.5 - view.x) * view.scale, (arguments[1] + 0.5 - view.y) * view.scale];
        """, x, y)
        ActionChains(self.driver).move_to_element_with_offset(self.element("view"), round(place[0]), round(place[1])).perform()

    def scale(self):
        return self.js("return state.view.scale")


def expect(condition, what):
    if not condition:
        raise AssertionError(what)


def expect_equal(found, expected, what):
    expect(found == expected, f"{what}: found {found!r}, expected {expected!r}")


def expect_near(found, expected, tolerance, what):
    expect(all(abs(a - b) <= tolerance for a, b in zip(found, expected)), f"{what}: found {found}, expected {expected}")


def check_names(report):
    """Names are text: no element came out of them, and they read as they were given."""
    expect_equal(report.js("return document.querySelectorAll('img, section b:not(.best > b)').length"), 0, "elements made of names")
    titles = report.js("return [...document.querySelectorAll('#method-tabs button')].map((b) => b.title)")
    expect_equal(titles, LABELS, "methods")
    expect_equal(report.texts("#frame-tabs button")[1], "</script><b>bold</b>", "name of the frame")
    expect("data & <more>" in report.element("subject").text, "the data set's name")


def check_toggling(report):
    expect_equal(report.method(), FLAT, "first model at the start")
    flat = report.colour(20, 10)
    expect_near(flat, [shown(0.25), shown(0.5), shown(2)], 1, "flat picture")
    for key, label in (("1", "noisy"), ("4", "mean"), ("0", "reference"), (Keys.ARROW_LEFT, "mean"),
                       (Keys.ARROW_RIGHT, "reference")):
        report.keys(key)
        expect_equal(report.method(), label, f"after key {key!r}")
    reference = report.colour(20, 10)
    expect(reference != flat, "reference and flat picture look the same")
    report.keys("3")
    for label in ("reference", FLAT, "reference"):
        report.keys(" ")
        expect_equal(report.method(), label, "after the space bar")
    report.driver.find_element(By.CSS_SELECTOR, "#method-tabs button:nth-child(3)").click()
    expect_equal(report.colour(20, 10), flat, "colour after a click on the tab")
    report.keys(" ")  # the tab has the focus: it must not be pressed as well
    expect_equal(report.method(), "reference", "space bar with the focus on a tab")
    report.keys("3")


def check_exposure(report):
    report.js("const e = document.getElementById('exposure'); e.value = 2; e.dispatchEvent(new Event('input'));")
    expect_near(report.colour(20, 10), [shown(x, 2) for x in (0.25, 0.5, 2)], 1, "two stops brighter")
    report.keys("[")
    expect_near(report.colour(20, 10), [shown(x, 1.5) for x in (0.25, 0.5, 2)], 1, "half a stop darker")
    expect_equal(report.element("exposure-value").text, "+1.5 EV", "exposure")
    report.element("exposure-reset").click()
    Select(report.element("tone")).select_by_value("srgb")
    expect_near(report.colour(20, 10), [round(255 * srgb(x)) for x in (0.25, 0.5, 1)], 1, "plain sRGB")
    Select(report.element("tone")).select_by_value("log")
    expect_equal(report.colour(0, 0), [255, 0, 255], "a NaN")


def check_zoom(report):
    fit = report.scale()
    expect(fit >= 1 and fit == int(fit), f"fits at a whole scale: {fit}")
    report.element("zoom-in").click()
    expect_equal(report.scale(), 2 * fit, "zoomed in")
    before = report.js("return [state.view.x, state.view.y]")
    view = report.element("view")
    ActionChains(report.driver).move_to_element(view).click_and_hold().move_by_offset(40, 20).release().perform()
    after = report.js("return [state.view.x, state.view.y]")
    expect_near(after, [before[0] - 20 / fit, before[1] - 10 / fit], 0.01, "panned")
    report.keys("1")  # another method: the same place
    expect_equal(report.js("return [state.view.x, state.view.y]"), after, "view after toggling")
    report.js("""document.getElementById('view').dispatchEvent(new WheelEvent('wheel',
      {deltaY: -240, clientX: arguments[0].x + 30, clientY: arguments[0].y + 30, cancelable: true}))""", view.rect)
    expect_equal(report.scale(), 4 * fit, "the wheel")
    report.keys("f")
    expect_equal(report.scale(), fit, "fit")
    report.keys("3")


def check_pixel_values(report):
    report.hover(20, 10)
    expect_equal(report.element("pixel-place").text, "x 20, y 10", "pixel")
    rows = {row[0]: row[1:] for row in report.js("return [...document.querySelectorAll('#pixel-values tbody tr')].map((r) => [...r.cells].map((c) => c.textContent))")}
    expect_equal(list(rows), LABELS, "rows")
    expect_equal(rows[FLAT], ["0.25", "0.5", "2"], "values")
    for channel in range(3):  # smooth_picture of test_frames.h, number 0
        value = 0.6 + 0.4 * math.sin(0.2 * 20 + 0.1 * channel) * math.cos(0.15 * 10)
        expect_near([float(rows["reference"][channel])], [value], 1e-3, "reference")
    report.hover(1, 0)
    expect(report.texts("#pixel-values tbody tr:nth-child(3) td")[0] in ("60000", "59970", "6.00e+4"), "a bright pixel")
    report.hover(0, 0)
    expect_equal(report.texts("#pixel-values tbody tr:nth-child(3) td")[1], "NaN", "a NaN")


def check_errors_and_region(report):
    report.keys("0", "e")
    expect_equal(report.colour(20, 10), [0, 0, 4], "the reference has no error")
    expect(report.element("legend").is_displayed(), "the legend of the error map")
    report.keys("3")
    flat = report.colour(20, 10)
    expect(sum(flat) > 100, f"the flat picture has errors: {flat}")
    expect_equal(report.colour(0, 0), [0, 255, 0], "the error of a NaN")
    report.keys("e")
    expect_equal(report.js("return document.querySelector('[data-mode=smape]').ariaPressed"), "true", "third mode")
    report.keys("e")
    for side, value in (("x", 20), ("y", 10), ("width", 8), ("height", 4)):
        report.js("const e = document.getElementById(arguments[0]); e.value = arguments[1]; e.dispatchEvent(new Event('change'));", f"region-{side}", value)
    expect_equal(report.js("return [...document.querySelectorAll('#crops canvas')].map((c) => c.height / c.width)"), [0.5] * 5, "crops")
    crop = report.js("return [...document.querySelectorAll('#crops canvas')[2].getContext('2d').getImageData(9, 9, 1, 1).data]")
    expect_near(crop[:3], [shown(0.25), shown(0.5), shown(2)], 1, "crop of the flat picture")
    view = report.element("view")
    ActionChains(report.driver).key_down(Keys.SHIFT).move_to_element(view).click_and_hold().move_by_offset(60, 40).release().key_up(Keys.SHIFT).perform()
    region = report.js("return state.region")
    scale = report.scale()
    expect(abs(region["width"] - 60 / scale) <= 1.01 and abs(region["height"] - 40 / scale) <= 1.01, f"chosen region {region} at scale {scale}")


def check_tables(report):
    data = report.js("return report")
    scores = data["evaluation"]["methods"]
    expect_equal(len(report.texts("#score-table tbody tr")), 5, "rows of scores and the floor's")
    expect("43.50" in report.texts("#score-table tbody tr")[4], "PSNR of the floor")
    expect("two independent halves" in report.element("score-note").text, "what the floor is")
    expect("PSNR 43.50" in report.element("pair-note").text, "the floor below the pairs")
    expect("reference's floor" in report.texts("#frame-table thead th")[-1], "the floor's column")
    expect(f"{scores['mean']['mean']['psnr']:.2f}" in report.texts("#score-table tbody tr")[3], "PSNR of the mean")
    expect("NaN or infinite" in report.element("score-note").text, "the broken method is named")
    expect_equal(report.js("return document.getElementById('baseline').selectedOptions[0].textContent"), "mean", "baseline")
    expect_equal(len(report.texts("#pair-table tbody tr")), 12, "rows of pairs")
    Select(report.element("baseline")).select_by_visible_text("blur")
    pair = data["comparisons"][1]["methods"]["noisy"]["psnr"]
    expect(f"{pair['better']} : {pair['worse']}" in report.texts("#pair-table tbody tr")[3], "counts against the blur")
    expect_equal(len(report.texts("#frame-table tbody tr")), 7, "rows of frames")
    expect("17.3 M" in report.element("cost-table").text, "parameters")
    expect(report.js("return document.querySelectorAll('#cost-plot circle').length") == 1, "timed methods with a score")
    expect("(d - r)^2 / (r^2 + 0.0001)" in report.element("formula-list").text, "formulas")


def check_frames(report):
    view = report.js("return {...state.view}")
    report.element("view").click()  # takes the focus from the list of baselines
    report.keys(Keys.ARROW_DOWN)
    report.wait_for_frame(1)
    expect_equal(report.js("return {...state.view}"), view, "view of another frame of the same size")
    report.driver.find_element(By.CSS_SELECTOR, "#frame-tabs button:nth-child(7)").click()
    report.wait_for_frame(6)
    expect("40×32" in report.element("status").text, "status")
    report.driver.find_element(By.CSS_SELECTOR, "#frame-table tbody tr:nth-child(1) button").click()
    report.wait_for_frame(0)


def check_sequences(report):
    """Clips play, and differences and slices show what the frozen method, the noise and the reference do."""
    js = report.js
    WebDriverWait(report.driver, 30).until(lambda d: d.execute_script("return document.getElementById('sequences').dataset.ready") == "0")
    expect_equal(report.texts("#clip-tabs button"), ["frame_0 + 3", "frame_4 + 3"], "sequences")
    expect_equal(report.texts("#clips figcaption"), LABELS, "methods that play")

    def pixel(canvas, x, y):
        return js("return [...[...document.querySelectorAll(arguments[0])].map((c) => [...c.getContext('2d').getImageData(arguments[1], arguments[2], 1, 1).data].slice(0, 3))]", canvas, x, y)

    clip = "#clips canvas:not(.slice)"
    scale = js("return document.querySelector('#clips canvas').width / 48")
    places = (int(20 * scale), int(5 * scale))
    first = pixel(clip, *places)
    reference = [shown(0.6 + 0.4 * math.sin(0.2 * 20 + 0.1 * c) * math.cos(0.15 * 5)) for c in range(3)]
    expect_near(first[4], reference, 1, "the reference")
    js("setClipFrame(2)")
    third = pixel(clip, *places)
    expect_equal((third[2], third[4]), (first[2], first[4]), "the frozen method and the reference at the third frame")
    expect(third[3] != first[3], "noise changes")
    report.driver.find_element(By.CSS_SELECTOR, "[data-clip-mode=difference]").click()
    expect_equal(pixel(clip, *places)[4], [128] * 3, "the reference's difference")
    expect(pixel(clip, *places)[3] != [128] * 3, "the difference of the noise")
    report.driver.find_element(By.CSS_SELECTOR, "[data-clip-mode=change]").click()
    expect_equal(pixel(clip, *places)[2], [128] * 3, "the frozen method's change")
    report.driver.find_element(By.CSS_SELECTOR, "[data-clip-mode=picture]").click()
    js("setClipLine(5)")
    rows = js("return document.querySelector('#clips .slice').height") // 4
    columns = [pixel("#clips .slice", 20, rows * f + rows // 2) for f in range(4)]
    expect(all(column[2] == columns[0][2] for column in columns), "no stripes of the frozen method")
    expect_near(columns[0][4], reference, 1, "the reference's slice")
    expect(len({tuple(column[3]) for column in columns}) == 4, "stripes of the noise")
    report.element("clip-play").click()
    expect_equal(report.element("clip-play").text, "Pause", "while it plays")
    WebDriverWait(report.driver, 10).until(lambda d: d.execute_script("return clip.frame") not in (2,))
    report.element("clip-play").click()
    frame = js("return clip.frame")
    expect_equal(report.texts("#clip-name"), [f"frame_{frame}"], "the frame's name")
    report.driver.find_element(By.CSS_SELECTOR, "#clip-tabs button:nth-child(2)").click()
    WebDriverWait(report.driver, 10).until(lambda d: d.execute_script("return document.getElementById('sequences').dataset.ready") == "1")
    expect_equal(report.texts("#clip-name"), ["frame_4"], "the other sequence")
    rows = report.texts("#sequence-table tbody tr")
    expect_equal(len(rows), 4, "rows of scores of sequences")
    expect("steadier ↑" in report.texts("#sequence-table thead th") and "detail → 1" in report.texts("#sequence-table thead th"), "measures")
    expect("2 sequences" in report.element("sequence-note").text, "what the means are over")
    expect("mean of |e|" in report.element("formula-list").text, "formulas of the measures")
    widths = js("return [...document.querySelectorAll('#curves img')].map((i) => i.complete && i.naturalWidth)")
    expect(len(widths) == 3 and all(widths), f"curves: {widths}")
    expect_equal(js("return document.querySelectorAll('img:not(.curve)').length"), 0, "elements made of names")


def check_silence(driver, page):
    """No complaint on the console, nothing asked of anyone but the file itself."""
    complaints = [entry for entry in driver.get_log("browser")
                  if entry["source"] != "rendering"]  # "rendering" remarks on how often this test reads canvases
    expect_equal(complaints, [], "console")
    requests = [message["params"]["request"]["url"] for message in
                (json.loads(entry["message"])["message"] for entry in driver.get_log("performance"))
                if message["method"] == "Network.requestWillBeSent"]
    own = (page.as_uri(), "data:", "chrome:")  # the last: the browser's page for new tabs
    expect_equal([url for url in requests if not url.startswith(own)], [], "requests")
    expect(page.as_uri() in requests, "the log of requests is empty")


CHECKS = (check_names, check_toggling, check_exposure, check_zoom, check_pixel_values, check_errors_and_region, check_tables,
          check_frames)


def main():
    program, out = Path(sys.argv[1]), Path(sys.argv[2]).absolute()
    out.mkdir(parents=True, exist_ok=True)
    page = out / "report.html"
    subprocess.run([program, page], check=True)
    with tempfile.TemporaryDirectory() as profile:
        driver = open_browser(profile)
        try:
            report = Report(driver, page)
            for check in CHECKS:
                check(report)
                print(check.__name__, "passed", flush=True)
            check_silence(driver, page)
            driver.save_screenshot(str(out / "report.png"))
            page = out / "sequences.html"
            subprocess.run([program, page, "sequences"], check=True)
            report = Report(driver, page)
            check_sequences(report)
            print("check_sequences passed", flush=True)
            check_silence(driver, page)
            report.element("sequences").screenshot(str(out / "sequences.png"))
        finally:
            driver.quit()


if __name__ == "__main__":
    main()
