"""What a programmer hands over by mistake is refused at the public functions."""

import numpy as np

import crankfem as cf
from refusals import refusals

CHAIN = cf.Chain(inertia=[1.0, 2.0], stiffness=[100.0])
ENGINE = cf.load_engine("6chn25-34")
UNIT = cf.OrderExcitation([1.0], [10.0], np.ones((1, 1, 2)))
MASKED = np.ma.masked_array([1.0, 2.0, 3.0, 4.0], mask=[0, 1, 0, 0])

test_what_is_another_object_is_refused = refusals(
    ("analysis", lambda: cf.engine_vibration(ENGINE, analysis="throw")),
    ("analysis", lambda: cf.whole_shaft(ENGINE, None)),
    ("engine_file", lambda: cf.whole_shaft("6chn25-34", None)),
    ("excitation", lambda: cf.forced_response(CHAIN, np.ones((1, 1, 2)))),
    ("chain_or_system", lambda: cf.forced_response("mwm-six", UNIT)),
    ("chain", lambda: cf.damped("mwm-six")),
    ("samples", lambda: cf.harmonics(MASKED, strokes=4)),
    ("size_factor", lambda: cf.mesh_throw(ENGINE.throw, size_factor=float("nan"))),
    ("size_factor", lambda: cf.mesh_throw(ENGINE.throw, size_factor="fine")),
    ("time_limit", lambda: cf.mesh_throw(ENGINE.throw, time_limit=-1.0)),
)
