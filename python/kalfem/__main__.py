# SPDX-License-Identifier: Apache-2.0
"""The command: ``python -m kalfem run case.yaml``."""

import sys

from .command import main

sys.exit(main())
