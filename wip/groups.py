import pickle,glob,sys
import numpy as np
sys.path.insert(0,'/tmp/wt/fe21')
from fem.superelement import Superelement
from fem.supports import support_throw
def element(d,row,f):
    f=np.asarray(f,float)
    n=len(d['radial']); K=np.zeros((12,12)); G=np.zeros((n,12,6)); F=np.zeros((6*n,6*n))
    for p in row['parts']:
        k=len(p['stiffness']); e=np.tensordot(f,p['errors'],1)
        K+=p['shares'].T@(p['copies']*p['stiffness']-e[:k,:k])@p['shares']
        g=p['pin_loads'].copy()
        for c,(pin,comp) in enumerate(p['comp']): g[pin,:,comp]+=e[:k,k+c]
        G+=p['shares'].T@g
        i=p['comp']@(6,1); F[np.ix_(i,i)]+=p['flex']+e[k:,k:]
    return Superelement(K,G,F,d['radial'])
def q(d,row,f):
    el=element(d,row,f); out=[]
    for s in ("pinned","guided"):
        t=support_throw(el,s); out+= [t.axial,t.torsional,t.influences[0]]
    return np.array(out)
data=[pickle.load(open(f,'rb')) for f in sorted(glob.glob('/tmp/fe21/data/*.pkl'))]
if __name__=="__main__":
    print(len(data))
    A=[];B=[];W=[]
    for d in data:
        ref=q(d,d['rows'][3],1.2*np.ones(6))
        for lev in range(3):
            r=d['rows'][lev]; base=q(d,r,np.zeros(6))
            sens=np.array([q(d,r,np.eye(6)[i])/base-1 for i in range(6)])  # 6 groups x 6 q
            for j in range(6):
                A.append(sens[:,j]); B.append(ref[j]/base[j]-1); W.append((d['filleted'],lev,j,d['seed']))
    A=np.array(A);B=np.array(B);W=np.array(W)
    np.savez('/tmp/fe21/AB.npz',A=A,B=B,W=W)
    print('mean shares by group', np.round((A/A.sum(1)[:,None]).mean(0),2))
    scale=np.abs(A.sum(1))
    for sel,name in ((slice(None),'all'),(W[:,2]==0,'e_n'),(W[:,2]==3,'e_g'),((W[:,2]==1),'tors'),((W[:,1]==0),'first'),(W[:,1]>0,'refined'),((W[:,0]==1),'filleted'),((W[:,0]==0),'sharp')):
        a=A[sel]/scale[sel][:,None]; b=B[sel]/scale[sel]
        x,res,_,_=np.linalg.lstsq(a,b,rcond=None)
        one=b.mean()
        print(name,len(b),'single',round(one,3),'std',round(b.std(),3),'groups',np.round(x,2),'std',round((b-a@x).std(),3))
