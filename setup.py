"""What pyproject.toml cannot say: ``derivations/`` and ``course/`` travel in the wheel as data, inside the package."""

from setuptools import find_packages, setup

setup(
    packages=[*find_packages(include=["imo_analysis*"]), "imo_analysis.derivations", "imo_analysis.course"],
    package_dir={"imo_analysis.derivations": "derivations", "imo_analysis.course": "course"},
)
