import numpy as np, time, crankfem as cf
throw = cf.CrankThrow(crank_radius=0.170,main_journal_diameter=0.220,pin_diameter=0.180,main_journal_length=0.120,pin_length=0.139,web_width=0.300,web_thickness=0.068,fillet_radius=0.012)
for acc in (0.02,0.01,0.005,0.002,0.001):
    t=time.process_time();w=time.time(); a=cf.analyze_throw(throw,accuracy=acc); t=time.process_time()-t
    print(acc,a.mesh.unknowns,a.axial_compliance()/1.281e-9-1,a.error_estimate,round(t,2),round(time.time()-w,2),{k:round(v,3) for k,v in a.seconds.items()})
