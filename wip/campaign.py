import sys,time,pickle
from pathlib import Path
import numpy as np, crankfem as cf
sys.path.insert(0,"/tmp/wt/fe21/tests/campaigns")
from random_throws import random_throw
from crankbase.errors import InputError, MeshError
from crankbase.stopwatch import Stopwatch
from fem.accuracy import Problem, solve_level, SAFETY, FIRST_FILLETED, FIRST_SHARP
from fem.refinement import refined_sizes
from fem.recovery import _samples,_differences,_products
FREE=lambda n: n not in ("left end","right end","crank plane","middle plane")
GROUPS=("end","fillet","free facet","free node","cut","inside")
def groups(mesh):
    n=len(mesh.points); c=mesh.elements[:,:4]
    def on(names):
        m=np.zeros(n,bool)
        for k in names:
            if k in mesh.surfaces and len(mesh.surfaces[k]): m[np.unique(mesh.surfaces[k])]=True
        return m[c].sum(1)
    S=mesh.surfaces
    end=on(["left end","right end"])>0; fil=on(["fillet"])>0; fr=on([k for k in S if FREE(k)]); cut=on(["crank plane","middle plane"])>0
    g=np.full(len(c),5); g[cut]=4; g[fr>0]=3; g[fr>=3]=2; g[fil]=1; g[end]=0
    return g
def error_energies(part,mesh,material):
    fields=np.concatenate([part.fields,part.pin_fields],axis=2)
    found=[_samples(mesh.points,mesh.elements,fields[:,:,i],material) for i in range(fields.shape[2])]
    vol=found[0][1]; samples=np.concatenate([a for a,_ in found],axis=2)
    D,sh=_differences(mesh.points,mesh.elements,samples)
    g=groups(mesh); w=vol.sum(1)[:,None]*sh
    return part.symmetry.copies*np.array([_products(D[g==i],w[g==i],material) if np.any(g==i) else np.zeros((fields.shape[2],)*2) for i in range(6)])
from fem.symmetry import symmetry_classes
from fem.loads import radial_directions
from geometry.mass import mesh_mass_properties
from geometry.mesher import mesh_isolated
from compliance_errors import described
out=Path("/tmp/fe21/data"); out.mkdir(exist_ok=True)
first,count=int(sys.argv[1]),int(sys.argv[2])
def record(level,p,throw,times):
    t=time.process_time()
    parts=[level.condense(s,p) for s in symmetry_classes(level.mesh.part)]
    t1=time.process_time()
    errs=[error_energies(q,level.mesh,cf.STEEL) for q in parts]
    t2=time.process_time()
    small=[dict(copies=q.symmetry.copies,shares=q.symmetry.shares,ends=q.symmetry.ends,stiffness=q.stiffness,pin_loads=q.pin_loads,comp=q.pin_components,flex=q.pin_flexibility,errors=e) for q,e in zip(parts,errs)]
    return dict(unknowns=level.mesh.unknowns,volume=level.mesh.solid,meshvolume=mesh_mass_properties(level.mesh,1.0).mass,counts=np.bincount(groups(level.mesh),minlength=6),relative=level.errors.relative,parts=small,times=(times,t1-t,t2-t1))
done=0; seed=first-1
while done<count:
    seed+=1
    f=out/f"{seed}.pkl"
    if f.exists(): done+=1; continue
    try:
        throw=random_throw(seed)
        if throw.symmetry=="full" and seed%3: continue
        p=Problem(cf.STEEL,"auto","rigid",Stopwatch())
        t=time.process_time(); w=time.time()
        level=solve_level(mesh_isolated(throw,FIRST_FILLETED if throw.filleted else FIRST_SHARP),p)
        rows=[record(level,p,throw,time.process_time()-t)]
        for target in (0.02,0.01,0.0018):
            level.solver.close()
            sizes=refined_sizes(level.mesh,level.errors,(0.85 if throw.filleted else .6)*target/SAFETY)
            factor=1.0
            while sizes.expected_unknowns(factor)>(220_000 if throw.symmetry!="full" else 300_000): factor*=1.05
            t=time.process_time()
            level=solve_level(mesh_isolated(throw,factor,"auto",sizes),p)
            rows.append(record(level,p,throw,time.process_time()-t))
        level.solver.close()
    except (InputError,MeshError) as e:
        print(seed,str(e)[:100],flush=True); continue
    f.write_bytes(pickle.dumps(dict(seed=seed,throw=throw,part=throw.symmetry,filleted=throw.filleted,features=described(throw),radial=radial_directions(throw),rows=rows)))
    done+=1
    print(seed,throw.symmetry,described(throw),[r["unknowns"] for r in rows],[round(100*SAFETY*r["relative"],2) for r in rows],round(time.time()-w),flush=True)
