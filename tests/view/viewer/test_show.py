"""``show`` does the right thing wherever Python runs."""

import asyncio
import os
import signal
import sys
from types import ModuleType, SimpleNamespace

import aiohttp
import pytest

import skinviz
from skinviz.view.viewer.show import in_notebook


@pytest.fixture
def notebook(monkeypatch):
    """Stand in for IPython in the kernel of a notebook."""
    shell, display = ModuleType("IPython"), ModuleType("IPython.display")
    shell.get_ipython = lambda: SimpleNamespace(kernel=object())
    display.IFrame = lambda url, _, height: SimpleNamespace(url=url, height=height)
    monkeypatch.setitem(sys.modules, "IPython", shell)
    monkeypatch.setitem(sys.modules, "IPython.display", display)
    return shell


def test_a_script_opens_the_browser_and_ends_when_interrupted(
    opened, monkeypatch, capsys
):
    seen = []

    def browse(url):
        seen.append(url)
        os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr("webbrowser.open", browse)
    assert skinviz.show(opened.scene) is None
    assert "secret=" in seen[0]
    assert seen[0] in capsys.readouterr().out


def test_a_notebook_gets_a_frame_that_answers(opened, notebook):
    async def cell():
        frame = skinviz.show(opened.scene)
        assert frame.height > 300
        await asyncio.sleep(0.5)  # the cell has ended, the kernel lives on
        async with aiohttp.ClientSession() as session, session.get(frame.url) as page:
            assert page.status == 200
            allowed = page.headers["Content-Security-Policy"]
            assert "frame-ancestors 'self' http://localhost:*" in allowed

    asyncio.run(cell())


def test_a_terminal_of_ipython_is_no_notebook(notebook):
    assert in_notebook()
    notebook.get_ipython = SimpleNamespace
    assert not in_notebook()
    notebook.get_ipython = lambda: None
    assert not in_notebook()
