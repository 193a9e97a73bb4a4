"""Loads the reader: paraview --script=load.py, or first thing in a script for pvpython. Where ParaView takes Python plugins by
itself, Tools > Manage Plugins does the same."""

import inspect
import os

from paraview.simple import LoadPlugin

# ParaView 5.11 asks for a function that Python 3.11 no longer has.
if not hasattr(inspect, "getargspec"):
    inspect.getargspec = inspect.getfullargspec

LoadPlugin(os.path.join(os.path.dirname(os.path.realpath(__file__)), "volcaustic_vdb.py"), remote=False, ns=globals())
