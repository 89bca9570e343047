"""States that were, to go back to."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

from skinviz.view.viewer.state import ViewState

_MOST = 200
_PAUSE = 1.0  # s, within which changes of one attribute are one step


@dataclass(frozen=True)
class History:
    """The present state, those before it and those that were undone.

    Attributes
    ----------
    present : ViewState
        What is shown.
    past, future : tuple of ViewState
        The nearest last.
    touched : tuple of str
        What the last step changed.
    at : float
        When that was. [s]
    """

    present: ViewState
    past: tuple[ViewState, ...] = ()
    future: tuple[ViewState, ...] = ()
    touched: tuple[str, ...] = ()
    at: float = -_PAUSE

    def changed(self, state: ViewState, now: float) -> History:
        """Return the history with a new present; a drag is one step."""
        if state == self.present:
            return self
        touched = tuple(
            field.name
            for field in dataclasses.fields(state)
            if getattr(state, field.name) != getattr(self.present, field.name)
        )
        same = touched == self.touched and now - self.at < _PAUSE
        past = self.past if same else (*self.past, self.present)[-_MOST:]
        return History(state, past, (), touched, now)

    def undone(self) -> History:
        """Return the history one step back."""
        if not self.past:
            return self
        return History(self.past[-1], self.past[:-1], (*self.future, self.present))

    def redone(self) -> History:
        """Return the history with the last step back taken again."""
        if not self.future:
            return self
        return History(self.future[-1], (*self.past, self.present), self.future[:-1])
