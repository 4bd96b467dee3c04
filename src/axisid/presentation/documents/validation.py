"""Estimates held against another record, as plain data."""

import math
from dataclasses import asdict
from typing import Any

from axisid.estimation.studies import Validation

from .identification import record_dict


def validation_dict(validation: Validation) -> dict[str, Any]:
    """Plain numbers and texts; what is not finite becomes null."""
    return {
        "record": record_dict(validation.record),
        "methods": [
            {
                name: None if isinstance(value, float) and not math.isfinite(value) else value
                for name, value in asdict(v).items()
            }
            for v in validation
        ],
        "time_base": validation.time_base or None,
    }
