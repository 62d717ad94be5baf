"""`python -m prsm_jax` is `prsm`."""

from .cli import main

raise SystemExit(main())
