"""The page in a real browser: what a researcher does, and what they then see."""

import asyncio
import base64
import contextlib
import dataclasses
import io
import shutil
import threading

import numpy as np
import pytest
from PIL import Image

from skinviz.view.viewer.opened import open_path
from skinviz.view.viewer.server import start

pytestmark = pytest.mark.browser

PICTURE = "[data-test=picture]"
SIZE = {"width": 1280, "height": 720}


@contextlib.contextmanager
def served(opened):
    """Serve in a thread of its own; Playwright's calls keep this one."""
    ready, loop = threading.Event(), asyncio.new_event_loop()
    running, ended = [], asyncio.Event()

    async def serve():
        running.append(start())
        await running[0].answering()
        await running[0].show(lambda: opened)
        ready.set()
        await ended.wait()
        await running[0].stop()

    thread = threading.Thread(target=lambda: loop.run_until_complete(serve()))
    thread.start()
    try:
        assert ready.wait(60)
        yield running[0]
    finally:
        loop.call_soon_threadsafe(ended.set)
        thread.join(60)
        loop.close()


@pytest.fixture(scope="module")
def running(tmp_path_factory):
    opened = open_path(None)
    folder = tmp_path_factory.mktemp("saved")
    with served(dataclasses.replace(opened, folder=folder)) as serving:
        yield serving


@pytest.fixture(scope="module")
def chromium():
    from playwright.sync_api import sync_playwright

    program = shutil.which("chromium")
    assert program, "install Debian's chromium, or leave out: -m 'not browser'"
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=program, args=["--no-sandbox", "--disable-dev-shm-usage"]
        )
        yield browser
        browser.close()


@pytest.fixture
def page(running, chromium):
    """A page that shows the still picture of the scene as it is, without errors."""
    context = chromium.new_context(viewport=SIZE)
    opened = context.new_page()
    faults = []
    opened.on("pageerror", lambda error: faults.append(str(error)))
    opened.goto(running.url)
    opened.wait_for_selector(PICTURE)
    wait_still(opened)
    if "?" in opened.url or running.viewer.state != running.viewer.opened.initial:
        with shown_anew(opened):
            opened.locator("[data-test=reset]").click()
    yield opened
    context.close()
    assert not faults


def wait_still(page):
    """Wait until the picture is still."""
    page.wait_for_selector(f"{PICTURE}[data-still=true]")


@contextlib.contextmanager
def shown_anew(page):
    """Wait, after what is done within, until a new still picture is shown."""
    old = page.locator(PICTURE).get_attribute("src")
    yield
    page.wait_for_function(
        "old => document.querySelector('[data-test=picture]').src !== old", arg=old
    )
    wait_still(page)


def picture(page):
    """Return the still picture that the page shows (height, width, 3)."""
    source = page.wait_for_function(
        """() => {
          const shown = document.querySelector('[data-test=picture]');
          return shown.dataset.still === 'true' && shown.src;
        }"""
    )
    kind, content = source.json_value().split(",")
    assert kind == "data:image/png;base64"
    with Image.open(io.BytesIO(base64.b64decode(content))) as image:
        return np.asarray(image.convert("RGB"))


def value_of(page, name):
    """Return the number that stands over a slider."""
    group = page.locator(f"[data-test={name}]").locator("xpath=../..")
    return group.locator(".sv-value").first.inner_text()


def click_at(page, across, along, **options):
    """Click the picture at shares of its width and height."""
    box = page.locator(PICTURE).bounding_box()
    at = {"x": box["width"] * across, "y": box["height"] * along}
    page.locator(PICTURE).click(position=at, **options)


def curves(page, name):
    """Return the names of a chart's curves."""
    chart = page.locator(f"[data-test={name}_chart]")
    return chart.locator(".legendtext").all_text_contents()


def test_points_are_marked_by_keys_alone(page):
    page.locator(PICTURE).focus()
    page.keyboard.press("Enter")
    page.wait_for_selector("text=L* ")
    page.keyboard.press("ArrowUp")
    page.keyboard.press("Shift+Enter")
    page.wait_for_selector("text=ΔE00 between A and B")
    wait_still(page)
    page.keyboard.press("Escape")
    page.wait_for_selector("text=ΔE00 between A and B", state="detached")


