import pickle,glob,sys
import numpy as np
sys.path.insert(0,'/tmp/wt/fe21')
from fem.superelement import Superelement
from fem.supports import support_throw
from fem.loads import RADIAL
def element(d,row,f):
    n=len(d['radial']); K=np.zeros((12,12)); G=np.zeros((n,12,6)); F=np.zeros((6*n,6*n))
    for p in row['parts']:
        k=len(p['stiffness']); e=f*p['errors']
        K+=p['shares'].T@(p['copies']*p['stiffness']-e[:k,:k])@p['shares']
        g=p['pin_loads'].copy()
        for c,(pin,comp) in enumerate(p['comp']): g[pin,:,comp]+=e[:k,k+c]
        G+=p['shares'].T@g
        i=p['comp']@(6,1); F[np.ix_(i,i)]+=p['flex']+e[k:,k:]
    return Superelement(K,G,F,d['radial'])
NAMES=['e_n','tors','c','e_g','tors_g','c_g']
def q(d,row,f):
    el=element(d,row,f); out=[]
    for s in ("pinned","guided"):
        t=support_throw(el,s); out+=[t.axial,t.torsional,t.influences[0]]
    return np.array(out)
FR=1.15
if __name__=="__main__":
    data=[pickle.load(open(f,'rb')) for f in sorted(glob.glob('/tmp/fe21/data/*.pkl'))]
    print(len(data))
    for lev in range(3):
        print('level',lev)
        for kind in (True,False):
            S=[d for d in data if d['filleted']==kind]
            if not S: continue
            fs=[];errs={f:[] for f in (0,1.0,1.1,1.2,1.3)}
            for d in S:
                ref=q(d,d['rows'][3],FR); a=q(d,d['rows'][lev],0); b=q(d,d['rows'][lev],1.0)
                fs.append((ref-a)/(b-a))
                for f in errs: errs[f].append(q(d,d['rows'][lev],f)/ref-1)
            fs=np.array(fs)
            print(' filleted' if kind else ' sharp',len(S),'f* median',np.round(np.median(fs,0),2),'10-90 e_n',np.round(np.quantile(fs[:,0],[0,.1,.25,.75,.9,1]),2))
            for f in errs:
                e=np.abs(np.array(errs[f]))*100; print('   f',f,'median',np.round(np.median(e,0),3),'95%',np.round(np.quantile(e,.95,axis=0),3))
