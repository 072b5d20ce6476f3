# SPDX-License-Identifier: Apache-2.0
"""The compiled module is built by CMake before: this only says that the wheel is for one platform."""

from setuptools import Distribution, setup


class CompiledDistribution(Distribution):
    def has_ext_modules(self):
        return True


setup(distclass=CompiledDistribution)
