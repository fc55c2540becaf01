"""The version of the package; that of poretwin."""

__version__ = "0.1.0"
