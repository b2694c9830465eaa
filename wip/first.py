import sys; sys.path.insert(0,"/tmp/wt/fe21/tests/campaigns"); sys.path.insert(0,'/tmp/fe21')
import numpy as np, crankfem as cf,time
from random_throws import random_throw
from crankbase.stopwatch import Stopwatch
from fem.accuracy import *
p=Problem(cf.STEEL,"auto","rigid",Stopwatch())
for s in list(range(2001,2026)):
    try: t=random_throw(s)
    except Exception: continue
    if t.symmetry!='quarter': continue
    out=[]
    for f in (2.0,1.66,1.4):
        l=solve_level(mesh_isolated(t,f),p); out.append((l.mesh.unknowns,round(100*l.axial_correction,2)))
    print(s,'fil' if t.filleted else 'sharp',out,flush=True)
