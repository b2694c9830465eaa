"""Is the lumped chain adequate, measured by a crankshaft of superelements?"""

import crankfem as cf

engine = cf.load_engine("6chn25-34")
analysis = cf.analyze_throw(engine.throw, engine.material, accuracy=0.1)  # coarse, for a quick look
run = cf.engine_vibration(engine, analysis=analysis, coupled=True)

modes = run.whole.modes
for mode in range(modes.rigid, modes.rigid + 4):
    print(f"crankshaft {modes.frequencies[mode]:6.1f} Hz: {modes.label(mode)}")
for verdict in run.comparison.verdicts:
    first, second = getattr(run, verdict.kind).chosen.elastic_frequencies[:2]
    adequate = "adequate" if verdict.suffices else "inadequate"
    print(f"{verdict.kind} chain, {first:.1f} and {second:.1f} Hz: {adequate}")
    for reason in verdict.reasons:
        print(f"  {reason}")
