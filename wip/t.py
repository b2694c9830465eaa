import numpy as np, time, crankfem as cf, sys
from geometry.mesher import mesh_isolated
from fem.recovery import *
import fem.recovery as r
throw = cf.CrankThrow(crank_radius=0.170,main_journal_diameter=0.220,pin_diameter=0.180,main_journal_length=0.120,pin_length=0.139,web_width=0.300,web_thickness=0.068,fillet_radius=0.012)
m=mesh_isolated(throw,2.0)
rng=np.random.default_rng(1); U=rng.normal(size=(len(m.points),3,5))*1e-6
t=time.process_time(); S=stress_errors(m.points,m.elements,U,cf.STEEL); t1=time.process_time(); P=S.products(); t2=time.process_time(); e=S.energy_errors(np.array([1,2,0,0,0.])); t3=time.process_time()
print(t1-t,t2-t1,t3-t2, len(m.elements))
a=np.array([1,2,0,0,0.]); print(e.elements.sum()/(a@P@a)-1)
import importlib.util
spec=importlib.util.spec_from_file_location('old','/work/main/fem/recovery.py'); old=importlib.util.module_from_spec(spec); spec.loader.exec_module(old)
t=time.process_time();O=old.energy_products(m.points,m.elements,U,cf.STEEL);print('old',time.process_time()-t)
print(np.abs(O.errors/P-1).max(), old.energy_errors(m.points,m.elements,U[:,:,0],cf.STEEL).relative/S.energy_errors(np.eye(5)[0]).relative-1)
