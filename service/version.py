"""The version that every plan, report and log carries."""

from importlib.metadata import version

__version__ = version("drumtrue")
