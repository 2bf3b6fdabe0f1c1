# SPDX-License-Identifier: Apache-2.0
"""`python -m irt_usd` is `irt`."""

from irt_usd.cli.main import main

if __name__ == "__main__":
    main()
