"""The viewer at work: what browsers ask for, and the pictures they get.

Requests only change the state; one task draws the newest, so that a slider that
moves faster than pictures are made is never behind.
"""

from __future__ import annotations

import asyncio
import logging
import threading
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any, TypeVar

from skinviz.errors import SkinvizError
from skinviz.view.viewer.asked import listen_to_requests
from skinviz.view.viewer.frames import quick_frame, still_frame
from skinviz.view.viewer.history import History
from skinviz.view.viewer.opened import Opened
from skinviz.view.viewer.pictures import Darkroom, Shown
from skinviz.view.viewer.samples import Sample
from skinviz.view.viewer.saving import command, save_scene, save_view_figure
from skinviz.view.viewer.settings import listen_to_settings
from skinviz.view.viewer.state import ViewState
from skinviz.view.viewer.told import opening_told, settings_of

_LOG = logging.getLogger(__name__)

Result = TypeVar("Result")

_STILL_AFTER = 0.15  # s without a change
_BUSY_AFTER = 0.3  # s of work, after which the page says so


class Viewer:
    """One view, shared by all browsers that look at it.

    Parameters
    ----------
    opened : Opened
        What there is to show.
    server : trame_server.Server
        By which browsers are told.
    """

    def __init__(self, opened: Opened, server: Any) -> None:
        """Take what is opened and who asks for it."""
        self.opened = opened
        self.history = History(opened.initial)
        self.shown: Shown | None = None
        self.size = (640, 640)
        self._server = server
        self._darkroom = Darkroom(opened)
        # Quick pictures do not wait for a still one that has become old.
        self._quick = ThreadPoolExecutor(1, "skinviz-quick")
        self._slow = ThreadPoolExecutor(1, "skinviz-slow")
        self._wake = asyncio.Event()  # used in one loop, whichever thread made it
        self._drawing: asyncio.Task[None] | None = None
        self._version = 0
        listen_to_settings(self, server)
        listen_to_requests(self, server)

    @property
    def state(self) -> ViewState:
        """What is to be shown."""
        return self.history.present

    def sample(self) -> Sample:
        """Return whose skin the active hand has, the scene's own before it is known."""
        shown, look = self.shown, self.state.look
        if shown is not None:
            for sample, own in zip(shown.samples, shown.state.looks, strict=True):
                if (own.person, own.site) == (look.person, look.site):
                    return sample
        return self.opened.own

    def begin(self) -> None:
        """Tell what was opened, and start to draw."""
        self._tell(**opening_told(self.opened))
        self._drawing = asyncio.create_task(self._draw())
        self._wake.set()

    async def close(self) -> None:
        """Stop drawing."""
        if self._drawing is not None:
            self._drawing.cancel()
            await asyncio.gather(self._drawing, return_exceptions=True)
        self._quick.shutdown(wait=False, cancel_futures=True)
        self._slow.shutdown(wait=False, cancel_futures=True)

    def change(self, make: Callable[[ViewState], ViewState]) -> None:
        """Show what is made of the present state; say why where that cannot be."""
        try:
            changed = make(self.state)
        except SkinvizError as error:
            self.refuse(str(error))
            return
        self._turn_to(self.history.changed(changed, time.monotonic()))

    def undo(self) -> None:
        """Go one step back."""
        self._turn_to(self.history.undone())

    def redo(self) -> None:
        """Take a step again."""
        self._turn_to(self.history.redone())

    def resize(self, width: int, height: int) -> None:
        """Draw pictures of another size. [pixels]"""
        if (width, height) != self.size:
            self.size = (width, height)
            self._wake.set()

    def list_people(self, group: str) -> None:
        """Offer the people of a group."""
        samples = self.opened.samples
        with self._server.state as told:
            told.groups = samples.groups()
            told.people = samples.people(group)

    def own_site(self) -> str:
        """Return the site of the scene's own skin, as far as it is known."""
        return str(self.opened.own.table.get("site", ""))

    def notice(self, text: str, *, bad: bool = True) -> None:
        """Show a line of text on the page."""
        with self._server.state as told:
            self._version += 1  # the same words twice are two notices
            told.notice = {"text": text, "bad": bad, "number": self._version}

    def refuse(self, text: str) -> None:
        """Say why something cannot be; controls that were set to it go back."""
        self.notice(text)
        if self.shown is not None and self.shown.state == self.state:
            self._tell(**settings_of(self.shown))

    async def save_scene(self, name: str) -> str | None:
        """Write the active hand's scene; return the command that draws it anew."""
        shown = self.shown
        if shown is None:
            return None
        file = await self._try(partial(save_scene, self.opened, shown, name))
        if file is None:
            return None
        self.notice(f"saved {file}", bad=False)
        return command(file.name, shown.state)

    async def save_figure(self, name: str) -> None:
        """Write the figure of what is shown."""
        if self.shown is None:
            return
        work = partial(save_view_figure, self.opened, self.shown, name)
        file = await self._try(work)
        if file is not None:
            self.notice(f"saved {file}", bad=False)

    def _turn_to(self, history: History) -> None:
        """Show the present of a history."""
        if history.present != self.state:
            self._wake.set()
        self.history = history

    async def _try(self, work: Callable[[], Result]) -> Result | None:
        """Do slow work beside the pictures; say why where it cannot be done."""
        try:
            return await self._busily(self._slow, work)
        except SkinvizError as error:
            self.notice(str(error))
        except Exception as error:  # a fault of ours must not end the view
            self._own_up("saving", error)
        return None

    def _own_up(self, work: str, error: Exception) -> None:
        """Tell of a fault that nobody else has made."""
        _LOG.exception("%s failed", work)
        self.notice(f"{work} failed: {error!r}; this is a fault of skinviz")

    async def _busily(
        self, pool: ThreadPoolExecutor, work: Callable[[], Result]
    ) -> Result:
        """Do work in a thread; the page says so if it takes long."""
        future = asyncio.get_running_loop().run_in_executor(pool, work)
        done, _ = await asyncio.wait([future], timeout=_BUSY_AFTER)
        if not done:
            self._tell(busy=True)
        try:
            return await future
        finally:
            if not done:
                self._tell(busy=False)

    async def _draw(self) -> None:
        """Draw the newest state whenever there is one, and a still one after it."""
        while True:
            await self._wake.wait()
            self._wake.clear()
            state = self.state
            try:
                await self._draw_state(state)
            except SkinvizError as error:
                self.notice(str(error))
                self._return_to_shown(state)
            except Exception as error:  # a fault of ours must not end the view
                self._own_up("drawing", error)
                self._return_to_shown(state)

    async def _draw_state(self, state: ViewState) -> None:
        """Draw a state, quickly at first."""
        work = partial(quick_frame, self._darkroom, state, self.size, self.shown)
        shown, told = await self._busily(self._quick, work)
        self.shown = shown
        if self.state is state:  # or what is being set would jump back
            told |= settings_of(shown)
        self._tell(still=False, **told)
        if await self._is_quiet():
            await self._draw_still(state)

    async def _is_quiet(self) -> bool:
        """Return whether nothing changes for a moment."""
        try:
            await asyncio.wait_for(self._wake.wait(), _STILL_AFTER)
        except TimeoutError:
            return True
        return False

    async def _draw_still(self, state: ViewState) -> None:
        """Show the picture within the tolerance, unless it has become old."""
        outdated = threading.Event()
        drawing = partial(still_frame, self._darkroom, state, self.size, outdated)
        work = asyncio.ensure_future(self._busily(self._slow, drawing))
        woken = asyncio.ensure_future(self._wake.wait())
        await asyncio.wait([work, woken], return_when=asyncio.FIRST_COMPLETED)
        woken.cancel()
        if not work.done():
            outdated.set()
            work.add_done_callback(_forgotten)
            return
        self._tell(still=True, **work.result())

    def _return_to_shown(self, failed: ViewState) -> None:
        """Go back to what could be shown, if nobody has gone elsewhere."""
        if self.shown is not None and self.state == failed:
            self.history = self.history.undone()
            if self.state == failed:  # nothing was before
                self._tell(**settings_of(self.shown))
            else:  # also what is shown, for its still picture may be missing
                self._wake.set()

    def _tell(self, **told: Any) -> None:
        """Set variables of the page."""
        with self._server.state as variables:
            variables.update(told)


def _forgotten(work: asyncio.Future[Any]) -> None:
    """Take note of a result that nobody waits for any more."""
    if not work.cancelled():
        work.exception()
