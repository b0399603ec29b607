"""`python -m gyrotest`: the same as `gyrotest`."""

import sys

from gyrotest.cli import main

sys.exit(main())
