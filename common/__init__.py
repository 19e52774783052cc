"""Code that every part needs: errors a user can act on, validated configuration, files written whole or not at all.

May import: no other folder.
"""

from common import processor  # noqa: F401  must come before numpy: it sets the variables that numpy reads when loaded