def test_the_picture_keeps_its_size_while_it_turns(page):
    """Pictures of what moves have fewer pixels, which are then shown larger."""
    measure = """() => {
      const shown = document.querySelector('[data-test=picture]');
      const box = shown.getBoundingClientRect();
      const frame = document.querySelector('[data-test=middle]');
      return [shown.naturalWidth, box.width, box.height, frame.clientWidth];
    }"""
    page.set_viewport_size({"width": 1600, "height": 1000})
    page.wait_for_function(f"({measure})()[0] === ({measure})()[3]")
    wait_still(page)
    pixels, *still = page.evaluate(measure)
    page.locator(PICTURE).focus()
    page.keyboard.press("ArrowLeft")
    page.wait_for_function(f"({measure})()[0] < {pixels}")
    _, *moving = page.evaluate(measure)
    assert moving == pytest.approx(still, abs=1)
    wait_still(page)
    assert page.evaluate(measure)[1:] == pytest.approx(still, abs=1)


def test_the_page_shows_the_hand_its_skin_and_its_light(page):
    shown = picture(page)
    assert shown.std() > 20
    assert page.title() == "skinviz: shipped hand"
    assert curves(page, "reflectance")[:2] == ["measured", "fitted"]
    assert curves(page, "illuminant") == ["D65"]
    assert page.locator(".sv-range").count() == 3
    page.get_by_text("still: ΔE00 ≤ 1").wait_for()
    assert "sampling" in page.locator("[data-test=plan]").inner_text()


def test_a_slider_changes_the_picture_and_the_number(page):
    before, number = picture(page), value_of(page, "weight_0")
    page.locator("[data-test=weight_0] [role=slider]").focus()
    with shown_anew(page):
        for _ in range(5):
            page.keyboard.press("PageUp")
    after = picture(page)
    assert float(value_of(page, "weight_0")) > float(number)
    assert after.mean() < before.mean() - 1  # more melanin is darker
    with shown_anew(page):
        page.keyboard.press("Control+z")
    np.testing.assert_array_equal(picture(page), before)
    assert value_of(page, "weight_0") == number


def test_a_drag_turns_the_hand_and_arrows_do(page):
    before = picture(page)
    box = page.locator(PICTURE).bounding_box()
    with shown_anew(page):
        page.mouse.move(box["x"] + 300, box["y"] + 300)
        page.mouse.down()
        page.mouse.move(box["x"] + 360, box["y"] + 300, steps=6)
        page.mouse.up()
    assert (picture(page) != before).mean() > 0.05
    assert "view=" in page.url
    angle = value_of(page, "view_angle")
    page.locator(PICTURE).focus()
    with shown_anew(page):
        page.keyboard.press("ArrowLeft")
    assert value_of(page, "view_angle") != angle
    with shown_anew(page):
        page.keyboard.press("0")
    np.testing.assert_array_equal(picture(page), before)


def test_a_click_shows_the_spectrum_of_a_point(page):
    assert page.locator("[data-test=radiance_chart] .sv-empty").is_visible()
    click_at(page, 0.5, 0.62)
    page.wait_for_selector(".sv-mark")
    page.wait_for_selector("[data-test=radiance_chart] .legendtext")
    assert curves(page, "radiance") == ["A", "A diffuse", "A specular"]
    click_at(page, 0.47, 0.75, modifiers=["Shift"])
    page.wait_for_selector("[data-test=difference]")
    told = page.locator("[data-test=points]").inner_text()
    assert "L*" in told
    assert "ΔE00 between A and B" in told
    page.wait_for_function(
        "document.querySelectorAll('[data-test=radiance_chart] .legendtext')"
        ".length === 6"
    )


def test_the_picture_has_the_colour_that_is_told(page, running):
    """Where the skin is even, to one level: the still picture is sent without loss."""
    with shown_anew(page):
        click_at(page, 0.5, 0.62)
    shown = picture(page)
    told = page.locator("[data-test=points]").inner_text()
    rgb = [int(word) for word in told.split("sRGB")[1].split()[:3]]
    height, width, _ = shown.shape
    pixel = shown[int(0.62 * height), int(0.5 * width)].astype(int)
    assert np.abs(pixel - rgb).max() <= 1
    # And so it is on the screen, in what the browser draws.
    box = page.locator(PICTURE).bounding_box()
    page.locator(PICTURE).focus()
    with shown_anew(page):
        page.keyboard.press("Escape")
    page.wait_for_selector(".sv-mark", state="detached")
    with Image.open(io.BytesIO(page.screenshot())) as screen:
        drawn = np.asarray(screen.convert("RGB")).astype(int)
    x, y = int(box["x"] + 0.5 * box["width"]), int(box["y"] + 0.62 * box["height"])
    assert np.abs(drawn[y, x] - rgb).max() <= 1


def choose(page, name, text):
    """Choose an entry of a list by its text."""
    page.locator(f"[data-test={name}]").click()
    page.locator(".v-overlay--active .v-list-item", has_text=text).first.click()


