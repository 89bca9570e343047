"""How a request is answered: what is wrong with it is told, and ends nothing."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from skinviz.errors import SkinvizError

if TYPE_CHECKING:
    from skinviz.view.viewer.app import Viewer


def checked(viewer: Viewer, answer: Callable[..., Any]) -> Callable[..., Any]:
    """Return a request's answer that tells what is wrong instead of failing."""

    def answered(*given: Any) -> Any:
        try:
            return answer(viewer, *given)
        except SkinvizError as error:
            viewer.refuse(str(error))
        # More or fewer arguments, of other kinds, or beyond all numbers.
        except (TypeError, ValueError, OverflowError):
            viewer.refuse("the page asked for something that the viewer has not")
        return None

    return answered
