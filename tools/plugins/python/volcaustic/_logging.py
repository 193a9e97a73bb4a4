"""What the library says goes to the logger "volcaustic" where a call names no other place."""

import logging

LOGGER = logging.getLogger("volcaustic")
LEVELS = {"detail": logging.DEBUG, "info": logging.INFO, "warning": logging.WARNING}


def log(level: str, line: str) -> None:
    LOGGER.log(LEVELS[level], "%s", line)
