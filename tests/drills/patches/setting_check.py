"""The setting is read from the environment."""

import os

from mcml_service.settings import Settings

os.environ["MCML_" + "motto".upper()] = "dance"
assert Settings().motto == "dance"
