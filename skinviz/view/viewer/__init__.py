"""The interactive viewer: a page in the browser, a window, or a cell of a notebook.

A frozen :class:`ViewState` says what is shown; pictures, numbers and curves are
functions of it and of what was opened, and know no browser. ``page`` lays them out,
``app`` hands them to and fro, ``server`` guards the door.
"""
