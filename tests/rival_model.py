"""A second model with a parameter less and one of its own, to compare with."""

from dataclasses import dataclass

import pytest

from skinviz.skin import models
from skinviz.skin.model import PIGMENTS, Parameter
from skinviz.skin.two_layer import TwoLayer

BLOOD = Parameter("blood", "1", 0.0, 1e12, "whole blood of one unnamed kind")


@dataclass(frozen=True)
class Rival(TwoLayer):
    """The two layers over a grey backing, the pigments under other names."""

    name = "rival"

    @property
    def parameters(self):
        return (PIGMENTS[0], BLOOD, PIGMENTS[2])

    def _constants(self, surface):
        epidermis, dermis, _, *rest = super()._constants(surface)
        return (epidermis, dermis, 0.2, *rest)


@pytest.fixture
def rival(monkeypatch):
    """Make the model known by its name."""
    monkeypatch.setitem(models._MODELS, Rival.name, Rival)
    return Rival
