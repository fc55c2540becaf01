"""The version of the package, which is the version of poretwin."""

__version__ = "0.1.0"