def test_from_daylight_to_a_lamp(page):
    before = picture(page)
    with shown_anew(page):
        choose(page, "illuminant", "A")
    after = picture(page)
    red = after[..., 0].mean() / after[..., 2].mean()
    assert red > 1.2 * before[..., 0].mean() / before[..., 2].mean()
    assert curves(page, "illuminant") == ["A"]


def test_two_people_and_the_map_between_them(page):
    page.locator("[data-test=hands] button").nth(1).click()
    page.locator("[data-test=active] button").nth(1).click()
    page.locator("[data-test=person] input").fill("UK/12")
    with shown_anew(page):
        page.locator(".v-overlay--active .v-list-item", has_text="UK/12").first.click()
    with shown_anew(page):
        page.locator("[data-test=difference_map] input").check()
    page.wait_for_selector(".sv-scale")
    shown = picture(page)
    names = page.locator(".sv-name").all_inner_texts()
    assert [name[:1] for name in names] == ["1", "2", "Δ"]
    assert "UK/12 back of hand" in names[1]
    third = shown.shape[1] // 3
    left, middle = shown[:, : third - 2], shown[:, third + 2 : 2 * third]
    assert (
        abs(left[left.shape[0] // 2].mean() - middle[middle.shape[0] // 2].mean()) > 0.1
    )


def test_a_figure_and_a_scene_are_saved(page, running):
    folder = running.viewer.opened.folder
    page.locator("[data-test=file_name] input").fill("by hand")
    page.locator("[data-test='save figure']").click()
    page.wait_for_selector(".sv-notice:has-text('by hand.png')")
    with Image.open(folder / "by hand.png") as figure:
        assert min(figure.size) > 500
    page.locator("[data-test='save scene, and copy command']").click()
    command = page.locator(".sv-command")
    command.wait_for()
    assert command.inner_text().startswith("skinviz render 'by hand.toml' -o")
    assert (folder / "by hand.toml").is_file()
    page.locator("[data-test='save scene']").click()  # it is there already
    page.wait_for_selector(".sv-notice:has-text('choose another name')")


def test_a_link_shows_the_same_and_a_reload_is_let_in(page, running, chromium):
    with shown_anew(page):
        page.locator("button", has_text="60/60").click()
    shown, link = picture(page), page.url
    assert "secret" not in link
    with shown_anew(page):
        page.locator("[data-test=reset]").click()
    page.goto(link)  # the browser is known by its cookie
    page.wait_for_function("document.querySelector('.sv-value')")
    page.wait_for_url("**view=60*")
    page.wait_for_function("window.trame.state.get('view_angle') === 60")
    np.testing.assert_array_equal(picture(page), shown)


def test_two_browsers_share_the_view(page, running, chromium):
    context = chromium.new_context(viewport=SIZE)
    other = context.new_page()
    other.goto(running.url)
    other.wait_for_selector("[data-test=browsers]")
    with shown_anew(page):
        choose(other, "illuminant", "FL2")
    wait_still(other)
    np.testing.assert_array_equal(picture(page), picture(other))
    context.close()
    page.wait_for_selector("[data-test=browsers]", state="detached")


@pytest.mark.parametrize("size", [(1280, 720), (2560, 1440)])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_nothing_is_cut_off(running, chromium, size, scheme):
    """Every text fits its box, and no panel is empty or beyond the page."""
    context = chromium.new_context(
        viewport={"width": size[0], "height": size[1]}, color_scheme=scheme
    )
    page = context.new_page()
    page.goto(running.url)
    page.wait_for_selector(PICTURE)
    wait_still(page)
    with shown_anew(page):
        click_at(page, 0.5, 0.62)
    page.wait_for_selector("[data-test=radiance_chart] .legendtext")
    theme = page.locator(".v-application").get_attribute("class")
    assert f"v-theme--{scheme}" in theme
    cut = page.evaluate(CUT)
    assert cut == []
    for name in ("reflectance", "radiance", "illuminant"):
        box = page.locator(f"[data-test={name}_chart] .main-svg").first.bounding_box()
        assert box["width"] > 300
        assert box["height"] > 100
        assert box["y"] + box["height"] <= size[1]
    box = page.locator(PICTURE).bounding_box()
    assert min(box["width"], box["height"]) > 0.4 * size[1]
    context.close()


CUT = """
() => [...document.querySelectorAll(
    '.sv-label, .sv-value, .sv-legend, .sv-chart-title, .sv-points td, .sv-title, ' +
    '.v-field__input, .v-btn__content, .sv-plan td'
  )].filter((e) => e.offsetParent && e.scrollWidth > e.clientWidth + 1 &&
    getComputedStyle(e).display !== 'inline')
  .map((e) => e.className + ': ' + e.innerText)
"""
