"""The one thing that pyproject.toml cannot say: ``derivations/`` travels in the wheel as data, inside the package."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["imo_analysis*"]), "imo_analysis.derivations"],
    package_dir={"imo_analysis.derivations": "derivations"},
    package_data={"imo_analysis.derivations": ["*.py"]},
)
